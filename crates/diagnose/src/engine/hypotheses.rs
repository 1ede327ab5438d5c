//! Every effect of a level on every subject, and the columns of those that the data can show.

use rayon::iter::Either;
use rayon::prelude::*;
use trueaxis_campaign::Campaign;
use trueaxis_effects::{Effect, Level, Scene, Shape, Subject, catalogue};
use trueaxis_leastsquares::median;
use trueaxis_selection::{FixedScan, Hypothesis, InstantScan, Projection, Scan, VisitTimes};

use crate::engine::{Measured, whitened};

/// Hypotheses that the data can show, and hypotheses that they cannot show.
pub(crate) struct Hypotheses {
    pub(crate) scans: Vec<Box<dyn Scan>>,
    pub(crate) without_trace: Vec<Hypothesis>,
}

/// All hypotheses of a level on wanted subjects, in the order of the catalogue.
pub(crate) fn of_catalogue(
    level: Level,
    scene: &Scene,
    is_wanted: impl Fn(&Subject) -> bool,
) -> Vec<Hypothesis> {
    let of_level = |effect: &&&Effect| effect.levels.contains(&level);
    let mut all = Vec::new();
    for effect in catalogue().iter().filter(of_level) {
        let mut subjects = effect.subjects(scene);
        subjects.retain(&is_wanted);
        all.extend(Hypothesis::of_each(effect, subjects));
    }
    all
}

/// Least number of positions of an axis that test how an effect depends on them: two agree with any law.
const LEAST_POSITIONS: usize = 3;

/// Whether the steps of a campaign test the law of effects on a subject. Only the bending of a stage, of a target by
/// an axis, has a curved law.
pub(crate) fn is_tested(campaign: &Campaign, subject: &Subject) -> bool {
    let (Some(axis), Some(_)) = (subject.axis, subject.target) else {
        return true;
    };
    let steps = campaign.steps.iter();
    let mut positions: Vec<f64> = steps.map(|step| step.positions[axis]).collect();
    positions.sort_by(f64::total_cmp);
    positions.dedup_by(|a, b| a.total_cmp(b).is_eq());
    positions.len() >= LEAST_POSITIONS
}

/// Prepares hypotheses, in their order, for the comparison with what `projection` leaves.
pub(crate) fn scans<D: Measured>(
    data: &D,
    model: &D::Model,
    projection: &Projection,
    all: &[Hypothesis],
) -> Hypotheses {
    let (columns_mm, visits) = (data.columns_mm(model), data.visits());
    let ready = |hypothesis: &Hypothesis| {
        let columns = (model, &columns_mm);
        match scan_at(data, columns, projection, &visits, *hypothesis) {
            Some(scan) => Either::Left(scan),
            None => Either::Right(*hypothesis),
        }
    };
    let (scans, without_trace) = all.par_iter().partition_map(ready);
    Hypotheses {
        scans,
        without_trace,
    }
}

/// Prepares one hypothesis, if the data can show it.
pub(crate) fn scan<D: Measured>(
    data: &D,
    model: &D::Model,
    projection: &Projection,
    hypothesis: Hypothesis,
) -> Option<Box<dyn Scan>> {
    let columns = (model, &data.columns_mm(model));
    scan_at(data, columns, projection, &data.visits(), hypothesis)
}

fn scan_at<D: Measured>(
    data: &D,
    (model, columns_mm): (&D::Model, &impl Fn(&Hypothesis, f64) -> Vec<Vec<f64>>),
    projection: &Projection,
    visits: &[VisitTimes],
    hypothesis: Hypothesis,
) -> Option<Box<dyn Scan>> {
    let kind = hypothesis.effect.shape;
    if kind == Shape::Instant {
        let always_mm = columns_mm(&hypothesis, f64::NEG_INFINITY);
        let columns = |is_after: &dyn Fn(usize) -> bool| {
            let after = |column: &Vec<f64>| {
                let rows = column.iter().enumerate();
                let rows = rows.map(|(row, x)| if is_after(row) { *x } else { 0.0 });
                rows.collect()
            };
            whitened(data, model, always_mm.iter().map(after).collect())
        };
        let scan = InstantScan::new(hypothesis, projection, visits, &columns)?;
        return Some(Box::new(scan));
    }
    let shapes = match kind.is_duration() {
        true => data.shapes(kind),
        false => vec![0.0],
    };
    let columns = |shape: f64| whitened(data, model, columns_mm(&hypothesis, shape));
    let scan = FixedScan::new(hypothesis, projection, &shapes, columns)?;
    Some(Box::new(scan))
}

/// Time constants to try.
pub(crate) struct TimeConstants {
    /// The shortest, as a part of the time without pauses ([`without_pauses`]), and the longest, as a part of the whole.
    pub(crate) parts: [f64; 2],
    /// How many.
    pub(crate) count: i32,
}

/// Fewest visits or arrivals within a time constant: fewer do not distinguish it from a slip.
const LEAST_VISITS: f64 = 3.0;

impl TimeConstants {
    /// The list for a number of visits, in equal ratios.
    pub(crate) fn of(&self, visits: usize, busy_s: f64, duration_s: f64) -> Vec<f64> {
        let [shortest, longest] = self.parts;
        let shortest_s = busy_s * shortest.max(LEAST_VISITS / visits.max(2) as f64);
        let steps = f64::from(self.count - 1);
        let ratio = (longest * duration_s / shortest_s).powf(steps.recip());
        let all = (0..self.count).map(|k| shortest_s * ratio.powi(k));
        all.filter(|value| *value > 0.0).collect()
    }
}

/// Pauses are most of the time if less than this part of it is left without them.
const MOSTLY_READ: f64 = 0.5;

/// The duration of visits without pauses ([`without_pauses`]), s.
pub(crate) fn busy_s(visits: &[VisitTimes]) -> f64 {
    let starts_s = visits.iter().map(|v| v.span_s[0]);
    without_pauses(starts_s.collect(), duration_s(visits))
}

/// The duration of visits or arrivals that began at these times (ascending), s; where pauses, as over a night, are most of it, the
/// median time from one to the next for each.
pub(crate) fn without_pauses(starts_s: Vec<f64>, duration_s: f64) -> f64 {
    let steps = starts_s.windows(2).map(|two| two[1] - two[0]);
    let busy_s =
        median(&mut steps.collect::<Vec<_>>()).map(|step_s| step_s * starts_s.len() as f64);
    let busy_s = busy_s.filter(|&busy_s| 0.0 < busy_s && busy_s < MOSTLY_READ * duration_s);
    busy_s.unwrap_or(duration_s)
}

/// Duration from the first to the last reading, s.
pub(crate) fn duration_s(visits: &[VisitTimes]) -> f64 {
    let first = visits.first().map_or(0.0, |v| v.span_s[0]);
    let last = visits.last().map_or(0.0, |v| v.span_s[1]);
    last - first
}

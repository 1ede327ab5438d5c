//! Every effect of the catalogue on every subject of a campaign.

use rayon::prelude::*;
use trueaxis_effects::{Effect, Level, Shape, Subject, catalogue};
use trueaxis_poses::Observation;

use crate::lengths::base::{Adjusted, Base};
use crate::lengths::step_scan::{StepScan, VisitTimes};
use crate::selection::{FixedScan, Hypothesis, Scan};

/// Time constants that are tried, from a hundredth of the campaign, or of the longest occupation of a station, to
/// twice its length in equal ratios.
const TIME_CONSTANTS: i32 = 24;
const SHORTEST: f64 = 0.01;
const TIME_CONSTANT_RATIO: f64 = 1.26;

/// Lags behind a temperature that are tried beside none, from a hundredth of the campaign in equal ratios.
const LAGS: i32 = 11;
const LAG_RATIO: f64 = 1.6;

/// Hypotheses that the data can show, and those that they cannot.
pub(crate) struct Hypotheses {
    pub(crate) scans: Vec<Box<dyn Scan>>,
    pub(crate) without_trace: Vec<Hypothesis>,
}

/// Makes hypotheses ready for what an adjusted model leaves, in their order.
pub(crate) fn hypotheses(base: &Base<'_>, adjusted: &Adjusted, all: &[Hypothesis]) -> Hypotheses {
    let visits = visit_times(base);
    let observations = base.observations(&adjusted.solution);
    let ready = |hypothesis: &Hypothesis| {
        scan_at(base, &observations, adjusted, &visits, *hypothesis).ok_or(*hypothesis)
    };
    let ready: Vec<_> = all.par_iter().map(ready).collect();
    let mut hypotheses = Hypotheses {
        scans: Vec::new(),
        without_trace: Vec::new(),
    };
    for scan in ready {
        match scan {
            Ok(scan) => hypotheses.scans.push(scan),
            Err(hypothesis) => hypotheses.without_trace.push(hypothesis),
        }
    }
    hypotheses
}

/// One hypothesis, if the data can show it.
pub(crate) fn scan(
    base: &Base<'_>,
    adjusted: &Adjusted,
    visits: &[VisitTimes],
    hypothesis: Hypothesis,
) -> Option<Box<dyn Scan>> {
    let observations = base.observations(&adjusted.solution);
    scan_at(base, &observations, adjusted, visits, hypothesis)
}

fn scan_at(
    base: &Base<'_>,
    observations: &[Observation<'_>],
    adjusted: &Adjusted,
    visits: &[VisitTimes],
    hypothesis: Hypothesis,
) -> Option<Box<dyn Scan>> {
    let projection = &adjusted.projection;
    let boxed = |scan: FixedScan| Box::new(scan) as Box<dyn Scan>;
    let columns =
        |shape: f64| base.columns_at(observations, &adjusted.whitened, &hypothesis, shape);
    match hypothesis.effect.shape {
        Shape::Instant => {
            let columns = columns(f64::NEG_INFINITY);
            let scan = StepScan::new(hypothesis, projection, visits, &columns)?;
            Some(Box::new(scan))
        }
        Shape::TimeConstant | Shape::SettlingTime => {
            let duration_s = match hypothesis.effect.shape {
                Shape::SettlingTime => longest_occupation_s(base),
                _ => duration_s(visits),
            };
            let shapes = time_constants(duration_s);
            FixedScan::new(hypothesis, projection, &shapes, columns).map(boxed)
        }
        Shape::Lag => {
            let shapes = lags(duration_s(visits));
            FixedScan::new(hypothesis, projection, &shapes, columns).map(boxed)
        }
        Shape::Fixed | Shape::Period | Shape::Waves => {
            FixedScan::new(hypothesis, projection, &[0.0], columns).map(boxed)
        }
    }
}

/// All hypotheses about the lengths, in the order of the catalogue.
pub(crate) fn of_catalogue(base: &Base<'_>) -> Vec<Hypothesis> {
    let effects = catalogue()
        .iter()
        .filter(|effect| effect.levels.contains(&Level::Lengths));
    effects
        .flat_map(|&effect| of_effect(base, effect))
        .collect()
}

fn of_effect(base: &Base<'_>, effect: &'static Effect) -> Vec<Hypothesis> {
    let subjects: Vec<Subject> = effect.subjects(&base.scene);
    // Poses take every coupling of axes; where runs differ, they are compared (`crate::runs`).
    let is_pose = |s: &Subject| s.other_axis.is_some() && s.component.is_some();
    let subjects: Vec<Subject> = subjects.into_iter().filter(|s| !is_pose(s)).collect();
    let count = subjects.len();
    let hypothesis = |subject| Hypothesis {
        effect,
        subject,
        subjects: count,
    };
    subjects.into_iter().map(hypothesis).collect()
}

/// Rows and times of all visits.
pub(crate) fn visit_times(base: &Base<'_>) -> Vec<VisitTimes> {
    let visits = base.network.visits.iter();
    visits
        .filter(|visit| !visit.readings.is_empty())
        .map(|visit| {
            let times = base.readings[visit.readings.clone()]
                .iter()
                .map(|r| r.time_s);
            VisitTimes {
                rows: visit.readings.clone(),
                span_s: [
                    times.clone().fold(f64::INFINITY, f64::min),
                    times.fold(f64::NEG_INFINITY, f64::max),
                ],
            }
        })
        .collect()
}

/// From the first to the last reading, s.
pub(crate) fn duration_s(visits: &[VisitTimes]) -> f64 {
    let first = visits.first().map_or(0.0, |v| v.span_s[0]);
    let last = visits.last().map_or(0.0, |v| v.span_s[1]);
    last - first
}

fn longest_occupation_s(base: &Base<'_>) -> f64 {
    let elapsed = base.readings.iter().map(|r| r.occupation_elapsed_s);
    elapsed.fold(0.0, f64::max)
}

fn time_constants(duration_s: f64) -> Vec<f64> {
    if duration_s <= 0.0 {
        return Vec::new();
    }
    (0..TIME_CONSTANTS)
        .map(|k| duration_s * SHORTEST * TIME_CONSTANT_RATIO.powi(k))
        .collect()
}

fn lags(duration_s: f64) -> Vec<f64> {
    let behind = (0..LAGS).map(|k| duration_s * SHORTEST * LAG_RATIO.powi(k));
    std::iter::once(0.0).chain(behind).collect()
}

/// Between which values a shape that was found in its list is looked for more closely; `None` if the list has all.
pub(crate) fn neighbours(base: &Base<'_>, shape: Shape, found: f64) -> Option<[f64; 2]> {
    match shape {
        Shape::TimeConstant | Shape::SettlingTime => {
            Some([found / TIME_CONSTANT_RATIO, found * TIME_CONSTANT_RATIO])
        }
        Shape::Lag => {
            let all = lags(duration_s(&visit_times(base)));
            let before = all.iter().rfind(|&&lag| lag < found);
            Some([*before.unwrap_or(&0.0), (found * LAG_RATIO).max(all[1])])
        }
        Shape::Fixed | Shape::Instant | Shape::Period | Shape::Waves => None,
    }
}

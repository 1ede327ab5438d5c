//! Every effect of level points on every subject of a campaign.

use rayon::prelude::*;
use trueaxis_effects::{Level, Shape, catalogue};

use crate::lengths::{StepScan, VisitTimes};
use crate::points::base::Base;
use crate::points::model::Model;
use crate::selection::{FixedScan, Hypothesis, Projection, Scan};

/// Time constants that are tried, from a hundredth of the campaign, and no less than three stops, to three times its
/// length in equal ratios.
const TIME_CONSTANTS: i32 = 20;
const SHORTEST: f64 = 0.01;
const LONGEST: f64 = 3.0;
const LEAST_STOPS: f64 = 3.0;

/// All of them, in the order of the catalogue.
pub(crate) fn of_catalogue(base: &Base<'_>) -> Vec<Hypothesis> {
    let effects = catalogue().iter();
    let effects = effects.filter(|effect| effect.levels.contains(&Level::Points));
    effects
        .flat_map(|effect| {
            let subjects = effect.subjects(base.scene);
            let count = subjects.len();
            subjects.into_iter().map(move |subject| Hypothesis {
                effect,
                subject,
                subjects: count,
            })
        })
        .collect()
}

/// Those that the data can show beside a model, ready to be compared with what it leaves.
pub(crate) fn scans(
    base: &Base<'_>,
    model: &Model,
    projection: &Projection,
    hypotheses: &[Hypothesis],
) -> Vec<Box<dyn Scan>> {
    let ready = hypotheses.par_iter();
    let ready: Vec<_> = ready
        .map(|hypothesis| scan(base, model, projection, *hypothesis))
        .collect();
    ready.into_iter().flatten().collect()
}

/// One, if the data can show it.
pub(crate) fn scan(
    base: &Base<'_>,
    model: &Model,
    projection: &Projection,
    hypothesis: Hypothesis,
) -> Option<Box<dyn Scan>> {
    let columns = |shape: f64| model.whitened(base, &base.columns_mm(&hypothesis, shape));
    let shapes = match hypothesis.effect.shape {
        Shape::Instant => {
            let columns = columns(f64::NEG_INFINITY);
            let scan = StepScan::new(hypothesis, projection, &visits(base), &columns)?;
            return Some(Box::new(scan));
        }
        Shape::TimeConstant | Shape::SettlingTime => time_constants(base),
        Shape::Fixed | Shape::Lag | Shape::Period | Shape::Waves => vec![0.0],
    };
    let scan = FixedScan::new(hypothesis, projection, &shapes, columns)?;
    Some(Box::new(scan))
}

/// Rows and times of all stops.
fn visits(base: &Base<'_>) -> Vec<VisitTimes> {
    let stops = base.readings.stops.iter();
    stops
        .map(|stop| VisitTimes {
            rows: 3 * stop.start..3 * stop.end,
            span_s: base.readings.span_s(stop),
        })
        .collect()
}

fn time_constants(base: &Base<'_>) -> Vec<f64> {
    let elapsed = base.readings.all.iter().map(|r| r.elapsed_s);
    let duration_s = elapsed.fold(0.0, f64::max);
    if duration_s <= 0.0 {
        return Vec::new();
    }
    let between = duration_s / base.readings.stops.len() as f64;
    let shortest = (SHORTEST * duration_s).max(LEAST_STOPS * between);
    let ratio = (LONGEST * duration_s / shortest).powf(1.0 / f64::from(TIME_CONSTANTS - 1));
    let constants = (0..TIME_CONSTANTS).map(|k| shortest * ratio.powi(k));
    constants.collect()
}

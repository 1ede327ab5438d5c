//! Lengths that are all off by the same amount, against what the others predict.

use trueaxis_campaign::{Campaign, Stop};
use trueaxis_kinematics::MICROMETRE;

use crate::mistake::What;
use crate::scope::Scope;
use crate::search::Trial;

/// Scatter about the mean that the machine's repeatability and the noise may have, mm: more is no constant.
const SCATTER_MM: f64 = 20.0 * MICROMETRE;

/// A constant is named if it is at least this many times its scatter.
const SIGNIFICANT: f64 = 10.0;

/// Fewer lengths prove nothing.
const LEAST: usize = 5;

/// The mean difference of the lengths of a part to a target from what a calibration without them predicts, if it is
/// a constant.
pub(crate) fn measured(
    campaign: &Campaign,
    others: &Trial,
    target: usize,
    scope: &Scope,
) -> Option<What> {
    let lengths = campaign.lengths.as_ref()?;
    let stops: Vec<&Stop> = scope.stops(campaign).collect();
    let predicted_mm = (others.lengths_mm)(campaign, target, &stops)?;
    let mut differences_mm = Vec::new();
    for (stop, predicted_mm) in stops.iter().zip(predicted_mm) {
        let readings = lengths.readings[stop.readings.clone()].iter();
        let of_target = readings.filter(|reading| reading.target == target);
        differences_mm.extend(of_target.map(|reading| reading.length_mm - predicted_mm));
    }
    let count = differences_mm.len();
    if count < LEAST {
        return None;
    }
    let offset_mm = differences_mm.iter().sum::<f64>() / count as f64;
    let squares: f64 = differences_mm.iter().map(|d| (d - offset_mm).powi(2)).sum();
    let scatter_mm = (squares / (count - 1) as f64).sqrt();
    let u_mm = scatter_mm / (count as f64).sqrt();
    let is_constant = scatter_mm < SCATTER_MM && offset_mm.abs() > SIGNIFICANT * scatter_mm;
    is_constant.then_some(What::Offset {
        target,
        offset_mm,
        u_mm,
    })
}

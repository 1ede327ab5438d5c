//! Targets that scatter more than the others weigh less.
//!
//! Told as of lengths ([`trueaxis_screening::uneven`]), by how the normalised residuals of a target change from one stop to the next that
//! was approached from the same side. Targets of one carrier are compared: what it does is common to them.

use trueaxis_campaign::Points;
use trueaxis_screening::{Scatter, uneven};

use crate::numbers::mean;
use crate::points::base::Base;
use crate::points::model::Model;

/// Rounds: a target that scatters bends the poses of the others, less each time.
const ROUNDS: usize = 6;

/// The points with larger standard deviations of such targets, and which these are. `again` adjusts points.
pub(super) fn weighed<'a>(
    points: &Points,
    (base, model): (&Base<'a>, &Model),
    again: impl Fn(&Points) -> (Base<'a>, Model),
) -> Option<(Points, Vec<usize>)> {
    let mut scatters = scatters(base, model);
    let carrier = |target: usize| base.scene.targets[target].carrier;
    let told = (0..scatters.len()).filter(|&target| {
        let of_carrier = scatters.iter().enumerate();
        let of_carrier = of_carrier.map(|(k, own)| own.filter(|_| carrier(k) == carrier(target)));
        let uneven = uneven(&of_carrier.collect::<Vec<_>>());
        carrier(target).is_some() && uneven.iter().any(|own| own.number == target)
    });
    let told: Vec<usize> = told.collect();
    if told.is_empty() {
        return None;
    }
    let mut weighed = points.clone();
    for _ in 0..ROUNDS {
        let variance = |target: usize| scatters[target].map(|own| own.variance);
        // Their ratio to the mean of those that do not.
        let larger = told.iter().map(|&target| {
            let others = (0..scatters.len()).filter(|k| carrier(*k) == carrier(target));
            let others = others.filter(|k| !told.contains(k)).filter_map(variance);
            let usual = mean(&others.collect::<Vec<f64>>());
            variance(target).map_or(1.0, |own| (own / usual).sqrt())
        });
        let larger: Vec<f64> = larger.collect();
        for reading in &mut weighed.readings {
            if let Some(k) = told.iter().position(|own| *own == reading.target) {
                reading.sigma_um = Some(reading.sigma_um.unwrap_or(1.0) * larger[k]);
            }
        }
        let (base, model) = again(&weighed);
        scatters = self::scatters(&base, &model);
    }
    Some((weighed, told))
}

/// What the points of each target scatter.
fn scatters(base: &Base<'_>, model: &Model) -> Vec<Option<Scatter>> {
    let left = |row: usize| model.left_of_row(row).max(f64::EPSILON);
    let normalised = |row: usize| model.projection.residuals[row] / left(row).sqrt();
    let of_target = |target: usize| {
        let from = |side: f64| {
            let readings = base.readings.all.iter().enumerate();
            let own = readings.filter(|(_, r)| r.target == target && r.side * side > 0.0);
            let own = own.map(|(i, _)| [0, 1, 2].map(|k| normalised(3 * i + k)));
            own.collect::<Vec<[f64; 3]>>()
        };
        let sides = [1.0, -1.0].map(from);
        let two = sides.iter().flat_map(|own| own.windows(2));
        let squares = two.flat_map(|two| [0, 1, 2].map(|k| (two[1][k] - two[0][k]).powi(2)));
        Scatter::of(squares.collect(), sides.concat().len())
    };
    (0..base.scene.targets.len()).map(of_target).collect()
}

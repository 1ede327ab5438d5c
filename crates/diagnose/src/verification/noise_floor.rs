//! The noise of one arrival, from what repeats do not reproduce.
//!
//! Pure error: readings at the same commanded positions in the same direction, against their mean. What moves from
//! cycle to cycle is an effect, not noise, and must not hide in the floor; so each pass (cycle and direction) first
//! has an offset and a slope of its own (a ball bar: a set-up of its own):
//!
//! ```text
//! y = μ(positions, direction) + a(pass) + b(pass) q + e      s² = Σ ê² / ν
//! ```
//!
//! Cells and passes together are fitted by subtracting cell means from both sides. Beside the noise only the
//! curvature of a drift within a pass stays in `e`.

use trueaxis_campaign::VerificationKind;
use trueaxis_selection::Projection;

use crate::numbers::mean;
use crate::verification::base::{
    cells, count, indicators, less_location, passes, set_up, sizes, times,
};
use crate::verification::comparison::Comparison;

/// A standard deviation from fewer degrees of freedom is uncertain by more than a quarter.
const LEAST_DEGREES_OF_FREEDOM: f64 = 8.0;

/// Passes of more readings have an offset of their own ([`scatter`]).
pub(crate) const SHORT_PASS: usize = 2;

/// Standard deviation of one arrival, µm; `None` without enough repeats.
pub(crate) fn noise_floor_um(comparison: &Comparison<'_>) -> Option<f64> {
    let cells = cells(comparison);
    let centred = |mut column: Vec<f64>| {
        less_location(&mut column, &cells, |own| mean(own));
        column
    };
    let of_passes = pass_columns(comparison, true).into_iter().map(centred);
    let columns: Vec<Vec<f64>> = of_passes.collect();
    let left = Projection::dense(centred(comparison.difference_um.clone()), &columns);
    let degrees_of_freedom = left.degrees_of_freedom - count(&cells) as f64;
    (degrees_of_freedom >= LEAST_DEGREES_OF_FREEDOM)
        .then(|| (left.squares() / degrees_of_freedom).sqrt())
}

/// Mean number of readings at the same commanded positions in the same direction.
pub(crate) fn repeats(comparison: &Comparison<'_>) -> f64 {
    let cells = count(&cells(comparison)).max(1);
    comparison.arrivals.len() as f64 / cells as f64
}

/// What repeats do not reproduce beyond an offset of each pass, with the model's projection; `None` without enough
/// repeats. An offset would make all readings of a pass of two stops look alike, as a slope those of one of three:
/// where no pass is longer, as in a test of repeatability, passes have none and are compared as they are.
pub(crate) fn scatter(comparison: &Comparison<'_>) -> Option<Projection> {
    let mut columns = indicators(&cells(comparison));
    let mut in_passes = sizes(&passes(comparison)).into_iter();
    if in_passes.any(|readings| readings > SHORT_PASS) {
        columns.extend(pass_columns(comparison, false));
    }
    let left = Projection::dense(comparison.difference_um.clone(), &columns);
    (left.degrees_of_freedom >= LEAST_DEGREES_OF_FREEDOM && left.squares() > 0.0).then_some(left)
}

/// An offset (and a slope), or a set-up, for each pass.
pub(crate) fn pass_columns(comparison: &Comparison<'_>, with_slope: bool) -> Vec<Vec<f64>> {
    let measured = comparison.axis();
    let shapes: Vec<Vec<f64>> = match comparison.kind {
        VerificationKind::Positioning { .. } => {
            let at = comparison.arrivals.iter().map(|a| a.positions[measured]);
            let constant = vec![1.0; comparison.arrivals.len()];
            match with_slope {
                true => vec![constant, at.collect()],
                false => vec![constant],
            }
        }
        VerificationKind::Ballbar { .. } => set_up(comparison),
    };
    let passes = indicators(&passes(comparison)).into_iter();
    let of_pass = |pass: Vec<f64>| -> Vec<Vec<f64>> {
        shapes.iter().map(|shape| times(shape, &pass)).collect()
    };
    passes.flat_map(of_pass).collect()
}

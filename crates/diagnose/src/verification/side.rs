//! The side from which an axis comes that moves with others, as on a circle.
//!
//! It is the sign of its speed at the row, from a parabola through three rows. Where that is nearly zero, at the end
//! of its travel, the axis is still on the side it came from. On a closed circle the first row follows the last.

/// Rounding of the coordinates of a circle; far below any step of a machine.
const ROUNDING_MM_OR_RAD: f64 = 1e-9;

/// The side from which an axis that moves with others comes to a row of a pass; zero where it stands. `closed` are
/// the rows before the first and after the last one of a closed circle.
pub(crate) fn side(
    positions: &[Vec<f64>],
    closed: Option<[usize; 2]>,
    axis: usize,
    row: usize,
) -> f64 {
    let last = positions.len() - 1;
    let at = |row: usize| positions[row][axis];
    let before = row.checked_sub(1).or(closed.map(|[end, _]| end));
    let after = Some(row + 1).filter(|next| *next <= last);
    let after = after.or(closed.map(|[_, start]| start));
    let came = before.map(|before| at(row) - at(before));
    let goes = after.map(|after| at(after) - at(row));
    // The tangent of a parabola: in the middle of its three points, at its first (a machine runs in before) or last.
    let (speed, steps, turned) = match (came, goes) {
        (Some(came), Some(goes)) => (came + goes, [came, goes], came),
        (None, Some(goes)) if last > 1 => {
            let next = at(2) - at(1);
            (3.0 * goes - next, [goes, next], -goes)
        }
        (Some(came), None) if last > 1 => {
            let earlier = at(row - 1) - at(row - 2);
            (3.0 * came - earlier, [came, earlier], came)
        }
        (one, other) => {
            let step = one.or(other).unwrap_or(0.0);
            (step, [step; 2], step)
        }
    };
    let step = steps[0].abs().max(steps[1].abs());
    if step <= ROUNDING_MM_OR_RAD {
        0.0
    } else if speed.abs() > TURNS_ROUND * step {
        speed.signum()
    } else {
        turned.signum()
    }
}

/// Share of a step by which an axis moves on from the row before to the one after, below which it turns in between.
const TURNS_ROUND: f64 = 0.1;

/// The rows before the first and after the last one of a closed circle: there each axis continues in its direction by
/// at most its longest step.
pub(crate) fn around(positions: &[Vec<f64>]) -> Option<[usize; 2]> {
    let last = positions.len() - 1;
    if last < LEAST_OF_CIRCLE {
        return None;
    }
    let axes = 0..positions[0].len();
    let step = |axis: usize, a: usize, b: usize| positions[b][axis] - positions[a][axis];
    let longest = |axis: usize| {
        let steps = (0..last).map(|i| step(axis, i, i + 1).abs());
        steps.fold(0.0, f64::max)
    };
    let within = |part: f64| {
        let mut axes = axes.clone();
        axes.all(|axis| step(axis, last, 0).abs() <= part * longest(axis))
    };
    let product = |axis: usize| step(axis, last - 1, last) * step(axis, last, 0);
    let goes_on = axes.clone().map(product).sum::<f64>() > 0.0;
    match within(SAME_PLACE) {
        true => Some([last - 1, 1]),
        false => (goes_on && within(1.0 + 1e-6)).then_some([last, 0]),
    }
}

/// Fewest rows of a closed circle.
const LEAST_OF_CIRCLE: usize = 6;

/// Share of a step from which on two rows are at two positions.
const SAME_PLACE: f64 = 0.05;

//! The side from which an axis comes that moves with others, as on a circle.
//!
//! It is the sign of its speed at the row, from a parabola through three rows over the path, which the machine travels at an
//! even feed: rows may be missing. Where it is nearly zero, at the end of its travel, the axis is still on the side it came
//! from. On a closed circle the first row follows the last.

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
    let step = |[from, to]: [usize; 2]| Step {
        moves: positions[to][axis] - positions[from][axis],
        path: distance(&positions[from], &positions[to]),
    };
    let before = row.checked_sub(1).or(closed.map(|[end, _]| end));
    let after = Some(row + 1).filter(|next| *next <= last);
    let after = after.or(closed.map(|[_, start]| start));
    let came = before.map(|before| step([before, row]));
    let goes = after.map(|after| step([row, after]));
    // The tangent of a parabola: in the middle of its three points, at its first (a machine runs in before) or last.
    let (speed, steps, turned) = match (came, goes) {
        (Some(came), Some(goes)) => (between(came, goes), [came, goes], came.moves),
        (None, Some(goes)) if last > 1 => {
            let next = step([1, 2]);
            (at_end(goes, next), [goes, next], -goes.moves)
        }
        (Some(came), None) if last > 1 => {
            let earlier = step([row - 2, row - 1]);
            (at_end(came, earlier), [came, earlier], came.moves)
        }
        (one, other) => {
            let step = one.or(other).unwrap_or_default();
            (step.moves, [step; 2], step.moves)
        }
    };
    let step = steps[0].moves.abs().max(steps[1].moves.abs());
    if step <= ROUNDING_MM_OR_RAD {
        0.0
    } else if speed.abs() > TURNS_ROUND * step {
        speed.signum()
    } else {
        turned.signum()
    }
}

/// What moves from a row to the next.
#[derive(Debug, Default, Clone, Copy)]
struct Step {
    /// By how much the axis moves.
    moves: f64,
    /// How far all axes move.
    path: f64,
}

/// How far rows are apart. Where linear axes follow a rotary one, they move by far more millimetres than it by radians.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (b - a).powi(2));
    squares.sum::<f64>().sqrt()
}

/// Speed of an axis at the row between two steps, as its move over their path.
fn between(came: Step, goes: Step) -> f64 {
    let ratio = ratio(came, goes);
    came.moves / ratio + goes.moves * ratio
}

/// The same at the row where a pass begins or ends, from the step next to it and the one beyond.
fn at_end(near: Step, far: Step) -> f64 {
    let ratio = ratio(near, far);
    near.moves * (2.0 + ratio.recip()) - far.moves * ratio
}

/// Ratio of the paths of two steps; 1 where one of them has none.
fn ratio(one: Step, other: Step) -> f64 {
    let ratio = one.path / other.path;
    if ratio.is_normal() { ratio } else { 1.0 }
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

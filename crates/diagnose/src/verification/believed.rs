//! Which causes are claimed: those that help on unused readings, and that do not merely imitate what
//! nothing explains.

use crate::OmnibusTest;
use crate::selection::{Fit, Projection};
use crate::verification::held_out::gain_of;
use crate::verification::omnibus::Family;
use crate::verification::problem::{Chosen, Problem};

/// Drops causes that do not gain on unused readings with a probability of nine in ten, the weakest first.
///
/// The gain of a true cause of strength λ scatters by 2/λ of itself: at λ = 7 a two-sided interval of
/// 95 % would lose 6 % of the true ones, this bound loses 1 %. Whether a gain is *claimed* is told by the
/// interval.
pub(crate) fn with_gain(problem: &Problem<'_>, causes: &mut Vec<Chosen>, folds: &[usize]) {
    while !causes.is_empty() {
        let bounds = (0..causes.len()).map(|k| {
            let gain = gain_of(problem, causes, k, folds);
            // What cannot be held out cannot be refuted.
            (k, gain.map_or(0.0, |gain| gain.upper_bound))
        });
        match bounds.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((k, bound)) if bound >= 1.0 => causes.remove(k),
            _ => return,
        };
    }
}

/// What is left in columns, times the part of a cause's trace that lies in them, in squares of that trace,
/// from which the cause is taken for an imitation. A cause that fits leaves noise, far less than it took.
const TOO_MUCH_LEFT: f64 = 0.25;

/// The same of one course in time: what wanders looks like a jump or a drift in most of its squares, so that these
/// are named only if they take 95 %. And of a free function of the position, which fits many things.
const TOO_MUCH_OF_ANY_FORM: f64 = 1.0 / 19.0;

/// Drops causes whose trace lies where structure is left: a wrong name takes a part of an unknown
/// disturbance and leaves the rest in the same columns.
pub(crate) fn without_imitations(
    problem: &Problem<'_>,
    causes: &mut Vec<Chosen>,
    left: &[OmnibusTest],
    families: &[Family],
    level: f64,
) {
    let after = problem.with(causes);
    // Columns of what is left, and its squares beyond those of noise.
    let suspect: Vec<(&Family, f64)> = left
        .iter()
        .filter(|test| test.p_value < level)
        .filter_map(|test| {
            let family = families
                .iter()
                .find(|f| f.varies_with == test.varies_with)?;
            let drop = after.squares() - after.extended(&family.columns).squares();
            Some((family, drop - test.columns as f64))
        })
        .collect();
    causes.retain(|cause| {
        let candidate = &problem.candidates[cause.candidate];
        let too_much = match candidate.is_of_time() || candidate.is_free {
            true => TOO_MUCH_OF_ANY_FORM,
            false => TOO_MUCH_LEFT,
        };
        let columns = problem.columns(std::slice::from_ref(cause));
        let trace = Fit::new(&problem.base, &columns).explained;
        let squares: f64 = trace.iter().map(|x| x * x).sum();
        !suspect.iter().any(|(family, left)| {
            let part = part_within(&problem.base, &family.columns, &trace);
            part * left > too_much * squares
        })
    });
}

/// Part of the squares of a trace that lies in columns, both after the projection.
fn part_within(model: &Projection, columns: &[Vec<f64>], trace: &[f64]) -> f64 {
    let squares: f64 = trace.iter().map(|x| x * x).sum();
    let mut rest = trace.to_vec();
    model.extended(columns).project(&mut rest);
    let left: f64 = rest.iter().map(|x| x * x).sum();
    if squares > 0.0 {
        1.0 - left / squares
    } else {
        0.0
    }
}

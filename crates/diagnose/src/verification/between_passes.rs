//! Passes of a line that scatter as wholes.
//!
//! An axis does not take up the same play at each reversal, nor does a zero stand still between passes. What all readings
//! of a pass share does not average out along it, so the mean of the differences of the sides is known less well than
//! the scatter of single readings says. With the means `m_p` of what the causes leave of each pass, the variance between
//! passes is, by analysis of variance for each direction,
//!
//! ```text
//! s_b² = Σ (m_p - m)² / ν - s² (1 + ρ)/(1 - ρ) / n        u²(lost motion) += s_b² (1/n₊ + 1/n₋)
//! ```
//!
//! with the variance s² and the correlation ρ of all that is left, which the u² of the fit contains.
//!
//! Where something wanders, a smooth course has taken part of that, and part of the means is the course. The differences
//! of the two passes of each cycle are nearly free of it: their variance over the number of cycles is the least `u²`.

use trueaxis_selection::{Projection, add};

use crate::engine::linear::Chosen;
use crate::numbers::squares_about_mean;
use crate::verification::base::{count, lines};
use crate::verification::problem::Problem;

/// Fewest degrees of freedom of a variance between passes, and between cycles.
const LEAST_OF_PASSES: f64 = 2.0;
const LEAST_OF_CYCLES: usize = 3;

/// Mean of what is left of each pass, µm.
struct Passes {
    /// By direction, backward first.
    means_um: [Vec<f64>; 2],
    /// Of two that follow each other in a cycle, the second less the first in the direction of the motion.
    differences_um: Vec<f64>,
}

impl Passes {
    fn new(problem: &Problem<'_>, left: &[f64]) -> Self {
        let left_um = problem.um(left);
        let rows: Vec<_> = problem.comparison.arrivals.iter().zip(&left_um).collect();
        let (mut means_um, mut differences_um) = ([Vec::new(), Vec::new()], Vec::new());
        let mut before: Option<(u32, f64, f64)> = None;
        for pass in rows.chunk_by(|(a, _), (b, _)| a.is_of_pass(b)) {
            let sum: f64 = pass.iter().map(|(_, left)| **left).sum();
            let (mean, own) = (sum / pass.len() as f64, pass[0].0);
            means_um[usize::from(own.direction > 0.0)].push(mean);
            if let Some((cycle, direction, of_before)) = before
                && cycle == own.cycle
                && direction * own.direction < 0.0
            {
                differences_um.push((mean - of_before) * own.direction);
            }
            before = Some((own.cycle, own.direction, mean));
        }
        Self {
            means_um,
            differences_um,
        }
    }
}

/// The variance of the mean lost motion of a line, µm², with what its passes differ by; `alone_um2` is without that.
pub(crate) fn variance_um2(
    problem: &Problem<'_>,
    (after, wandered): (&Projection, &[f64]),
    causes: &[Chosen],
    alone_um2: f64,
) -> f64 {
    // Passes of several lines do not follow each other in one cycle.
    if count(&lines(problem.comparison)) > 1 {
        return alone_um2;
    }
    let mut left = after.residuals.clone();
    add(&mut left, wandered, 1.0);
    let passes = Passes::new(problem, &left);
    if problem.wanders {
        let differences = &passes.differences_um;
        let enough = differences.len() > LEAST_OF_CYCLES;
        let of_cycles = || squares_about_mean(differences) / (differences.len() - 1) as f64;
        return match enough {
            true => alone_um2.max(of_cycles() / differences.len() as f64),
            false => alone_um2,
        };
    }
    let counts = passes.means_um.each_ref().map(|own| own.len() as f64);
    let of_time = causes.iter().map(|cause| problem.listed.hypothesis(cause));
    let of_time = of_time.filter(|own| own.is_of_time()).count() as f64;
    let freedom = counts[0] + counts[1] - 2.0 - of_time;
    if counts.contains(&0.0) || freedom < LEAST_OF_PASSES {
        return alone_um2;
    }
    let of_each = passes.means_um.iter();
    let total: f64 = of_each.map(|own| squares_about_mean(own)).sum();
    let readings = problem.readings() as f64;
    let rho = problem.whitening.correlation;
    let of_reading_um2 = problem.rms_um(after).powi(2) * (1.0 + rho) / (1.0 - rho);
    let of_means_um2 = of_reading_um2 * (counts[0] + counts[1]) / readings;
    let between_um2 = (total / freedom - of_means_um2).max(0.0);
    alone_um2 + between_um2 * (1.0 / counts[0] + 1.0 / counts[1])
}

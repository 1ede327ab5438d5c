//! When the results of growing numbers of trials are stable (JCGM 101, 7.9).

use crate::coverage::{self, Ranks};
use crate::error::Error;
use crate::moments::Moments;
use crate::summary::Scatter;
use crate::tolerance::numerical_tolerance;
use crate::values::{Part, Values};

/// Least number of trials of a block.
const LEAST_BLOCK: usize = 10_000;

/// Whether an adaptive number of trials was enough, with the evidence.
///
/// After every block the standard deviation `s` of the average over the blocks of mean, u and both
/// ends of the symmetric interval is compared with the tolerance δ of u: all outputs have
/// stabilised when `2 s ≤ δ` for all four. After two blocks `s` has one degree of freedom only, so
/// a propagation of few outputs can end too soon by luck; [`Summary::scatter`](crate::Summary) does
/// not depend on blocks and shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// Whether every output has stabilised; if not, the most trials were used up.
    pub stabilised: bool,
    /// Blocks made.
    pub blocks: usize,
    /// Trials of each: max(10⁴, 100/(1 - p)).
    pub block_trials: usize,
    /// The evidence for each output.
    pub outputs: Vec<OutputStability>,
}

/// Scatter between the blocks of one output and what is tolerated, in the unit of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputStability {
    /// Numerical tolerance δ of the standard uncertainty of all values.
    pub tolerance: f64,
    /// Standard deviations of the averages over the blocks.
    pub scatter: Scatter,
}

impl OutputStability {
    /// Whether twice the scatter stays within the tolerance.
    pub fn is_stabilised(&self) -> bool {
        2.0 * self.scatter.largest() <= self.tolerance
    }
}

/// Trials of a block: max(J, 10⁴), J the least integer not below 100/(1 - p).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive integer; where it is too large for usize, no number of trials holds it"
)]
pub(crate) fn block_trials(coverage: f64) -> usize {
    // 1 - p is rounded, which must not lift an integer quotient to the next.
    let quotient = 100.0 / (1.0 - coverage) * (1.0 - 1e-12);
    LEAST_BLOCK.max(quotient.ceil() as usize)
}

/// The blocks made so far.
#[derive(Debug, Clone)]
pub(crate) struct Blocks {
    significant_digits: u32,
    /// Trials of one block.
    pub(crate) trials: usize,
    coverage: f64,
    made: usize,
    outputs: Vec<OutputBlocks>,
}

impl Blocks {
    pub(crate) fn new(coverage: f64, significant_digits: u32) -> Self {
        Self {
            significant_digits,
            trials: block_trials(coverage),
            coverage,
            made: 0,
            outputs: Vec::new(),
        }
    }

    /// Takes in the last batch of `values` as the next block.
    pub(crate) fn add(&mut self, values: &Values) -> Result<Stability, Error> {
        let (trials, coverage) = (self.trials, self.coverage);
        let ranks =
            coverage::ranks(trials, coverage).ok_or(Error::TooFewTrials { trials, coverage })?;
        let block = values.map_outputs(Part::LastBatch, |output, column| {
            figures_of_block(output, column, ranks)
        })?;
        self.outputs.resize(block.len(), OutputBlocks::NONE);
        for (blocks, (moments, figures)) in self.outputs.iter_mut().zip(&block) {
            blocks.add(moments, figures);
        }
        self.made += 1;
        let digits = self.significant_digits;
        let outputs: Vec<_> = self.outputs.iter().map(|o| o.stability(digits)).collect();
        Ok(Stability {
            stabilised: self.made > 1 && outputs.iter().all(OutputStability::is_stabilised),
            blocks: self.made,
            block_trials: trials,
            outputs,
        })
    }
}

/// Mean, u, and the lower and upper end of the symmetric interval of an output.
type Figures<T> = [T; 4];

/// What one block says about one output.
fn figures_of_block(
    output: usize,
    values: &mut [f64],
    ranks: Ranks,
) -> Result<(Moments, Figures<f64>), Error> {
    let moments = Moments::of(values);
    let (mean, u) = (moments.mean, moments.standard_deviation());
    if !(mean.is_finite() && u.is_finite()) {
        return Err(Error::Overflow { output });
    }
    values.sort_unstable_by(f64::total_cmp);
    let interval = coverage::symmetric(values, ranks);
    Ok((moments, [mean, u, interval.low, interval.high]))
}

/// What the blocks so far say about one output.
#[derive(Debug, Clone, Copy)]
struct OutputBlocks {
    all_values: Moments,
    figures: Figures<Moments>,
}

impl OutputBlocks {
    const NONE: Self = Self {
        all_values: Moments::NONE,
        figures: [Moments::NONE; 4],
    };

    fn add(&mut self, moments: &Moments, figures: &Figures<f64>) {
        self.all_values = self.all_values.merged(moments);
        for (all, &figure) in self.figures.iter_mut().zip(figures) {
            *all = all.merged(&Moments::of(&[figure]));
        }
    }

    fn stability(&self, significant_digits: u32) -> OutputStability {
        let u = self.all_values.standard_deviation();
        let [mean, u_scatter, low, high] = self.figures.map(|all| all.mean_scatter());
        OutputStability {
            tolerance: numerical_tolerance(u, significant_digits),
            scatter: Scatter {
                mean,
                u: u_scatter,
                low,
                high,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn block_holds_a_hundred_values_outside_and_ten_thousand_trials() {
        for (coverage, trials) in [
            (0.5, 10_000),
            (0.95, 10_000),
            (0.99, 10_000),
            (0.995, 20_000),
            (0.999, 100_000),
            (0.9973, 37_038),
        ] {
            assert_eq!(block_trials(coverage), trials, "{coverage}");
        }
    }

    /// Three blocks of two values: s of the average is that of 7.9.4, Σ(x - x̄)² / (h (h - 1)).
    #[test]
    fn scatter_of_the_averages_over_blocks() {
        let mut blocks = OutputBlocks::NONE;
        for [low, high] in [[0.0, 4.0], [1.0, 3.0], [3.0, 7.0]] {
            let moments = Moments::of(&[low, high]);
            let figures = [moments.mean, moments.standard_deviation(), low, high];
            blocks.add(&moments, &figures);
        }
        let found = blocks.stability(1);
        // Means 2, 2, 5; u √8, √2, √8; low 0, 1, 3; high 4, 3, 7; u of all √6.
        assert!((found.scatter.mean - 1.0).abs() < 1e-12);
        assert!((found.scatter.u - 2.0_f64.sqrt() / 3.0).abs() < 1e-12);
        assert!((found.scatter.low - (7.0_f64 / 9.0).sqrt()).abs() < 1e-12);
        assert!((found.scatter.high - (13.0_f64 / 9.0).sqrt()).abs() < 1e-12);
        assert!((found.tolerance - 0.5).abs() < 1e-15);
        assert!(!found.is_stabilised());
    }
}

//! The gain on data not used for the fit.
//!
//! Blocks of neighbouring rows, such as whole sweeps, are assigned to folds in advance; each fold is predicted from the
//! others, without the causes and with them. Instants and time constants are sought again in the others
//! ([`sought_again`]). The ratio of the rms has an interval from a bootstrap of blocks.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_selection::{DECISIVE, Projection, ln_f_test};

use crate::engine::{Measured, Suspect, scan};
use crate::{Gain, HeldOutRatio};

/// Sums of squares of held-out rows in variances of the noise: without the causes, with them, and expected from noise
/// alone.
pub(crate) type Squares = [f64; 3];

/// How well held-out rows are predicted without and with the causes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HeldOut {
    pub(crate) squares: Squares,
    /// Ratio of the rms, with its 95 % interval.
    pub(crate) ratio: HeldOutRatio,
    /// The ratio is below this with a probability of nine in ten.
    pub(crate) upper_bound: f64,
}

/// Number of folds.
pub(crate) const FOLDS: usize = 5;

/// Resamples of the bootstrap: its 95 % interval is then good to a tenth of its width.
const DRAWS: usize = 2000;

const SEED: u64 = 0x6865_6c64_5f6f_7574;

impl HeldOut {
    /// From the squares of blocks; `None` if there is nothing to explain.
    pub(crate) fn of(blocks: &[Squares]) -> Option<Self> {
        let squares = [0, 1, 2].map(|k| blocks.iter().map(|block| block[k]).sum::<f64>());
        if squares[0] <= 0.0 {
            return None;
        }
        let ratios = resampled_ratios(blocks);
        let quantile = |per_mille: usize| ratios.get(per_mille * ratios.len() / 1000).copied();
        Some(Self {
            squares,
            ratio: HeldOutRatio {
                ratio: (squares[1] / squares[0]).sqrt(),
                interval: [quantile(25)?, quantile(975)?],
            },
            upper_bound: quantile(900)?,
        })
    }

    /// Rms without and with the causes, in standard deviations of the noise.
    pub(crate) fn rms(&self) -> [f64; 2] {
        let [before, after, noise] = self.squares;
        [before, after].map(|squares| (squares / noise).sqrt())
    }

    /// Whether the causes certainly predict worse than nothing. Where few blocks can show a cause, the ratio may be above one in every draw
    /// by nearly nothing.
    pub(crate) fn is_loss(&self) -> bool {
        // Minus twice the logarithm of the ratio of the likelihoods.
        self.ratio.interval[0] >= 1.0 && self.squares[1] - self.squares[0] > DECISIVE
    }

    /// Whether the causes certainly predict better than nothing.
    pub(crate) fn is_gain(&self) -> bool {
        self.ratio.interval[1] < 1.0
    }

    /// The gain, with the share of the misfit above the noise that was removed, by these squares.
    pub(crate) fn gain(&self, [before, after, noise]: Squares) -> Gain {
        let excess = before - noise;
        let removed = ((before - after) / excess).clamp(0.0, 1.0);
        Gain {
            heldout_rms_ratio: self.ratio.ratio,
            interval: self.ratio.interval,
            share_of_excess_removed: if excess > 0.0 { removed } else { 0.0 },
            leave_one_station_out: None,
        }
    }
}

/// The squares of blocks, from those of rows with the number of the block of each.
pub(crate) fn in_blocks(rows: impl Iterator<Item = (usize, Squares)>) -> Vec<Squares> {
    let mut blocks: Vec<Squares> = Vec::new();
    for (block, squares) in rows {
        blocks.resize(blocks.len().max(block + 1), [0.0; 3]);
        for (sum, own) in blocks[block].iter_mut().zip(squares) {
            *sum += own;
        }
    }
    blocks
}

/// Ratios of the rms with and without the causes for resampled blocks, in ascending order.
fn resampled_ratios(blocks: &[Squares]) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(SEED);
    let mut resampled = || {
        let mut sums = [0.0; 2];
        for _ in blocks {
            let drawn = blocks[generator.random_range(0..blocks.len())];
            sums[0] += drawn[0];
            sums[1] += drawn[1];
        }
        (sums[1] / sums[0]).sqrt()
    };
    let ratios = (0..DRAWS).map(|_| resampled());
    // Draws of blocks in which nothing is predicted have none.
    let mut ratios: Vec<f64> = ratios.filter(|ratio| ratio.is_finite()).collect();
    ratios.sort_by(f64::total_cmp);
    ratios
}

/// The same causes with shapes and parameters from other data, given a model `plain` of these without causes, and the
/// residuals with the causes; directions of the parameters that these data hardly show are shrunk
/// ([`trueaxis_selection::Gram::shrunk`]). A cause that they do not show, at the level of causes, is left out: its values would be those of
/// noise.
pub(crate) fn sought_again<D: Measured>(
    data: &D,
    plain: &D::Model,
    suspects: &[Suspect],
) -> (Vec<Suspect>, Projection) {
    let mut projection = D::projection(plain).clone();
    let mut again: Vec<Suspect> = Vec::new();
    for suspect in suspects {
        let Some(scan) = scan(data, plain, &projection, suspect.hypothesis) else {
            continue;
        };
        let mut best: Option<(f64, f64, usize, Vec<f64>)> = None;
        let mut shapes = 0;
        scan.for_each(&projection.residuals, &mut |tried, gram, s| {
            shapes += 1;
            let statistic = gram.statistic(s);
            if best.as_ref().is_none_or(|best| statistic > best.1) {
                best = Some((tried.shape, statistic, gram.rank(), gram.shrunk(s)));
            }
        });
        let freedom = projection.degrees_of_freedom;
        let Some((shape, statistic, rank, parameters)) = best else {
            continue;
        };
        // Readings without weight count in the freedom but leave no squares; the noise is that of the final model.
        let squares = projection.squares().max(freedom);
        let ln_p = ln_f_test(statistic, squares, rank, freedom);
        if ln_p + f64::from(shapes).ln() >= D::CAUSE_LEVEL.ln() {
            continue;
        }
        projection = projection.extended(&scan.columns(shape));
        again.push(Suspect {
            shape,
            parameters,
            ..suspect.clone()
        });
    }
    (again, projection)
}

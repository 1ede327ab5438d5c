//! The gain on data not used for the fit.
//!
//! Whole sweeps are assigned to folds in advance; each fold is predicted from the others, without the causes and with
//! them. Instants and time constants are sought again in the others ([`sought_again`]). The ratio of the rms has an
//! interval from a bootstrap of sweeps.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_selection::{DECISIVE, Projection, ln_f_test};

use crate::engine::{Measured, Suspect, scan};
use crate::{Gain, HeldOutRatio};

/// Held-out rms without and with the causes in standard deviations of the noise, and the interval of
/// their ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HeldOut {
    pub(crate) before: f64,
    pub(crate) after: f64,
    pub(crate) interval: [f64; 2],
    /// By how much the squares are more with the causes: minus twice the logarithm of the ratio of the likelihoods.
    more: f64,
}

/// Number of readings of a sweep, and its squares without and with the causes.
pub(crate) type Sums = (usize, f64, f64);

/// Number of folds.
pub(crate) const FOLDS: usize = 5;

/// Resamples of the bootstrap: its 95 % interval is then good to a tenth of its width.
const RESAMPLES: usize = 1000;

const SEED: u64 = 0x6865_6c64_2d6f_7574;

impl HeldOut {
    /// From the sums of sweeps.
    pub(crate) fn of(sums: &[Sums]) -> Self {
        let count: usize = sums.iter().map(|s| s.0).sum();
        let rms = |squares: f64| (squares / count as f64).sqrt();
        let squares: Vec<[f64; 2]> = sums.iter().map(|s| [s.1, s.2]).collect();
        let ratios = resampled_ratios(&squares, RESAMPLES, SEED);
        let tail = RESAMPLES / 40;
        Self {
            before: rms(sums.iter().map(|s| s.1).sum()),
            after: rms(sums.iter().map(|s| s.2).sum()),
            interval: [ratios[tail], ratios[RESAMPLES - tail - 1]],
            more: squares.iter().map(|[before, after]| after - before).sum(),
        }
    }

    /// Whether the causes certainly predict worse than nothing. Where few sweeps can show a cause, the ratio may be above one in every draw
    /// by nearly nothing.
    pub(crate) fn is_loss(&self) -> bool {
        self.interval[0] >= 1.0 && self.more > DECISIVE
    }

    /// Whether the causes certainly predict better than nothing.
    pub(crate) fn is_gain(&self) -> bool {
        self.interval[1] < 1.0
    }

    pub(crate) fn ratio(self) -> HeldOutRatio {
        HeldOutRatio {
            ratio: self.after / self.before,
            interval: self.interval,
        }
    }

    /// The gain, with the share of the misfit above the noise that was removed, by the rms `before` and `after`, µm.
    pub(crate) fn gain(self, before_um: f64, after_um: f64, noise_um: f64) -> Gain {
        let excess = before_um.powi(2) - noise_um.powi(2);
        let left = (after_um.powi(2) - noise_um.powi(2)).max(0.0);
        let removed = (1.0 - left / excess).clamp(0.0, 1.0);
        Gain {
            heldout_rms_ratio: self.ratio().ratio,
            interval: self.interval,
            share_of_excess_removed: if excess > 0.0 { removed } else { 0.0 },
            leave_one_station_out: None,
        }
    }
}

/// The square root of the second of two sums divided by the first, for resampled blocks, in ascending order.
pub(crate) fn resampled_ratios(blocks: &[[f64; 2]], draws: usize, seed: u64) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut resampled = || {
        let mut sums = [0.0; 2];
        for _ in blocks {
            let drawn = blocks[generator.random_range(0..blocks.len())];
            sums[0] += drawn[0];
            sums[1] += drawn[1];
        }
        (sums[1] / sums[0]).sqrt()
    };
    let mut ratios: Vec<f64> = (0..draws).map(|_| resampled()).collect();
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
        // Readings without weight count in the freedom but leave no squares; the noise is that of the final model.
        let squares = projection.squares().max(freedom);
        let is_shown = |&(_, statistic, rank, _): &(f64, f64, usize, Vec<f64>)| {
            let ln_p = ln_f_test(statistic, squares, rank, freedom);
            ln_p + f64::from(shapes).ln() < D::CAUSE_LEVEL.ln()
        };
        let Some((shape, _, _, parameters)) = best.filter(is_shown) else {
            continue;
        };
        projection = projection.extended(&scan.columns(shape));
        again.push(Suspect {
            shape,
            parameters,
            ..suspect.clone()
        });
    }
    (again, projection)
}

//! How small the smallest p-value gets when there is nothing but noise.
//!
//! White noise goes through the same projection and the same scans. The smallest p-value `q` of all
//! hypotheses and shapes then behaves as that of `m` independent tests, `P(q < x) = 1 - (1 - x)^m`;
//! the effective number `m` is estimated by maximum likelihood, `1/m = mean of -ln(1 - q)`, so that a
//! few hundred draws give the tail that a level of 1 % needs.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use trueaxis_leastsquares::dot;

use crate::selection::{Projection, Scan, ln_f_test};

/// The null distribution of the smallest p-value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Null {
    /// Effective number of independent tests.
    pub(crate) tests: f64,
}

/// Draws of noise: the effective number of tests is then known to 7 %, the level of 1 % is one between
/// 0.93 and 1.07 %.
const DRAWS: u64 = 200;

const SEED: u64 = 0x7472_7565_6178_6973;

impl Null {
    /// From white noise through the projection and the scans; the same every time.
    pub(crate) fn simulated(projection: &Projection, scans: &[Box<dyn Scan>]) -> Self {
        let smallest = |draw: u64| {
            let mut generator = ChaCha8Rng::seed_from_u64(SEED);
            generator.set_stream(draw);
            let mut noise: Vec<f64> = StandardNormal
                .sample_iter(&mut generator)
                .take(projection.rows())
                .collect();
            projection.project(&mut noise);
            smallest_ln_p(&noise, projection.degrees_of_freedom, scans)
        };
        // Collected in order, so that the sum does not depend on the number of threads.
        let smallest: Vec<f64> = (0..DRAWS).into_par_iter().map(smallest).collect();
        let sum: f64 = smallest.iter().map(|ln_p| -(-ln_p.exp()).ln_1p()).sum();
        Self {
            tests: (DRAWS as f64 / sum.max(f64::MIN_POSITIVE)).max(1.0),
        }
    }

    /// Probability that noise alone gives a p-value as small somewhere.
    pub(crate) fn family_wise(&self, ln_p: f64) -> f64 {
        // 1 - (1 - p)^m without losing small p.
        let ln_none = self.tests * (-ln_p.exp()).ln_1p();
        let some = -ln_none.exp_m1();
        if some > 0.0 {
            some
        } else {
            (ln_p + self.tests.ln()).exp()
        }
    }
}

/// Logarithm of the smallest p-value of all hypotheses and shapes.
pub(crate) fn smallest_ln_p(
    residuals: &[f64],
    degrees_of_freedom: f64,
    scans: &[Box<dyn Scan>],
) -> f64 {
    let squares = dot(residuals, residuals);
    let mut largest: Vec<f64> = Vec::new();
    for scan in scans {
        scan.for_each(residuals, &mut |_, gram, s| {
            let rank = gram.rank();
            if largest.len() <= rank {
                largest.resize(rank + 1, 0.0);
            }
            largest[rank] = largest[rank].max(gram.statistic(s));
        });
    }
    let of_ranks = largest.iter().enumerate();
    of_ranks
        .map(|(rank, &drop)| ln_f_test(drop, squares, rank, degrees_of_freedom))
        .fold(0.0, f64::min)
}

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

use crate::selection::dots::{SIDE_BY_SIDE, SideBySide};
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
        let smallest = |batch: u64| {
            let draws = batch * SIDE_BY_SIDE as u64..DRAWS.min((batch + 1) * SIDE_BY_SIDE as u64);
            let noise = |draw: u64| -> Vec<f64> {
                let mut generator = ChaCha8Rng::seed_from_u64(SEED);
                generator.set_stream(draw);
                StandardNormal
                    .sample_iter(&mut generator)
                    .take(projection.rows())
                    .collect()
            };
            let mut noise: Vec<Vec<f64>> = draws.map(noise).collect();
            projection.project_all(&mut noise);
            smallest_ln_p(&noise, projection.degrees_of_freedom, scans)
        };
        // Collected in order, so that the sum does not depend on the number of threads.
        let batches = (0..DRAWS.div_ceil(SIDE_BY_SIDE as u64)).into_par_iter();
        let smallest: Vec<Vec<f64>> = batches.map(smallest).collect();
        let smallest = smallest.concat();
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

/// Logarithm of the smallest p-value of all hypotheses and shapes for each of some residuals.
fn smallest_ln_p(
    residuals: &[Vec<f64>],
    degrees_of_freedom: f64,
    scans: &[Box<dyn Scan>],
) -> Vec<f64> {
    let side_by_side = SideBySide::new(residuals);
    let mut largest: Vec<[f64; SIDE_BY_SIDE]> = Vec::new();
    for scan in scans {
        scan.for_each_of(&side_by_side, &mut |gram, s| {
            let rank = gram.rank();
            if largest.len() <= rank {
                largest.resize(rank + 1, [0.0; SIDE_BY_SIDE]);
            }
            for (largest, own) in largest[rank].iter_mut().zip(gram.statistics(s)) {
                *largest = largest.max(own);
            }
        });
    }
    let smallest = |(lane, residuals): (usize, &Vec<f64>)| {
        let squares = dot(residuals, residuals);
        let of_ranks = largest.iter().enumerate();
        of_ranks
            .map(|(rank, drops)| ln_f_test(drops[lane], squares, rank, degrees_of_freedom))
            .fold(0.0, f64::min)
    };
    residuals.iter().enumerate().map(smallest).collect()
}

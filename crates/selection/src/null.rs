//! How small the smallest p-value becomes by noise alone.
//!
//! White noise goes through the same projection and the same scans. The smallest p-value `q` of all hypotheses and
//! shapes behaves like that of independent tests whose number grows as `q` falls:
//!
//! ```text
//! P(q < x) = 1 - (1 - x)^m(x)      m(x) = m (2 - ln x)^b
//! ```
//!
//! Neighbouring instants of a jump are tested by nearly the same lengths. They exceed a low threshold together and a
//! high one alone. One number of tests for all thresholds, which the many draws with large `q` would determine, would
//! therefore halve the small p-values. For a statistic of two degrees of freedom that moves like a random walk `b` is
//! 1, for one that is smooth in its shape ½ (R. B. Davies, *Biometrika* 74, 33, 1987; B. James, K. L. James, D.
//! Siegmund, *Biometrika* 74, 71, 1987), for independent tests 0. `m` and `b` are estimated by maximum likelihood, so
//! that a few hundred draws give the tail needed for a level of 1 %. `m(x)` never exceeds the number of all tests
//! (Bonferroni).

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use trueaxis_leastsquares::lane_products::LaneMatrix;
use trueaxis_leastsquares::{LANES, Lanes, dot};

use crate::{Projection, Scan, ln_f_test};

/// The null distribution of the smallest p-value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Null {
    /// `m`.
    tests: f64,
    /// `b`.
    growth: f64,
    /// Number of tests, of all hypotheses and shapes.
    most: f64,
}

/// Draws of noise: they determine the level of 1 % to some 20 %.
const DRAWS: u64 = 200;

/// Batches of draws for which the columns of the scans are read together.
const TOGETHER: usize = 4;
const TOGETHER_DRAWS: u64 = (TOGETHER * LANES) as u64;

/// Largest growth: beyond it `m(x) x` would not increase with x.
const MOST_GROWTH: f64 = 2.0;

/// Growths that are compared, from none to the largest.
const GROWTHS: u32 = 41;

/// Tests are independent, as few tests of few data are, unless growth gains this log-likelihood (Akaike).
const GROWS: f64 = 1.0;

const SEED: u64 = 0x7472_7565_6178_6973;

impl Null {
    /// From white noise through the projection and the scans; it is the same every time.
    pub fn simulated(projection: &Projection, scans: &[Box<dyn Scan>]) -> Self {
        Self::simulated_in(projection, scans, |noise| noise)
    }

    /// As [`Self::simulated`], for rows along vectors that rounding can turn or exchange, such as eigenvectors:
    /// `along` maps noise in fixed directions to the rows.
    pub fn simulated_in(
        projection: &Projection,
        scans: &[Box<dyn Scan>],
        along: impl Fn(Vec<f64>) -> Vec<f64> + Sync,
    ) -> Self {
        let smallest = |first: u64| {
            let draws = first * TOGETHER_DRAWS..DRAWS.min((first + 1) * TOGETHER_DRAWS);
            let noise = |draw: u64| -> Vec<f64> {
                let mut generator = ChaCha8Rng::seed_from_u64(SEED);
                generator.set_stream(draw);
                let white = StandardNormal.sample_iter(&mut generator);
                along(white.take(projection.rows()).collect())
            };
            let mut noise: Vec<Vec<f64>> = draws.map(noise).collect();
            for batch in noise.chunks_mut(LANES) {
                projection.project_all(batch);
            }
            smallest_ln_p(&noise, projection.degrees_of_freedom, scans)
        };
        // Collected in order, so that the sum does not depend on the number of threads.
        let batches = (0..DRAWS.div_ceil(TOGETHER_DRAWS)).into_par_iter();
        let smallest: Vec<Vec<f64>> = batches.map(smallest).collect();
        Self::most_likely(&smallest.concat(), tests_of(scans))
    }

    /// The most likely distribution, by the logarithm of each draw's smallest p-value and the number of tests.
    fn most_likely(smallest: &[f64], tests: usize) -> Self {
        let (count, most) = (smallest.len() as f64, tests as f64);
        let of_growth = |step: u32| {
            let growth = MOST_GROWTH * f64::from(step) / f64::from(GROWTHS - 1);
            let of_one = |ln_p: &f64| -grown(*ln_p, growth) * (-ln_p.exp()).ln_1p();
            let sum: f64 = smallest.iter().map(of_one).sum();
            let tests = count / sum.max(f64::MIN_POSITIVE);
            let slopes = smallest.iter().map(|ln_p| ln_slope(*ln_p, growth));
            let null = Self {
                tests,
                growth,
                most,
            };
            (count * tests.ln() + slopes.sum::<f64>(), null)
        };
        let (of_none, none) = of_growth(0);
        let all = (1..GROWTHS).map(of_growth);
        let best = all.fold((of_none + GROWS, none), |best, next| {
            if next.0 > best.0 { next } else { best }
        });
        best.1
    }

    /// The distribution of independent tests.
    pub fn independent(tests: f64) -> Self {
        Self {
            tests,
            growth: 0.0,
            most: tests,
        }
    }

    /// Effective number of independent tests at this smallest p-value.
    pub fn tests_at(&self, ln_p: f64) -> f64 {
        let tests = self.tests * grown(ln_p, self.growth);
        tests.min(self.most).max(1.0)
    }

    /// Whether noise alone gives a p-value as small somewhere with a probability below `level`, if this holds for any
    /// number of tests from one to the most that [`Null::simulated`] can find.
    pub fn decided(scans: &[Box<dyn Scan>], ln_p: f64, level: f64) -> Option<bool> {
        let at_most = Self::independent(tests_of(scans) as f64).family_wise(ln_p);
        let at_least = Self::independent(1.0).family_wise(ln_p);
        match (at_most < level, at_least >= level) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    }

    /// Probability that noise alone gives a p-value as small somewhere.
    pub fn family_wise(&self, ln_p: f64) -> f64 {
        let tests = self.tests_at(ln_p);
        // 1 - (1 - p)^m without losing small p.
        let some = -(tests * (-ln_p.exp()).ln_1p()).exp_m1();
        if some > 0.0 {
            some
        } else {
            (ln_p + tests.ln()).exp()
        }
    }
}

/// `m(x)` for `m = 1`.
fn grown(ln_p: f64, growth: f64) -> f64 {
    (2.0 - ln_p).powf(growth)
}

/// Logarithm of the derivative of `-ln P(q > x)` by x for `m = 1`: of the density of `q` over `P(q > x)`.
fn ln_slope(ln_p: f64, growth: f64) -> f64 {
    let (p, from) = (ln_p.exp(), 2.0 - ln_p);
    let left = (1.0 - p).max(f64::EPSILON);
    let of_one = 1.0 / left + growth * left.ln() / (from * p);
    growth * from.ln() + of_one.max(f64::MIN_POSITIVE).ln()
}

/// Number of tests of all hypotheses and shapes.
fn tests_of(scans: &[Box<dyn Scan>]) -> usize {
    scans.iter().map(|scan| scan.tests()).sum()
}

/// The logarithm of the smallest p-value over all hypotheses and shapes, for each of some residuals.
fn smallest_ln_p(
    residuals: &[Vec<f64>],
    degrees_of_freedom: f64,
    scans: &[Box<dyn Scan>],
) -> Vec<f64> {
    let (rows, batches) = (
        residuals.first().map_or(0, Vec::len),
        residuals.len().div_ceil(LANES),
    );
    let mut side_by_side = vec![Lanes::ZERO; rows * batches];
    for (draw, residuals) in residuals.iter().enumerate() {
        let lane = side_by_side.iter_mut().skip(draw / LANES).step_by(batches);
        for (row, e) in lane.zip(residuals) {
            row.0[draw % LANES] = *e;
        }
    }
    let side_by_side = LaneMatrix::by_rows(&side_by_side, [rows, batches]);
    // The largest statistic of each rank, batch by batch.
    let mut largest: Vec<Vec<Lanes>> = Vec::new();
    for scan in scans {
        scan.for_each_of(side_by_side, &mut |gram, s| {
            let rank = gram.rank();
            if largest.len() <= rank {
                largest.resize(rank + 1, vec![Lanes::ZERO; batches]);
            }
            for (batch, largest) in largest[rank].iter_mut().enumerate() {
                let own = gram.statistics(s, batch);
                for (largest, own) in largest.0.iter_mut().zip(own.0) {
                    *largest = largest.max(own);
                }
            }
        });
    }
    let smallest = |(draw, residuals): (usize, &Vec<f64>)| {
        let squares = dot(residuals, residuals);
        let of_ranks = largest.iter().enumerate();
        of_ranks
            .map(|(rank, drops)| {
                let drop = drops[draw / LANES].0[draw % LANES];
                ln_f_test(drop, squares, rank, degrees_of_freedom)
            })
            .fold(0.0, f64::min)
    };
    residuals.iter().enumerate().map(smallest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    /// How often the level of 1 % is crossed, relative to that level: mean of 20 fits to 200 draws each, and its
    /// standard uncertainty, which contains the scatter of the draws.
    fn crossed(draws: &[f64], fit: impl Fn(&[f64]) -> Null) -> (f64, f64) {
        let part = |own: &[f64]| {
            let null = fit(own);
            let below = draws.iter().filter(|ln_p| null.family_wise(**ln_p) < 0.01);
            below.count() as f64 / (0.01 * draws.len() as f64)
        };
        let parts: Vec<f64> = draws.chunks(200).take(20).map(part).collect();
        let mean = parts.iter().sum::<f64>() / 20.0;
        let squares = parts.iter().map(|part| (part - mean).powi(2));
        let of_draws = 1.0 / (0.01 * draws.len() as f64);
        (mean, (squares.sum::<f64>() / 380.0 + of_draws).sqrt())
    }

    /// The distribution with one number of tests for all p-values.
    fn one_number(smallest: &[f64]) -> Null {
        let sum: f64 = smallest.iter().map(|ln_p| -(-ln_p.exp()).ln_1p()).sum();
        Null::independent(smallest.len() as f64 / sum)
    }

    /// Four standard uncertainties are exceeded with a probability of 1e-4.
    #[test]
    fn the_level_of_independent_tests_is_met() {
        let mut generator = ChaCha8Rng::seed_from_u64(5);
        let mut smallest = || {
            let none: f64 = generator.random();
            (-(none.ln() / 300.0).exp_m1()).ln()
        };
        let draws: Vec<f64> = (0..100_000).map(|_| smallest()).collect();
        let (part, u) = crossed(&draws, |fit| Null::most_likely(fit, 1000));
        assert!((part - 1.0).abs() < 4.0 * u, "{part} ± {u}");
    }

    /// Two coordinates that move like a random walk of 1,000 steps (Ornstein-Uhlenbeck), as the statistic of a jump
    /// does with its instant.
    #[test]
    fn the_level_of_neighbouring_tests_is_met() {
        let mut generator = ChaCha8Rng::seed_from_u64(6);
        let mut smallest = || {
            let mut normal = || -> f64 { generator.sample(StandardNormal) };
            let mut place = [normal(), normal()];
            let mut largest = 0.0_f64;
            for _ in 0..1000 {
                place = place.map(|x| 0.99 * x + (1.0 - 0.99_f64.powi(2)).sqrt() * normal());
                largest = largest.max(place[0] * place[0] + place[1] * place[1]);
            }
            // The upper tail of χ² with two degrees of freedom.
            -0.5 * largest
        };
        let draws: Vec<f64> = (0..40_000).map(|_| smallest()).collect();
        let (part, u) = crossed(&draws, |fit| Null::most_likely(fit, 1000));
        assert!((part - 1.0).abs() < 4.0 * u, "{part} ± {u}");
        let (part, u) = crossed(&draws, one_number);
        assert!(part - 1.0 > 4.0 * u, "{part} ± {u}");
    }
}

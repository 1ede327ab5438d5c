//! The functions that make up the course of a disturbance.

use std::f64::consts::PI;

use trueaxis_leastsquares::{half_waves, matern_roots};

/// A constant, if there is one, and half waves over a range, all or only part of which the argument covers.
#[derive(Debug, Clone)]
pub(crate) struct Basis {
    has_mean: bool,
    /// Positions in the half waves at which the argument begins and ends.
    ends: [f64; 2],
    /// Means that are taken from the half waves, so that only the constant has a mean.
    means: Vec<f64>,
}

/// Half waves are level at both ends. Warming up is steepest at the beginning, and waves that end there leave a
/// remainder that looks like slips and jumps: therefore they go beyond both ends by an eighth of the measured range.
const BEYOND: [f64; 2] = [0.1, 0.9];

impl Basis {
    /// Half waves that end with the argument, with a constant or without.
    pub(crate) fn within(waves: usize, has_mean: bool) -> Self {
        Self {
            has_mean,
            ends: [0.0, 1.0],
            means: vec![0.0; waves],
        }
    }

    /// Half waves that go beyond the argument, without their means.
    pub(crate) fn beyond(waves: usize) -> Self {
        let [first, last] = BEYOND;
        let mean = |wave: usize| {
            let k = wave as f64 * PI;
            ((k * last).sin() - (k * first).sin()) / (k * (last - first))
        };
        Self {
            has_mean: false,
            ends: BEYOND,
            means: (1..=waves).map(mean).collect(),
        }
    }

    pub(crate) fn has_mean(&self) -> bool {
        self.has_mean
    }

    /// Number of functions.
    pub(crate) fn width(&self) -> usize {
        usize::from(self.has_mean) + self.means.len()
    }

    /// Each function at an argument, 0 to 1.
    pub(crate) fn at(&self, x: f64) -> impl Iterator<Item = f64> {
        let [first, last] = self.ends;
        let waves = half_waves(first + (last - first) * x, self.waves());
        let without_mean = waves.zip(&self.means).map(|(wave, mean)| wave - mean);
        self.has_mean.then_some(1.0).into_iter().chain(without_mean)
    }

    /// `S_k^½` of each function for a correlation length, as a share of the range of the argument.
    pub(crate) fn roots_of_spectrum(&self, length: f64) -> Vec<f64> {
        let [first, last] = self.ends;
        let mut roots = matern_roots(length * (last - first), self.waves());
        if !self.has_mean {
            roots.remove(0);
        }
        roots
    }

    fn waves(&self) -> u32 {
        u32::try_from(self.means.len()).unwrap_or(u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;
    use trueaxis_leastsquares::dense::solve;
    use trueaxis_leastsquares::dot;

    use super::*;

    /// Mean over the range by the midpoint rule, wrong by `(kπ/n)²/24`.
    #[test]
    fn only_the_constant_has_a_mean() {
        let n = 4000;
        for basis in [Basis::within(8, false), Basis::beyond(10)] {
            let mut sums = vec![0.0; basis.width()];
            for i in 0..n {
                let at = basis.at((f64::from(i) + 0.5) / f64::from(n));
                sums.iter_mut().zip(at).for_each(|(sum, x)| *sum += x);
            }
            assert!(
                sums.iter().all(|sum| (sum / f64::from(n)).abs() < 1e-5),
                "{sums:?}"
            );
        }
    }

    /// An exponential that falls to e⁻⁵: waves that end with it leave nineteen times as much of its first tenth.
    #[test]
    fn waves_that_go_beyond_begin_steeply() {
        let n = 400;
        let at = |i: usize| i as f64 / n as f64;
        let rest = |basis: &Basis| {
            let rows = (0..n).flat_map(|i| basis.at(at(i)).chain([1.0]));
            let design = DMatrix::from_row_iterator(n, basis.width() + 1, rows);
            let course: Vec<f64> = (0..n).map(|i| (-5.0 * at(i)).exp()).collect();
            let fit = solve(&design, &course).unwrap();
            let first = &fit.residuals[..n / 10];
            (dot(first, first) / first.len() as f64).sqrt()
        };
        let (within, beyond) = (rest(&Basis::within(8, false)), rest(&Basis::beyond(10)));
        assert!(within > 10.0 * beyond, "{within} {beyond}");
    }
}

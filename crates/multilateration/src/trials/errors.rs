//! Errors of lengths, drawn from the noise that weighs them.
//!
//! With the factor `C = L Lᵀ` of the covariance of one visit's lengths, errors are `e = L z` with
//! standard normal `z`. Most lengths depend on no other one, and `L` is a number.

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use crate::noise::unwhiten_row;

/// Factors of all visits in measuring order.
#[derive(Debug, Clone, Default)]
pub(crate) struct ErrorNoise {
    /// Standard deviation of each reading; one where a factor takes its place.
    sigmas_mm: Vec<f64>,
    correlated: Vec<CorrelatedErrors>,
}

#[derive(Debug, Clone)]
struct CorrelatedErrors {
    first: usize,
    count: usize,
    /// `L`, row by row up to the diagonal.
    factor: Vec<f64>,
}

impl ErrorNoise {
    /// Adds a length that depends on no other one.
    pub(crate) fn push_independent(&mut self, sigma_mm: f64) {
        self.sigmas_mm.push(sigma_mm);
    }

    /// Adds the lengths of a visit that depend on each other.
    pub(crate) fn push_correlated(&mut self, count: usize, factor: &[f64]) {
        let first = self.sigmas_mm.len();
        self.sigmas_mm.resize(first + count, 1.0);
        self.correlated.push(CorrelatedErrors {
            first,
            count,
            factor: factor.to_vec(),
        });
    }

    /// Number of lengths.
    pub(crate) fn readings(&self) -> usize {
        self.sigmas_mm.len()
    }

    /// One error for each reading.
    pub(crate) fn draw<R: Rng + ?Sized>(&self, rng: &mut R, errors_mm: &mut [f64]) {
        for (error, sigma_mm) in errors_mm.iter_mut().zip(&self.sigmas_mm) {
            let normal: f64 = rng.sample(StandardNormal);
            *error = normal * sigma_mm;
        }
        for visit in &self.correlated {
            let errors = &mut errors_mm[visit.first..][..visit.count];
            // From below: each error needs the standard normal numbers up to its own.
            for i in (0..visit.count).rev() {
                let row = unwhiten_row(&visit.factor, i);
                errors[i] = row.iter().zip(&*errors).map(|(l, z)| l * z).sum();
            }
        }
    }
}

/// Whether a visit's lengths depend on each other, by the factor of their covariance.
pub(crate) fn is_correlated(factor: &[f64], count: usize) -> bool {
    let below_diagonal = |i| unwhiten_row(factor, i)[..i].iter();
    (0..count).flat_map(below_diagonal).any(|l| *l != 0.0)
}

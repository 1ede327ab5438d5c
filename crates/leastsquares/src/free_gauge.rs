//! The shared unknowns without a datum: the shortest correction.
//!
//! Where free motions change no observation, all corrections that differ by one of them are as good.
//! An iteration may take any, and the datum can move the result as a whole when it is found: then the
//! constraints of the datum, most of the work of an elimination, are left out of the iteration. With
//! the scaled matrix `N` of the reduced system and an orthonormal basis `G` of the free motions,
//!
//! ```text
//! s = (N + G Gᵀ)⁻¹ g
//! ```
//!
//! is free of them, and `N + G Gᵀ` has an inverse if nothing else is free.

use crate::Error;
use crate::inverse::invert;
use crate::reduced::{Reduced, SHARED_RANK_TOL, dot, orthonormal};

/// A correction of the shared unknowns.
#[derive(Debug, Clone)]
pub struct Correction {
    /// The shortest one, in units in which the matrix has a unit diagonal.
    pub shared: Vec<f64>,
    /// By how much the linear model says that the correction of all unknowns lowers the sum of
    /// squares.
    pub decrease: f64,
}

impl Reduced {
    /// Solves a system without constraints for the shortest `s`, after checking that only
    /// `free_motions` are free: motions that change no observation, their part in the shared unknowns.
    ///
    /// # Errors
    /// [`Error::SharedRank`], [`Error::NotFinite`].
    pub fn shortest_correction(&self, free_motions: &[Vec<f64>]) -> Result<Correction, Error> {
        debug_assert_eq!(self.datum(), 0, "constraints");
        let n = self.shared();
        let (scale, mut inverse) = self.scaled(n)?;
        let motions = orthonormal(free_motions, &scale);
        for motion in &motions {
            for (row, a) in inverse.chunks_exact_mut(n.max(1)).zip(motion) {
                for (x, b) in row.iter_mut().zip(motion) {
                    *x += a * b;
                }
            }
        }
        let inverted = invert(&mut inverse, n);
        if !inverted || !self.rules_out_free(&inverse) {
            self.check_rank(&scale, &motions, motions.len())?;
        }
        if !inverted {
            return Err(Error::NotFinite {
                what: "the inverse of the reduced system",
            });
        }
        let right: Vec<f64> = (0..n)
            .map(|i| scale[i] * self.at(i, self.width()))
            .collect();
        let scaled: Vec<f64> = inverse
            .chunks_exact(n.max(1))
            .map(|row| dot(row, &right))
            .collect();
        let decrease = dot(&scaled, &right) + self.decrease_by_blocks();
        let shared: Vec<f64> = scaled.iter().zip(&scale).map(|(x, s)| x * s).collect();
        if !shared.iter().all(|x| x.is_finite()) {
            return Err(Error::NotFinite {
                what: "the solution of the reduced system",
            });
        }
        Ok(Correction { shared, decrease })
    }

    /// Whether the inverse of the scaled matrix says that nothing is free: a free unit vector that
    /// meets all constraints is taken to less than the limit, so that the norm of the inverse is at
    /// least the limit's reciprocal.
    pub(crate) fn rules_out_free(&self, inverse: &[f64]) -> bool {
        // The largest eigenvalue is not above the sum of all, the number of shared unknowns.
        dot(inverse, inverse).sqrt() * SHARED_RANK_TOL * (self.shared() as f64) < 1.0
    }
}

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
use crate::definite::solve_definite;
use crate::in_widest_registers;
use crate::reduced::{Reduced, finite, orthonormal};

/// A correction of the shared unknowns.
#[derive(Debug, Clone)]
pub struct Correction {
    /// Of all that are as good the shortest one, lengths being measured in units in which the matrix has
    /// a unit diagonal.
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
        debug_assert_eq!(self.datum, 0, "constraints");
        let n = self.shared;
        let (units, mut matrix) = self.in_units(n)?;
        let motions = orthonormal(free_motions, &units);
        let right: Vec<f64> = (0..n)
            .map(|i| units[i] * self.at(i, self.width()))
            .collect();
        let solved = in_widest_registers(
            #[inline(always)]
            || {
                for motion in &motions {
                    for (i, row) in matrix.chunks_exact_mut(n.max(1)).enumerate() {
                        for (x, b) in row[i..].iter_mut().zip(&motion[i..]) {
                            *x += motion[i] * b;
                        }
                    }
                }
                solve_definite(&mut matrix, right)
            },
        );
        if !solved
            .as_ref()
            .is_some_and(|solved| self.rules_out_free(solved.trace_of_inverse))
        {
            self.check_rank(&units, &motions, motions.len())?;
        }
        let solved = solved.ok_or(Error::NotFinite {
            what: "the inverse of the reduced system",
        })?;
        let decrease = solved.square + self.decrease_by_blocks();
        let scaled = solved.solution.iter().zip(&units);
        let shared = finite(scaled.map(|(x, s)| x * s).collect())?;
        Ok(Correction { shared, decrease })
    }
}

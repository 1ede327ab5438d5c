//! The reduced system in the shared unknowns `s` and the datum multipliers `λ`.
//!
//! With `B, r` the rows that are left of the blocks and `R x + C s = c`, `W = R⁻ᵀ H`:
//!
//! ```text
//! [  Σ BᵀB    -Σ CᵀW ] [s]   [ Σ Bᵀr     ]
//! [ -Σ WᵀC    -Σ WᵀW ] [λ] = [ h - Σ Wᵀc ]
//! ```
//!
//! Its inverse is symmetric but indefinite: the datum takes variance away from the blocks.

use faer::linalg::solvers::{DenseSolveCore, Solve};
use faer::{Mat, Side};

use crate::Error;

/// What the observations leave free, and the constraint that fixes it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Datum {
    /// For each constraint a motion that changes no observation: its part in the shared unknowns.
    pub free_motions: Vec<Vec<f64>>,
    /// `h`: what `Σ Hᵀ δx` shall be.
    pub closure: Vec<f64>,
}

/// Sums over all blocks.
#[derive(Debug, Clone)]
pub(crate) struct Reduced {
    shared: usize,
    datum: usize,
    /// The matrix above with contiguous columns; of the symmetric top left part only the upper
    /// triangle, and the datum columns complete.
    matrix: Vec<f64>,
    right_side: Vec<f64>,
    block_squares: f64,
}

/// Solution of the reduced system.
pub(crate) struct ReducedSolution {
    /// `s`, then `λ`.
    pub(crate) unknowns: Vec<f64>,
    /// Inverse of the matrix.
    pub(crate) inverse: Mat<f64>,
    /// Decrease of the sum of squares by `s`.
    pub(crate) decrease: f64,
}

/// Relative eigenvalue of the scaled normal matrix below which a combination of shared unknowns
/// counts as free. Rounding leaves about 1e-15; a combination at the limit would be known a
/// million times worse than the best one, so nothing usable is refused.
const SHARED_RANK_TOL: f64 = 1e-12;

/// An unknown's share in a free combination below which it is not worth a name.
const FREE_SHARE_TOL: f64 = 0.05;

impl Reduced {
    pub(crate) fn new(shared: usize, datum: usize) -> Self {
        let width = shared + datum;
        Self {
            shared,
            datum,
            matrix: vec![0.0; width * width],
            right_side: vec![0.0; width],
            block_squares: 0.0,
        }
    }

    pub(crate) fn shared(&self) -> usize {
        self.shared
    }

    pub(crate) fn datum(&self) -> usize {
        self.datum
    }

    /// `Σ |c|²`: the part of the sum of squares that the blocks take whatever `s` is.
    pub(crate) fn block_squares(&self) -> f64 {
        self.block_squares
    }

    /// Adds rows that are free of block unknowns; `column(shared)` is their residual.
    pub(crate) fn add_rows<'a>(&mut self, column: impl Fn(usize) -> &'a [f64]) {
        let width = self.shared + self.datum;
        for k in 0..self.shared {
            let b_k = column(k);
            for j in 0..=k {
                self.matrix[k * width + j] += dot(column(j), b_k);
            }
            self.right_side[k] += dot(b_k, column(self.shared));
        }
    }

    /// Adds a block's part of the datum: `C` by columns, `W` and `c`.
    pub(crate) fn add_datum<'a>(
        &mut self,
        coupling: impl Fn(usize) -> &'a [f64],
        weighted_datum: &[f64],
        offset: &[f64],
    ) {
        let (width, n) = (self.shared + self.datum, offset.len());
        self.block_squares += dot(offset, offset);
        for (j, w_j) in weighted_datum.chunks_exact(n).enumerate() {
            let row = self.shared + j;
            for k in 0..self.shared {
                self.matrix[row * width + k] -= dot(coupling(k), w_j);
            }
            for (k, w_k) in weighted_datum.chunks_exact(n).take(j + 1).enumerate() {
                self.matrix[row * width + self.shared + k] -= dot(w_k, w_j);
            }
            self.right_side[row] -= dot(w_j, offset);
        }
    }

    /// Solves for `s` and `λ` after checking that only the datum's motions are free.
    pub(crate) fn solve(&self, datum: &Datum) -> Result<ReducedSolution, Error> {
        let width = self.shared + self.datum;
        let at = |i: usize, j: usize| {
            let (low, high) = (i.min(j), i.max(j));
            self.matrix[high * width + low]
        };
        if width == 0 {
            let inverse = Mat::zeros(0, 0);
            return Ok(ReducedSolution {
                unknowns: Vec::new(),
                inverse,
                decrease: 0.0,
            });
        }
        if !self
            .matrix
            .iter()
            .chain(&self.right_side)
            .chain(&datum.closure)
            .all(|x| x.is_finite())
        {
            return Err(Error::NotFinite {
                what: "the reduced system",
            });
        }
        // Unit diagonal: unknowns of different units become comparable.
        let scale: Vec<f64> = (0..width)
            .map(|i| match at(i, i).abs().sqrt() {
                s if s > 0.0 => 1.0 / s,
                _ => 1.0,
            })
            .collect();
        let scaled = Mat::from_fn(width, width, |i, j| scale[i] * at(i, j) * scale[j]);
        self.check_rank(&scaled, &scale, datum)?;

        let lu = scaled.partial_piv_lu();
        let right = Mat::from_fn(width, 1, |i, _| {
            let h = if i < self.shared {
                0.0
            } else {
                datum.closure[i - self.shared]
            };
            scale[i] * (self.right_side[i] + h)
        });
        let solution = lu.solve(&right);
        let unknowns: Vec<f64> = (0..width).map(|i| scale[i] * solution[(i, 0)]).collect();
        let inverse = lu.inverse();
        let symmetric = Mat::from_fn(width, width, |i, j| {
            0.5 * scale[i] * (inverse[(i, j)] + inverse[(j, i)]) * scale[j]
        });
        if !unknowns.iter().all(|x| x.is_finite()) {
            return Err(Error::NotFinite {
                what: "the solution of the reduced system",
            });
        }
        let decrease = dot(&unknowns[..self.shared], &self.right_side[..self.shared]);
        Ok(ReducedSolution {
            unknowns,
            inverse: symmetric,
            decrease,
        })
    }

    fn check_rank(&self, scaled: &Mat<f64>, scale: &[f64], datum: &Datum) -> Result<(), Error> {
        let shared = scaled.as_ref().submatrix(0, 0, self.shared, self.shared);
        let eigen = shared
            .self_adjoint_eigen(Side::Lower)
            .map_err(|_| Error::Decomposition {
                what: "eigenvalue decomposition",
            })?;
        let values = eigen.S().column_vector();
        let largest = (0..self.shared).fold(0.0_f64, |max, i| max.max(values[i]));
        let limit = SHARED_RANK_TOL;
        let free: Vec<usize> = (0..self.shared)
            .filter(|&i| values[i] <= limit * largest)
            .collect();
        if free.len() <= self.datum {
            return Ok(());
        }
        // Shares of the unknowns in what is free beyond the datum's own motions.
        let motions = orthonormal(
            datum
                .free_motions
                .iter()
                .map(|motion| motion.iter().zip(scale).map(|(m, s)| m / s).collect()),
        );
        let mut shares = vec![0.0; self.shared];
        for &i in &free {
            let mut vector: Vec<f64> = (0..self.shared).map(|k| eigen.U()[(k, i)]).collect();
            for motion in &motions {
                remove(&mut vector, motion);
            }
            for (share, v) in shares.iter_mut().zip(&vector) {
                *share += v * v;
            }
        }
        let total: f64 = shares.iter().sum();
        let mut named: Vec<(usize, f64)> = shares
            .iter()
            .enumerate()
            .map(|(k, share)| (k, share / total))
            .filter(|&(_, share)| share > FREE_SHARE_TOL)
            .collect();
        named.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let eigenvalue = free
            .iter()
            .fold(0.0_f64, |max, &i| max.max(values[i] / largest));
        let defect = free.len() - self.datum;
        Err(Error::SharedRank {
            defect,
            eigenvalue,
            limit,
            free: named,
        })
    }
}

fn orthonormal(vectors: impl Iterator<Item = Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut vector in vectors {
        for other in &basis {
            remove(&mut vector, other);
        }
        let length = dot(&vector, &vector).sqrt();
        if length > 0.0 {
            vector.iter_mut().for_each(|v| *v /= length);
            basis.push(vector);
        }
    }
    basis
}

fn remove(vector: &mut [f64], unit: &[f64]) {
    let along = dot(vector, unit);
    for (v, u) in vector.iter_mut().zip(unit) {
        *v -= along * u;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

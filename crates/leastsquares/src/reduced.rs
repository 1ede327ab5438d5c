//! The reduced system in the shared unknowns `s` and the datum multipliers `λ`.
//!
//! With what the elimination of the blocks leaves ([`crate::BlockBatch`]):
//!
//! ```text
//! [ Σ (BᵀB - WᵀW)   -Σ WᵀW_H  ] [s]   [ Σ (Bᵀr - Wᵀc) ]
//! [   -Σ W_HᵀW      -Σ W_HᵀW_H] [λ] = [ h - Σ W_Hᵀc   ]
//! ```
//!
//! Its inverse is symmetric but indefinite: the datum takes variance away from the blocks.
//!
//! Sums of any blocks can be made on their own and added up afterwards, so that several threads
//! can make them; the same parts added in the same order give the same bits.
//!
//! A combination of shared unknowns counts as free if the scaled matrix has an eigenvalue below
//! [`SHARED_RANK_TOL`]. Eigenvalues cost more than all the rest, so they are looked at only if the
//! inverse does not rule it out ([`Reduced::rules_out_free`]).

use nalgebra::{DMatrix, DVector};

use crate::Error;
use crate::dense::symmetric_eigen;
use crate::dot::dot;

/// Sums over some or all blocks.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// Number of shared unknowns, and of constraints.
    pub(crate) shared: usize,
    pub(crate) datum: usize,
    /// Rows of the matrix above, bordered by the right side as last column; of the symmetric part
    /// the upper triangle.
    matrix: Vec<f64>,
    /// Sum of squares of the whitened residuals, `Σ|r|²`.
    pub(crate) squares: f64,
    /// Number of rows, and of unknowns of blocks.
    pub(crate) observations: usize,
    block_unknowns: usize,
}

/// Solution of the reduced system.
#[derive(Debug, Clone)]
pub struct ReducedSolution {
    pub(crate) shared: usize,
    /// `s`, then `λ`.
    pub unknowns: Vec<f64>,
    /// Symmetric inverse of the matrix.
    pub(crate) inverse: DMatrix<f64>,
}

/// Relative eigenvalue of the scaled normal matrix below which a combination of shared unknowns
/// counts as free. Rounding leaves about 1e-15; a combination at the limit would be known a
/// million times worse than the best one, so nothing usable is refused.
const SHARED_RANK_TOL: f64 = 1e-12;

/// An unknown's share in a free combination below which it is not worth a name.
const FREE_SHARE_TOL: f64 = 0.05;

impl Reduced {
    /// Zero sums.
    pub fn new(shared: usize, datum: usize) -> Self {
        let width = shared + datum + 1;
        Self::from_sums(shared, datum, vec![0.0; width * width])
    }

    pub(crate) fn from_sums(shared: usize, datum: usize, matrix: Vec<f64>) -> Self {
        Self {
            shared,
            datum,
            matrix,
            squares: 0.0,
            observations: 0,
            block_unknowns: 0,
        }
    }

    /// Number of unknowns, blocks and shared.
    pub(crate) fn unknowns(&self) -> usize {
        self.block_unknowns + self.shared
    }

    /// Counts rows, unknowns of blocks, and their part of the sum of squares.
    pub(crate) fn count(&mut self, observations: usize, block_unknowns: usize, squares: f64) {
        self.observations += observations;
        self.block_unknowns += block_unknowns;
        self.squares += squares;
    }

    /// Adds a whitened row that holds shared unknowns alone, with its derivatives by those of some columns,
    /// ascending: what is known of them beforehand.
    pub fn observe(&mut self, columns: &[(usize, f64)], residual: f64) {
        let width = self.width() + 1;
        for (n, &(i, derivative)) in columns.iter().enumerate() {
            let row = &mut self.matrix[i * width..][..width];
            for &(j, other) in &columns[n..] {
                row[j] += derivative * other;
            }
            row[width - 1] += derivative * residual;
        }
        self.count(1, 0, residual * residual);
    }

    /// Adds the sums of other blocks.
    pub fn merge(&mut self, other: &Self) {
        for (m, o) in self.matrix.iter_mut().zip(&other.matrix) {
            *m += o;
        }
        self.count(other.observations, other.block_unknowns, other.squares);
    }

    /// Solves for `s` and `λ` after checking that only the datum's motions are free.
    /// `free_motions` are motions that change no observation, their part in the shared unknowns, one
    /// for each constraint; they only serve to name what is free beyond them.
    ///
    /// # Errors
    /// [`Error::SharedRank`], [`Error::NotFinite`].
    pub fn solve(
        &self,
        free_motions: impl FnOnce() -> Vec<Vec<f64>>,
    ) -> Result<ReducedSolution, Error> {
        let width = self.width();
        let (units, upper) = self.in_units(width)?;
        // The rows of the upper triangle are the columns of the lower one.
        let mut matrix = DMatrix::from_vec(width, width, upper);
        matrix.fill_upper_triangle_with_lower_triangle();
        let inverse = matrix.lu().try_inverse();
        // The norm of a matrix is not below its largest eigenvalue.
        if !inverse
            .as_ref()
            .is_some_and(|inverse| self.rules_out_free(inverse.norm()))
        {
            let motions = orthonormal(&free_motions(), &units);
            self.check_rank(&units, &motions, self.datum)?;
        }
        let inverse = inverse.ok_or(Error::NotFinite {
            what: "the inverse of the reduced system",
        })?;
        let units = DVector::from_vec(units);
        let inverse = 0.5 * (&inverse + inverse.transpose());
        let inverse = inverse.component_mul(&(&units * units.transpose()));
        let right = DVector::from_fn(width, |i, _| self.at(i, width));
        let unknowns = finite((&inverse * right).data.into())?;
        Ok(ReducedSolution {
            shared: self.shared,
            unknowns,
            inverse,
        })
    }

    /// Number of shared unknowns and constraints.
    pub(crate) fn width(&self) -> usize {
        self.shared + self.datum
    }

    /// Element of the bordered matrix.
    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        self.matrix[i.min(j) * (self.width() + 1) + i.max(j)]
    }

    /// What the blocks take off the sum of squares whatever `s` is, `Σ|c|²`.
    pub(crate) fn decrease_by_blocks(&self) -> f64 {
        -self.at(self.width(), self.width())
    }

    /// The first `n` rows and columns of the matrix with unit diagonal, which makes unknowns of
    /// different units comparable, and the units for it; of the matrix the upper triangle.
    pub(crate) fn in_units(&self, n: usize) -> Result<(Vec<f64>, Vec<f64>), Error> {
        if !self.matrix.iter().all(|x| x.is_finite()) {
            return Err(Error::NotFinite {
                what: "the reduced system",
            });
        }
        let units: Vec<f64> = (0..n)
            .map(|i| match self.at(i, i).abs().sqrt() {
                s if s > 0.0 => 1.0 / s,
                _ => 1.0,
            })
            .collect();
        let mut matrix = vec![0.0; n * n];
        let rows = self.matrix.chunks_exact(self.width() + 1);
        for ((i, row), scaled) in rows.enumerate().zip(matrix.chunks_exact_mut(n.max(1))) {
            for ((x, m), s) in scaled[i..].iter_mut().zip(&row[i..]).zip(&units[i..]) {
                *x = units[i] * m * s;
            }
        }
        Ok((units, matrix))
    }

    /// Whether the inverse of that matrix, of which no eigenvalue is above `largest`, says that
    /// nothing is free: a free unit vector that meets all constraints is taken to less than the limit,
    /// so that the inverse has an eigenvalue of at least the limit's reciprocal.
    pub(crate) fn rules_out_free(&self, largest: f64) -> bool {
        // The largest eigenvalue of the matrix is not above the sum of all, the number of shared unknowns.
        largest * SHARED_RANK_TOL * (self.shared as f64) < 1.0
    }

    /// Checks that no more than `expected` combinations of the shared unknowns are free; `motions`,
    /// an orthonormal basis, are those that may be.
    pub(crate) fn check_rank(
        &self,
        units: &[f64],
        motions: &[Vec<f64>],
        expected: usize,
    ) -> Result<(), Error> {
        let scaled = DMatrix::from_fn(self.shared, self.shared, |i, j| {
            units[i] * self.at(i, j) * units[j]
        });
        let eigen = symmetric_eigen(scaled)?;
        let (values, vectors) = (eigen.eigenvalues, eigen.eigenvectors);
        let largest = values.iter().copied().fold(0.0, f64::max);
        let limit = SHARED_RANK_TOL;
        let free: Vec<usize> = (0..self.shared)
            .filter(|&i| values[i] <= limit * largest)
            .collect();
        if free.len() <= expected {
            return Ok(());
        }
        // Shares of the unknowns in what is free beyond the motions.
        let mut shares = vec![0.0; self.shared];
        for &i in &free {
            let mut vector = vectors.column(i).as_slice().to_vec();
            for motion in motions {
                remove(&mut vector, motion);
            }
            for (share, v) in shares.iter_mut().zip(&vector) {
                *share += v * v;
            }
        }
        let total: f64 = shares.iter().sum();
        let shares = shares.iter().map(|share| share / total).enumerate();
        let mut named: Vec<(usize, f64)> = shares.filter(|x| x.1 > FREE_SHARE_TOL).collect();
        named.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let eigenvalues = free.iter().map(|&i| values[i] / largest);
        Err(Error::SharedRank {
            defect: free.len() - expected,
            eigenvalue: eigenvalues.fold(0.0, f64::max),
            limit,
            free: named,
        })
    }
}

/// What is left of a motion after those before it, relative to its length, below which it depends on
/// them: it would be rounding.
const DEPENDENT_MOTION: f64 = 1e-9;

/// An orthonormal basis of motions, in units in which the matrix has a unit diagonal.
pub(crate) fn orthonormal(motions: &[Vec<f64>], units: &[f64]) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(motions.len());
    for motion in motions {
        let mut vector: Vec<f64> = motion.iter().zip(units).map(|(m, s)| m / s).collect();
        let before = dot(&vector, &vector).sqrt();
        // Once more takes away what rounding has left of the others.
        for _ in 0..2 {
            for other in &basis {
                remove(&mut vector, other);
            }
        }
        let length = dot(&vector, &vector).sqrt();
        if length > DEPENDENT_MOTION * before {
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

/// A solution, if it is finite.
pub(crate) fn finite(solution: Vec<f64>) -> Result<Vec<f64>, Error> {
    match solution.iter().all(|x| x.is_finite()) {
        true => Ok(solution),
        false => Err(Error::NotFinite {
            what: "the solution of the reduced system",
        }),
    }
}

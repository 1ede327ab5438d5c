//! What the lengths' own noise alone does to the adjusted unknowns.
//!
//! The noise of a length is the laser's and the machine's return, `C = C_l + C_m`; the weights stay
//! those of `C`. With the whitened part `V = L⁻¹ C_l L⁻ᵀ` of each visit and the factors of
//! [`crate::influence`], the errors that it makes are
//!
//! ```text
//! dp_i = ξ_i - Z_i t     ξ_i = R⁻¹ Oᵀ e_i     t = Σ Σ_i T_iᵀ e_i
//! cov(ξ_i) = R⁻¹ Oᵀ V O R⁻ᵀ     cov(ξ_i, Tᵀe) = R⁻¹ Oᵀ V T = N_i     cov(Tᵀe) = Σ_i Tᵀ V T = M
//! ```
//!
//! Written with doubled couplings `[Z N]` this has the form of the whole covariance:
//!
//! ```text
//! cov(dp_i, dp_k) = [i = k] cov(ξ_i) + [Z_i N_i] S [Z_k N_k]ᵀ     S = | ΣMΣ  -Σ |
//!                                                                     | -Σ    0 |
//! ```
//!
//! The machine's part is the rest.

use faer::Mat;
use nalgebra::DMatrix;
use rayon::prelude::*;

use crate::influence::Influence;
use crate::visit_terms::VisitTerms;
use crate::{Network, Solution};
use trueaxis_leastsquares::row_products::{
    add_symmetric_product, add_transposed_product, append_product, mirror,
};

/// Covariance of points and stations for the lengths' own noise alone, mm².
pub struct LengthNoise<'a> {
    influence: Influence<'a>,
    shared: Mat<f64>,
}

/// The points' part of [`LengthNoise`]: memory that serves one group after the other.
#[derive(Default)]
pub struct GroupNoise {
    /// Covariance of the points with all stations held (3 rows and columns each), mm².
    pub own: DMatrix<f64>,
    /// `[Z N]`: twice as many columns as [`trueaxis_leastsquares::Covariance::coupling`] has.
    pub coupling: DMatrix<f64>,
    memory: Memory,
}

impl Solution {
    /// What the lengths' own noise alone does to the unknowns; `network` must be the one that was
    /// solved.
    pub fn length_noise<'a>(&'a self, network: &'a Network) -> LengthNoise<'a> {
        let influence = Influence::new(network, self);
        let width = influence.width();
        let groups = influence.groups();
        let parts: Vec<Vec<f64>> = (0..groups.div_ceil(PIECE))
            .into_par_iter()
            .map(|piece| {
                let mut sum = vec![0.0; width * width];
                let mut memory = Memory::default();
                for group in piece * PIECE..groups.min((piece + 1) * PIECE) {
                    let Memory {
                        terms, part, times, ..
                    } = &mut memory;
                    influence.visits(group, terms);
                    times.clear();
                    part.append_times(&influence, group, terms.shared_rows(), width, times);
                    add_symmetric_product(&mut sum, terms.shared_rows(), times, width);
                }
                mirror(&mut sum, width);
                sum
            })
            .collect();
        let mut middle = Mat::<f64>::zeros(width, width);
        for part in parts {
            for i in 0..width {
                for j in 0..width {
                    middle[(i, j)] += part[i * width + j];
                }
            }
        }
        let sigma = influence.reduced_inverse();
        let mut shared = Mat::zeros(2 * width, 2 * width);
        shared
            .submatrix_mut(0, 0, width, width)
            .copy_from(sigma * &middle * sigma);
        for (row, column) in [(0, width), (width, 0)] {
            shared
                .submatrix_mut(row, column, width, width)
                .copy_from(-sigma.to_owned());
        }
        LengthNoise { influence, shared }
    }
}

impl LengthNoise<'_> {
    /// What the lengths' own noise does to the points of a group.
    pub fn group(&self, group: usize, noise: &mut GroupNoise) {
        let influence = &self.influence;
        let covariance = influence.covariance();
        let GroupNoise {
            own,
            coupling,
            memory,
        } = noise;
        influence.visits(group, &mut memory.terms);
        let terms = &memory.terms;
        let (unknowns, width) = (terms.own_width(), influence.width());
        // R⁻ᵀ with contiguous rows.
        let factor = covariance.inverse_factor_columns(group);
        // O R⁻ᵀ and V O R⁻ᵀ.
        let (rows, times) = (&mut memory.rows, &mut memory.times);
        rows.clear();
        append_product(rows, terms.own_rows(), factor, [unknowns; 2]);
        times.clear();
        memory
            .part
            .append_times(influence, group, rows, unknowns, times);
        own.resize_mut(unknowns, unknowns, 0.0);
        own.fill(0.0);
        add_transposed_product(own.as_mut_slice(), times, rows, [unknowns; 2]);
        // Columns of [Z N]; those of N are the rows of Tᵀ V O R⁻ᵀ.
        coupling.resize_mut(unknowns, 2 * width, 0.0);
        let (z, n) = coupling.as_mut_slice().split_at_mut(width * unknowns);
        z.copy_from_slice(covariance.coupling_columns(group));
        n.fill(0.0);
        add_transposed_product(n, terms.shared_rows(), times, [width, unknowns]);
    }

    /// `S`: covariance of the shared sources. The first of them are the stations (x y z L each);
    /// the whole makes sense only between couplings.
    pub fn shared(&self) -> &Mat<f64> {
        &self.shared
    }
}

/// Groups that one thread takes at a time.
const PIECE: usize = 256;

/// Memory to work in.
#[derive(Default)]
struct Memory {
    terms: VisitTerms,
    part: LengthPart,
    rows: Vec<f64>,
    times: Vec<f64>,
}

/// `V = L⁻¹ diag(σ_l²) L⁻ᵀ` of one visit: memory to work in.
#[derive(Default)]
pub(crate) struct LengthPart {
    unit: Vec<f64>,
    part: Vec<f64>,
}

impl LengthPart {
    /// `V` of a visit with `count` readings, rows contiguous.
    pub(crate) fn of(&mut self, influence: &Influence<'_>, visit: usize, count: usize) -> &[f64] {
        let Self { unit, part } = self;
        part.clear();
        part.resize(count * count, 0.0);
        let readings = influence.network().visits[visit].readings.clone();
        for (i, reading) in readings.enumerate() {
            influence.unit_error_into(visit, count, i, unit);
            let variance = influence.length_sigma_mm(visit, reading).powi(2);
            for (row, u) in part.chunks_exact_mut(count).zip(&*unit) {
                for (v, other) in row.iter_mut().zip(&*unit) {
                    *v += variance * u * other;
                }
            }
        }
        part
    }

    /// Appends `V X` to `out`, visit after visit of a group, for rows of `columns` elements.
    fn append_times(
        &mut self,
        influence: &Influence<'_>,
        group: usize,
        mut rows: &[f64],
        columns: usize,
        out: &mut Vec<f64>,
    ) {
        for &visit in influence.model().visits_of(group) {
            let count = influence.network().visits[visit].readings.len();
            let (own, rest) = rows.split_at(count * columns);
            append_product(out, self.of(influence, visit, count), own, [count, columns]);
            rows = rest;
        }
    }
}

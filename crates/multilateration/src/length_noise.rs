//! What the lengths' own noise alone does to the adjusted unknowns.
//!
//! The noise of a length is the laser's and the machine's return, `C = C_l + C_m`; the weights stay
//! those of `C`. With the whitened part `V = L⁻¹ C_l L⁻ᵀ` of each visit and the factors of
//! [`crate::batch_influence`], the errors that it makes are
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

use std::ops::Range;

use faer::Mat;
use trueaxis_leastsquares::lane_products::{LaneMatrix, add_product, add_symmetric_product};
use trueaxis_leastsquares::row_products::mirror;
use trueaxis_leastsquares::{Lanes, in_widest_registers, zeros};

use crate::batch_influence::{BatchInfluence, BatchRows};
use crate::batches::Batch;
use crate::free_adjustment::FreeAdjustment;
use crate::free_points::State;
use crate::{Network, Solution};

/// Covariance of points and stations for the lengths' own noise alone, mm².
pub struct LengthNoise<'a> {
    influence: BatchInfluence<'a, FreeAdjustment<'a>, State>,
    shared: Mat<f64>,
}

/// The points' part of [`LengthNoise`] for the groups of a batch, one in each lane: memory that serves one
/// batch after the other. Lanes behind the last group have no meaning.
#[derive(Debug, Default)]
pub struct BatchNoise {
    /// Covariance of the points with all stations held (3 rows and columns each, rows one after the
    /// other), mm².
    pub own: Vec<Lanes>,
    /// `[Z N]`, rows one after the other: twice as many columns as
    /// [`trueaxis_leastsquares::Covariance::coupling`] has.
    pub coupling: Vec<Lanes>,
    rows: BatchRows,
    /// `O R⁻ᵀ`.
    errors: Vec<Lanes>,
    memory: PartMemory,
    /// `N`.
    mixed: Vec<Lanes>,
}

impl Solution {
    /// What the lengths' own noise alone does to the unknowns; `network` must be the one that was
    /// solved.
    pub fn length_noise<'a>(&'a self, network: &'a Network) -> LengthNoise<'a> {
        let influence = BatchInfluence::new(network, self);
        let width = influence.width();
        let parts = influence.of_pieces(
            #[inline(always)]
            |piece, rows| {
                let mut sum = vec![Lanes::ZERO; width * width];
                let mut memory = PartMemory::default();
                for b in piece {
                    influence.fill(b, rows);
                    let (batch, shared) = (&influence.batches()[b], rows.hat.shared());
                    let part = memory.part_of(shared, batch, rows);
                    add_symmetric_product(&mut sum, shared.transposed(), part);
                }
                let mut sum: Vec<f64> = sum.into_iter().map(Lanes::sum).collect();
                mirror(&mut sum, width);
                sum
            },
        );
        let mut middle = Mat::<f64>::zeros(width, width);
        for part in parts {
            for i in 0..width {
                for j in 0..width {
                    middle[(i, j)] += part[i * width + j];
                }
            }
        }
        let sigma = self.covariance.reduced_inverse();
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
    /// What the lengths' own noise does to the points of these groups, which must be those of a batch
    /// ([`crate::batches_of_groups`]).
    ///
    /// # Panics
    /// If they are not.
    pub fn batch(&self, groups: &Range<usize>, noise: &mut BatchNoise) {
        let batches = self.influence.batches();
        let b = batches.partition_point(|batch| batch.groups.start < groups.start);
        assert_eq!(&batches[b].groups, groups, "groups of a batch");
        in_widest_registers(
            #[inline(always)]
            || self.fill(b, noise),
        );
    }

    #[inline(always)]
    fn fill(&self, b: usize, noise: &mut BatchNoise) {
        let BatchNoise {
            own,
            coupling,
            rows,
            errors,
            memory,
            mixed,
        } = noise;
        self.influence.fill(b, rows);
        let (batch, width) = (&self.influence.batches()[b], self.influence.width());
        let (count, unknowns) = (batch.slots(), rows.hat.own().columns());
        let factors = rows.hat.factors();
        zeros(errors, count * unknowns);
        let factor = factors.inverse_factor();
        add_product(errors, rows.hat.own(), factor.transposed());
        let of_points = LaneMatrix::by_rows(errors, [count, unknowns]);
        let part = memory.part_of(of_points, batch, rows).transposed();
        zeros(own, unknowns * unknowns);
        add_product(own, part, of_points);
        zeros(mixed, unknowns * width);
        add_product(mixed, part, rows.hat.shared());
        coupling.clear();
        for i in 0..unknowns {
            coupling.extend_from_slice(factors.coupling().row(i));
            coupling.extend_from_slice(&mixed[i * width..(i + 1) * width]);
        }
    }

    /// `S`: covariance of the shared sources. The first of them are the stations (x y z L each);
    /// the whole makes sense only between couplings.
    pub fn shared(&self) -> &Mat<f64> {
        &self.shared
    }
}

/// Memory for the lengths' own part of the noise.
#[derive(Debug, Default)]
struct PartMemory {
    /// `V` of a visit.
    part: Vec<Lanes>,
    /// `V X`.
    part_of: Vec<Lanes>,
}

impl PartMemory {
    /// `V X`, visit after visit, for the rows `X` of a batch.
    #[inline(always)]
    fn part_of(&mut self, x: LaneMatrix<'_>, batch: &Batch, rows: &BatchRows) -> LaneMatrix<'_> {
        let columns = x.columns();
        zeros(&mut self.part_of, batch.slots() * columns);
        for visit in rows.visits(batch) {
            let slots = visit.slots.clone();
            visit.fill_length_part(rows, &mut self.part);
            let part = LaneMatrix::by_rows(&self.part, [slots.len(); 2]);
            let product = &mut self.part_of[slots.start * columns..slots.end * columns];
            add_product(product, part, x.part(slots));
        }
        LaneMatrix::by_rows(&self.part_of, [batch.slots(), columns])
    }
}

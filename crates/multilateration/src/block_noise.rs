//! The errors of the adjusted groups: a part of its own for each, and one through what all share.
//!
//! ```text
//! cov(x_i, x_k) = [i = k] D_i + Z_i S Z_kᵀ
//! ```
//!
//! For the whole noise this is the covariance that the adjustment left. The noise of a length is the sum of the
//! laser's and the machine's repeatability, `C = C_l + C_m`. For the laser's part alone the weights remain those of
//! `C`; with its whitened part `V = L⁻¹ C_l L⁻ᵀ` of each visit and the factors of [`crate::batch_influence`] the
//! errors are
//!
//! ```text
//! dx_i = ξ_i - Z_i t     ξ_i = R⁻¹ Oᵀ e_i     t = Σ Σ_i T_iᵀ e_i
//! cov(ξ_i) = R⁻¹ Oᵀ V O R⁻ᵀ     cov(ξ_i, Tᵀe) = R⁻¹ Oᵀ V T = N_i     cov(Tᵀe) = Σ_i Tᵀ V T = M
//! ```
//!
//! Written with doubled couplings `[Z N]` this has the same form:
//!
//! ```text
//! cov(dx_i, dx_k) = [i = k] cov(ξ_i) + [Z_i N_i] S [Z_k N_k]ᵀ     S = | ΣMΣ  -Σ |
//!                                                                     | -Σ    0 |
//! ```

use nalgebra::{DMatrix, DVector};
use trueaxis_leastsquares::lane_products::{LaneMatrix, add_product, add_symmetric_product};
use trueaxis_leastsquares::{BatchFactors, Covariance, Factors, Lanes, zeros};

use crate::batch_influence::{BatchInfluence, BatchRows};
use crate::batches::Batch;
use crate::{Network, Solution};

/// Covariance of all groups and of what they share, mm and rad: see [`Solution::noise`] and
/// [`Solution::length_noise`].
#[derive(Debug, Clone)]
pub struct BlockNoise<'a> {
    covariance: &'a Covariance,
    /// `cov(ξ)` and `N` of each group, in the places of `R⁻¹` and `Z`; `None` for the whole noise.
    of_lengths: Option<Factors>,
    shared: DMatrix<f64>,
}

impl Solution {
    /// The whole noise: both parts, as given to the adjustment.
    pub fn noise(&self) -> BlockNoise<'_> {
        BlockNoise {
            covariance: &self.covariance,
            of_lengths: None,
            shared: self.covariance.reduced_inverse().clone(),
        }
    }

    /// The part of the covariance of the shared sources that the uncertainty of what is known beside the lengths
    /// causes: `Σ KᵀK Σ` for whitened rows `K`. `network` must be the one that was solved.
    pub fn known_noise(&self, network: &Network) -> DMatrix<f64> {
        let sigma = self.covariance.reduced_inverse();
        let width = sigma.ncols();
        let mut known = DMatrix::zeros(width, width);
        for row in self.known_rows(network) {
            let mut through = DVector::zeros(width);
            for (column, derivative) in row.columns {
                through.axpy(derivative, &sigma.column(column), 1.0);
            }
            known.ger(1.0, &through, &through, 1.0);
        }
        known
    }

    /// The lengths' own noise alone, without the machine's repeatability; `network` must be the one that was
    /// solved.
    pub fn length_noise(&self, network: &Network) -> BlockNoise<'_> {
        let influence = BatchInfluence::new(network, self);
        let width = influence.width();
        let batches = influence.batches();
        let parts = influence.of_chunks(
            #[inline(always)]
            |chunk, rows| {
                let mut memory = PartMemory::default();
                let mut sum = vec![Lanes::ZERO; width * width];
                let unknowns = batches[chunk.clone()].iter().map(Batch::unknowns);
                let mut blocks = Factors::with_room(width, unknowns);
                for b in chunk {
                    influence.fill(b, rows);
                    let (batch, shared) = (&batches[b], rows.hat.shared());
                    let part = memory.part_of(shared, batch, rows);
                    add_symmetric_product(&mut sum, shared.transposed(), part);
                    let of_batch = (&*rows, influence.factors(b));
                    add_blocks(batch, of_batch, &mut memory, &mut blocks);
                }
                let sum = sum.into_iter().map(Lanes::sum);
                (DMatrix::from_row_iterator(width, width, sum), blocks)
            },
        );
        let mut middle = DMatrix::zeros(width, width);
        let mut blocks = Factors::default();
        for (sum, of_chunk) in parts {
            middle += sum;
            blocks.append(of_chunk);
        }
        middle.fill_lower_triangle_with_upper_triangle();
        let sigma = influence.sigma();
        let mut shared = DMatrix::zeros(2 * width, 2 * width);
        let size = (width, width);
        shared
            .view_mut((0, 0), size)
            .copy_from(&(sigma * middle * sigma));
        shared.view_mut((0, width), size).copy_from(&-sigma);
        shared.view_mut((width, 0), size).copy_from(&-sigma);
        BlockNoise {
            covariance: &self.covariance,
            of_lengths: Some(blocks),
            shared,
        }
    }
}

impl BlockNoise<'_> {
    /// `D` of a group, its covariance with all shared unknowns held fixed, and `Z`, one row for each unknown of the
    /// group (see [`Solution::covariance`]).
    ///
    /// # Panics
    /// If there is no such group.
    pub fn block(&self, group: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let factors = &self.covariance.factors;
        let factor = factors.inverse_factor(group);
        let coupling = factors.coupling_transposed(group).transpose();
        match &self.of_lengths {
            None => (&factor * factor.transpose(), coupling),
            Some(blocks) => {
                let width = coupling.ncols();
                let mixed = blocks.coupling_transposed(group);
                let mut doubled = coupling.resize_horizontally(2 * width, 0.0);
                doubled.columns_mut(width, width).tr_copy_from(&mixed);
                (blocks.inverse_factor(group), doubled)
            }
        }
    }

    /// `S`: covariance of the shared sources. The first are the stations (x y z L each), the dead paths after
    /// interruptions and the deformations of the bodies, as in [`Solution::covariance`]; the rest has a meaning only
    /// between couplings. With the shared unknowns `s`, `cov(x_i, s) = -Z_i S`.
    pub fn shared(&self) -> &DMatrix<f64> {
        &self.shared
    }
}

/// Appends `cov(ξ)` and `N` of the groups of a batch with these rows and factors.
#[inline(always)]
fn add_blocks(
    batch: &Batch,
    (rows, factors): (&BatchRows, BatchFactors<'_>),
    memory: &mut PartMemory,
    blocks: &mut Factors,
) {
    let (own, shared) = (rows.hat.own(), rows.hat.shared());
    let (count, unknowns, width) = (batch.slots(), own.columns(), shared.columns());
    // O R⁻ᵀ.
    let mut errors = vec![Lanes::ZERO; count * unknowns];
    add_product(&mut errors, own, factors.inverse_factor.transposed());
    let errors = LaneMatrix::by_rows(&errors, [count, unknowns]);
    let part = memory.part_of(errors, batch, rows).transposed();
    let mut of_group = vec![Lanes::ZERO; unknowns * unknowns];
    add_product(&mut of_group, part, errors);
    let mut mixed = vec![Lanes::ZERO; unknowns * width];
    add_product(&mut mixed, part, shared);
    let numbers = blocks.begin(batch.groups.clone(), unknowns);
    numbers.extend(of_group);
    numbers.extend(mixed);
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

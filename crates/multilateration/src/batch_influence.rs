//! How the whitened lengths enter a solved network: the rows `O`, `T` of the hat matrix ([`HatRows`]), batch by batch.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::DMatrix;
use rayon::prelude::*;
use trueaxis_leastsquares::lane_products::{LaneMatrix, SharedMatrix};
use trueaxis_leastsquares::{
    BatchFactors, Covariance, HatRows, Lanes, in_widest_registers, lanes_only, zeros,
};

use crate::adjustment::GroupAdjustment;
use crate::batches::Batch;
use crate::memory::{Constraints, Memory};
use crate::noise::factor_len;
use crate::state::State;
use crate::tie::Tie;
use crate::visit_weights::{by_visit, is_read, own_variance};
use crate::{Network, Solution};

/// Batches that one thread takes at a time, each time for one partial sum.
const CHUNK: usize = 32;

/// A solved network, ready to say what each batch contributed.
pub(crate) struct BatchInfluence<'a> {
    pub(crate) model: GroupAdjustment<'a>,
    pub(crate) state: State,
    covariance: &'a Covariance,
}

/// What a batch contributed, and memory to make it.
#[derive(Debug, Default)]
pub(crate) struct BatchRows {
    /// `O`, `T` and the residuals, rows in the order of the slots.
    pub(crate) hat: HatRows,
    memory: Memory,
    /// `L⁻¹` of each visit, its rows one after the other, one visit after the other.
    unit_errors: Vec<Lanes>,
    /// Variance of the length of each slot without the machine's repeatability, mm².
    pub(crate) variances: Vec<Lanes>,
    /// One where a slot has a reading, zero where there is none.
    pub(crate) there: Vec<Lanes>,
}

impl<'a> BatchInfluence<'a> {
    /// `network` must be the one that `solution` solved.
    pub(crate) fn new(network: &'a Network, solution: &'a Solution) -> Self {
        Self {
            model: GroupAdjustment::new(network, &solution.batches),
            state: solution.state(),
            covariance: &solution.covariance,
        }
    }

    pub(crate) fn batches(&self) -> &Arc<Vec<Batch>> {
        &self.model.batches
    }

    /// Number of columns of `T`.
    pub(crate) fn width(&self) -> usize {
        self.covariance.factors.width()
    }

    /// `Σ`.
    pub(crate) fn sigma(&self) -> &DMatrix<f64> {
        self.covariance.reduced_inverse()
    }

    /// `R⁻¹` and `Z` of batch `b`.
    #[inline(always)]
    pub(crate) fn factors(&self, b: usize) -> BatchFactors<'_> {
        self.covariance.factors.batch(b)
    }

    /// `Σ` for products in lanes.
    #[inline(always)]
    pub(crate) fn shared_sigma(&self) -> SharedMatrix<'_> {
        // Symmetric: columns are rows.
        SharedMatrix::by_rows(self.sigma().as_slice(), [self.width(); 2])
    }

    /// The chunks of the batches, in order.
    pub(crate) fn chunks(&self) -> impl ExactSizeIterator<Item = Range<usize>> + use<> {
        let batches = self.batches().len();
        let starts = (0..batches).step_by(CHUNK);
        starts.map(move |start| start..batches.min(start + CHUNK))
    }

    /// The results of `work` on the chunks of the batches, in order; `work` runs on all threads with the widest
    /// registers ([`in_widest_registers`]).
    pub(crate) fn of_chunks<T: Send>(
        &self,
        work: impl Fn(Range<usize>, &mut BatchRows) -> T + Sync + Send,
    ) -> Vec<T> {
        self.with_chunks(
            vec![(); self.chunks().len()],
            #[inline(always)]
            |chunk, (), rows| work(chunk, rows),
        )
    }

    /// The same as [`Self::of_chunks`], where each chunk takes a part of its own along.
    pub(crate) fn with_chunks<P: Send, T: Send>(
        &self,
        parts: Vec<P>,
        work: impl Fn(Range<usize>, P, &mut BatchRows) -> T + Sync + Send,
    ) -> Vec<T> {
        let chunks: Vec<_> = self.chunks().zip(parts).collect();
        let of_chunk = |rows: &mut BatchRows, (chunk, part)| {
            in_widest_registers(
                #[inline(always)]
                || work(chunk, part, rows),
            )
        };
        let chunks = chunks.into_par_iter();
        chunks.map_init(BatchRows::default, of_chunk).collect()
    }

    /// Takes the rows of batch `b`, with the widest registers. Inlined at every caller this would take minutes to
    /// compile.
    #[inline(never)]
    pub(crate) fn fill(&self, b: usize, rows: &mut BatchRows) {
        in_widest_registers(
            #[inline(always)]
            || self.fill_inlined(b, rows),
        );
    }

    #[inline(always)]
    fn fill_inlined(&self, b: usize, rows: &mut BatchRows) {
        let BatchRows {
            hat,
            memory,
            unit_errors,
            variances,
            there,
        } = rows;
        self.model.fill(&self.state, b, Constraints::None, memory);
        let batch = &self.batches()[b];
        let (used, noise) = (batch.groups.len(), &self.model.network.noise);
        hat.fill(&memory.equations, self.factors(b), used);

        let mask = Lanes::mask(used);
        variances.clear();
        there.clear();
        for slot in 0..batch.slots() {
            let distance_mm = memory.beams.of_slots[slot].distance_mm;
            variances.push(own_variance(batch, noise, slot, distance_mm));
            there.push(is_read(batch, slot) * mask);
        }
        unit_errors.clear();
        for (_, count, weights) in by_visit(batch, &memory.weights) {
            for i in 0..count {
                let row = &weights[factor_len(i)..factor_len(i + 1)];
                unit_errors.extend_from_slice(row);
                unit_errors.resize(unit_errors.len() + count - row.len(), Lanes::ZERO);
            }
        }
    }
}

/// The rows of one visit.
pub(crate) struct VisitPart<'a> {
    pub(crate) slots: Range<usize>,
    /// `L⁻¹`: column `i` is a unit error of slot `i` of the visit, whitened; zero where there is no
    /// reading. Lanes without a group repeat another one's.
    pub(crate) unit_errors: LaneMatrix<'a>,
}

impl VisitPart<'_> {
    /// Row `i` of `L`, from `lᵀ L⁻¹ = eᵢᵀ`; zeros where there is no reading.
    #[inline(always)]
    pub(crate) fn fill_factor_row(&self, i: usize, row: &mut Vec<Lanes>) {
        zeros(row, self.slots.len());
        for k in (0..=i).rev() {
            let mut left = Lanes::splat(f64::from(u8::from(k == i)));
            for (j, known) in row.iter().enumerate().take(i + 1).skip(k + 1) {
                left -= *known * self.unit_errors.at(j, k);
            }
            let pivot = self.unit_errors.at(k, k);
            // Without a reading there is no pivot.
            let value = left / pivot;
            row[k] = Lanes::from_fn(|lane| {
                if pivot.0[lane] > 0.0 {
                    value.0[lane]
                } else {
                    0.0
                }
            });
        }
    }

    /// `V = L⁻¹ diag(σ_l²) L⁻ᵀ`: the lengths' own part of the whitened noise, rows contiguous; zero in
    /// lanes without a group.
    #[inline(always)]
    pub(crate) fn fill_length_part(&self, rows: &BatchRows, part: &mut Vec<Lanes>) {
        let count = self.slots.len();
        zeros(part, count * count);
        for (i, slot) in self.slots.clone().enumerate() {
            let variance = rows.variances[slot] * rows.there[slot];
            for (r, row) in part.chunks_exact_mut(count).enumerate() {
                let factor = variance * self.unit_errors.at(r, i);
                for (c, v) in row.iter_mut().enumerate() {
                    lanes_only();
                    *v = factor.mul_add(self.unit_errors.at(c, i), *v);
                }
            }
        }
    }
}

impl BatchRows {
    /// The points of the groups of the batch, x y z of each, mm.
    pub(crate) fn points_mm(&self) -> &[Lanes] {
        &self.memory.beams.points
    }

    /// Writes the whitened derivatives of a slot by the shared unknowns to the front of `place`, which must be zero.
    #[inline(always)]
    pub(crate) fn copy_shared_row(&self, slot: usize, place: &mut [Lanes]) {
        self.memory.equations.copy_shared_row(slot, place);
    }

    /// What ties the points of a batch that has a body.
    pub(crate) fn tie(&self) -> &Tie {
        &self.memory.tie
    }

    /// The visits of the batch whose rows these are.
    #[inline(always)]
    pub(crate) fn visits<'r>(&'r self, batch: &'r Batch) -> impl Iterator<Item = VisitPart<'r>> {
        let mut rest = self.unit_errors.as_slice();
        batch.layout.visits.iter().map(
            #[inline(always)]
            move |visit| {
                let count = visit.slots.len();
                let (own, others) = rest.split_at(count * count);
                rest = others;
                VisitPart {
                    slots: visit.slots.clone(),
                    unit_errors: LaneMatrix::by_rows(own, [count; 2]),
                }
            },
        )
    }
}

//! The weights of the lengths of eight groups: `W = L⁻¹` of each visit, `C = L Lᵀ` ([`crate::noise`]).

use trueaxis_leastsquares::Lanes;

use crate::batches::Batch;
use crate::beams::Beams;
use crate::noise::{Noise, factor_len};
use crate::slots::SlotVisit;

/// The weights of a batch: `L⁻¹` of each visit row by row, with zero rows where a reading is missing.
#[inline(always)]
pub(crate) fn fill_weights(
    batch: &Batch,
    noise: &Noise,
    beams: &Beams,
    factor: &mut Vec<Lanes>,
    weights: &mut [Lanes],
) {
    let mut rest = weights;
    for SlotVisit { slots, .. } in &batch.layout.visits {
        let (first, count) = (slots.start, slots.len());
        let (own, others) = rest.split_at_mut(factor_len(count));
        rest = others;
        factor.resize(factor_len(count), Lanes::ZERO);
        for i in 0..count {
            fill_factor_row(batch, noise, beams, (first, i), factor);
        }
        // L⁻¹ by rows: (L⁻¹)_ij = -Σ_k L_ik (L⁻¹)_kj / L_ii, and zero for what is missing.
        for i in 0..count {
            let row = &factor[factor_len(i)..factor_len(i + 1)];
            let reciprocal = row[i] * is_read(batch, first + i);
            for j in 0..i {
                let mut sum = Lanes::ZERO;
                for k in j..i {
                    sum = row[k].mul_add(own[factor_len(k) + j], sum);
                }
                own[factor_len(i) + j] = -sum * reciprocal;
            }
            own[factor_len(i) + i] = reciprocal;
        }
    }
}

/// Row `i` of the Cholesky factor of a visit whose slots start at `first`, with the reciprocal of the diagonal; a
/// missing reading has unit variance and correlates with nothing.
#[inline(always)]
fn fill_factor_row(
    batch: &Batch,
    noise: &Noise,
    beams: &Beams,
    (first, i): (usize, usize),
    factor: &mut [Lanes],
) {
    let repeatability_mm = if batch.is_bed {
        0.0
    } else {
        noise.repeatability_mm
    };
    let repeatability_variance = Lanes::splat(repeatability_mm * repeatability_mm);
    let there = is_read(batch, first + i);
    let (above, row) = factor.split_at_mut(factor_len(i));
    for j in 0..i {
        let of_j = &above[factor_len(j)..factor_len(j + 1)];
        let returning = beams.returning(batch, first + i, first + j);
        let mut c = repeatability_variance * returning * there * is_read(batch, first + j);
        for k in 0..j {
            c = row[k].mul_add(-of_j[k], c);
        }
        row[j] = c * of_j[j];
    }
    let beam = &beams.of_slots[first + i];
    let returning = beams.returning(batch, first + i, first + i);
    let own = own_variance(batch, noise, first + i, beam.distance_mm)
        + repeatability_variance * returning;
    let mut c = own * there + (Lanes::splat(1.0) - there);
    for x in &row[..i] {
        c = x.mul_add(-*x, c);
    }
    row[i] = Lanes::splat(1.0) / c.sqrt();
}

/// Variance of the length of a slot without the machine's repeatability, mm².
#[inline(always)]
pub(crate) fn own_variance(batch: &Batch, noise: &Noise, slot: usize, distance_mm: Lanes) -> Lanes {
    let constant = Lanes::splat(noise.length_sigma_mm * noise.length_sigma_mm);
    let relative = Lanes::splat(noise.length_sigma_relative * noise.length_sigma_relative);
    (constant + relative * (distance_mm * distance_mm)) * batch.variance_factor(slot)
}

/// One where a slot has a reading, zero where it is missing.
#[inline(always)]
pub(crate) fn is_read(batch: &Batch, slot: usize) -> Lanes {
    if batch.is_full() {
        return Lanes::splat(1.0);
    }
    let factors = batch.variance_factor(slot);
    Lanes::from_fn(|lane| f64::from(u8::from(factors.0[lane] > 0.0)))
}

/// The first slot of each visit of a batch, the number of its slots, and its weights ([`fill_weights`]).
pub(crate) fn by_visit<'w>(
    batch: &'w Batch,
    weights: &'w [Lanes],
) -> impl Iterator<Item = (usize, usize, &'w [Lanes])> {
    let mut weights = weights;
    batch.layout.visits.iter().map(
        #[inline(always)]
        move |SlotVisit { slots, .. }| {
            let own;
            (own, weights) = weights.split_at(factor_len(slots.len()));
            (slots.start, slots.len(), own)
        },
    )
}

//! The weights of the lengths of eight groups: `W = L⁻¹` of each visit, `C = L Lᵀ` ([`crate::noise`]).

use trueaxis_leastsquares::Lanes;

use crate::batches::Batch;
use crate::beams::Beams;
use crate::noise::{Noise, factor_len};
use crate::slots::SlotVisit;

/// The weights of a batch: `L⁻¹` of each visit row by row, with zero rows where there is no reading.
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
        factor.clear();
        for i in 0..count {
            append_factor_row(batch, noise, beams, (first, i), factor);
        }
        // L⁻¹ by rows: (L⁻¹)_ij = -Σ_k L_ik (L⁻¹)_kj / L_ii, and zero for what is missing.
        for i in 0..count {
            let row = &factor[factor_len(i)..factor_len(i + 1)];
            let reciprocal = Lanes::splat(1.0) / row[i];
            for j in 0..i {
                let mut sum = Lanes::ZERO;
                for k in j..i {
                    sum = row[k].mul_add(own[factor_len(k) + j], sum);
                }
                own[factor_len(i) + j] = -sum * reciprocal;
            }
            own[factor_len(i) + i] = reciprocal;
        }
        for i in 0..count {
            let there = is_read(batch, first + i);
            for weight in &mut own[factor_len(i)..factor_len(i + 1)] {
                *weight = *weight * there;
            }
        }
    }
}

/// Appends row `i` of the Cholesky factor of a visit whose slots start at `first`; a reading that is
/// missing has unit variance and correlates with nothing.
#[inline(always)]
fn append_factor_row(
    batch: &Batch,
    noise: &Noise,
    beams: &Beams,
    (first, i): (usize, usize),
    factor: &mut Vec<Lanes>,
) {
    let repeatability_mm = if batch.is_bed {
        0.0
    } else {
        noise.repeatability_mm
    };
    let repeatability_variance = Lanes::splat(repeatability_mm * repeatability_mm);
    let there = is_read(batch, first + i);
    let start = factor.len();
    for j in 0..i {
        let cosine = beams.cosine(first + i, first + j);
        let mut c = repeatability_variance * cosine * there * is_read(batch, first + j);
        let above = factor_len(j);
        for k in 0..j {
            c = factor[start + k].mul_add(-factor[above + k], c);
        }
        factor.push(c / factor[above + j]);
    }
    let own = own_variance(
        batch,
        noise,
        first + i,
        beams.of_slots[first + i].distance_mm,
    ) + repeatability_variance;
    let mut c = own * there + (Lanes::splat(1.0) - there);
    for x in &factor[start..] {
        c = x.mul_add(-*x, c);
    }
    factor.push(c.sqrt());
}

/// Variance of the length of a slot without the machine's repeatability, mm².
#[inline(always)]
pub(crate) fn own_variance(batch: &Batch, noise: &Noise, slot: usize, distance_mm: Lanes) -> Lanes {
    let constant = Lanes::splat(noise.length_sigma_mm * noise.length_sigma_mm);
    let relative = Lanes::splat(noise.length_sigma_relative * noise.length_sigma_relative);
    (constant + relative * (distance_mm * distance_mm)) * batch.variance_factor(slot)
}

/// One where there is a reading, zero where there is none.
#[inline(always)]
pub(crate) fn is_read(batch: &Batch, slot: usize) -> Lanes {
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

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, Point3, Vector3};

    use super::*;
    use crate::batches::batches;
    use crate::state::State;
    use crate::{Network, Reading, Visit};

    /// `W C Wᵀ = 1` with the covariance by its definition.
    #[test]
    fn weights_whiten_the_covariance() {
        let noise = Noise {
            length_sigma_mm: 3e-4,
            length_sigma_relative: 5e-7,
            repeatability_mm: 1e-3,
        };
        let factors = [1.0, 25.0, 1.0];
        let network = Network {
            stations: vec![None],
            nominal_mm: vec![
                Point3::new(300.0, 600.0, 600.0),
                Point3::new(733.0, -367.0, 733.0),
                Point3::new(600.0, 0.0, 800.0),
            ],
            groups: std::iter::once(0..3).collect(),
            visits: vec![Visit {
                station: 0,
                group: 0,
                readings: 0..3,
            }],
            readings: (0..3)
                .map(|point| Reading {
                    point,
                    length_mm: 0.0,
                })
                .collect(),
            variance_factors: factors.to_vec(),
            noise,
            ..Network::default()
        };
        let points = network.nominal_mm.clone();
        let state = State::new(&network, vec![Point3::origin()], vec![0.0], points);
        let batch = &batches(&network)[0];
        let (mut beams, mut weights) = (Beams::default(), vec![Lanes::ZERO; batch.weights()]);
        beams.fill(batch, state.common(), &state.points);
        fill_weights(batch, &noise, &beams, &mut Vec::new(), &mut weights);
        let w = DMatrix::from_fn(3, 3, |i, j| match j <= i {
            true => weights[factor_len(i) + j].0[0],
            false => 0.0,
        });
        let beam = |i: usize| -> Vector3<f64> { network.nominal_mm[i].coords };
        let c = DMatrix::from_fn(3, 3, |i, j| {
            let own = (9e-8 + (5e-7 * beam(i).norm()).powi(2)) * factors[i];
            let common = 1e-6 * beam(i).normalize().dot(&beam(j).normalize());
            common + if i == j { own } else { 0.0 }
        });
        let whitened = &w * c * w.transpose();
        assert!((whitened - DMatrix::<f64>::identity(3, 3)).amax() < 1e-12);
    }
}

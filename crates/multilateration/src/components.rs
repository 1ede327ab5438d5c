//! Variance components: the noise of a length and of the machine's return, from the residuals.
//!
//! The covariance of the lengths is `C = Σ_k θ_k V_k` with two parts: the lengths' own noise (its
//! ratio of constant and proportional part is kept) and the return of the machine. Restricted
//! maximum likelihood (Patterson and Thompson 1971; in geodesy Helmert's method) solves
//!
//! ```text
//! Σ_l ½ tr(P V_k P V_l) θ_l = ½ vᵀ C⁻¹ V_k C⁻¹ v      P = C⁻¹ (C - J Q Jᵀ) C⁻¹
//! ```
//!
//! repeatedly; the inverse of the left side is the covariance of the estimates. `P` never appears as
//! a matrix: with the factors of [`crate::influence`] every trace is a sum over groups.

use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;

use crate::influence::Influence;
use crate::length_noise::LengthPart;
use crate::visit_terms::{VisitTerms, add_transposed_product, dot, product, times_symmetric};

/// One step towards the restricted maximum of the likelihood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Components {
    /// Estimated factors on the variances of the two parts: lengths, return.
    pub(crate) factors: Vector2<f64>,
    /// Their covariance.
    pub(crate) covariance: Matrix2<f64>,
    /// `1 - ρ²`: how far the data tell the two parts apart, from 0 (not at all) to 1.
    pub(crate) separation: f64,
}

/// Estimates the factors on both parts of the noise with which the network was solved; the return
/// must not be zero. `None` if the residuals say nothing.
pub(crate) fn components(influence: &Influence<'_>) -> Option<Components> {
    let sums = sums(influence);
    let width = influence.width();
    let sigma = influence.sigma();
    // Σ G_k of both parts, G_2 = G - G_1.
    let mut through = Vec::with_capacity(width * width);
    product(&sigma, &sums.length, width, &mut through);
    let mut through_all = Vec::new();
    product(&sigma, &sums.all, width, &mut through_all);
    let through_return: Vec<f64> = through_all
        .iter()
        .zip(&through)
        .map(|(all, length)| all - length)
        .collect();
    let trace = |a: &[f64], b: &[f64]| -> f64 {
        (0..width)
            .map(|i| {
                (0..width)
                    .map(|j| a[i * width + j] * b[j * width + i])
                    .sum::<f64>()
            })
            .sum()
    };
    let both = [
        trace(&through, &through),
        trace(&through, &through_return),
        trace(&through_return, &through_return),
    ];
    let [first, mixed, second] = std::array::from_fn(|pair| sums.left[pair] + 0.5 * both[pair]);
    let left = Matrix2::new(first, mixed, mixed, second);
    let separation = 1.0 - left[(0, 1)].powi(2) / (left[(0, 0)] * left[(1, 1)]);
    let covariance = left.try_inverse()?;
    let factors = covariance * sums.right;
    factors.iter().all(|f| f.is_finite()).then_some(Components {
        factors,
        covariance,
        separation,
    })
}

/// The sums that make the equations.
struct Sums {
    /// `½ vᵀ C⁻¹ V_k C⁻¹ v`.
    right: Vector2<f64>,
    /// What of `½ tr(P V_k P V_l)` is a sum over groups, for the pairs 11, 12, 22.
    left: [f64; 3],
    /// `Tᵀ V_1 T` and `Tᵀ T`.
    length: Vec<f64>,
    all: Vec<f64>,
}

/// Groups that one thread takes at a time.
const PIECE: usize = 256;

fn sums(influence: &Influence<'_>) -> Sums {
    let (groups, width) = (influence.groups(), influence.width());
    let sigma = influence.sigma();
    let zero = || Sums {
        right: Vector2::zeros(),
        left: [0.0; 3],
        length: vec![0.0; width * width],
        all: vec![0.0; width * width],
    };
    let parts: Vec<Sums> = (0..groups.div_ceil(PIECE))
        .into_par_iter()
        .map(|piece| {
            let mut sums = zero();
            let mut memory = GroupSums::default();
            for group in piece * PIECE..groups.min((piece + 1) * PIECE) {
                memory.add(influence, &sigma, group, &mut sums);
            }
            sums
        })
        .collect();
    // In order, so that the bits do not depend on the number of threads.
    parts.into_iter().fold(zero(), |mut sums, part| {
        sums.right += part.right;
        for (sum, x) in sums.left.iter_mut().zip(part.left) {
            *sum += x;
        }
        for (sum, part) in [(&mut sums.length, part.length), (&mut sums.all, part.all)] {
            for (sum, x) in sum.iter_mut().zip(part) {
                *sum += x;
            }
        }
        sums
    })
}

/// What a group adds: memory to work in. `V_1` is the lengths' own part, `V_2 = I - V_1`.
#[derive(Default)]
struct GroupSums {
    terms: Vec<VisitTerms>,
    part: LengthPart,
    /// `V_1 O`, `V_1 T`, `T Σ` of a visit.
    own_part: Vec<f64>,
    shared_part: Vec<f64>,
    through: Vec<f64>,
    row: Vec<f64>,
    /// Of the group for `V_1` and for the identity: `Oᵀ V O`, `Oᵀ V T`, `Oᵀ V T Σ`.
    own: [Vec<f64>; 2],
    cross: [Vec<f64>; 2],
    cross_through: [Vec<f64>; 2],
}

impl GroupSums {
    fn add(&mut self, influence: &Influence<'_>, sigma: &[f64], group: usize, sums: &mut Sums) {
        influence.visits(group, &mut self.terms);
        let width = influence.width();
        let unknowns = self.terms.first().map_or(0, VisitTerms::own_width);
        for (memory, size) in [
            (&mut self.own, unknowns * unknowns),
            (&mut self.cross, unknowns * width),
            (&mut self.cross_through, unknowns * width),
        ] {
            for memory in memory {
                memory.clear();
                memory.resize(size, 0.0);
            }
        }
        let visits = influence.model().visits_of(group);
        for (&visit, terms) in visits.iter().zip(&self.terms) {
            let count = terms.count();
            let (own, shared) = (terms.own_rows(), terms.shared_rows());
            let v = self.part.of(influence, visit, count);
            product(v, own, unknowns, &mut self.own_part);
            product(v, shared, width, &mut self.shared_part);
            self.through.clear();
            for i in 0..count {
                times_symmetric(sigma, terms.shared(i), &mut self.row);
                self.through.extend_from_slice(&self.row);
            }

            // Residuals and traces of the visit alone.
            let mut length = 0.0;
            let (mut all, mut once, mut twice) = ([0.0; 2], [0.0; 2], [0.0; 2]);
            let squares = dot(terms.residuals(), terms.residuals());
            for i in 0..count {
                for j in 0..count {
                    let v_ij = v[i * count + j];
                    length += v_ij * terms.residuals()[i] * terms.residuals()[j];
                    let v_v = (0..count).map(|k| v[i * count + k] * v[k * count + j]);
                    let v_v: f64 = v_v.sum();
                    // tr(V V), and the same with O Oᵀ and T Σ Tᵀ between them.
                    let rows = |i: usize| i * width..(i + 1) * width;
                    let adjusted = dot(terms.own(i), terms.own(j));
                    let through = dot(&self.through[rows(i)], terms.shared(j));
                    let between = adjusted + through;
                    if i == j {
                        all[0] += 1.0;
                        all[1] += between;
                        once[0] += v_ij;
                        twice[0] += v_v;
                    }
                    once[1] += v_ij * between;
                    twice[1] += v_v * between;
                }
            }
            sums.right += Vector2::new(length, squares - length) * 0.5;
            // ½ tr(V_k V_l) - tr(V_k (O Oᵀ + T Σ Tᵀ) V_l), by V_2 = I - V_1.
            let noise = pairs(twice[0], once[0], all[0]);
            let absorbed = pairs(twice[1], once[1], all[1]);
            for (sum, (noise, absorbed)) in sums.left.iter_mut().zip(noise.iter().zip(absorbed)) {
                *sum += 0.5 * noise - absorbed;
            }

            add_transposed_product(&mut sums.all, shared, shared, [width; 2]);
            add_transposed_product(&mut sums.length, shared, &self.shared_part, [width; 2]);
            for (k, part) in [self.own_part.as_slice(), own].into_iter().enumerate() {
                add_transposed_product(&mut self.own[k], own, part, [unknowns; 2]);
                let columns = [unknowns, width];
                add_transposed_product(&mut self.cross[k], part, shared, columns);
                add_transposed_product(&mut self.cross_through[k], part, &self.through, columns);
            }
        }
        // ½ tr(H_k H_l) + tr(Σ K_kᵀ K_l) with H = OᵀVO, K = OᵀVT of the whole group.
        let h = |k: usize, l: usize| dot(&self.own[k], &self.own[l]);
        let c = |k: usize, l: usize| dot(&self.cross_through[k], &self.cross[l]);
        let h = pairs(h(0, 0), h(0, 1), h(1, 1));
        let c = pairs(c(0, 0), c(0, 1), c(1, 1));
        for (sum, (h, c)) in sums.left.iter_mut().zip(h.into_iter().zip(c)) {
            *sum += 0.5 * h + c;
        }
    }
}

/// A form that is linear in both parts, for the pairs 11, 12, 22, from its values for `V_1 V_1`,
/// `V_1` and the identity.
fn pairs(twice: f64, once: f64, all: f64) -> [f64; 3] {
    [twice, once - twice, all - 2.0 * once + twice]
}

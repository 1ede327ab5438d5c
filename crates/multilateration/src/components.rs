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

use std::ops::Range;

use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;

use crate::influence::Influence;
use crate::length_noise::LengthPart;
use crate::visit_terms::VisitTerms;
use trueaxis_leastsquares::row_products::{
    add_symmetric_product, add_transposed_product, append_product, dot, mirror,
};

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
    append_product(&mut through, &sigma, &sums.length, [width; 2]);
    let mut through_all = Vec::new();
    append_product(&mut through_all, &sigma, &sums.all, [width; 2]);
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
            mirror(&mut sums.length, width);
            mirror(&mut sums.all, width);
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
    terms: VisitTerms,
    part: LengthPart,
    /// `V_1 O`, `V_1 T`, `T Σ`.
    own_part: Vec<f64>,
    shared_part: Vec<f64>,
    through: Vec<f64>,
    /// For `V_1` and for the identity: `Oᵀ V O`, `Oᵀ V T`, `Oᵀ V T Σ`.
    own: [Vec<f64>; 2],
    cross: [Vec<f64>; 2],
    cross_through: [Vec<f64>; 2],
}

impl GroupSums {
    fn add(&mut self, influence: &Influence<'_>, sigma: &[f64], group: usize, sums: &mut Sums) {
        influence.visits(group, &mut self.terms);
        let (width, unknowns) = (influence.width(), self.terms.own_width());
        self.through.clear();
        append_product(
            &mut self.through,
            self.terms.shared_rows(),
            sigma,
            [width; 2],
        );
        self.own_part.clear();
        self.shared_part.clear();
        let mut first = 0;
        for &visit in influence.model().visits_of(group) {
            let rows = first..first + influence.network().visits[visit].readings.len();
            self.add_visit(influence, visit, rows.clone(), sums);
            first = rows.end;
        }

        let (own, shared) = (self.terms.own_rows(), self.terms.shared_rows());
        add_symmetric_product(&mut sums.all, shared, shared, width);
        add_symmetric_product(&mut sums.length, shared, &self.shared_part, width);
        for (k, part) in [self.own_part.as_slice(), own].into_iter().enumerate() {
            let products = [
                (&mut self.own[k], own),
                (&mut self.cross[k], shared),
                (&mut self.cross_through[k], &self.through),
            ];
            for (product, right) in products {
                let columns = right.len() / self.terms.count().max(1);
                product.clear();
                product.resize(unknowns * columns, 0.0);
                add_transposed_product(product, part, right, [unknowns, columns]);
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

    /// The residuals and traces of a visit alone; appends its `V_1 O` and `V_1 T`.
    fn add_visit(
        &mut self,
        influence: &Influence<'_>,
        visit: usize,
        rows: Range<usize>,
        sums: &mut Sums,
    ) {
        let terms = &self.terms;
        let (count, unknowns, width) = (rows.len(), terms.own_width(), influence.width());
        let of = |columns: usize| rows.start * columns..rows.end * columns;
        let own = &terms.own_rows()[of(unknowns)];
        let shared = &terms.shared_rows()[of(width)];
        let v = self.part.of(influence, visit, count);
        append_product(&mut self.own_part, v, own, [count, unknowns]);
        append_product(&mut self.shared_part, v, shared, [count, width]);

        let residuals = &terms.residuals()[rows.clone()];
        let mut length = 0.0;
        let (mut all, mut once, mut twice) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for i in 0..count {
            let through = &self.through[(rows.start + i) * width..][..width];
            for j in 0..=i {
                // All forms are symmetric.
                let times = if i == j { 1.0 } else { 2.0 };
                let v_ij = times * v[i * count + j];
                length += v_ij * residuals[i] * residuals[j];
                let v_v = (0..count).map(|k| v[i * count + k] * v[k * count + j]);
                let v_v = times * v_v.sum::<f64>();
                // tr(V V), and the same with O Oᵀ and T Σ Tᵀ between them.
                let (row, other) = (rows.start + i, rows.start + j);
                let adjusted = dot(terms.own(row), terms.own(other));
                let between = adjusted + dot(through, terms.shared(other));
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
        sums.right += Vector2::new(length, dot(residuals, residuals) - length) * 0.5;
        // ½ tr(V_k V_l) - tr(V_k (O Oᵀ + T Σ Tᵀ) V_l), by V_2 = I - V_1.
        let noise = pairs(twice[0], once[0], all[0]);
        let absorbed = pairs(twice[1], once[1], all[1]);
        for (sum, (noise, absorbed)) in sums.left.iter_mut().zip(noise.iter().zip(absorbed)) {
            *sum += 0.5 * noise - absorbed;
        }
    }
}

/// A form that is linear in both parts, for the pairs 11, 12, 22, from its values for `V_1 V_1`,
/// `V_1` and the identity.
fn pairs(twice: f64, once: f64, all: f64) -> [f64; 3] {
    [twice, once - twice, all - 2.0 * once + twice]
}

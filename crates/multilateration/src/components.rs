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

use faer::{Mat, MatRef};
use nalgebra::{Matrix2, Vector2};
use trueaxis_leastsquares::BlockRows;

use crate::influence::{Influence, VisitRows};
use crate::length_noise::length_part;
use crate::quadratic_form::quadratic_form;

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

/// The sums that make the equations.
struct Sums {
    /// `½ vᵀ C⁻¹ V_k C⁻¹ v`.
    right: Vector2<f64>,
    /// What of `½ tr(P V_k P V_l)` is a sum over groups.
    left: Matrix2<f64>,
    /// `Σ Tᵀ V_k T`.
    shared: [Mat<f64>; 2],
    /// `Σ Tᵀ (V_k V_l - V_k O Oᵀ V_l) T` for the pairs 11, 12, 22.
    mixed: [Mat<f64>; 3],
}

const PAIRS: [(usize, usize); 3] = [(0, 0), (0, 1), (1, 1)];

/// Estimates the factors on both parts of the noise with which the network was solved; the return
/// must not be zero. `None` if the residuals say nothing.
pub(crate) fn components(influence: &Influence<'_>) -> Option<Components> {
    let sums = sums(influence);
    let sigma = influence.reduced_inverse();
    let through: [Mat<f64>; 2] = std::array::from_fn(|k| sigma * &sums.shared[k]);
    let mut left = sums.left;
    for (pair, &(k, l)) in PAIRS.iter().enumerate() {
        // tr(Σ G_k Σ G_l) - 2 tr(Σ Σ Tᵀ(V_kV_l - V_kOOᵀV_l)T)
        let both = trace_of_product(through[k].as_ref(), through[l].as_ref());
        let mixed = trace_of_product(sigma, sums.mixed[pair].as_ref());
        let more = 0.5 * (both - 2.0 * mixed);
        left[(k, l)] += more;
        if k != l {
            left[(l, k)] += more;
        }
    }
    let separation = 1.0 - left[(0, 1)].powi(2) / (left[(0, 0)] * left[(1, 1)]);
    let covariance = left.try_inverse()?;
    let factors = covariance * sums.right;
    factors.iter().all(|f| f.is_finite()).then_some(Components {
        factors,
        covariance,
        separation,
    })
}

fn sums(influence: &Influence<'_>) -> Sums {
    let width = influence.width();
    let square = || Mat::<f64>::zeros(width, width);
    let mut sums = Sums {
        right: Vector2::zeros(),
        left: Matrix2::zeros(),
        shared: [square(), square()],
        mixed: [square(), square(), square()],
    };
    let mut memory = BlockRows::default();
    for g in 0..influence.groups() {
        let group = influence.group(g, &mut memory);
        let (rows, unknowns) = (group.own.nrows(), group.own.ncols());
        let mut own: [Mat<f64>; 2] = std::array::from_fn(|_| Mat::zeros(rows, unknowns));
        let mut shared: [Mat<f64>; 2] = std::array::from_fn(|_| Mat::zeros(rows, width));
        for visit in &group.visits {
            let parts = parts(influence, visit);
            let residuals = &group.residuals[visit.first..visit.first + visit.count];
            for (k, part) in parts.iter().enumerate() {
                sums.right[k] += 0.5 * quadratic_form(part, residuals);
                let range = |m: &Mat<f64>| part * m.as_ref().subrows(visit.first, visit.count);
                own[k]
                    .as_mut()
                    .subrows_mut(visit.first, visit.count)
                    .copy_from(range(&group.own));
                shared[k]
                    .as_mut()
                    .subrows_mut(visit.first, visit.count)
                    .copy_from(range(&group.shared));
            }
            for (k, l) in PAIRS {
                let traces = 0.5 * trace_of_product(parts[k].as_ref(), parts[l].as_ref());
                sums.left[(k, l)] += traces;
            }
        }
        // H_k = OᵀV_kO and K_k = OᵀV_kT.
        let h: [Mat<f64>; 2] = std::array::from_fn(|k| group.own.transpose() * &own[k]);
        let cross: [Mat<f64>; 2] = std::array::from_fn(|k| group.own.transpose() * &shared[k]);
        for (sum, shared) in sums.shared.iter_mut().zip(&shared) {
            *sum += group.shared.transpose() * shared;
        }
        for (pair, (k, l)) in PAIRS.into_iter().enumerate() {
            sums.left[(k, l)] += 0.5 * trace_of_product(h[k].as_ref(), h[l].as_ref())
                - trace_of_product(own[k].transpose(), own[l].as_ref());
            sums.mixed[pair] += shared[k].transpose() * &shared[l];
            sums.mixed[pair] -= cross[k].transpose() * &cross[l];
        }
    }
    sums.left[(1, 0)] = sums.left[(0, 1)];
    sums
}

/// The two parts of a visit's whitened covariance, which add to the identity.
fn parts(influence: &Influence<'_>, visit: &VisitRows) -> [Mat<f64>; 2] {
    let length = length_part(influence, visit);
    let machine_return = Mat::from_fn(visit.count, visit.count, |i, j| {
        f64::from(u8::from(i == j)) - length[(i, j)]
    });
    [length, machine_return]
}

/// `tr(A B)`.
fn trace_of_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    (0..a.nrows())
        .map(|i| (0..a.ncols()).map(|j| a[(i, j)] * b[(j, i)]).sum::<f64>())
        .sum()
}

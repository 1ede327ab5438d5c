//! Variance components: the noise of a length and the machine's repeatability, from the residuals.
//!
//! The covariance of the lengths is `C = Σ_k θ_k V_k` with two parts: the lengths' own noise (its
//! ratio of constant and proportional part is kept) and the return of the machine. Restricted
//! maximum likelihood (Patterson and Thompson 1971; in geodesy Helmert's method) solves
//!
//! ```text
//! Σ_l ½ tr(P V_k P V_l) θ_l = ½ vᵀ C⁻¹ V_k C⁻¹ v      P = C⁻¹ (C - J Q Jᵀ) C⁻¹
//! ```
//!
//! repeatedly; the inverse of the left side is the covariance of the estimates. (What is known of reflectors
//! beforehand is a third part of known size; its trace with the others is below a quarter for each contrast and is
//! left out.) `P` is never made as a matrix: with the whitened parts `V_1` (visit by visit) and `V_2 = I - V_1` of
//! the noise, and the hat matrix `[same group] O Oᵀ + T Σ Tᵀ` ([`crate::batch_influence`]), every trace consists of
//! sums over groups, linear in the number of lengths:
//!
//! ```text
//! tr(P V_k P V_l) = Σ_groups { tr(V_k V_l) - 2 tr(Oᵀ V_k V_l O) + tr(H_k H_l) + 2 tr(K_k Σ K_lᵀ) }
//!                   - 2 tr(Σ M_kl) + tr(Σ M_k Σ M_l)
//!
//! H_k = Oᵀ V_k O     K_k = Oᵀ V_k T     M_k = Σ_groups Tᵀ V_k T     M_kl = Σ_groups Tᵀ V_k V_l T
//! ```

use nalgebra::{DMatrix, Matrix2, Vector2};
use trueaxis_leastsquares::lane_products::{LaneMatrix, add_product, add_symmetric_product};
use trueaxis_leastsquares::{Lanes, zeros};

use crate::batch_influence::{BatchInfluence, BatchRows, VisitPart};
use crate::batches::Batch;
use crate::{Network, Solution};

/// One step towards the restricted maximum of the likelihood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VarianceComponents {
    /// Estimated factors on the variances of the two parts: lengths, return.
    pub factors: Vector2<f64>,
    /// Their covariance.
    pub covariance: Matrix2<f64>,
    /// `1 - ρ²`: how well the data separate the two parts, from 0 (not at all) to 1.
    pub separation: f64,
}

impl Solution {
    /// Estimates the factors on both parts of the noise with which `network` was solved; its repeatability must not
    /// be zero. `None` if the residuals do not determine them.
    pub fn variance_components(&self, network: &Network) -> Option<VarianceComponents> {
        components(&BatchInfluence::new(network, self))
    }
}

fn components(influence: &BatchInfluence<'_>) -> Option<VarianceComponents> {
    let sums = sums(influence);
    // Σ M for V_1 V_1, for V_1, and for the identity.
    let [through_twice, through, through_all] =
        sums.shared.map(|middle| influence.sigma() * middle);
    let through_repeatability = &through_all - &through;
    // Traces of products.
    let both = [
        through.tr_dot(&through),
        through.tr_dot(&through_repeatability),
        through_repeatability.tr_dot(&through_repeatability),
    ];
    let absorbed = pairs([through_twice, through, through_all].map(|a| a.trace()));
    let [first, mixed, second] =
        std::array::from_fn(|pair| sums.left[pair] - absorbed[pair] + 0.5 * both[pair]);
    let left = Matrix2::new(first, mixed, mixed, second);
    let separation = 1.0 - left[(0, 1)].powi(2) / (left[(0, 0)] * left[(1, 1)]);
    let covariance = left.try_inverse()?;
    let factors = covariance * sums.right;
    factors
        .iter()
        .all(|f| f.is_finite())
        .then_some(VarianceComponents {
            factors,
            covariance,
            separation,
        })
}

/// The sums that make the equations.
struct Sums {
    /// `½ vᵀ C⁻¹ V_k C⁻¹ v`.
    right: Vector2<f64>,
    /// The part of `½ tr(P V_k P V_l)` that is a sum over groups, for the pairs 11, 12, 22.
    left: [f64; 3],
    /// `Tᵀ V_1 V_1 T`, `Tᵀ V_1 T` and `Tᵀ T`.
    shared: [DMatrix<f64>; 3],
}

fn sums(influence: &BatchInfluence<'_>) -> Sums {
    let width = influence.width();
    let parts = influence.of_chunks(
        #[inline(always)]
        |chunk, rows| {
            let mut sums = LaneSums::new(width);
            let mut memory = Products::default();
            for b in chunk {
                influence.fill(b, rows);
                memory.add(influence, &influence.batches()[b], rows, &mut sums);
            }
            sums.over_lanes(width)
        },
    );
    // In order, so that the bits do not depend on the number of threads.
    let zero = || LaneSums::new(width).over_lanes(width);
    parts.into_iter().fold(zero(), |mut sums, part| {
        sums.right += part.right;
        for (sum, x) in sums.left.iter_mut().zip(part.left) {
            *sum += x;
        }
        for (sum, x) in sums.shared.iter_mut().zip(part.shared) {
            *sum += x;
        }
        sums
    })
}

/// The sums of a chunk, lane by lane.
#[derive(Default)]
struct LaneSums {
    /// `rᵀ V_1 r` and `rᵀ r` of the whitened residuals.
    residuals: [Lanes; 2],
    /// Forms that are linear in both parts of the noise.
    noise: Form,
    absorbed: Form,
    own: Form,
    mixed: Form,
    /// Upper triangles of `Tᵀ V_1 V_1 T`, `Tᵀ V_1 T` and `Tᵀ T`.
    shared: [Vec<Lanes>; 3],
}

/// A symmetric form that is linear in both parts of the noise: its values for `V_1` twice, for `V_1` and
/// the identity, and for the identity twice.
#[derive(Debug, Clone, Copy, Default)]
struct Form {
    twice: Lanes,
    once: Lanes,
    all: Lanes,
}

impl Form {
    /// For the pairs 11, 12, 22.
    fn pairs(&self) -> [f64; 3] {
        pairs([self.twice, self.once, self.all].map(Lanes::sum))
    }

    /// Adds the symmetric form `Σ a_k b_l` for elements of `V_1` (`a_part`) and of the identity (`a_all`).
    #[inline(always)]
    fn add_products(&mut self, [a_part, a_all]: [Lanes; 2], [b_part, b_all]: [Lanes; 2]) {
        self.twice = a_part.mul_add(b_part, self.twice);
        self.once = a_part.mul_add(b_all, self.once);
        self.all = a_all.mul_add(b_all, self.all);
    }
}

/// A form that is linear in both parts, for the pairs 11, 12, 22, by `V_2 = I - V_1`.
fn pairs([twice, once, all]: [f64; 3]) -> [f64; 3] {
    [twice, once - twice, all - 2.0 * once + twice]
}

impl LaneSums {
    fn new(width: usize) -> Self {
        Self {
            shared: [(); 3].map(|()| vec![Lanes::ZERO; width * width]),
            ..Self::default()
        }
    }

    fn over_lanes(self, width: usize) -> Sums {
        let [noise, absorbed, own, mixed] =
            [self.noise, self.absorbed, self.own, self.mixed].map(|form| form.pairs());
        let whole = |upper: Vec<Lanes>| {
            let upper = upper.into_iter().map(Lanes::sum);
            let mut matrix = DMatrix::from_row_iterator(width, width, upper);
            matrix.fill_lower_triangle_with_upper_triangle();
            matrix
        };
        let [length, all] = self.residuals.map(Lanes::sum);
        Sums {
            right: Vector2::new(length, all - length) * 0.5,
            left: std::array::from_fn(|k| 0.5 * (noise[k] + own[k]) - absorbed[k] + mixed[k]),
            shared: self.shared.map(whole),
        }
    }
}

/// The products of a batch: memory to work in.
#[derive(Default)]
struct Products {
    /// `V_1` of a visit.
    part: Vec<Lanes>,
    /// `V_1 O` and `V_1 T`.
    own_part: Vec<Lanes>,
    shared_part: Vec<Lanes>,
    /// For `V_1` and the identity: `H`, `K` and `K Σ`.
    own: [Vec<Lanes>; 2],
    cross: [Vec<Lanes>; 2],
    cross_through: [Vec<Lanes>; 2],
}

impl Products {
    #[inline(always)]
    fn add(
        &mut self,
        influence: &BatchInfluence<'_>,
        batch: &Batch,
        rows: &BatchRows,
        sums: &mut LaneSums,
    ) {
        let (count, width) = (batch.slots(), influence.width());
        let (own, shared) = (rows.hat.own(), rows.hat.shared());
        let unknowns = own.columns();
        zeros(&mut self.own_part, count * unknowns);
        zeros(&mut self.shared_part, count * width);
        for visit in rows.visits(batch) {
            self.add_visit(rows, &visit, sums);
        }
        let own_part = LaneMatrix::by_rows(&self.own_part, [count, unknowns]);
        let shared_part = LaneMatrix::by_rows(&self.shared_part, [count, width]);
        for (k, right) in [own_part, own].into_iter().enumerate() {
            zeros(&mut self.own[k], unknowns * unknowns);
            add_product(&mut self.own[k], own.transposed(), right);
        }
        for (k, right) in [shared_part, shared].into_iter().enumerate() {
            zeros(&mut self.cross[k], unknowns * width);
            add_product(&mut self.cross[k], own.transposed(), right);
            zeros(&mut self.cross_through[k], unknowns * width);
            let cross = LaneMatrix::by_rows(&self.cross[k], [unknowns, width]);
            add_product(&mut self.cross_through[k], cross, influence.shared_sigma());
        }
        for i in 0..count {
            for k in 0..unknowns {
                let both = [own_part.at(i, k), own.at(i, k)];
                sums.absorbed.add_products(both, both);
            }
        }
        for (part, all) in self.own[0].iter().zip(&self.own[1]) {
            sums.own.add_products([*part, *all], [*part, *all]);
        }
        let through = self.cross_through[0].iter().zip(&self.cross_through[1]);
        let cross = self.cross[0].iter().zip(&self.cross[1]);
        for ((a_part, a_all), (b_part, b_all)) in cross.zip(through) {
            sums.mixed
                .add_products([*a_part, *a_all], [*b_part, *b_all]);
        }
        let [twice, once, all] = &mut sums.shared;
        add_symmetric_product(twice, shared_part.transposed(), shared_part);
        add_symmetric_product(once, shared.transposed(), shared_part);
        add_symmetric_product(all, shared.transposed(), shared);
    }

    /// Adds the residuals and traces of a visit; makes its rows of `V_1 O` and `V_1 T`.
    #[inline(always)]
    fn add_visit(&mut self, rows: &BatchRows, visit: &VisitPart<'_>, sums: &mut LaneSums) {
        let count = visit.slots.len();
        visit.fill_length_part(rows, &mut self.part);
        let part = LaneMatrix::by_rows(&self.part, [count; 2]);
        for (product, right) in [
            (&mut self.own_part, rows.hat.own()),
            (&mut self.shared_part, rows.hat.shared()),
        ] {
            let columns = right.columns();
            let own = visit.slots.start * columns..visit.slots.end * columns;
            add_product(&mut product[own], part, right.part(visit.slots.clone()));
        }
        let residual = &rows.hat.residual()[visit.slots.clone()];
        let there = &rows.there[visit.slots.clone()];
        for (i, v) in self.part.chunks_exact(count).enumerate() {
            sums.residuals[1] = residual[i].mul_add(residual[i], sums.residuals[1]);
            sums.noise.all += there[i];
            sums.noise.once += v[i];
            for (v_ij, r) in v.iter().zip(residual) {
                sums.residuals[0] = v_ij.mul_add(residual[i] * *r, sums.residuals[0]);
                sums.noise.twice = v_ij.mul_add(*v_ij, sums.noise.twice);
            }
        }
    }
}

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
//! a matrix: with the whitened parts `V_1` (visit by visit) and `V_2 = I - V_1` of the noise, and the hat
//! matrix `[same group] H + G`, `H = O Oᵀ`, `G = T Σ Tᵀ` ([`crate::batch_influence`]), every trace is a
//! sum over groups:
//!
//! ```text
//! tr(P V_k P V_l) = Σ tr(V_k V_l) - 2 tr(V_k (H + G) V_l) + tr(V_k H V_l H) + 2 tr(V_k H V_l G)
//!                   + tr(Σ M_k Σ M_l)                       M_k = Σ Tᵀ V_k T
//! ```

use nalgebra::{Matrix2, Vector2};
use trueaxis_leastsquares::lane_products::{LaneMatrix, add_product, add_symmetric_product};
use trueaxis_leastsquares::row_products::{append_product, mirror};
use trueaxis_leastsquares::{Lanes, lanes_only, zeros};

use crate::batch_influence::{BatchInfluence, BatchRows, VisitPart};
use crate::batches::Batch;
use crate::passes::GroupModel;

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
pub(crate) fn components<M: GroupModel>(
    influence: &BatchInfluence<'_, M, M::State>,
) -> Option<Components> {
    let sums = sums(influence);
    let width = influence.width();
    let sigma = influence.sigma();
    // Σ M_k of both parts, M_2 = M - M_1.
    let mut through = Vec::with_capacity(width * width);
    append_product(&mut through, sigma, &sums.length, [width; 2]);
    let mut through_all = Vec::new();
    append_product(&mut through_all, sigma, &sums.all, [width; 2]);
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

fn sums<M: GroupModel>(influence: &BatchInfluence<'_, M, M::State>) -> Sums {
    let width = influence.width();
    let parts = influence.of_pieces(
        #[inline(always)]
        |piece, rows| {
            let mut sums = LaneSums::new(width);
            let mut memory = Products::default();
            for b in piece {
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
        for (sum, part) in [(&mut sums.length, part.length), (&mut sums.all, part.all)] {
            for (sum, x) in sum.iter_mut().zip(part) {
                *sum += x;
            }
        }
        sums
    })
}

/// The sums of a piece, lane by lane.
struct LaneSums {
    /// `rᵀ V_1 r` and `rᵀ r` of the whitened residuals.
    residuals: [Lanes; 2],
    /// Forms that are linear in both parts of the noise.
    noise: Form,
    absorbed: Form,
    own: Form,
    mixed: Form,
    /// Upper triangles of `Tᵀ V_1 T` and `Tᵀ T`.
    length: Vec<Lanes>,
    all: Vec<Lanes>,
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
    /// For the pairs 11, 12, 22, by `V_2 = I - V_1`.
    fn pairs(&self) -> [f64; 3] {
        let [twice, once, all] = [self.twice, self.once, self.all].map(Lanes::sum);
        [twice, once - twice, all - 2.0 * once + twice]
    }
}

impl LaneSums {
    fn new(width: usize) -> Self {
        Self {
            residuals: [Lanes::ZERO; 2],
            noise: Form::default(),
            absorbed: Form::default(),
            own: Form::default(),
            mixed: Form::default(),
            length: vec![Lanes::ZERO; width * width],
            all: vec![Lanes::ZERO; width * width],
        }
    }

    fn over_lanes(self, width: usize) -> Sums {
        let [noise, absorbed, own, mixed] =
            [self.noise, self.absorbed, self.own, self.mixed].map(|form| form.pairs());
        let whole = |upper: Vec<Lanes>| {
            let mut matrix: Vec<f64> = upper.into_iter().map(Lanes::sum).collect();
            mirror(&mut matrix, width);
            matrix
        };
        let [length, all] = self.residuals.map(Lanes::sum);
        Sums {
            right: Vector2::new(length, all - length) * 0.5,
            left: std::array::from_fn(|k| 0.5 * (noise[k] + own[k]) - absorbed[k] + mixed[k]),
            length: whole(self.length),
            all: whole(self.all),
        }
    }
}

/// The products of a batch: memory to work in.
#[derive(Default)]
struct Products {
    /// `V_1` of a visit.
    part: Vec<Lanes>,
    /// `V_1 T`, `T Σ`.
    shared_part: Vec<Lanes>,
    through: Vec<Lanes>,
    /// `H` and `G`, and `V_1 H` and `V_1 G`.
    own: Vec<Lanes>,
    mixed: Vec<Lanes>,
    own_part: Vec<Lanes>,
    mixed_part: Vec<Lanes>,
}

impl Products {
    #[inline(always)]
    fn add<M: GroupModel>(
        &mut self,
        influence: &BatchInfluence<'_, M, M::State>,
        batch: &Batch,
        rows: &BatchRows,
        sums: &mut LaneSums,
    ) {
        let (count, width) = (batch.slots(), influence.width());
        let (own, shared) = (rows.hat.own(), rows.hat.shared());
        zeros(&mut self.through, count * width);
        add_product(&mut self.through, shared, influence.shared_sigma());
        let through = LaneMatrix::by_rows(&self.through, [count, width]);
        for product in [&mut self.own, &mut self.mixed] {
            zeros(product, count * count);
        }
        add_product(&mut self.own, own, own.transposed());
        add_product(&mut self.mixed, through, shared.transposed());
        for product in [&mut self.own_part, &mut self.mixed_part] {
            zeros(product, count * count);
        }
        zeros(&mut self.shared_part, count * width);
        for visit in rows.visits(batch) {
            self.add_visit(rows, &visit, (count, width), sums);
        }
        // tr(V H V H) and tr(V H V G); products of symmetric matrices have the traces of their transposes.
        let [h, g, vh, vg] = [&self.own, &self.mixed, &self.own_part, &self.mixed_part];
        add_trace(&mut sums.own.twice, vh, vh, count);
        add_trace(&mut sums.own.once, vh, h, count);
        add_trace(&mut sums.own.all, h, h, count);
        add_trace(&mut sums.mixed.twice, vh, vg, count);
        add_trace(&mut sums.mixed.once, vh, g, count);
        add_trace(&mut sums.mixed.all, h, g, count);
        let part = LaneMatrix::by_rows(&self.shared_part, [count, width]);
        add_symmetric_product(&mut sums.all, shared.transposed(), shared);
        add_symmetric_product(&mut sums.length, shared.transposed(), part);
    }

    /// The residuals and traces of a visit alone; makes its rows of `V_1 H`, `V_1 G` and `V_1 T`.
    #[inline(always)]
    fn add_visit(
        &mut self,
        rows: &BatchRows,
        visit: &VisitPart<'_>,
        (all_rows, width): (usize, usize),
        sums: &mut LaneSums,
    ) {
        let count = visit.slots.len();
        visit.fill_length_part(rows, &mut self.part);
        let part = LaneMatrix::by_rows(&self.part, [count; 2]);
        let of = |columns: usize| visit.slots.start * columns..visit.slots.end * columns;
        for (product, right) in [
            (&mut self.own_part, &self.own),
            (&mut self.mixed_part, &self.mixed),
        ] {
            let right = LaneMatrix::by_rows(&right[of(all_rows)], [count, all_rows]);
            add_product(&mut product[of(all_rows)], part, right);
        }
        let shared = rows.hat.shared().part(visit.slots.clone());
        add_product(&mut self.shared_part[of(width)], part, shared);

        let residual = &rows.hat.residual()[visit.slots.clone()];
        for (i, v) in self.part.chunks_exact(count).enumerate() {
            let row = visit.slots.start + i;
            let first = row * all_rows + visit.slots.start;
            let (own, mixed) = (&self.own[first..], &self.mixed[first..]);
            sums.residuals[1] = residual[i].mul_add(residual[i], sums.residuals[1]);
            sums.noise.all += rows.there[row];
            sums.noise.once += v[i];
            sums.absorbed.all += own[i] + mixed[i];
            for (j, &v_ij) in v.iter().enumerate() {
                let adjusted = own[j] + mixed[j];
                let squares = residual[i] * residual[j];
                sums.residuals[0] = v_ij.mul_add(squares, sums.residuals[0]);
                sums.noise.twice = v_ij.mul_add(v_ij, sums.noise.twice);
                sums.absorbed.once = v_ij.mul_add(adjusted, sums.absorbed.once);
                let mut v_v = Lanes::ZERO;
                for (k, &v_ik) in v.iter().enumerate() {
                    v_v = v_ik.mul_add(self.part[k * count + j], v_v);
                }
                sums.absorbed.twice = v_v.mul_add(adjusted, sums.absorbed.twice);
            }
        }
    }
}

/// `sum += tr(A B)` with the rows of both contiguous.
#[inline(always)]
fn add_trace(sum: &mut Lanes, a: &[Lanes], b: &[Lanes], count: usize) {
    for (i, row) in a.chunks_exact(count.max(1)).enumerate() {
        for (j, x) in row.iter().enumerate() {
            lanes_only();
            *sum = x.mul_add(b[j * count + i], *sum);
        }
    }
}

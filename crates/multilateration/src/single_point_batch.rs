//! Points in the lanes of registers, linearised: orthonormal columns, residuals, levers.
//!
//! What [`crate::single_points`] says of a point is worked out here, for a batch of points at a time.

use pulp::Simd;
use trueaxis_leastsquares::BLOCK_RANK_TOL;

use crate::free_points::{DATUM, FreePoints, PER_STATION, State};
use crate::single_points::SinglePoints;

/// Registers of points that are worked on together: their intermediate results stay in the first
/// level cache, and sums over them in registers.
pub(crate) const REGISTERS: usize = 8;

/// Most lanes of a register.
pub(crate) const MOST_LANES: usize = 8;

/// One register of each of a batch's vectors.
pub(crate) type Registers<S> = [<S as Simd>::f64s; REGISTERS];

/// The points of a batch, linearised.
pub(crate) struct Batch<S: Simd> {
    /// `g_j`, four for each station.
    pub(crate) shared: Vec<Registers<S>>,
    /// `v_j`, three for each station.
    pub(crate) orthonormal: Vec<Registers<S>>,
    /// `r_j`.
    pub(crate) residuals: Vec<Registers<S>>,
    /// `R⁻¹` by rows: 00 01 02 11 12 22.
    pub(crate) inverse_factor: [Registers<S>; 6],
    /// Lever arms of the datum's rotations.
    pub(crate) lever: [Registers<S>; 3],
    /// Points minus nominal ones, mm.
    pub(crate) deviation_mm: [Registers<S>; 3],
    /// The least of `pivot² - limit²` so far, relative: positive if all are good.
    slack: S::f64s,
    /// Coordinates of the points, the levers and the deviations, lane by lane.
    staged: [[f64; REGISTERS * MOST_LANES]; 9],
}

impl<S: Simd> Batch<S> {
    pub(crate) fn new(simd: S, stations: usize) -> Self {
        let zero = [simd.splat_f64s(0.0); REGISTERS];
        Self {
            shared: vec![zero; PER_STATION * stations],
            orthonormal: vec![zero; 3 * stations],
            residuals: vec![zero; stations],
            inverse_factor: [zero; 6],
            lever: [zero; 3],
            deviation_mm: [zero; 3],
            slack: simd.splat_f64s(f64::MAX),
            staged: [[0.0; REGISTERS * MOST_LANES]; 9],
        }
    }

    /// Linearises `registers` registers of points from `first` on.
    #[inline(always)]
    pub(crate) fn linearise(
        &mut self,
        simd: S,
        (single, model, state): (&SinglePoints, &FreePoints<'_>, &State),
        first: usize,
        registers: usize,
    ) {
        self.stage(model, state, first, registers * S::F64_LANES);
        for at in 0..registers {
            let place = first + at * S::F64_LANES;
            let mut position = [simd.splat_f64s(0.0); 3];
            for (axis, position) in position.iter_mut().enumerate() {
                *position = load::<S>(&self.staged[axis], at * S::F64_LANES);
                self.lever[axis][at] = load::<S>(&self.staged[3 + axis], at * S::F64_LANES);
                self.deviation_mm[axis][at] = load::<S>(&self.staged[6 + axis], at * S::F64_LANES);
            }
            let mut normal = [simd.splat_f64s(0.0); 6];
            for j in 0..single.stations {
                let column = j * single.points..(j + 1) * single.points;
                let length_mm = load::<S>(&single.lengths_mm[column.clone()], place);
                let weight = load::<S>(&single.weights[column], place);
                let station = &state.stations[j];
                let beam = [
                    simd.sub_f64s(position[0], simd.splat_f64s(station.x)),
                    simd.sub_f64s(position[1], simd.splat_f64s(station.y)),
                    simd.sub_f64s(position[2], simd.splat_f64s(station.z)),
                ];
                let squared = dot(simd, &beam, &beam);
                let distance = simd.sqrt_f64s(squared);
                let scale = simd.div_f64s(weight, distance);
                let u = scaled(simd, &beam, scale);
                for (axis, u) in u.into_iter().enumerate() {
                    self.shared[PER_STATION * j + axis][at] = u;
                }
                self.shared[PER_STATION * j + 3][at] = weight;
                let zero = simd.splat_f64s(state.dead_paths_mm[j]);
                let residual = simd.sub_f64s(simd.add_f64s(length_mm, zero), distance);
                self.residuals[j][at] = simd.mul_f64s(weight, residual);
                add_square(simd, &mut normal, &u);
            }
            let (mut inverse, [first_slack, second_slack]) = inverted_factor(simd, &normal);
            // A comparison with what is not a number is caught by the sums.
            self.slack = simd.min_f64s(self.slack, simd.min_f64s(first_slack, second_slack));
            let mut again = [simd.splat_f64s(0.0); 6];
            for j in 0..single.stations {
                let u = take3::<S>(&self.shared[PER_STATION * j..], at);
                let v = row_times_upper(simd, &u, &inverse);
                for (axis, v) in v.into_iter().enumerate() {
                    self.orthonormal[3 * j + axis][at] = v;
                }
                add_square(simd, &mut again, &v);
            }
            let (correction, _) = inverted_factor(simd, &again);
            for j in 0..single.stations {
                let v = take3::<S>(&self.orthonormal[3 * j..], at);
                let v = row_times_upper(simd, &v, &correction);
                for (axis, v) in v.into_iter().enumerate() {
                    self.orthonormal[3 * j + axis][at] = v;
                }
            }
            inverse = upper_times_upper(simd, &inverse, &correction);
            for (all, x) in self.inverse_factor.iter_mut().zip(inverse) {
                all[at] = x;
            }
        }
    }

    /// Whether all pivots so far were good.
    #[inline(always)]
    pub(crate) fn is_sound(&self, simd: S) -> bool {
        simd.reduce_min_f64s(self.slack) > 0.0
    }

    /// `R⁻¹` of the points of register `at`.
    #[inline(always)]
    pub(crate) fn inverse_factor_at(&self, at: usize) -> [S::f64s; 6] {
        let [t00, t01, t02, t11, t12, t22] = &self.inverse_factor;
        [t00[at], t01[at], t02[at], t11[at], t12[at], t22[at]]
    }

    /// Puts the coordinates of points into lanes.
    #[inline(always)]
    fn stage(&mut self, model: &FreePoints<'_>, state: &State, first: usize, count: usize) {
        let nominal_mm = &model.network().nominal_mm[first..first + count];
        let points = &state.points[first..first + count];
        for (lane, (point, nominal)) in points.iter().zip(nominal_mm).enumerate() {
            let lever = model.lever(*nominal);
            for axis in 0..3 {
                self.staged[axis][lane] = point[axis];
                self.staged[3 + axis][lane] = lever[axis];
                self.staged[6 + axis][lane] = point[axis] - nominal[axis];
            }
        }
    }
}

/// A register of a column from place `first` on.
#[inline(always)]
fn load<S: Simd>(column: &[f64], first: usize) -> S::f64s {
    S::as_simd_f64s(&column[first..first + S::F64_LANES]).0[0]
}

/// Register `at` of each of the first three vectors.
#[inline(always)]
pub(crate) fn take3<S: Simd>(vectors: &[Registers<S>], at: usize) -> [S::f64s; 3] {
    [vectors[0][at], vectors[1][at], vectors[2][at]]
}

#[inline(always)]
pub(crate) fn scaled<S: Simd>(simd: S, a: &[S::f64s; 3], factor: S::f64s) -> [S::f64s; 3] {
    [
        simd.mul_f64s(a[0], factor),
        simd.mul_f64s(a[1], factor),
        simd.mul_f64s(a[2], factor),
    ]
}

/// `x - a b`.
#[inline(always)]
fn less_product<S: Simd>(simd: S, x: S::f64s, a: S::f64s, b: S::f64s) -> S::f64s {
    simd.mul_add_f64s(simd.neg_f64s(a), b, x)
}

/// `a × b`.
#[inline(always)]
pub(crate) fn cross<S: Simd>(simd: S, a: &[S::f64s; 3], b: &[S::f64s; 3]) -> [S::f64s; 3] {
    [
        less_product(simd, simd.mul_f64s(a[1], b[2]), a[2], b[1]),
        less_product(simd, simd.mul_f64s(a[2], b[0]), a[0], b[2]),
        less_product(simd, simd.mul_f64s(a[0], b[1]), a[1], b[0]),
    ]
}

#[inline(always)]
fn reciprocal_root<S: Simd>(simd: S, x: S::f64s) -> S::f64s {
    simd.div_f64s(simd.splat_f64s(1.0), simd.sqrt_f64s(x))
}

#[inline(always)]
fn dot<S: Simd>(simd: S, a: &[S::f64s; 3], b: &[S::f64s; 3]) -> S::f64s {
    let sum = simd.mul_f64s(a[0], b[0]);
    simd.mul_add_f64s(a[2], b[2], simd.mul_add_f64s(a[1], b[1], sum))
}

/// `N += u uᵀ`; elements 00 01 02 11 12 22.
#[inline(always)]
fn add_square<S: Simd>(simd: S, normal: &mut [S::f64s; 6], u: &[S::f64s; 3]) {
    let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    for (n, (i, k)) in normal.iter_mut().zip(pairs) {
        *n = simd.mul_add_f64s(u[i], u[k], *n);
    }
}

/// `R⁻¹` of `N = RᵀR`, upper triangular (00 01 02 11 12 22), and by how much the squares of the second and
/// third pivot, times that of their column, are above the limit.
#[inline(always)]
fn inverted_factor<S: Simd>(simd: S, n: &[S::f64s; 6]) -> ([S::f64s; 6], [S::f64s; 2]) {
    let limit = simd.splat_f64s(BLOCK_RANK_TOL * BLOCK_RANK_TOL);
    let t00 = reciprocal_root(simd, n[0]);
    let (r01, r02) = (simd.mul_f64s(n[1], t00), simd.mul_f64s(n[2], t00));
    let left1 = less_product(simd, n[3], r01, r01);
    let t11 = reciprocal_root(simd, left1);
    let r12 = simd.mul_f64s(less_product(simd, n[4], r01, r02), t11);
    let left2 = less_product(simd, less_product(simd, n[5], r02, r02), r12, r12);
    let t22 = reciprocal_root(simd, left2);
    let slack = [
        less_product(simd, left1, limit, n[3]),
        less_product(simd, left2, limit, n[5]),
    ];
    let zero = simd.splat_f64s(0.0);
    let t01 = less_product(simd, zero, simd.mul_f64s(t00, r01), t11);
    let t12 = less_product(simd, zero, simd.mul_f64s(t11, r12), t22);
    let sum = simd.mul_add_f64s(r01, t12, simd.mul_f64s(r02, t22));
    let t02 = less_product(simd, zero, sum, t00);
    ([t00, t01, t02, t11, t12, t22], slack)
}

/// `uᵀ T` for an upper triangular `T`.
#[inline(always)]
pub(crate) fn row_times_upper<S: Simd>(
    simd: S,
    u: &[S::f64s; 3],
    t: &[S::f64s; 6],
) -> [S::f64s; 3] {
    let third = simd.mul_add_f64s(u[1], t[4], simd.mul_f64s(u[0], t[2]));
    [
        simd.mul_f64s(u[0], t[0]),
        simd.mul_add_f64s(u[1], t[3], simd.mul_f64s(u[0], t[1])),
        simd.mul_add_f64s(u[2], t[5], third),
    ]
}

/// `T y` for an upper triangular `T`.
#[inline(always)]
pub(crate) fn upper_times<S: Simd>(simd: S, t: &[S::f64s; 6], y: &[S::f64s; 3]) -> [S::f64s; 3] {
    let first = simd.mul_add_f64s(t[1], y[1], simd.mul_f64s(t[0], y[0]));
    [
        simd.mul_add_f64s(t[2], y[2], first),
        simd.mul_add_f64s(t[4], y[2], simd.mul_f64s(t[3], y[1])),
        simd.mul_f64s(t[5], y[2]),
    ]
}

/// The product of two upper triangular matrices.
#[inline(always)]
fn upper_times_upper<S: Simd>(simd: S, a: &[S::f64s; 6], b: &[S::f64s; 6]) -> [S::f64s; 6] {
    let zero = simd.splat_f64s(0.0);
    let [c00, c01, c02] = row_times_upper(simd, &[a[0], a[1], a[2]], b);
    let [_, c11, c12] = row_times_upper(simd, &[zero, a[3], a[4]], b);
    [c00, c01, c02, c11, c12, simd.mul_f64s(a[5], b[5])]
}

/// `[W | c]` for the register `at`: rows of `W = R⁻ᵀH` and `c`.
#[inline(always)]
pub(crate) fn weighted_datum<S: Simd>(
    simd: S,
    batch: &Batch<S>,
    at: usize,
) -> [[S::f64s; DATUM]; 3] {
    let zero = simd.splat_f64s(0.0);
    let [t00, t01, t02, t11, t12, t22] = batch.inverse_factor_at(at);
    let lever = take3::<S>(&batch.lever, at);
    // Row i of R⁻ᵀ is column i of R⁻¹; the columns of H are e, then e × lever.
    let rows = [[t00, zero, zero], [t01, t11, zero], [t02, t12, t22]];
    let mut weighted = [[zero; DATUM]; 3];
    for (weighted, row) in weighted.iter_mut().zip(&rows) {
        weighted[..3].copy_from_slice(row);
        weighted[3..].copy_from_slice(&cross(simd, &lever, row));
    }
    weighted
}

//! The passes for points that are groups of their own and read once from each station: lengths in
//! columns, and several points at a time in the lanes of wide registers.
//!
//! A point's whitened rows are `[U | B | r]` with one row for each station `j`: `u_j`, and in the columns
//! of the station `-g_j = -(u_j, w_j)`, where `w_j` is the reciprocal standard deviation (zero where
//! there is no reading). Orthonormal columns `V = U R⁻¹` and the projection `P = 1 - V Vᵀ` on what they
//! leave give the point's part of the reduced system ([`trueaxis_leastsquares::Reduced`]):
//!
//! ```text
//! (s_j, s_k): g_j P_jk g_kᵀ       (s_j, [λ, 1]): g_j (v_jᵀ [W, c] - [0, r_j])
//! ([λ, 1], [λ, 1]): -[W, c]ᵀ [W, c]        W = R⁻ᵀH    c = Vᵀr
//! ```
//!
//! Beams nearly in a plane would spoil `R` from `UᵀU = RᵀR`, whose relative error is `ε κ²`. The same
//! step is made a second time with `V` instead of `U` (`CholeskyQR2`; Y. Yamamoto et al., "Roundoff error
//! analysis of the `CholeskyQR2` algorithm", ETNA 44, 2015): the columns are then as orthonormal as
//! reflections make them for every condition up to 1e8, beyond what counts as determined, and there is
//! no branch in it. A pivot of `UᵀU` itself is known to a few `ε`, so whether it is below the limit, whose
//! square is 1e-12, can be decided. If one is, or something is not finite, the piece is looked through
//! group by group for the error to report.
//!
//! Why lanes by hand: sums over points are chains that a compiler may not regroup, so plain loops
//! stay scalar; with them, and the widest instructions that the processor has, a pass takes a quarter
//! of the time. [`pulp`] chooses the instructions at run time and needs no `unsafe` here.

use std::ops::Range;

use nalgebra::Point3;
use pulp::{Arch, Simd, WithSimd};
use trueaxis_leastsquares::{Error as LeastSquaresError, FactorsMut, Reduced};

use crate::free_points::{DATUM, FreePoints, PER_STATION, State};
use crate::group_equations::GroupMemory;
use crate::single_point_batch::{
    Batch, MOST_LANES, REGISTERS, scaled, take3, upper_times, weighted_datum,
};
use crate::single_point_sums::Sums;

/// Lengths in columns.
pub(crate) struct SinglePoints {
    pub(crate) stations: usize,
    pub(crate) points: usize,
    /// Length of every point from the first station, then from the second, and so on, mm.
    pub(crate) lengths_mm: Vec<f64>,
    /// Reciprocal standard deviations in the same order, 1/mm; zero without a reading.
    pub(crate) weights: Vec<f64>,
}

impl SinglePoints {
    /// `None` unless each group is one point, without interruptions, read at most once from each
    /// station.
    pub(crate) fn new(model: &FreePoints<'_>) -> Option<Self> {
        let network = model.network();
        let (stations, points) = (network.stations.len(), network.groups.len());
        if network.nominal_mm.len() != points || !network.interruptions.is_empty() {
            return None;
        }
        let mut single = Self {
            stations,
            points,
            lengths_mm: vec![0.0; stations * points],
            weights: vec![0.0; stations * points],
        };
        for (v, visit) in network.visits.iter().enumerate() {
            let place = visit.station * points + visit.group;
            match network.readings_of(visit) {
                [] => {}
                [reading] if single.weights[place] <= 0.0 => {
                    single.lengths_mm[place] = reading.length_mm;
                    single.weights[place] = 1.0 / model.factor(v)[0];
                }
                _ => return None,
            }
        }
        Some(single)
    }

    /// The reduced system of a piece.
    pub(crate) fn reduce(
        &self,
        model: &FreePoints<'_>,
        state: &State,
        piece: Range<usize>,
    ) -> Result<Reduced, LeastSquaresError> {
        let arch = Arch::new();
        let (single, range) = (self, piece.clone());
        let (mut reduced, done, sound) = arch.dispatch(Reduce {
            single,
            model,
            state,
            range,
        });
        let mut memory = GroupMemory::new(model);
        // What did not fill all lanes.
        for group in done..piece.end {
            model.eliminate_group(state, group, &mut memory)?;
            model.reduce_group(group, &memory, &mut reduced);
        }
        if !sound {
            for group in piece {
                model.eliminate_group(state, group, &mut memory)?;
            }
        }
        Ok(reduced)
    }

    /// The points of a piece moved by `factor` times the correction that belongs to `t`.
    pub(crate) fn step(
        &self,
        model: &FreePoints<'_>,
        state: &State,
        (t, factor): (&[f64], f64),
        piece: Range<usize>,
        moved: &mut [Point3<f64>],
    ) -> Result<(), LeastSquaresError> {
        let arch = Arch::new();
        let (single, range) = (self, piece.clone());
        let done = arch.dispatch(Step {
            single,
            model,
            state,
            range,
            t,
            factor,
            moved: &mut *moved,
        });
        let (mut memory, mut x) = (GroupMemory::new(model), Vec::new());
        for group in done..piece.end {
            model.correct_group(state, group, t, &mut memory, &mut x)?;
            for (axis, x) in x.iter().enumerate() {
                moved[group - piece.start][axis] = state.points[group][axis] + factor * x;
            }
        }
        Ok(())
    }

    /// The factors of a piece.
    pub(crate) fn factors(
        &self,
        model: &FreePoints<'_>,
        state: &State,
        piece: Range<usize>,
        factors: &mut FactorsMut<'_>,
    ) -> Result<(), LeastSquaresError> {
        let arch = Arch::new();
        let (single, range) = (self, piece.clone());
        let done = arch.dispatch(FillFactors {
            single,
            model,
            state,
            range,
            factors: &mut *factors,
        });
        let mut memory = GroupMemory::new(model);
        for group in done..piece.end {
            model.eliminate_group(state, group, &mut memory)?;
            factors.set(group, &memory.block);
        }
        Ok(())
    }
}

/// Sums of the points that fill whole registers; the first point that does not; whether all points
/// are determined.
struct Reduce<'a> {
    single: &'a SinglePoints,
    model: &'a FreePoints<'a>,
    state: &'a State,
    range: Range<usize>,
}

impl WithSimd for Reduce<'_> {
    type Output = (Reduced, usize, bool);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let stations = self.single.stations;
        let mut batch = Batch::new(simd, stations);
        let mut sums = Sums::new(simd, stations);
        let mut squares = simd.splat_f64s(0.0);
        let (batches, end) = batches::<S>(&self.range);
        for (first, registers) in batches {
            let content = (self.single, self.model, self.state);
            batch.linearise(simd, content, first, registers);
            for residuals in &batch.residuals {
                for r in &residuals[..registers] {
                    squares = simd.mul_add_f64s(*r, *r, squares);
                }
            }
            sums.add(simd, &batch, registers);
        }
        let mut reduced = Reduced::new(self.model.shared(), DATUM);
        sums.add_to(simd, &mut reduced);
        let count = end - self.range.start;
        let squares = simd.reduce_sum_f64s(squares);
        reduced.count(
            self.single.readings(self.range.start..end),
            3 * count,
            squares,
        );
        let sound = batch.is_sound(simd) && reduced.is_finite();
        (reduced, end, sound)
    }
}

impl SinglePoints {
    /// Number of readings of some points.
    fn readings(&self, points: Range<usize>) -> usize {
        let columns = self.weights.chunks_exact(self.points.max(1));
        let count = |column: &[f64]| column[points.clone()].iter().filter(|&&w| w > 0.0).count();
        columns.map(count).sum()
    }
}

/// The batches of a range, each as its first point and a number of registers, and the first point that
/// does not fill a register.
fn batches<S: Simd>(range: &Range<usize>) -> (impl Iterator<Item = (usize, usize)>, usize) {
    let all = range.len() / S::F64_LANES;
    let (start, lanes) = (range.start, S::F64_LANES);
    let batches = (0..all).step_by(REGISTERS);
    let batches = batches.map(move |done| (start + done * lanes, (all - done).min(REGISTERS)));
    (batches, start + all * lanes)
}

/// Moves the points that fill whole registers; the first that does not.
struct Step<'a> {
    single: &'a SinglePoints,
    model: &'a FreePoints<'a>,
    state: &'a State,
    range: Range<usize>,
    t: &'a [f64],
    factor: f64,
    moved: &'a mut [Point3<f64>],
}

impl WithSimd for Step<'_> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let stations = self.single.stations;
        let mut batch = Batch::new(simd, stations);
        let (s, multipliers) = self.t.split_at(self.model.shared());
        let factor = simd.splat_f64s(self.factor);
        let (batches, end) = batches::<S>(&self.range);
        for (first, registers) in batches {
            let content = (self.single, self.model, self.state);
            batch.linearise(simd, content, first, registers);
            for at in 0..registers {
                let t = batch.inverse_factor_at(at);
                // y = c - C s - W λ, of which Vᵀ (r + g s) first.
                let mut y = [simd.splat_f64s(0.0); 3];
                for j in 0..stations {
                    let mut r = batch.residuals[j][at];
                    let own = PER_STATION * j..PER_STATION * (j + 1);
                    for (g, s) in batch.shared[own.clone()].iter().zip(&s[own]) {
                        r = simd.mul_add_f64s(g[at], simd.splat_f64s(*s), r);
                    }
                    for (y, v) in y.iter_mut().zip(&batch.orthonormal[3 * j..]) {
                        *y = simd.mul_add_f64s(v[at], r, *y);
                    }
                }
                for (y, row) in y.iter_mut().zip(weighted_datum(simd, &batch, at)) {
                    for (w, multiplier) in row.into_iter().zip(multipliers) {
                        let taken = simd.mul_f64s(w, simd.splat_f64s(*multiplier));
                        *y = simd.sub_f64s(*y, taken);
                    }
                }
                let x = upper_times(simd, &t, &y);
                for (axis, x) in x.into_iter().enumerate() {
                    let mut lanes = [0.0; MOST_LANES];
                    S::as_mut_simd_f64s(&mut lanes).0[0] = simd.mul_f64s(factor, x);
                    let point = first + at * S::F64_LANES;
                    for (lane, x) in lanes[..S::F64_LANES].iter().enumerate() {
                        self.moved[point + lane - self.range.start][axis] =
                            self.state.points[point + lane][axis] + x;
                    }
                }
            }
        }
        end
    }
}

/// Fills the factors of the points that fill whole registers; the first that does not.
struct FillFactors<'a, 'b> {
    single: &'a SinglePoints,
    model: &'a FreePoints<'a>,
    state: &'a State,
    range: Range<usize>,
    factors: &'a mut FactorsMut<'b>,
}

impl WithSimd for FillFactors<'_, '_> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let stations = self.single.stations;
        let mut batch = Batch::new(simd, stations);
        let width = PER_STATION * stations + DATUM;
        // Z of the points of a register, columns contiguous.
        let mut couplings = vec![simd.splat_f64s(0.0); 3 * width];
        let (batches, end) = batches::<S>(&self.range);
        for (first, registers) in batches {
            let content = (self.single, self.model, self.state);
            batch.linearise(simd, content, first, registers);
            for at in 0..registers {
                let t = batch.inverse_factor_at(at);
                let (of_stations, of_datum) = couplings.split_at_mut(3 * PER_STATION * stations);
                for (j, columns) in of_stations.chunks_exact_mut(3 * PER_STATION).enumerate() {
                    let v = take3::<S>(&batch.orthonormal[3 * j..], at);
                    let x = scaled(simd, &upper_times(simd, &t, &v), simd.splat_f64s(-1.0));
                    for (k, column) in columns.chunks_exact_mut(3).enumerate() {
                        let g = batch.shared[PER_STATION * j + k][at];
                        for (z, x) in column.iter_mut().zip(x) {
                            *z = simd.mul_f64s(x, g);
                        }
                    }
                }
                let [a, b, c] = weighted_datum(simd, &batch, at);
                for (k, column) in of_datum.chunks_exact_mut(3).enumerate() {
                    column.copy_from_slice(&upper_times(simd, &t, &[a[k], b[k], c[k]]));
                }
                let zero = simd.splat_f64s(0.0);
                let [t00, t01, t02, t11, t12, t22] = t;
                let inverse_factor = [t00, zero, zero, t01, t11, zero, t02, t12, t22];
                for lane in 0..S::F64_LANES {
                    let point = first + at * S::F64_LANES + lane;
                    let (inverse, coupling) = self.factors.block_mut(point);
                    take_lane::<S>(&inverse_factor, lane, inverse);
                    take_lane::<S>(&couplings, lane, coupling);
                }
            }
        }
        end
    }
}

/// One lane of many registers.
#[inline(always)]
fn take_lane<S: Simd>(registers: &[S::f64s], lane: usize, values: &mut [f64]) {
    let lanes: &[f64] = pulp::bytemuck::cast_slice(registers);
    for (value, register) in values.iter_mut().zip(lanes.chunks_exact(S::F64_LANES)) {
        *value = register[lane];
    }
}

//! The exact gradient and the correction of eight groups.

use std::sync::Arc;

use nalgebra::Vector3;
use trueaxis_leastsquares::lane_products::add_product;
use trueaxis_leastsquares::{LANES, Lanes, add_times, lanes_only, zeros};

use crate::batch_influence::{BatchInfluence, BatchRows};
use crate::batches::Batch;
use crate::beams::take_points;
use crate::lane_vectors::{LaneVector, add, at, cross, dot, minus, plus, splat, times};
use crate::slots::Slots;
use crate::state::{DATUM, PER_STATION, zero_column};
use crate::tie::Tie;

/// Eight groups of a solved network.
#[derive(Debug, Clone)]
pub(crate) struct TrialGroups {
    batches: Arc<Vec<Batch>>,
    /// The number of the batch.
    number: usize,
    unknowns: usize,
    /// The reading of each slot; none where it is missing.
    readings: Vec<[Option<usize>; LANES]>,
    /// From the station of each slot to its point, mm, and the length of that vector.
    beams_mm: Vec<[Lanes; 3]>,
    distances_mm: Vec<Lanes>,
    /// `P = C⁻¹` of each visit, rows one after the other; zero where a reading is missing.
    weights: Vec<Lanes>,
    /// The column of the dead path of each slot, where it is not the station's in all lanes.
    zeros: Vec<[usize; LANES]>,
    tie: Option<Tie>,
    /// Lever arms of the rotations of the datum at the nominal points, x y z of each; and one in lanes with a group,
    /// zero in others.
    levers: Vec<Lanes>,
    used: Lanes,
    /// `D` and `Z`, rows one after the other.
    own: Vec<Lanes>,
    coupling: Vec<Lanes>,
}

/// Values of the unknowns: those of eight groups, and the shared ones.
pub(crate) struct At<'a> {
    pub(crate) own: &'a [Lanes],
    pub(crate) shared: &'a [f64],
}

/// Intermediate results of one correction.
#[derive(Debug, Clone, Default)]
pub(crate) struct Scratch {
    /// Displacements of the points, x y z of each, mm, and the gradient with respect to them.
    moved: Vec<Lanes>,
    forces: Vec<Lanes>,
    /// Arms after the deformation, and after the rotation.
    arms: Vec<Lanes>,
    turned: Vec<Lanes>,
    residuals: Vec<Lanes>,
    units: Vec<[Lanes; 3]>,
}

/// A vector turned by a rotation vector, to second order: the third-order part is below 1e-15 of it.
#[inline(always)]
fn turned(by: LaneVector, x: LaneVector) -> LaneVector {
    let once = cross(by, x);
    let twice = times(cross(by, once), Lanes::splat(0.5));
    plus(x, plus(once, twice))
}

impl TrialGroups {
    /// Batch `b` with these rows; `slots` has the places of its readings.
    pub(crate) fn new(
        influence: &BatchInfluence<'_>,
        b: usize,
        rows: &BatchRows,
        slots: &Slots<'_>,
    ) -> Self {
        let batches = influence.batches();
        let (batch, state) = (&batches[b], &influence.state);
        let mut readings = vec![[None; LANES]; batch.slots()];
        for (lane, _) in batch.groups.clone().enumerate() {
            for &(slot, reading) in slots.places(lane) {
                readings[slot][lane] = Some(reading);
            }
        }
        let points = rows.points_mm();
        let (mut beams_mm, mut distances_mm) = (Vec::new(), Vec::new());
        for visit in &batch.layout.visits {
            let station = state.stations[visit.station];
            let station = splat(station.x, station.y, station.z);
            for slot in visit.slots.clone() {
                let point = at(points, batch.layout.point_of_slot[slot]);
                let beam_mm = minus(point, station);
                distances_mm.push(dot(beam_mm, beam_mm).sqrt());
                beams_mm.push(beam_mm);
            }
        }
        let mut weights = Vec::new();
        for visit in rows.visits(batch) {
            let (count, errors) = (visit.slots.len(), visit.unit_errors);
            let first = weights.len();
            weights.resize(first + count * count, Lanes::ZERO);
            add_product(&mut weights[first..], errors.transposed(), errors);
        }
        // A repeated group would count twice.
        let used = Lanes::mask(batch.groups.len());
        let mut levers = Vec::new();
        let nominal_mm = batch.own(&influence.model.network.nominal_mm);
        take_points(batch, nominal_mm, &mut levers);
        let datum = influence.model.datum;
        let per_radius = Lanes::splat(1.0 / datum.radius_mm);
        for (k, lever) in levers.iter_mut().enumerate() {
            *lever = (*lever - Lanes::splat(datum.centroid[k % 3])) * per_radius;
        }
        weights
            .iter_mut()
            .for_each(|weight| *weight = *weight * used);
        let stations = state.stations.len();
        let columns = |zeros: &[usize; LANES]| zeros.map(|zero| zero_column(zero, stations));
        let factors = influence.factors(b);
        let unknowns = factors.coupling.rows();
        let mut own = vec![Lanes::ZERO; unknowns * unknowns];
        let factor = factors.inverse_factor;
        add_product(&mut own, factor, factor.transposed());
        let coupling = (0..unknowns).flat_map(|k| factors.coupling.row(k).to_vec());
        Self {
            batches: Arc::clone(batches),
            number: b,
            unknowns,
            readings,
            beams_mm,
            distances_mm,
            weights,
            zeros: batch.zeros.iter().map(columns).collect(),
            tie: batch.body.map(|_| rows.tie().clone()),
            levers,
            used,
            own,
            coupling: coupling.collect(),
        }
    }

    pub(crate) fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Number of slots.
    pub(crate) fn slots(&self) -> usize {
        self.readings.len()
    }

    #[inline(always)]
    fn batch(&self) -> &Batch {
        &self.batches[self.number]
    }

    #[inline(always)]
    fn points(&self) -> usize {
        self.batch().points
    }

    /// Writes the errors of the readings of each slot, zero where a reading is missing.
    pub(crate) fn take_errors(&self, errors_mm: &[f64], of_slots: &mut [Lanes]) {
        for (errors, readings) in of_slots.iter_mut().zip(&self.readings) {
            *errors = Lanes::from_fn(|lane| readings[lane].map_or(0.0, |i| errors_mm[i]));
        }
    }

    /// Computes the displacements of the points; for tied points also their present arms.
    #[inline(always)]
    fn displace(&self, values: &At<'_>, scratch: &mut Scratch) {
        let Scratch {
            moved,
            arms,
            turned: after,
            ..
        } = scratch;
        let Some(tied) = &self.tie else {
            moved.clear();
            moved.extend_from_slice(values.own);
            return;
        };
        zeros(moved, 3 * self.points());
        arms.clear();
        arms.extend_from_slice(&tied.arms_mm);
        let deformations = tied.deformations.chunks_exact(3 * self.points());
        for (deformation, amount) in deformations.zip(&values.shared[tied.first..]) {
            let amount = Lanes::splat(*amount);
            for (arm, x) in arms.iter_mut().zip(deformation) {
                *arm = amount.mul_add(*x, *arm);
            }
        }
        zeros(after, 3 * self.points());
        let (shift, turn) = (at(values.own, 0), at(values.own, 1));
        for point in 0..self.points() {
            let arm = turned(turn, at(arms, point));
            let before = at(&tied.arms_mm, point);
            after[3 * point..3 * point + 3].copy_from_slice(&arm);
            let by = plus(shift, minus(arm, before));
            moved[3 * point..3 * point + 3].copy_from_slice(&by);
        }
    }

    /// Adds what the displaced points lack of satisfying the constraints of the datum: for turned bodies it is of
    /// second order.
    #[inline(always)]
    pub(crate) fn add_to_closure(&self, closure: &mut [Lanes; DATUM], scratch: &Scratch) {
        for point in 0..self.points() {
            let moved = times(at(&scratch.moved, point), self.used);
            add(&mut closure[..3], moved);
            add(&mut closure[3..], cross(at(&self.levers, point), moved));
        }
    }

    /// Writes the exact gradient with respect to the groups' unknowns at these values, and adds that of the shared
    /// ones.
    #[inline(always)]
    pub(crate) fn gradient(
        &self,
        errors_mm: &[Lanes],
        values: &At<'_>,
        (own, shared): (&mut [Lanes], &mut [Lanes]),
        scratch: &mut Scratch,
    ) {
        self.displace(values, scratch);
        self.take_residuals(errors_mm, values, scratch);
        let Scratch {
            forces,
            residuals,
            units,
            turned: arms,
            ..
        } = scratch;
        zeros(forces, 3 * self.points());
        let mut weights = self.weights.as_slice();
        let batch = self.batch();
        for visit in &batch.layout.visits {
            let count = visit.slots.len();
            let of_visit = &residuals[visit.slots.clone()];
            let station = PER_STATION * visit.station;
            for slot in visit.slots.clone() {
                let (row, rest) = weights.split_at(count);
                weights = rest;
                let mut weighted = Lanes::ZERO;
                for (p, r) in row.iter().zip(of_visit) {
                    weighted = p.mul_add(*r, weighted);
                }
                let force = times(units[slot], weighted);
                let point = batch.layout.point_of_slot[slot];
                add(&mut forces[3 * point..], force);
                for (sum, x) in shared[station..].iter_mut().zip(force) {
                    *sum -= x;
                }
                let contrasts = batch.contrasts_of(point);
                let first = shared.len() - contrasts.len();
                add_times(&mut shared[first..], weighted, contrasts);
                match self.zeros.get(slot) {
                    None => shared[station + PER_STATION - 1] -= weighted,
                    Some(columns) => {
                        for (lane, &column) in columns.iter().enumerate() {
                            shared[column].0[lane] -= weighted.0[lane];
                        }
                    }
                }
            }
        }
        let Some(tied) = &self.tie else {
            own.copy_from_slice(forces);
            return;
        };
        own.fill(Lanes::ZERO);
        for point in 0..self.points() {
            let force = at(forces, point);
            add(&mut own[..3], force);
            add(&mut own[3..], cross(at(arms, point), force));
        }
        let turn = at(values.own, 1);
        let columns = shared[tied.first..].iter_mut();
        let deformations = tied.deformations.chunks_exact(3 * self.points());
        for (deformation, sum) in deformations.zip(columns) {
            for point in 0..self.points() {
                let (x, force) = (turned(turn, at(deformation, point)), at(forces, point));
                *sum += dot(x, force);
            }
        }
    }

    /// Errors less the change of the lengths by the displaced points, stations and dead paths, and the beams there.
    #[inline(always)]
    fn take_residuals(&self, errors_mm: &[Lanes], values: &At<'_>, scratch: &mut Scratch) {
        let Scratch {
            moved,
            residuals,
            units,
            ..
        } = scratch;
        residuals.clear();
        units.clear();
        let batch = self.batch();
        for visit in &batch.layout.visits {
            let station = &values.shared[PER_STATION * visit.station..][..PER_STATION];
            let place = splat(station[0], station[1], station[2]);
            for slot in visit.slots.clone() {
                let point = batch.layout.point_of_slot[slot];
                let moved = minus(at(moved, point), place);
                let beam = plus(self.beams_mm[slot], moved);
                let distance = dot(beam, beam).sqrt();
                let dead_path = match self.zeros.get(slot) {
                    None => Lanes::splat(station[PER_STATION - 1]),
                    Some(columns) => Lanes::from_fn(|lane| values.shared[columns[lane]]),
                };
                let contrasts = batch.contrasts_of(point);
                let amounts = &values.shared[values.shared.len() - contrasts.len()..];
                let constant = product(contrasts, amounts, |a| Lanes::splat(*a));
                let longer = distance - self.distances_mm[slot] + constant;
                residuals.push(errors_mm[slot] + dead_path - longer);
                let per_distance = Lanes::splat(1.0) / distance;
                units.push(times(beam, per_distance));
            }
        }
    }

    /// Takes `Zᵀ g` off the right side.
    #[inline(always)]
    pub(crate) fn reduce(&self, gradient: &[Lanes], right: &mut [Lanes]) {
        for (row, g) in self.coupling.chunks_exact(right.len()).zip(gradient) {
            add_times(right, -*g, row);
        }
    }

    /// Adds `D g - Z (s, λ)` to the unknowns; returns the product of this correction with the gradient.
    #[inline(always)]
    pub(crate) fn correct(&self, step: &[f64], gradient: &[Lanes], own: &mut [Lanes]) -> Lanes {
        let mut along = Lanes::ZERO;
        let rows = self.own.chunks_exact(self.unknowns);
        let rows = rows.zip(self.coupling.chunks_exact(step.len()));
        for ((value, g), (d, z)) in own.iter_mut().zip(gradient).zip(rows) {
            let by_gradient = product(d, gradient, |g| *g);
            let by_shared = product(z, step, |s| Lanes::splat(*s));
            let correction = by_gradient - by_shared;
            *value += correction;
            along = g.mul_add(correction, along);
        }
        along * self.used
    }

    /// Writes the corrections of the groups, whose unknowns start at `starts`, and of their points.
    #[inline(always)]
    pub(crate) fn hand_out(
        &self,
        values: &At<'_>,
        (groups, starts): (&mut [f64], &[usize]),
        points: &mut [Vector3<f64>],
        scratch: &mut Scratch,
    ) {
        self.displace(values, scratch);
        let batch = self.batch();
        for (lane, group) in batch.groups.clone().enumerate() {
            for (value, x) in groups[starts[group]..].iter_mut().zip(values.own) {
                *value = x.0[lane];
            }
            let own = &mut points[batch.first_points[lane]..][..batch.points];
            for (k, point) in own.iter_mut().enumerate() {
                *point = Vector3::from(at(&scratch.moved, k).map(|x| x.0[lane]));
            }
        }
    }
}

/// `Σ a_i b_i` in four independent sums, which the processor adds side by side.
#[inline(always)]
fn product<T>(a: &[Lanes], b: &[T], in_lanes: impl Fn(&T) -> Lanes) -> Lanes {
    let ((a_fours, a_rest), (b_fours, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [Lanes::ZERO; 4];
    for ([a, b, c, d], [p, q, r, s]) in a_fours.iter().zip(b_fours) {
        lanes_only();
        sums[0] = a.mul_add(in_lanes(p), sums[0]);
        sums[1] = b.mul_add(in_lanes(q), sums[1]);
        sums[2] = c.mul_add(in_lanes(r), sums[2]);
        sums[3] = d.mul_add(in_lanes(s), sums[3]);
    }
    for (a, b) in a_rest.iter().zip(b_rest) {
        lanes_only();
        sums[0] = a.mul_add(in_lanes(b), sums[0]);
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

//! The whitened equations of eight groups.
//!
//! With the beam `u = (p - S) / |p - S|`:
//!
//! ```text
//! dl = uᵀ dp - uᵀ dS - dL + hᵀ da
//! ```
//!
//! with the contrasts `a` of the reflectors' constants ([`crate::reflectors`]), where a free point has three unknowns `dp` of its own. Points of a body have home positions `r_k`, common to
//! all groups, and a pose in each:
//!
//! ```text
//! p_k = R r_k + t       dp_k = dt + dω × (p_k - c) + R N_k ds
//! ```
//!
//! with the centroid `c` of the group's points and the deformations `s` of the body that no motion makes (three
//! for a triangle). Against free points this ties nine coordinates of a triangle to six unknowns. Rows are
//! multiplied by the weights `W = L⁻¹` of their visit, `C = L Lᵀ` ([`crate::noise`]).

use nalgebra::{DVector, Matrix3, Point3};
use trueaxis_leastsquares::{BlockBatch, LANES, Lanes, RowMut, Shape, lanes_only};

use crate::batches::Batch;
use crate::bodies::Bodies;
use crate::datum::Datum;
use crate::lane_vectors::{LaneVector, at, cross, dot, minus, plus, splat, times};
use crate::noise::{Noise, factor_len};
use crate::slots::SlotVisit;
use crate::state::{Common, DATUM, PER_STATION, POSE, State};

/// Beams and misclosures of the slots of a batch.
#[derive(Debug, Clone, Default)]
pub(crate) struct Beams {
    /// The points of the groups, x y z of each, mm.
    pub(crate) points: Vec<Lanes>,
    /// Their nominal places, where the datum is asked for.
    nominal: Vec<Lanes>,
    of_slots: Vec<Beam>,
}

/// The beam of a slot.
#[derive(Debug, Clone, Copy, Default)]
struct Beam {
    /// Unit vector from the station to the point.
    unit: LaneVector,
    distance_mm: Lanes,
    /// Observed minus computed length, mm.
    residual_mm: Lanes,
}

impl Beams {
    /// Takes the beams to the points of a batch ([`Batch::own`]).
    #[inline(always)]
    pub(crate) fn fill(&mut self, batch: &Batch, common: Common<'_>, points: &[Point3<f64>]) {
        let Common {
            stations,
            dead_paths_mm,
            contrasts_mm,
        } = common;
        take_points(batch, points, &mut self.points);
        self.of_slots.resize(batch.slots(), Beam::default());
        let lengths_mm = batch.lengths_mm();
        for visit in &batch.layout.visits {
            let station = stations[visit.station];
            let station = splat(station.x, station.y, station.z);
            let dead_path = Lanes::splat(dead_paths_mm[visit.station]);
            for slot in visit.slots.clone() {
                let point = batch.layout.point_of_slot[slot];
                let beam_mm = minus(at(&self.points, point), station);
                let distance_mm = dot(beam_mm, beam_mm).sqrt();
                let per_distance = Lanes::splat(1.0) / distance_mm;
                let dead_path = match batch.zeros.get(slot) {
                    Some(zeros) => Lanes::from_fn(|lane| dead_paths_mm[zeros[lane]]),
                    None => dead_path,
                };
                let mut constant = Lanes::ZERO;
                for (h, a) in batch.contrasts_of(point).iter().zip(contrasts_mm) {
                    lanes_only();
                    constant = h.mul_add(Lanes::splat(*a), constant);
                }
                self.of_slots[slot] = Beam {
                    unit: times(beam_mm, per_distance),
                    distance_mm,
                    residual_mm: lengths_mm[slot] + dead_path - constant - distance_mm,
                };
            }
        }
    }

    /// Sum of squares of the whitened misclosures; zero in lanes without a group.
    #[inline(always)]
    pub(crate) fn squares(&self, batch: &Batch, weights: &[Lanes]) -> Lanes {
        let mut weights = weights.iter();
        let mut squares = Lanes::ZERO;
        for visit in &batch.layout.visits {
            for i in visit.slots.clone() {
                let mut residual = Lanes::ZERO;
                for (beam, w) in self.of_slots[visit.slots.start..=i]
                    .iter()
                    .zip(&mut weights)
                {
                    residual = w.mul_add(beam.residual_mm, residual);
                }
                squares = residual.mul_add(residual, squares);
            }
        }
        let used = batch.groups.len();
        squares * Lanes::from_fn(|lane| f64::from(u8::from(lane < used)))
    }

    #[inline(always)]
    pub(crate) fn distance_mm(&self, slot: usize) -> Lanes {
        self.of_slots[slot].distance_mm
    }

    /// Cosine of the angle between the beams of two slots.
    #[inline(always)]
    fn cosine(&self, slot: usize, other: usize) -> Lanes {
        dot(self.of_slots[slot].unit, self.of_slots[other].unit)
    }
}

/// Fills the coordinates of the points of a batch ([`Batch::own`]), x y z of each.
#[inline(always)]
pub(crate) fn take_points(batch: &Batch, points: &[Point3<f64>], coordinates: &mut Vec<Lanes>) {
    coordinates.clear();
    let first = batch
        .first_points
        .map(|first| first - batch.first_points[0]);
    for point in 0..batch.points {
        let of_lanes = first.map(|first| &points[first + point]);
        for axis in [0, 1, 2] {
            let of_lane = |lane: usize| of_lanes[lane][axis];
            coordinates.push(Lanes::from_fn(of_lane));
        }
    }
}

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
    let own = own_variance(batch, noise, first + i, beams.distance_mm(first + i))
        + repeatability_variance;
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

/// What ties the points of a batch to poses.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tie {
    /// From the centroid of each group's points to these, mm, x y z of each.
    pub(crate) arms_mm: Vec<Lanes>,
    /// What a unit of each deformation does to the points, one deformation after the other, and the column of
    /// the first among the shared unknowns.
    pub(crate) deformations: Vec<Lanes>,
    pub(crate) first: usize,
}

impl Tie {
    /// Takes the points of a batch of a body with these deformations, the first of which has the column
    /// `first`.
    #[inline(always)]
    pub(crate) fn fill(
        &mut self,
        batch: &Batch,
        (state, points): (&State, &[Lanes]),
        bodies: &Bodies,
        (first, deformations): (usize, &[DVector<f64>]),
    ) {
        let count = batch.points;
        let mut sum = [Lanes::ZERO; 3];
        for point in 0..count {
            sum = plus(sum, at(points, point));
        }
        let centre = times(sum, Lanes::splat(1.0 / count as f64));
        self.arms_mm.clear();
        for point in 0..count {
            self.arms_mm.extend(minus(at(points, point), centre));
        }
        self.first = first;
        let group = |lane: usize| batch.groups.start + lane.min(batch.groups.len() - 1);
        let groups: [usize; LANES] = std::array::from_fn(group);
        let mut rotations = [Matrix3::zeros(); LANES];
        let mut places: [&[usize]; LANES] = [&[]; LANES];
        for (lane, &g) in groups.iter().enumerate() {
            rotations[lane] = state.poses[g].rotation.to_rotation_matrix().into_inner();
            places[lane] = &bodies.of_groups[g].places;
        }
        let column = |j: usize| -> LaneVector {
            [
                Lanes::from_fn(|lane| rotations[lane][(0, j)]),
                Lanes::from_fn(|lane| rotations[lane][(1, j)]),
                Lanes::from_fn(|lane| rotations[lane][(2, j)]),
            ]
        };
        let (x, y, z) = (column(0), column(1), column(2));
        self.deformations.clear();
        for deformation in deformations {
            let deformation = deformation.as_slice();
            for point in 0..count {
                let home = |axis: usize| {
                    Lanes::from_fn(|lane| deformation[3 * places[lane][point] + axis])
                };
                let turned = plus(
                    plus(times(x, home(0)), times(y, home(1))),
                    times(z, home(2)),
                );
                self.deformations.extend(turned);
            }
        }
    }
}

/// Fills the equations of a batch, which are not yet whitened; `shared` is the number of all shared unknowns.
/// The datum comes with the nominal points; without it there are no constraints. Points of a body come with
/// what ties them.
#[inline(always)]
pub(crate) fn fill(
    batch: &Batch,
    tie: Option<&Tie>,
    datum: Option<(&Datum, &[Point3<f64>])>,
    beams: &mut Beams,
    (stations, shared): (usize, usize),
    equations: &mut BlockBatch,
) {
    let in_runs = PER_STATION * stations;
    equations.reset(Shape {
        rows: batch.slots(),
        unknowns: tie.map_or(3 * batch.points, |_| POSE),
        in_runs,
        shared,
        datum: if datum.is_some() { DATUM } else { 0 },
    });
    for visit in &batch.layout.visits {
        for slot in visit.slots.clone() {
            let row = equations.row_mut(slot);
            *row.start = PER_STATION * visit.station;
            fill_row(
                (batch, slot),
                &beams.of_slots[slot],
                tie,
                (stations, in_runs),
                row,
            );
        }
    }
    if let Some((datum, nominal_mm)) = datum {
        take_points(batch, batch.own(nominal_mm), &mut beams.nominal);
        fill_datum(datum, beams, tie, equations);
    }
    equations.use_only(batch.groups.len());
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

/// The derivatives of a length by all unknowns: the only place where they stand.
#[inline(always)]
fn fill_row(
    (batch, slot): (&Batch, usize),
    beam: &Beam,
    tie: Option<&Tie>,
    (stations, in_runs): (usize, usize),
    row: RowMut<'_>,
) {
    let point = batch.layout.point_of_slot[slot];
    let u = beam.unit;
    match tie {
        None => row.own[3 * point..3 * point + 3].copy_from_slice(&u),
        Some(tie) => {
            row.own[..3].copy_from_slice(&u);
            row.own[3..].copy_from_slice(&cross(at(&tie.arms_mm, point), u));
            let moved = tie.deformations.chunks_exact(3 * batch.points);
            for (moved, x) in moved.zip(&mut row.others[tie.first - in_runs..]) {
                *x = dot(u, at(moved, point));
            }
        }
    }
    // The last shared unknowns.
    let contrasts = batch.contrasts_of(point);
    let first = row.others.len() - contrasts.len();
    row.others[first..].copy_from_slice(contrasts);
    for (x, u) in row.run.iter_mut().zip(u) {
        *x = -u;
    }
    *row.residual = beam.residual_mm;
    let minus = Lanes::splat(-1.0);
    let Some(zeros) = batch.zeros.get(slot) else {
        row.run[PER_STATION - 1] = minus;
        return;
    };
    for (lane, &zero) in zeros.iter().enumerate() {
        match zero.checked_sub(stations) {
            None => row.run[PER_STATION - 1].0[lane] = -1.0,
            Some(after) => row.others[after].0[lane] = -1.0,
        }
    }
}

/// `H` of the points, or of what ties them, and what they miss of the closure. The datum takes shapes as they
/// are.
#[inline(always)]
fn fill_datum(datum: &Datum, beams: &Beams, tie: Option<&Tie>, equations: &mut BlockBatch) {
    let centroid = splat(datum.centroid.x, datum.centroid.y, datum.centroid.z);
    let per_radius = Lanes::splat(1.0 / datum.radius_mm);
    let (one, zero) = (Lanes::splat(1.0), Lanes::ZERO);
    for point in 0..beams.points.len() / 3 {
        let (place, nominal) = (at(&beams.points, point), at(&beams.nominal, point));
        let lever = times(minus(nominal, centroid), per_radius);
        let [rx, ry, rz] = lever;
        let motions = [
            [one, zero, zero],
            [zero, one, zero],
            [zero, zero, one],
            [zero, -rz, ry],
            [rz, zero, -rx],
            [-ry, rx, zero],
        ];
        let shift = minus(place, nominal);
        let turn = cross(lever, shift);
        let missed = shift.into_iter().chain(turn);
        for (k, (motion, missed)) in motions.into_iter().zip(missed).enumerate() {
            let column = equations.datum_mut(k);
            match tie {
                None => column[3 * point..3 * point + 3].copy_from_slice(&motion),
                Some(tie) => {
                    let turned = cross(at(&tie.arms_mm, point), motion);
                    for (x, h) in column.iter_mut().zip(motion.into_iter().chain(turned)) {
                        *x += h;
                    }
                }
            }
            equations.closure_mut()[k] -= missed;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, Vector3};

    use super::*;
    use crate::batches::batches;
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

//! The whitened equations of eight groups with free points.
//!
//! With the beam `u = (p - S) / |p - S|`:
//!
//! ```text
//! dl = uᵀ dp - uᵀ dS - dL
//! ```
//!
//! and rows multiplied by the weights `W = L⁻¹` of their visit, `C = L Lᵀ` ([`crate::noise`]).

use nalgebra::Point3;
use trueaxis_leastsquares::{BlockBatch, LANES, Lanes, Shape};

use crate::batches::Batch;
use crate::datum::Datum;
use crate::noise::{Noise, factor_len};
use crate::slots::SlotVisit;
use crate::state::{DATUM, PER_STATION, State};

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
    unit: [Lanes; 3],
    distance_mm: Lanes,
    /// Observed minus computed length, mm.
    residual_mm: Lanes,
}

impl Beams {
    #[inline(always)]
    pub(crate) fn fill(&mut self, batch: &Batch, state: &State) {
        take_points(batch, &state.points, &mut self.points);
        self.of_slots.resize(batch.slots(), Beam::default());
        let lengths_mm = batch.lengths_mm();
        for visit in &batch.layout.visits {
            let station = state.stations[visit.station];
            let station = [station.x, station.y, station.z].map(Lanes::splat);
            let dead_path = Lanes::splat(state.dead_paths_mm[visit.station]);
            for slot in visit.slots.clone() {
                let point = &self.points[3 * batch.layout.point_of_slot[slot]..][..3];
                let [x, y, z] = [0, 1, 2].map(|axis| point[axis] - station[axis]);
                let distance_mm = z.mul_add(z, y.mul_add(y, x * x)).sqrt();
                let per_distance = Lanes::splat(1.0) / distance_mm;
                let dead_path = match batch.zeros.get(slot) {
                    Some(zeros) => Lanes::from_fn(|lane| state.dead_paths_mm[zeros[lane]]),
                    None => dead_path,
                };
                self.of_slots[slot] = Beam {
                    unit: [x, y, z].map(|x| x * per_distance),
                    distance_mm,
                    residual_mm: lengths_mm[slot] + dead_path - distance_mm,
                };
            }
        }
    }

    /// Mean of the points, x y z.
    #[inline(always)]
    pub(crate) fn centroid(&self) -> [Lanes; 3] {
        let mut sum = [Lanes::ZERO; 3];
        for (coordinate, x) in self.points.iter().enumerate() {
            sum[coordinate % 3] += *x;
        }
        let share = Lanes::splat(3.0 / self.points.len() as f64);
        sum.map(|x| x * share)
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
        let ([x, y, z], [a, b, c]) = (self.of_slots[slot].unit, self.of_slots[other].unit);
        x * a + y * b + z * c
    }
}

/// Fills the coordinates of the points of a batch, x y z of each.
#[inline(always)]
pub(crate) fn take_points(batch: &Batch, points: &[Point3<f64>], coordinates: &mut Vec<Lanes>) {
    coordinates.clear();
    for point in 0..batch.points {
        let of_lanes = batch.first_points.map(|first| &points[first + point]);
        for axis in [0, 1, 2] {
            let of_lane = |lane: usize| of_lanes[lane][axis];
            coordinates.push(Lanes::from_fn(of_lane));
        }
    }
}

/// The weights of a batch: `L⁻¹` of each visit row by row, with zero rows where there is no reading.
/// Without beams those of noise that is the same for all.
#[inline(always)]
pub(crate) fn fill_weights(
    batch: &Batch,
    noise: &Noise,
    beams: Option<&Beams>,
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
    beams: Option<&Beams>,
    (first, i): (usize, usize),
    factor: &mut Vec<Lanes>,
) {
    let return_variance = Lanes::splat(noise.return_sigma_mm * noise.return_sigma_mm);
    let there = is_read(batch, first + i);
    let start = factor.len();
    for j in 0..i {
        let cosine = beams.map_or(Lanes::ZERO, |beams| beams.cosine(first + i, first + j));
        let mut c = return_variance * cosine * there * is_read(batch, first + j);
        let above = factor_len(j);
        for k in 0..j {
            c = factor[start + k].mul_add(-factor[above + k], c);
        }
        factor.push(c / factor[above + j]);
    }
    let distance = beams.map_or(Lanes::ZERO, |beams| beams.of_slots[first + i].distance_mm);
    let own = own_variance(batch, noise, first + i, distance) + return_variance;
    let mut c = own * there + (Lanes::splat(1.0) - there);
    for x in &factor[start..] {
        c = x.mul_add(-*x, c);
    }
    factor.push(c.sqrt());
}

/// Variance of the length of a slot without the machine's return, mm².
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

/// Fills the equations of a batch; `weights` are those of [`fill_weights`], and `shared` is the number
/// of all shared unknowns. The datum comes with the nominal points; without it there are no
/// constraints.
#[inline(always)]
pub(crate) fn fill(
    (batch, weights): (&Batch, &[Lanes]),
    datum: Option<(&Datum, &[Point3<f64>])>,
    beams: &mut Beams,
    (stations, shared): (usize, usize),
    equations: &mut BlockBatch,
) {
    equations.reset(Shape {
        rows: batch.slots(),
        unknowns: 3 * batch.points,
        in_runs: PER_STATION * stations,
        shared,
        datum: if datum.is_some() { DATUM } else { 0 },
    });
    let mut weights = weights.iter();
    for visit in &batch.layout.visits {
        let first = visit.slots.start;
        for i in visit.slots.clone() {
            let (mut run, mut residual) = ([Lanes::ZERO; PER_STATION], Lanes::ZERO);
            for (j, &w) in (first..=i).zip(&mut weights) {
                let beam = &beams.of_slots[j];
                let own = 3 * batch.layout.point_of_slot[j];
                for (axis, u) in beam.unit.into_iter().enumerate() {
                    let x = w * u;
                    equations.own_mut(own + axis)[i] += x;
                    run[axis] -= x;
                }
                residual = w.mul_add(beam.residual_mm, residual);
                run[PER_STATION - 1] -= match batch.zeros.get(j) {
                    None => w,
                    Some(zeros) => after_interruption(equations, (stations, i), zeros, w),
                };
            }
            equations.residual_mut()[i] = residual;
            let (start, own) = equations.run_mut(i);
            (*start, *own) = (PER_STATION * visit.station, run);
        }
    }
    if let Some((datum, nominal_mm)) = datum {
        take_points(batch, nominal_mm, &mut beams.nominal);
        fill_datum(datum, beams, equations);
    }
    equations.use_only(batch.groups.len());
}

/// Writes the weights to the columns of dead paths after interruptions; what is left for the station's.
#[inline(always)]
fn after_interruption(
    equations: &mut BlockBatch,
    (stations, row): (usize, usize),
    zeros: &[usize; LANES],
    weights: Lanes,
) -> Lanes {
    let mut own = weights;
    for (lane, &zero) in zeros.iter().enumerate() {
        if zero >= stations {
            let column = PER_STATION * stations + zero - stations;
            equations.other_mut(column)[row].0[lane] -= weights.0[lane];
            own.0[lane] = 0.0;
        }
    }
    own
}

/// `H` of the points and what they miss of the closure.
#[inline(always)]
fn fill_datum(datum: &Datum, beams: &Beams, equations: &mut BlockBatch) {
    let centroid = [datum.centroid.x, datum.centroid.y, datum.centroid.z];
    let per_radius = Lanes::splat(1.0 / datum.radius_mm);
    let one = Lanes::splat(1.0);
    let of_points = beams.points.chunks_exact(3);
    for (point, (places, nominal)) in of_points.zip(beams.nominal.chunks_exact(3)).enumerate() {
        let place = 3 * point;
        let [rx, ry, rz] =
            [0, 1, 2].map(|axis| (nominal[axis] - Lanes::splat(centroid[axis])) * per_radius);
        let [dx, dy, dz] = [0, 1, 2].map(|axis| places[axis] - nominal[axis]);
        let zero = Lanes::ZERO;
        let motions = [
            [one, zero, zero],
            [zero, one, zero],
            [zero, zero, one],
            [zero, -rz, ry],
            [rz, zero, -rx],
            [-ry, rx, zero],
        ];
        let missed = [
            dx,
            dy,
            dz,
            ry * dz - rz * dy,
            rz * dx - rx * dz,
            rx * dy - ry * dx,
        ];
        for (k, (motion, missed)) in motions.into_iter().zip(missed).enumerate() {
            equations.datum_mut(k)[place..place + 3].copy_from_slice(&motion);
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
            return_sigma_mm: 1e-3,
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
        beams.fill(batch, &state);
        fill_weights(batch, &noise, Some(&beams), &mut Vec::new(), &mut weights);
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

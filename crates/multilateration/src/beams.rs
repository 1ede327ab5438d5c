//! Beams from the stations to the points of eight groups, and the misclosures `l + L - hᵀa - |p - S|` of their lengths.

use nalgebra::Point3;
use trueaxis_leastsquares::{Lanes, lanes_only};

use crate::batches::Batch;
use crate::lane_vectors::{LaneVector, at, dot, minus, splat, times};
use crate::state::Common;

/// Beams and misclosures of the slots of a batch.
#[derive(Debug, Clone, Default)]
pub(crate) struct Beams {
    /// The points of the groups, x y z of each, mm.
    pub(crate) points: Vec<Lanes>,
    /// Their nominal positions, where the datum is needed.
    pub(crate) nominal: Vec<Lanes>,
    pub(crate) of_slots: Vec<Beam>,
}

/// The beam of a slot.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Beam {
    /// Unit vector from the station to the point.
    pub(crate) unit: LaneVector,
    pub(crate) distance_mm: Lanes,
    /// [`LaneReturn::lever`](crate::returns::LaneReturn::lever); zero where nothing turns.
    pub(crate) lever: Lanes,
    /// Observed minus computed length, mm.
    pub(crate) residual_mm: Lanes,
}

impl Beams {
    /// Computes the beams to the points, and their misclosures.
    #[inline(always)]
    pub(crate) fn fill(&mut self, batch: &Batch, common: Common<'_>) {
        let Common {
            stations,
            dead_paths_mm,
            contrasts_mm,
        } = common;
        self.of_slots.resize(batch.slots(), Beam::default());
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
                let unit = times(beam_mm, per_distance);
                self.of_slots[slot] = Beam {
                    unit,
                    distance_mm,
                    lever: batch.returns.as_ref().map_or(Lanes::ZERO, |group| {
                        group.lever(unit, at(&self.points, point))
                    }),
                    residual_mm: batch.lengths_mm[slot] + dead_path - constant - distance_mm,
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
        squares * Lanes::mask(batch.groups.len())
    }

    /// Covariance of the lengths of two slots of a batch through the return of the machine, over the variance of the
    /// network's repeatability.
    #[inline(always)]
    pub(crate) fn returning(&self, batch: &Batch, slot: usize, other: usize) -> Lanes {
        let (a, b) = (&self.of_slots[slot], &self.of_slots[other]);
        let along = match slot == other {
            true => Lanes::splat(1.0),
            false => dot(a.unit, b.unit),
        };
        let own = batch.returns.as_ref().map(|group| group.variance_ratio);
        a.lever
            .mul_add(b.lever, own.map_or(along, |ratio| ratio * along))
    }
}

/// Fills the coordinates of the points of a batch ([`Batch::own`]), x y z of each.
#[inline(always)]
pub(crate) fn take_points(batch: &Batch, points: &[Point3<f64>], coordinates: &mut Vec<Lanes>) {
    coordinates.clear();
    let place =
        |lane: usize, point: usize| batch.first_points[lane] - batch.first_points[0] + point;
    for point in 0..batch.points {
        for axis in [0, 1, 2] {
            let of_lane = |lane: usize| points[place(lane, point)][axis];
            coordinates.push(Lanes::from_fn(of_lane));
        }
    }
}

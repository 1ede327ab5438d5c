//! The adjustment model: every point is free.
//!
//! Block unknowns are the coordinates of a group's points, shared ones the stations and dead
//! paths, four each: `x y z L`, and behind them the dead paths after interruptions. With the beam
//! `u = (p - S) / |p - S|`:
//!
//! ```text
//! dl = uᵀ dp - uᵀ dS - dL
//! ```

use std::ops::Range;

use nalgebra::{Point3, Vector3};
use trueaxis_leastsquares::{
    Adjustment, Arrowhead, BlockRows, Correction, Datum, Error as LeastSquaresError,
};

use crate::network::{Network, Visit};
use crate::noise::{Beam, factor_len, whiten};

/// Position and orientation.
pub(crate) const DATUM: usize = 6;

/// Unknowns of a station.
pub(crate) const PER_STATION: usize = 4;

/// Column of a dead path among the shared unknowns.
pub(crate) fn zero_column(zero: usize, stations: usize) -> usize {
    if zero < stations {
        PER_STATION * zero + PER_STATION - 1
    } else {
        PER_STATION * stations + zero - stations
    }
}

/// Values of all unknowns.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) stations: Vec<Point3<f64>>,
    /// One for each station, then one for each interruption.
    pub(crate) dead_paths_mm: Vec<f64>,
    pub(crate) points: Vec<Point3<f64>>,
}

impl State {
    /// Beam and distance from a station to a point.
    pub(crate) fn beam(&self, station: usize, point: usize) -> (Vector3<f64>, f64) {
        let beam = self.points[point] - self.stations[station];
        let distance = beam.norm();
        (beam / distance, distance)
    }
}

/// The model with its weights, which stay as they are while it is adjusted.
pub(crate) struct FreePoints<'a> {
    network: &'a Network,
    visits_by_group: Vec<Vec<usize>>,
    /// The dead path of every reading.
    zeros: Vec<usize>,
    factors: Vec<f64>,
    factor_starts: Vec<usize>,
    centroid: Point3<f64>,
    /// Rms distance of the nominal points from their centroid, mm: makes rotations of the datum
    /// comparable with translations.
    radius_mm: f64,
}

impl<'a> FreePoints<'a> {
    pub(crate) fn new(network: &'a Network, state: &State) -> Self {
        let count = network.nominal_mm.len().max(1) as f64;
        let sum: Vector3<f64> = network.nominal_mm.iter().map(|p| p.coords).sum();
        let centroid = Point3::from(sum / count);
        let squares: f64 = network
            .nominal_mm
            .iter()
            .map(|p| (p - centroid).norm_squared())
            .sum();
        let mut model = Self {
            network,
            visits_by_group: network.visits_by_group(),
            zeros: network.zero_of_readings(),
            factors: Vec::new(),
            factor_starts: Vec::new(),
            centroid,
            radius_mm: (squares / count).sqrt().max(f64::MIN_POSITIVE),
        };
        model.update_weights(state);
        model
    }

    /// Rms distance of the nominal points from their centroid, mm.
    pub(crate) fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Takes the weights from the beams at `state`.
    pub(crate) fn update_weights(&mut self, state: &State) {
        self.factors.clear();
        self.factor_starts.clear();
        let mut beams = Vec::new();
        for visit in &self.network.visits {
            beams.clear();
            for i in visit.readings.clone() {
                let point = self
                    .network
                    .point(visit.group, self.network.readings[i].point);
                let (direction, distance_mm) = state.beam(visit.station, point);
                beams.push(Beam {
                    direction,
                    distance_mm,
                    variance_factor: self.network.variance_factor(i),
                });
            }
            self.factor_starts.push(self.factors.len());
            self.network.noise.append_factor(&beams, &mut self.factors);
        }
    }

    pub(crate) fn factor(&self, visit: usize) -> &[f64] {
        let start = self.factor_starts[visit];
        &self.factors[start..start + factor_len(self.network.visits[visit].readings.len())]
    }

    /// Observed minus computed lengths of a visit, mm.
    pub(crate) fn residuals_mm<'b>(
        &'b self,
        state: &'b State,
        visit: &'b Visit,
    ) -> impl Iterator<Item = f64> + 'b {
        visit.readings.clone().map(move |i| {
            let reading = &self.network.readings[i];
            let point = self.network.point(visit.group, reading.point);
            let (_, distance) = state.beam(visit.station, point);
            reading.length_mm + state.dead_paths_mm[self.zeros[i]] - distance
        })
    }

    /// The motion of a point at `p` under the six free motions: translations along x, y, z, then
    /// rotations about them (scaled to the size of the network).
    fn free_motions_at(&self, p: Point3<f64>) -> [Vector3<f64>; DATUM] {
        let r = self.lever(p);
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
        [x, y, z, x.cross(&r), y.cross(&r), z.cross(&r)]
    }

    /// Lever arm of the rotations of the datum at `p`, in units of the radius.
    pub(crate) fn lever(&self, p: Point3<f64>) -> Vector3<f64> {
        (p - self.centroid) / self.radius_mm
    }

    /// Number of shared unknowns.
    pub(crate) fn shared(&self) -> usize {
        PER_STATION * self.network.stations.len() + self.network.interruptions.len()
    }

    /// The visits of a group, in the order of its rows.
    pub(crate) fn visits_of(&self, group: usize) -> &[usize] {
        &self.visits_by_group[group]
    }

    /// The dead path of a reading.
    pub(crate) fn zero_of(&self, reading: usize) -> usize {
        self.zeros[reading]
    }

    /// The whitened rows of a group, visit after visit.
    pub(crate) fn fill_rows(&self, state: &State, group: usize, rows: &mut BlockRows) {
        let visits = &self.visits_by_group[group];
        let count = visits
            .iter()
            .map(|&v| self.network.visits[v].readings.len())
            .sum();
        let unknowns = 3 * self.network.groups[group].len();
        rows.reset(count, unknowns, self.shared());
        let stations = self.network.stations.len();
        let behind_stations = PER_STATION * stations..self.shared();
        let mut first = 0;
        for &v in visits {
            let visit = &self.network.visits[v];
            let readings = self.network.readings_of(visit);
            let (end, shared) = (first + readings.len(), PER_STATION * visit.station);
            for (i, reading) in readings.iter().enumerate() {
                let (u, _) = state.beam(visit.station, self.network.point(group, reading.point));
                for axis in 0..3 {
                    rows.block_mut(3 * reading.point + axis)[first + i] = u[axis];
                    rows.shared_mut(shared + axis)[first + i] = -u[axis];
                }
                let zero = zero_column(self.zeros[visit.readings.start + i], stations);
                rows.shared_mut(zero)[first + i] = -1.0;
            }
            for (r, value) in rows.residual_mut()[first..end]
                .iter_mut()
                .zip(self.residuals_mm(state, visit))
            {
                *r = value;
            }
            let factor = self.factor(v);
            for k in 0..unknowns {
                whiten(factor, &mut rows.block_mut(k)[first..end]);
            }
            for k in (shared..shared + PER_STATION).chain(behind_stations.clone()) {
                whiten(factor, &mut rows.shared_mut(k)[first..end]);
            }
            whiten(factor, &mut rows.residual_mut()[first..end]);
            first = end;
        }
    }

    /// `H` of a group's points, best fit to the nominal ones n: `Σ (p - n) = 0` and
    /// `Σ n × (p - n) = 0`. Appends its columns and takes what the points miss from the closure.
    pub(crate) fn datum_of(
        &self,
        state: &State,
        group: Range<usize>,
        columns: &mut Vec<f64>,
        closure: &mut [f64],
    ) {
        let first = columns.len();
        columns.resize(first + 3 * group.len() * DATUM, 0.0);
        for (k, point) in group.clone().enumerate() {
            let nominal = self.network.nominal_mm[point];
            let deviation = state.points[point] - nominal;
            for (c, motion) in self.free_motions_at(nominal).iter().enumerate() {
                let start = first + 3 * (c * group.len() + k);
                columns[start..start + 3].copy_from_slice(motion.as_slice());
                closure[c] -= motion.dot(&deviation);
            }
        }
    }

    /// What the free motions do to `shared` shared unknowns, of which the first are the stations.
    pub(crate) fn free_motions(&self, state: &State, shared: usize) -> Vec<Vec<f64>> {
        let mut free_motions = vec![Vec::new(); DATUM];
        for station in &state.stations {
            for (all, motion) in free_motions.iter_mut().zip(self.free_motions_at(*station)) {
                all.extend([motion.x, motion.y, motion.z, 0.0]);
            }
        }
        for motion in &mut free_motions {
            motion.resize(shared, 0.0);
        }
        free_motions
    }

    /// Moves stations and dead paths by `factor` times the correction.
    pub(crate) fn move_stations(&self, moved: &mut State, correction: &Correction, factor: f64) {
        let stations = moved.stations.len();
        for (j, position) in moved.stations.iter_mut().enumerate() {
            let x = &correction.shared[PER_STATION * j..];
            *position += Vector3::new(x[0], x[1], x[2]) * factor;
        }
        for (zero, dead_path) in moved.dead_paths_mm.iter_mut().enumerate() {
            *dead_path += correction.shared[zero_column(zero, stations)] * factor;
        }
    }
}

impl Adjustment for FreePoints<'_> {
    type State = State;

    fn linearise(&self, state: &State) -> Result<(Arrowhead, Datum), LeastSquaresError> {
        let mut system = Arrowhead::new(self.shared(), DATUM);
        let mut closure = vec![0.0; DATUM];
        let mut rows = BlockRows::default();
        let mut datum = Vec::new();
        for (g, group) in self.network.groups.iter().enumerate() {
            self.fill_rows(state, g, &mut rows);
            datum.clear();
            self.datum_of(state, group.clone(), &mut datum, &mut closure);
            system.eliminate(&mut rows, &datum)?;
        }
        let free_motions = self.free_motions(state, self.shared());
        Ok((
            system,
            Datum {
                free_motions,
                closure,
            },
        ))
    }

    fn squares(&self, state: &State) -> f64 {
        let mut sum = 0.0;
        let mut residuals = Vec::new();
        for (v, visit) in self.network.visits.iter().enumerate() {
            residuals.clear();
            residuals.extend(self.residuals_mm(state, visit));
            whiten(self.factor(v), &mut residuals);
            sum += residuals.iter().map(|r| r * r).sum::<f64>();
        }
        sum
    }

    fn moved(&self, state: &State, correction: &Correction, factor: f64) -> State {
        let mut moved = state.clone();
        self.move_stations(&mut moved, correction, factor);
        for (g, group) in self.network.groups.iter().enumerate() {
            for (point, x) in group.clone().zip(correction.block(g).chunks_exact(3)) {
                moved.points[point] += Vector3::new(x[0], x[1], x[2]) * factor;
            }
        }
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Interruption, Noise, Reading};

    /// Analytic rows against central differences of the whitened residuals.
    #[test]
    fn rows_are_the_derivatives_of_the_lengths() {
        let network = Network {
            interruptions: vec![Interruption {
                station: 1,
                first_reading: 3,
            }],
            variance_factors: vec![1.0, 4.0, 1.0, 1.0],
            stations: vec![None; 2],
            nominal_mm: vec![Point3::new(0.0, 0.0, 0.0), Point3::new(100.0, 50.0, -30.0)],
            groups: std::iter::once(0..2).collect(),
            visits: (0..2)
                .map(|station| Visit {
                    station,
                    group: 0,
                    readings: 2 * station..2 * station + 2,
                })
                .collect(),
            readings: [(0, 700.0), (1, 810.0), (0, 500.0), (1, 420.0)]
                .map(|(point, length_mm)| Reading { point, length_mm })
                .to_vec(),
            noise: Noise {
                return_sigma_mm: 2e-3,
                ..Noise::default()
            },
        };
        let state = State {
            stations: vec![
                Point3::new(600.0, 300.0, 200.0),
                Point3::new(-300.0, 400.0, 100.0),
            ],
            dead_paths_mm: vec![3.0, 4.0, 5.0],
            points: vec![Point3::new(1.0, 2.0, 3.0), Point3::new(101.0, 49.0, -31.0)],
        };
        let model = FreePoints::new(&network, &state);
        let mut rows = BlockRows::default();
        model.fill_rows(&state, 0, &mut rows);
        let residuals = |state: &State| {
            let mut all = Vec::new();
            for (v, visit) in network.visits.iter().enumerate() {
                let mut r: Vec<f64> = model.residuals_mm(state, visit).collect();
                whiten(model.factor(v), &mut r);
                all.extend(r);
            }
            all
        };
        let step = 1e-4;
        for k in 0..15 {
            let shift = |state: &mut State, by: f64| match k {
                0..6 => state.points[k / 3][k % 3] += by,
                14 => state.dead_paths_mm[2] += by,
                _ if (k - 6) % 4 == 3 => state.dead_paths_mm[(k - 6) / 4] += by,
                _ => state.stations[(k - 6) / 4][(k - 6) % 4] += by,
            };
            let (mut plus, mut minus) = (state.clone(), state.clone());
            shift(&mut plus, step);
            shift(&mut minus, -step);
            let column = if k < 6 {
                rows.block_mut(k)
            } else {
                rows.shared_mut(k - 6)
            };
            for ((analytic, p), m) in column.iter().zip(residuals(&plus)).zip(residuals(&minus)) {
                let difference = (m - p) / (2.0 * step);
                // Whitened rows are of the order 1e3 per mm; differences are good to 1e-9 of that.
                assert!(
                    (analytic - difference).abs() < 1e-4,
                    "column {k}: {analytic} {difference}"
                );
            }
        }
    }
}

//! Whitened rows of free points, group by group in measuring order.
//!
//! [`crate::free_adjustment`] solves the same equations; here they are for what is asked of the result.
//! Block unknowns are the coordinates of a group's points, shared ones the stations and dead
//! paths, four each: `x y z L`, and behind them the dead paths after interruptions. With the beam
//! `u = (p - S) / |p - S|`:
//!
//! ```text
//! dl = uᵀ dp - uᵀ dS - dL
//! ```

use std::ops::Range;

use nalgebra::{Isometry3, Point3, Vector3};
use trueaxis_leastsquares::BlockRows;

use crate::network::{Network, Visit, VisitsByGroup};
use crate::noise::{Beam, factor_len, whiten};
use crate::passes::{in_parallel, pieces};

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
    /// Moves stations and points as a whole; dead paths stay.
    pub(crate) fn move_by(&mut self, motion: &Isometry3<f64>) {
        for place in self.stations.iter_mut().chain(&mut self.points) {
            *place = motion * *place;
        }
    }

    /// The farthest that a station or point is from where it is in `other`, mm.
    pub(crate) fn farthest_move_mm(&self, other: &Self) -> f64 {
        let of = |a: &[Point3<f64>], b: &[Point3<f64>]| {
            let squares = a.iter().zip(b).map(|(a, b)| (a - b).norm_squared());
            squares.fold(0.0, f64::max)
        };
        let stations = of(&self.stations, &other.stations);
        stations.max(of(&self.points, &other.points)).sqrt()
    }

    /// Beam and distance from a station to a point.
    pub(crate) fn beam(&self, station: usize, point: usize) -> (Vector3<f64>, f64) {
        let beam = self.points[point] - self.stations[station];
        let distance = beam.norm();
        (beam / distance, distance)
    }

    /// Observed minus computed length of a reading with the dead path `zero` over a distance, mm.
    pub(crate) fn residual_mm(&self, length_mm: f64, zero: usize, distance_mm: f64) -> f64 {
        length_mm + self.dead_paths_mm[zero] - distance_mm
    }

    /// Observed minus computed length of every reading, mm.
    pub(crate) fn residuals_mm(&self, network: &Network) -> Vec<f64> {
        let zeros = network.zero_of_readings();
        let mut residuals = Vec::with_capacity(network.readings.len());
        for visit in &network.visits {
            for i in visit.readings.clone() {
                let reading = &network.readings[i];
                let point = network.point(visit.group, reading.point);
                let (_, distance) = self.beam(visit.station, point);
                residuals.push(self.residual_mm(reading.length_mm, zeros[i], distance));
            }
        }
        residuals
    }
}

/// The model with its weights, which stay as they are while it is adjusted.
pub(crate) struct FreePoints<'a> {
    network: &'a Network,
    visits_by_group: VisitsByGroup,
    /// The dead path of every reading.
    zeros: Vec<usize>,
    factors: Vec<f64>,
    factor_starts: Vec<usize>,
}

impl<'a> FreePoints<'a> {
    pub(crate) fn new(network: &'a Network, state: &State) -> Self {
        let factors = in_parallel(pieces(network.visits.len()), |visits| {
            factors_of(network, state, visits)
        });
        let mut length = 0;
        let start = |visit: &Visit| {
            length += factor_len(visit.readings.len());
            length - factor_len(visit.readings.len())
        };
        Self {
            network,
            visits_by_group: network.visits_by_group(),
            zeros: network.zero_of_readings(),
            factor_starts: network.visits.iter().map(start).collect(),
            factors: factors.concat(),
        }
    }

    pub(crate) fn factor(&self, visit: usize) -> &[f64] {
        let start = self.factor_starts[visit];
        &self.factors[start..start + factor_len(self.network.visits[visit].readings.len())]
    }

    /// Number of shared unknowns.
    pub(crate) fn shared(&self) -> usize {
        PER_STATION * self.network.stations.len() + self.network.interruptions.len()
    }

    /// The visits of a group, in the order of its rows.
    pub(crate) fn visits_of(&self, group: usize) -> &[usize] {
        self.visits_by_group.of(group)
    }

    /// The dead path of a reading.
    pub(crate) fn zero_of(&self, reading: usize) -> usize {
        self.zeros[reading]
    }

    /// The whitened rows of a group, visit after visit.
    pub(crate) fn fill_rows(&self, state: &State, group: usize, rows: &mut BlockRows) {
        let visits = self.visits_by_group.of(group);
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
                let point = self.network.point(group, reading.point);
                let (u, distance) = state.beam(visit.station, point);
                for axis in 0..3 {
                    rows.block_mut(3 * reading.point + axis)[first + i] = u[axis];
                    rows.shared_mut(shared + axis)[first + i] = -u[axis];
                }
                let zero = self.zeros[visit.readings.start + i];
                rows.shared_mut(zero_column(zero, stations))[first + i] = -1.0;
                let residual = state.residual_mm(reading.length_mm, zero, distance);
                rows.residual_mut()[first + i] = residual;
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
}

/// The factors of the covariances of some visits with the beams at `state`, one after the other.
fn factors_of(network: &Network, state: &State, visits: Range<usize>) -> Vec<f64> {
    let mut factors = Vec::new();
    let mut beams = Vec::new();
    for visit in &network.visits[visits] {
        beams.clear();
        for i in visit.readings.clone() {
            let point = network.point(visit.group, network.readings[i].point);
            let (direction, distance_mm) = state.beam(visit.station, point);
            beams.push(Beam {
                direction,
                distance_mm,
                variance_factor: network.variance_factor(i),
            });
        }
        network.noise.append_factor(&beams, &mut factors);
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Interruption, Noise, Reading, Visit};

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
            let mut all = state.residuals_mm(&network);
            for (v, visit) in network.visits.iter().enumerate() {
                whiten(model.factor(v), &mut all[visit.readings.clone()]);
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

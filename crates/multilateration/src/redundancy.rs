//! Redundancy numbers: how far each length is checked by the others.

use faer::Mat;

use crate::free_points::{FreePoints, PER_STATION, State};
use crate::{Network, Solution};

impl Solution {
    /// Redundancy number of every reading, between 0 (nothing checks it: an error in it goes
    /// wholly into the result) and 1 (an error in it shows wholly in its residual). Their sum is
    /// [`Solution::degrees_of_freedom`].
    ///
    /// `r = diag(I - J Q Jᵀ C⁻¹)` with the Jacobian `J` and the covariance `Q` of the unknowns.
    /// `network` must be the one that was solved.
    pub fn redundancy_numbers(&self, network: &Network) -> Vec<f64> {
        let state = State {
            stations: self.stations.iter().map(|s| s.position_mm).collect(),
            dead_paths_mm: self.stations.iter().map(|s| s.dead_path_mm).collect(),
            points: self.points_mm.clone(),
        };
        let model = FreePoints::new(network, &state);
        let mut numbers = Vec::with_capacity(network.readings.len());
        for (v, visit) in network.visits.iter().enumerate() {
            let readings = network.readings_of(visit);
            let coupling = self.covariance.coupling(visit.group);
            let inverse_factor = self.covariance.inverse_factor(visit.group);
            let width = coupling.ncols();
            // Own part A R⁻¹ and shared part B - A Z of the Jacobian.
            let mut own = Mat::<f64>::zeros(readings.len(), coupling.nrows());
            let mut shared = Mat::<f64>::zeros(readings.len(), width);
            for (i, reading) in readings.iter().enumerate() {
                let point = network.point(visit.group, reading.point);
                let (u, _) = state.beam(visit.station, point);
                for axis in 0..3 {
                    let row = 3 * reading.point + axis;
                    for k in 0..coupling.nrows() {
                        own[(i, k)] += u[axis] * inverse_factor[(row, k)];
                    }
                    for k in 0..width {
                        shared[(i, k)] -= u[axis] * coupling[(row, k)];
                    }
                    shared[(i, PER_STATION * visit.station + axis)] -= u[axis];
                }
                shared[(i, PER_STATION * visit.station + 3)] -= 1.0;
            }
            let adjusted = &own * own.transpose()
                + &shared * self.covariance.reduced_inverse() * shared.transpose();
            // (J Q Jᵀ C⁻¹)_ii with C⁻¹ e_i from the Cholesky factor.
            for i in 0..readings.len() {
                let weights = column_of_inverse(model.factor(v), readings.len(), i);
                let used: f64 = (0..readings.len())
                    .map(|k| adjusted[(i, k)] * weights[k])
                    .sum();
                numbers.push(1.0 - used);
            }
        }
        numbers
    }
}

/// Column `i` of `(L Lᵀ)⁻¹` for a factor packed by rows.
fn column_of_inverse(factor: &[f64], n: usize, i: usize) -> Vec<f64> {
    let at = |row: usize, column: usize| factor[row * (row + 1) / 2 + column];
    let mut x = vec![0.0; n];
    x[i] = 1.0;
    for row in 0..n {
        let below: f64 = (0..row).map(|k| at(row, k) * x[k]).sum();
        x[row] = (x[row] - below) / at(row, row);
    }
    for row in (0..n).rev() {
        let above: f64 = (row + 1..n).map(|k| at(k, row) * x[k]).sum();
        x[row] = (x[row] - above) / at(row, row);
    }
    x
}

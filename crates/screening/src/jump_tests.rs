//! Tests of jumps in a station's zero (Baarda's w, as for a reading: [`trueaxis_multilateration::Tests`]).
//!
//! A jump is an equal error in all readings of a zero from an instant on: the sum `c = Σ e_i` of their unit
//! errors. With the whitened rows `O`, `T` of the hat matrix ([`Whitened`]) and the whitened `c`,
//!
//! ```text
//! w = cᵀv / √(cᵀc - Σ_groups |Oᵀ c|² - (Tᵀc)ᵀ Σ Tᵀc)
//! ```
//!
//! and all sums accumulate reading by reading.

use nalgebra::{DMatrix, DMatrixView};
use rayon::prelude::*;
use trueaxis_leastsquares::dot;
use trueaxis_multilateration::{CHECKED_TOL, Network, Whitened};

/// The test of a jump in a station's zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JumpTest {
    pub(crate) station: usize,
    pub(crate) first_reading: usize,
    /// Readings of the same zero before the jump, and after it.
    pub(crate) before: usize,
    pub(crate) after: usize,
    /// Standardised size of the jump.
    pub(crate) w: f64,
}

/// Steps whose part through the shared unknowns is computed together.
const JUMPS: usize = 32;

/// The most significant jump of every zero.
pub(crate) fn largest_jumps(network: &Network, rows: &Whitened) -> Vec<JumpTest> {
    let zeros = network.zero_of_readings();
    let mut occupations: Vec<Vec<(usize, usize)>> = vec![Vec::new(); network.zeros()];
    for (number, visit) in network.visits.iter().enumerate() {
        for reading in visit.readings.clone() {
            occupations[zeros[reading]].push((reading, number));
        }
    }
    let occupations = occupations.par_iter();
    let largest = occupations.filter_map(|occupation| largest_jump(occupation, network, rows));
    largest.collect()
}

/// Adds the readings of a zero (with their visits) one by one from the last to the first; the sum of unit errors
/// after each reading is the jump that begins with it.
fn largest_jump(
    occupation: &[(usize, usize)],
    network: &Network,
    rows: &Whitened,
) -> Option<JumpTest> {
    let width = rows.shared_width;
    let mut largest: Option<JumpTest> = None;
    let mut sums = Sums::new(rows);
    let mut jumps: Vec<(usize, JumpSums)> = Vec::with_capacity(JUMPS);
    // Symmetric: rows are columns.
    let sigma = DMatrixView::from_slice(&rows.reduced_inverse, width, width);
    let mut shared = Vec::with_capacity(JUMPS * width);
    for (place, &(reading, visit)) in occupation.iter().enumerate().skip(1).rev() {
        sums.add(rows, reading, visit);
        jumps.push((place, sums.jump));
        shared.extend_from_slice(&sums.shared);
        if jumps.len() < JUMPS && place > 1 {
            continue;
        }
        let of_jumps = DMatrixView::from_slice(&shared, width, jumps.len());
        let through: DMatrix<f64> = sigma * of_jumps;
        let parts = through.column_iter().zip(of_jumps.column_iter());
        for ((place, jump), (through, shared)) in jumps.drain(..).zip(parts) {
            let kept = jump.squares - jump.own_squares - through.dot(&shared);
            if kept <= CHECKED_TOL * jump.squares {
                continue;
            }
            let w = jump.numerator / kept.sqrt();
            if largest.is_none_or(|best| w.abs() > best.w.abs()) {
                let (first_reading, visit) = occupation[place];
                largest = Some(JumpTest {
                    station: network.visits[visit].station,
                    first_reading,
                    before: place,
                    after: occupation.len() - place,
                    w,
                });
            }
        }
        shared.clear();
    }
    largest
}

/// Sums over the readings of a jump.
#[derive(Debug, Clone, Copy, Default)]
struct JumpSums {
    /// `cᵀv`, `cᵀc` and `Σ |Oᵀ c|²`.
    numerator: f64,
    squares: f64,
    own_squares: f64,
}

struct Sums {
    jump: JumpSums,
    /// `Tᵀc`, and `Oᵀ c` of all groups.
    shared: Vec<f64>,
    own: Vec<f64>,
    /// A reading's unit error, and `c` in the rows of its visit.
    unit: Vec<f64>,
    of_visit: Vec<f64>,
    visit: Option<usize>,
}

impl Sums {
    fn new(rows: &Whitened) -> Self {
        Self {
            jump: JumpSums::default(),
            shared: vec![0.0; rows.shared_width],
            own: vec![0.0; rows.groups * rows.own_width],
            unit: Vec::new(),
            of_visit: Vec::new(),
            visit: None,
        }
    }

    fn add(&mut self, rows: &Whitened, reading: usize, visit: usize) {
        rows.unit_error(visit, reading, &mut self.unit);
        if self.visit.replace(visit) != Some(visit) {
            self.of_visit.clear();
            self.of_visit.resize(self.unit.len(), 0.0);
        }
        let range = rows.visits[visit].clone();
        let own = &mut self.own[rows.columns_of_group(range.start)];
        let before = dot(own, own);
        for ((row, &x), sum) in range.zip(&self.unit).zip(&mut self.of_visit) {
            self.jump.numerator += x * rows.residuals[row];
            self.jump.squares += x * (x + 2.0 * *sum);
            *sum += x;
            rows.add_row(row, x, own, &mut self.shared);
        }
        self.jump.own_squares += dot(own, own) - before;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use trueaxis_multilateration::{Interruption, Noise, Reading, Visit, solve};

    use super::*;

    const STATIONS: [[f64; 3]; 4] = [
        [1500.0, 300.0, 900.0],
        [-600.0, 1600.0, 100.0],
        [-700.0, -700.0, 700.0],
        [900.0, 900.0, 1900.0],
    ];
    const GROUPS: usize = 10;
    const POINTS: usize = 3;

    fn wave(i: usize, k: f64) -> f64 {
        (k * (i as f64 + 0.7)).sin()
    }

    /// Visits of two or three readings with errors of a micrometre, the stations in turn, forward and backward; one
    /// zero is interrupted within a visit.
    fn network() -> Network {
        let place = |i: usize| Point3::from([1.3, 2.7, 3.1].map(|k| 300.0 * wave(i, k)));
        let mut network = Network {
            stations: vec![None; STATIONS.len()],
            nominal_mm: (0..POINTS * GROUPS).map(place).collect(),
            groups: (0..GROUPS).map(|g| POINTS * g..POINTS * (g + 1)).collect(),
            noise: Noise {
                repeatability_mm: 1e-3,
                ..Noise::default()
            },
            ..Network::default()
        };
        for number in 0..2 * STATIONS.len() * GROUPS {
            let (station, group) = (number % STATIONS.len(), number / STATIONS.len() % GROUPS);
            let first = network.readings.len();
            let order = (0..POINTS).map(|k| if number % 2 == 0 { k } else { POINTS - 1 - k });
            for point in order.filter(|point| (number + point) % 7 != 0) {
                let place = network.nominal_mm[network.point(group, point)];
                let error_mm = 1e-3 * wave(network.readings.len(), 3.3);
                let length_mm = (place - Point3::from(STATIONS[station])).norm() + error_mm;
                network.readings.push(Reading { point, length_mm });
            }
            network.visits.push(Visit {
                station,
                group,
                readings: first..network.readings.len(),
            });
        }
        network.interruptions.push(Interruption {
            station: 2,
            first_reading: network.visits[42].readings.start + 1,
        });
        network
    }

    #[test]
    fn the_largest_step_is_that_of_all_steps() {
        let network = network();
        let solution = solve(&network).unwrap();
        let rows = Whitened::new(&network, &solution);
        let zero_of = network.zero_of_readings();
        let jumps = largest_jumps(&network, &rows);
        assert_eq!(jumps.len(), STATIONS.len() + 1);
        for jump in jumps {
            let zero = zero_of[jump.first_reading];
            let of_zero = (0..zero_of.len()).filter(|&i| zero_of[i] == zero);
            let mut largest = (0.0_f64, 0);
            for first in of_zero.skip(1) {
                let in_step = |i: usize| i >= first && zero_of[i] == zero;
                let mut error: Vec<f64> = (0..zero_of.len())
                    .map(|i| f64::from(u8::from(in_step(i))))
                    .collect();
                rows.whiten(&mut error);
                let mut kept = error.clone();
                rows.project(&mut kept);
                let w = dot(&error, &rows.residuals) / dot(&error, &kept).sqrt();
                if w.abs() > largest.0.abs() {
                    largest = (w, first);
                }
            }
            assert_eq!(jump.first_reading, largest.1);
            let (found, expected) = (jump.w, largest.0);
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
}

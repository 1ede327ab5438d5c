//! Tests of steps in a station's zero (Baarda's w, [`crate::baarda`]).
//!
//! A step is an equal error in all readings of a zero from an instant on: the sum `c = Σ e_i` of their unit
//! errors. With the whitened rows `O`, `T` of the hat matrix ([`Whitened`]) and the whitened `c`,
//!
//! ```text
//! w = cᵀv / √(cᵀc - Σ_groups |Oᵀ c|² - (Tᵀc)ᵀ Σ Tᵀc)
//! ```
//!
//! and all sums grow reading by reading.

use nalgebra::{DMatrix, DMatrixView};
use rayon::prelude::*;
use trueaxis_leastsquares::dot;

use crate::baarda::CHECKED_TOL;
use crate::network::Network;
use crate::whitened::{Whitened, add_times};

/// The test of a step in a station's zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepTest {
    /// The station.
    pub(crate) station: usize,
    /// First reading after the step.
    pub(crate) first_reading: usize,
    /// Readings of the same zero before it, and from it on.
    pub(crate) before: usize,
    pub(crate) after: usize,
    /// Standardised size of the step.
    pub(crate) w: f64,
}

/// Steps whose part through the shared unknowns is calculated at a time.
const STEPS: usize = 32;

/// For every zero the instant at which a step of it is most significant.
pub(crate) fn largest_steps(network: &Network, rows: &Whitened) -> Vec<StepTest> {
    let zeros = network.zero_of_readings();
    let mut occupations: Vec<Vec<(usize, usize)>> = vec![Vec::new(); network.zeros()];
    for (number, visit) in network.visits.iter().enumerate() {
        for reading in visit.readings.clone() {
            occupations[zeros[reading]].push((reading, number));
        }
    }
    let occupations = occupations.par_iter();
    let largest = occupations.filter_map(|occupation| largest_step(occupation, network, rows));
    largest.collect()
}

/// Adds the readings of a zero (with their visits) one by one from the last to the first; after each
/// of them the sum of their unit errors is the step that begins there.
fn largest_step(
    occupation: &[(usize, usize)],
    network: &Network,
    rows: &Whitened,
) -> Option<StepTest> {
    let width = rows.shared_width;
    let mut largest: Option<StepTest> = None;
    let mut sums = Sums::new(rows);
    let mut steps: Vec<(usize, Step)> = Vec::with_capacity(STEPS);
    // Symmetric: rows are columns.
    let sigma = DMatrixView::from_slice(&rows.reduced_inverse, width, width);
    let mut shared = Vec::with_capacity(STEPS * width);
    for (place, &(reading, visit)) in occupation.iter().enumerate().skip(1).rev() {
        sums.add(rows, reading, visit);
        steps.push((place, sums.step));
        shared.extend_from_slice(&sums.shared);
        if steps.len() < STEPS && place > 1 {
            continue;
        }
        let of_steps = DMatrixView::from_slice(&shared, width, steps.len());
        let through: DMatrix<f64> = sigma * of_steps;
        let parts = through.column_iter().zip(of_steps.column_iter());
        for ((place, step), (through, shared)) in steps.drain(..).zip(parts) {
            let kept = step.squares - step.own_squares - through.dot(&shared);
            if kept <= CHECKED_TOL * step.squares {
                continue;
            }
            let w = step.numerator / kept.sqrt();
            if largest.is_none_or(|best| w.abs() > best.w.abs()) {
                let (first_reading, visit) = occupation[place];
                largest = Some(StepTest {
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

/// Sums over the readings of a step.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    /// `cᵀv`, `cᵀc` and `Σ |Oᵀ c|²`.
    numerator: f64,
    squares: f64,
    own_squares: f64,
}

struct Sums {
    step: Step,
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
            step: Step::default(),
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
            self.step.numerator += x * rows.residuals[row];
            self.step.squares += x * (x + 2.0 * *sum);
            *sum += x;
            add_times(own, x, rows.own_row(row));
            add_times(&mut self.shared, x, rows.shared_row(row));
        }
        self.step.own_squares += dot(own, own) - before;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::factor_len;
    use crate::{Interruption, Reading, Visit};

    const STATIONS: usize = 3;
    const VISITS: usize = 70;
    const GROUPS: usize = 10;
    const OWN: usize = 2;
    const SHARED: usize = 4;

    fn wave(i: usize, k: f64) -> f64 {
        (k * (i as f64 + 0.7)).sin()
    }

    /// Visits of one to three readings, the stations in turn; one zero is interrupted within a visit. The rows are any.
    fn rows() -> (Network, Whitened) {
        let mut network = Network {
            stations: vec![None; STATIONS],
            ..Network::default()
        };
        for number in 0..VISITS {
            let first = network.readings.len();
            let readings = (0..1 + number % 3).map(|point| Reading {
                point,
                length_mm: 0.0,
            });
            network.readings.extend(readings);
            network.visits.push(Visit {
                station: number % STATIONS,
                group: number % GROUPS,
                readings: first..network.readings.len(),
            });
        }
        network.interruptions.push(Interruption {
            station: 2,
            first_reading: network.visits[32].readings.start + 1,
        });
        let count = network.readings.len();
        let values = |count: usize, size: f64, k: f64| -> Vec<f64> {
            (0..count).map(|i| size * wave(i, k)).collect()
        };
        let visits: Vec<_> = network.visits.iter().map(|v| v.readings.clone()).collect();
        let mut weights = Vec::new();
        let mut weight_starts = Vec::new();
        for rows in &visits {
            weight_starts.push(weights.len());
            weights.extend(values(factor_len(rows.len()), 1.0, 1.9 + rows.start as f64));
        }
        let symmetric = |i: usize| wave(i / SHARED + i % SHARED, 2.3);
        let whitened = Whitened {
            group_of_row: network
                .visits
                .iter()
                .flat_map(|v| vec![v.group; v.readings.len()])
                .collect(),
            groups: GROUPS,
            own_width: OWN,
            own: values(count * OWN, 0.2, 1.3),
            shared_width: SHARED,
            shared: values(count * SHARED, 0.05, 2.7),
            reduced_inverse: (0..SHARED * SHARED).map(symmetric).collect(),
            residuals: values(count, 1.0, 3.1),
            degrees_of_freedom: count,
            // The readings of a visit in an order of their own.
            reading_of_row: visits.iter().flat_map(|rows| rows.clone().rev()).collect(),
            visits,
            weights,
            weight_starts,
        };
        (network, whitened)
    }

    #[test]
    fn the_largest_step_is_that_of_all_steps() {
        let (network, rows) = rows();
        let zero_of = network.zero_of_readings();
        let steps = largest_steps(&network, &rows);
        assert_eq!(steps.len(), STATIONS + 1);
        for step in steps {
            let zero = zero_of[step.first_reading];
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
            assert_eq!(step.first_reading, largest.1);
            let (found, expected) = (step.w, largest.0);
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
}

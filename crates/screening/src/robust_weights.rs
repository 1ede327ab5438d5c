//! Weights that keep gross errors from bending the adjustment.
//!
//! A reading's weight follows from its distance `t` from what the others predict, in units of the spread that most
//! readings show, by Welsch's redescending rule `exp(-(t/c)²)`: far readings lose all pull. While steps in the zeros
//! of stations are still sought, `t` is the distance from the median of the readings around it: a lost count shifts
//! the neighbours as well and keeps its weight, a gross error stands alone and loses it.

use trueaxis_leastsquares::median;
use trueaxis_multilateration::ReadingTest;

/// Median of |w| for standard normal w.
const NORMAL_MEDIAN: f64 = 0.674_489_750_196_081_7;

/// Welsch's constant for 95 % efficiency with normal noise. The final adjustment is fully weighted.
const WELSCH: f64 = 2.985;

/// Readings of a zero before and after one, with which the median for its comparison is taken.
const NEIGHBOURS: usize = 6;

/// The factor on the variance of a removed reading: it pulls by a hundred millionth of its error, while its own test
/// keeps eight digits.
pub(crate) const REMOVED: f64 = 1e8;

/// Standard deviation of w that most readings show: 1 if the noise is as declared.
pub(crate) fn spread(tests: &[ReadingTest], factors: &[f64]) -> f64 {
    let taking_part = |(test, &factor): (&ReadingTest, &f64)| {
        (factor < REMOVED && test.sigma_mm.is_finite()).then_some(test.w.abs())
    };
    let mut sizes: Vec<f64> = tests.iter().zip(factors).filter_map(taking_part).collect();
    median(&mut sizes).map_or(1.0, |median| median / NORMAL_MEDIAN)
}

/// Variance factor of a reading at distance `t`, in units of the width.
pub(crate) fn welsch(t: f64) -> f64 {
    (t / WELSCH).powi(2).exp().min(REMOVED)
}

/// Distance of each reading's error from the median of its neighbours in time, in standard deviations;
/// `zeros` is the dead path of each reading.
pub(crate) fn distances_from_neighbours(tests: &[ReadingTest], zeros: &[usize]) -> Vec<f64> {
    let mut distances = vec![0.0; tests.len()];
    let count = zeros.iter().max().map_or(0, |&last| last + 1);
    let mut sequences = vec![Vec::new(); count];
    for (reading, &zero) in zeros.iter().enumerate() {
        sequences[zero].push(reading);
    }
    let mut window = Vec::new();
    for sequence in sequences {
        for (place, &reading) in sequence.iter().enumerate() {
            let from = place.saturating_sub(NEIGHBOURS);
            let to = (place + NEIGHBOURS + 1).min(sequence.len());
            window.clear();
            window.extend(sequence[from..to].iter().map(|&i| tests[i].error_mm));
            let test = &tests[reading];
            let expected_mm = median(&mut window).unwrap_or(test.error_mm);
            distances[reading] = (test.error_mm - expected_mm) / test.sigma_mm;
        }
    }
    distances
}

//! Tests of single lengths and of steps in a station's zero (Baarda's w).
//!
//! Whether an error of the form `c ∇` is in the lengths is tested on the adjusted residuals `v`:
//!
//! ```text
//! w = cᵀC⁻¹v / √(cᵀC⁻¹ Q_v C⁻¹c)      ∇ = cᵀC⁻¹v / cᵀC⁻¹ Q_v C⁻¹c
//! ```
//!
//! `w` is standard normal if nothing is wrong (W. Baarda, A testing procedure for use in geodetic
//! networks, 1968). `c` is one reading, or all readings of a station after an instant.
//!
//! A reading whose own variance is inflated by a factor `f` has all but left the adjustment; `∇` is
//! then its distance from what the others predict, and `1/den - (f - 1) σ²` the variance of that if
//! nothing were wrong. So readings are tested alike whether they take part or not.

use faer::Mat;
use trueaxis_leastsquares::BlockRows;

use crate::influence::{Influence, VisitRows};
use crate::quadratic_form::quadratic_form;

/// The test of one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ReadingTest {
    /// Baarda's w.
    pub(crate) w: f64,
    /// Estimated error, observed minus right, mm.
    pub(crate) error_mm: f64,
    /// Standard deviation of the estimated error, mm; infinite where nothing checks the reading.
    pub(crate) sigma_mm: f64,
    /// Part of an error in it that the residuals keep, from 0 to 1.
    pub(crate) kept: f64,
}

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

/// Below this part of a reading's weight, what the residuals keep of an error in it is rounding.
const CHECKED_TOL: f64 = 1e-9;

/// The tests of all readings and visits.
#[derive(Debug, Default)]
pub(crate) struct Tests {
    /// Of every reading.
    pub(crate) readings: Vec<ReadingTest>,
    /// Baarda's w of an equal error in all lengths of each visit: the machine stood elsewhere, or the
    /// beam was lost and found again. Zero for visits of a single length.
    pub(crate) visits: Vec<f64>,
}

/// Tests every reading and every visit.
pub(crate) fn test_all(influence: &Influence<'_>) -> Tests {
    let network = influence.network();
    let unchecked = ReadingTest {
        w: 0.0,
        error_mm: 0.0,
        sigma_mm: f64::INFINITY,
        kept: 0.0,
    };
    let mut tests = Tests {
        readings: vec![unchecked; network.readings.len()],
        visits: vec![0.0; network.visits.len()],
    };
    let mut memory = BlockRows::default();
    for g in 0..influence.groups() {
        let group = influence.group(g, &mut memory);
        for visit in &group.visits {
            let kept = influence.kept(&group, visit);
            let sigmas_mm = influence.length_sigmas_mm(visit);
            let residuals = &group.residuals[visit.first..visit.first + visit.count];
            let first = network.visits[visit.visit].readings.start;
            let mut all = vec![0.0; visit.count];
            for (i, sigma_mm) in sigmas_mm.into_iter().enumerate() {
                let unit = influence.unit_error(visit, i);
                for (sum, unit) in all.iter_mut().zip(&unit) {
                    *sum += unit;
                }
                let numerator: f64 = dot(&unit, residuals);
                let denominator = quadratic_form(&kept, &unit);
                if denominator <= CHECKED_TOL * dot(&unit, &unit) {
                    continue;
                }
                let factor = network.variance_factor(first + i);
                let inflation = sigma_mm.powi(2) * (1.0 - 1.0 / factor);
                let error_mm = numerator / denominator;
                let sigma_mm = (1.0 / denominator - inflation)
                    .max(f64::MIN_POSITIVE)
                    .sqrt();
                tests.readings[first + i] = ReadingTest {
                    w: error_mm / sigma_mm,
                    error_mm,
                    sigma_mm,
                    kept: denominator / dot(&unit, &unit),
                };
            }
            let denominator = quadratic_form(&kept, &all);
            if visit.count > 1 && denominator > CHECKED_TOL * dot(&all, &all) {
                tests.visits[visit.visit] = dot(&all, residuals) / denominator.sqrt();
            }
        }
    }
    tests
}

/// For every zero the instant at which a step of it is most significant.
pub(crate) fn largest_steps(influence: &Influence<'_>) -> Vec<StepTest> {
    let columns = columns(influence);
    (0..influence.network().zeros())
        .filter_map(|zero| {
            let own: Vec<&Column> = columns.iter().filter(|c| c.zero == zero).collect();
            largest_step(&own, influence)
        })
        .collect()
}

/// One reading's unit error as the adjustment sees it.
struct Column {
    station: usize,
    zero: usize,
    reading: usize,
    group: usize,
    visit: usize,
    /// `L⁻¹ e`.
    whitened: Vec<f64>,
    /// Its product with the residuals.
    numerator: f64,
    /// `Oᵀ L⁻¹ e` and `Tᵀ L⁻¹ e`.
    own: Vec<f64>,
    shared: Vec<f64>,
}

/// The columns of all readings, in measuring order.
fn columns(influence: &Influence<'_>) -> Vec<Column> {
    let network = influence.network();
    let mut columns = Vec::with_capacity(network.readings.len());
    let mut memory = BlockRows::default();
    for g in 0..influence.groups() {
        let group = influence.group(g, &mut memory);
        for visit in &group.visits {
            let content = &network.visits[visit.visit];
            let residuals = &group.residuals[visit.first..visit.first + visit.count];
            for i in 0..visit.count {
                let reading = content.readings.start + i;
                let whitened = influence.unit_error(visit, i);
                columns.push(Column {
                    station: content.station,
                    zero: influence.model().zero_of(reading),
                    reading,
                    group: g,
                    visit: visit.visit,
                    numerator: dot(&whitened, residuals),
                    own: transposed_times(&group.own, visit, &whitened),
                    shared: transposed_times(&group.shared, visit, &whitened),
                    whitened,
                });
            }
        }
    }
    columns.sort_by_key(|column| column.reading);
    columns
}

/// Adds the readings of a zero one by one from the last to the first; after each of them the sum of
/// the columns is the step that begins there.
fn largest_step(columns: &[&Column], influence: &Influence<'_>) -> Option<StepTest> {
    let sigma = influence.reduced_inverse();
    let width = influence.width();
    let mut largest: Option<StepTest> = None;
    let mut sums = Sums::new(influence);
    for (place, column) in columns.iter().enumerate().skip(1).rev() {
        sums.add(column);
        let through_shared: f64 = (0..width)
            .map(|j| {
                let s: f64 = (0..width).map(|i| sigma[(i, j)] * sums.shared[i]).sum();
                s * sums.shared[j]
            })
            .sum();
        let kept = sums.squares - sums.own_squares - through_shared;
        if kept <= CHECKED_TOL * sums.squares {
            continue;
        }
        let w = sums.numerator / kept.sqrt();
        if largest.is_none_or(|best| w.abs() > best.w.abs()) {
            largest = Some(StepTest {
                station: column.station,
                first_reading: column.reading,
                before: place,
                after: columns.len() - place,
                w,
            });
        }
    }
    largest
}

/// Sums of columns with what their squares need.
struct Sums {
    numerator: f64,
    squares: f64,
    own_squares: f64,
    shared: Vec<f64>,
    own: Vec<Vec<f64>>,
    whitened: Vec<f64>,
    visit: Option<usize>,
}

impl Sums {
    fn new(influence: &Influence<'_>) -> Self {
        Self {
            numerator: 0.0,
            squares: 0.0,
            own_squares: 0.0,
            shared: vec![0.0; influence.width()],
            own: vec![Vec::new(); influence.groups()],
            whitened: Vec::new(),
            visit: None,
        }
    }

    fn add(&mut self, column: &Column) {
        self.numerator += column.numerator;
        if self.visit != Some(column.visit) {
            self.visit = Some(column.visit);
            self.whitened.clear();
            self.whitened.resize(column.whitened.len(), 0.0);
        }
        self.squares += grown(&mut self.whitened, &column.whitened);
        let own = &mut self.own[column.group];
        own.resize(column.own.len(), 0.0);
        self.own_squares += grown(own, &column.own);
        for (sum, x) in self.shared.iter_mut().zip(&column.shared) {
            *sum += x;
        }
    }
}

/// Adds to a vector; returns by how much its square grows.
fn grown(sum: &mut [f64], x: &[f64]) -> f64 {
    let before = dot(sum, sum);
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum += x;
    }
    dot(sum, sum) - before
}

/// `Xᵀ y` over the rows of a visit.
fn transposed_times(x: &Mat<f64>, visit: &VisitRows, y: &[f64]) -> Vec<f64> {
    (0..x.ncols())
        .map(|k| {
            (0..visit.count)
                .map(|i| x[(visit.first + i, k)] * y[i])
                .sum()
        })
        .collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

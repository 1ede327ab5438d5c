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

use std::ops::Range;

use rayon::prelude::*;

use crate::influence::Influence;
use crate::visit_terms::VisitTerms;
use trueaxis_leastsquares::row_products::{append_product, dot};

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

/// Groups that one thread takes at a time.
const PIECE: usize = 256;

/// Tests every reading and every visit.
pub(crate) fn test_all(influence: &Influence<'_>) -> Tests {
    let network = influence.network();
    let sigma = influence.sigma();
    let groups = influence.groups();
    let of_piece = |piece: usize| piece * PIECE..groups.min((piece + 1) * PIECE);
    let pieces = (0..groups.div_ceil(PIECE)).into_par_iter();
    let tested: Vec<Tests> = pieces
        .map(|piece| {
            let mut tests = Tests::default();
            let mut work = VisitTest::default();
            for group in of_piece(piece) {
                influence.visits(group, &mut work.terms);
                let mut first = 0;
                for &visit in influence.model().visits_of(group) {
                    let rows = first..first + network.visits[visit].readings.len();
                    first = rows.end;
                    work.test(influence, &sigma, (visit, rows), &mut tests);
                }
            }
            tests
        })
        .collect();
    let mut tests = Tests {
        readings: vec![ReadingTest::UNCHECKED; network.readings.len()],
        visits: vec![0.0; network.visits.len()],
    };
    // From the order of the groups to that of measuring.
    for (piece, part) in tested.into_iter().enumerate() {
        let visits = of_piece(piece).flat_map(|group| influence.model().visits_of(group));
        let mut readings = part.readings.as_slice();
        for (&visit, w) in visits.zip(part.visits) {
            let content = network.visits[visit].readings.clone();
            let (own, rest) = readings.split_at(content.len());
            tests.readings[content].copy_from_slice(own);
            tests.visits[visit] = w;
            readings = rest;
        }
    }
    tests
}

impl ReadingTest {
    const UNCHECKED: Self = Self {
        w: 0.0,
        error_mm: 0.0,
        sigma_mm: f64::INFINITY,
        kept: 0.0,
    };
}

/// The tests of one visit: memory to work in.
#[derive(Default)]
struct VisitTest {
    terms: VisitTerms,
    kept: Vec<f64>,
    memory: Vec<f64>,
    unit: Vec<f64>,
    all: Vec<f64>,
}

impl VisitTest {
    /// Appends the tests of a visit with these rows of the present terms.
    fn test(
        &mut self,
        influence: &Influence<'_>,
        sigma: &[f64],
        (visit, rows): (usize, Range<usize>),
        tests: &mut Tests,
    ) {
        let network = influence.network();
        let Self {
            terms,
            kept,
            memory,
            unit,
            all,
        } = self;
        terms.kept(rows.clone(), sigma, kept, memory);
        let count = rows.len();
        let residuals = &terms.residuals()[rows];
        all.clear();
        all.resize(count, 0.0);
        for (i, reading) in network.visits[visit].readings.clone().enumerate() {
            influence.unit_error_into(visit, count, i, unit);
            for (sum, unit) in all.iter_mut().zip(&*unit) {
                *sum += unit;
            }
            let numerator: f64 = dot(unit, residuals);
            let denominator = quadratic(kept, unit);
            if denominator <= CHECKED_TOL * dot(unit, unit) {
                tests.readings.push(ReadingTest::UNCHECKED);
                continue;
            }
            let factor = network.variance_factor(reading);
            let sigma_mm = influence.length_sigma_mm(visit, reading);
            let inflation = sigma_mm.powi(2) * (1.0 - 1.0 / factor);
            let error_mm = numerator / denominator;
            let sigma_mm = (1.0 / denominator - inflation)
                .max(f64::MIN_POSITIVE)
                .sqrt();
            tests.readings.push(ReadingTest {
                w: error_mm / sigma_mm,
                error_mm,
                sigma_mm,
                kept: denominator / dot(unit, unit),
            });
        }
        let denominator = quadratic(kept, all);
        let is_checked = count > 1 && denominator > CHECKED_TOL * dot(all, all);
        tests.visits.push(match is_checked {
            true => dot(all, residuals) / denominator.sqrt(),
            false => 0.0,
        });
    }
}

/// For every zero the instant at which a step of it is most significant.
pub(crate) fn largest_steps(influence: &Influence<'_>) -> Vec<StepTest> {
    let network = influence.network();
    let mut turns: Vec<Vec<(usize, usize)>> = vec![Vec::new(); network.zeros()];
    for (number, visit) in network.visits.iter().enumerate() {
        for reading in visit.readings.clone() {
            turns[influence.model().zero_of(reading)].push((reading, number));
        }
    }
    turns
        .par_iter()
        .map(|turn| largest_step(turn, influence))
        .collect::<Vec<_>>()
        .into_iter()
        .flatten()
        .collect()
}

/// Adds the readings of a zero (with their visits) one by one from the last to the first; after each
/// of them the sum of their unit errors is the step that begins there.
fn largest_step(turn: &[(usize, usize)], influence: &Influence<'_>) -> Option<StepTest> {
    let network = influence.network();
    let (sigma, width) = (influence.sigma(), influence.width());
    let mut largest: Option<StepTest> = None;
    let mut sums = Sums::new(influence);
    let mut steps: Vec<(usize, Step)> = Vec::with_capacity(STEPS);
    let (mut shared, mut through) = (Vec::with_capacity(STEPS * width), Vec::new());
    for (place, &(reading, visit)) in turn.iter().enumerate().skip(1).rev() {
        sums.add(influence, reading, visit);
        steps.push((place, sums.step));
        shared.extend_from_slice(&sums.shared);
        if steps.len() < STEPS && place > 1 {
            continue;
        }
        through.clear();
        append_product(&mut through, &shared, &sigma, [width; 2]);
        let rows = shared.chunks_exact(width).zip(through.chunks_exact(width));
        for ((place, step), (shared, through)) in steps.drain(..).zip(rows) {
            let kept = step.squares - step.own_squares - dot(through, shared);
            if kept <= CHECKED_TOL * step.squares {
                continue;
            }
            let w = step.numerator / kept.sqrt();
            if largest.is_none_or(|best| w.abs() > best.w.abs()) {
                let (first_reading, visit) = turn[place];
                largest = Some(StepTest {
                    station: network.visits[visit].station,
                    first_reading,
                    before: place,
                    after: turn.len() - place,
                    w,
                });
            }
        }
        shared.clear();
    }
    largest
}

/// Steps whose part through the shared unknowns is calculated at a time.
const STEPS: usize = 32;

/// Sums over the readings of a step.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    numerator: f64,
    squares: f64,
    own_squares: f64,
}

/// Sums of whitened unit errors `L⁻¹ e`, with what their squares need.
struct Sums {
    step: Step,
    /// `Tᵀ L⁻¹ e`, and `Oᵀ L⁻¹ e` of all groups.
    shared: Vec<f64>,
    own: Vec<f64>,
    own_starts: Vec<usize>,
    /// Of the present visit.
    whitened: Vec<f64>,
    visit: Option<usize>,
    terms: VisitTerms,
    unit: Vec<f64>,
}

impl Sums {
    fn new(influence: &Influence<'_>) -> Self {
        let mut own_starts = vec![0];
        for group in 0..influence.groups() {
            let size = influence.covariance().inverse_factor(group).ncols();
            own_starts.push(own_starts[group] + size);
        }
        Self {
            step: Step::default(),
            shared: vec![0.0; influence.width()],
            own: vec![0.0; own_starts[influence.groups()]],
            own_starts,
            whitened: Vec::new(),
            visit: None,
            terms: VisitTerms::default(),
            unit: Vec::new(),
        }
    }

    fn add(&mut self, influence: &Influence<'_>, reading: usize, visit: usize) {
        let content = &influence.network().visits[visit];
        if self.visit != Some(visit) {
            self.visit = Some(visit);
            influence.visit(visit, &mut self.terms);
            self.whitened.clear();
            self.whitened.resize(self.terms.count(), 0.0);
        }
        let i = reading - content.readings.start;
        let (terms, unit) = (&self.terms, &mut self.unit);
        influence.unit_error_into(visit, terms.count(), i, unit);
        self.step.numerator += dot(unit, terms.residuals());
        self.step.squares += grown(&mut self.whitened, |sum| add_to(sum, unit, 1.0));
        let start = self.own_starts[content.group];
        let own = &mut self.own[start..self.own_starts[content.group + 1]];
        // Rows before the reading's own have no part in its unit error.
        let rows = || unit.iter().enumerate().skip(i);
        self.step.own_squares += grown(own, |sum| {
            rows().for_each(|(row, &factor)| add_to(sum, terms.own(row), factor));
        });
        for (row, &factor) in rows() {
            add_to(&mut self.shared, terms.shared(row), factor);
        }
    }
}

/// Changes a vector; returns by how much its square grows.
fn grown(sum: &mut [f64], change: impl Fn(&mut [f64])) -> f64 {
    let before = dot(sum, sum);
    change(sum);
    dot(sum, sum) - before
}

fn add_to(sum: &mut [f64], x: &[f64], factor: f64) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum += factor * x;
    }
}

/// `xᵀ A x` with the rows of `A` contiguous.
fn quadratic(matrix: &[f64], x: &[f64]) -> f64 {
    matrix
        .chunks_exact(x.len().max(1))
        .zip(x)
        .map(|(row, x_i)| x_i * dot(row, x))
        .sum()
}

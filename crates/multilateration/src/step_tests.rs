//! Tests of steps in a station's zero (Baarda's w, [`crate::baarda`]).
//!
//! A step is an equal error in all readings of a zero from an instant on: the sum `c = Σ e_i` of their unit
//! errors. With the Jacobian `[A | B]` and the covariance `C` of the lengths, and the factors `R⁻¹`, `Z`, `Σ`
//! of the covariance of the unknowns,
//!
//! ```text
//! w = cᵀC⁻¹v / √(cᵀC⁻¹c - Σ_groups |R⁻ᵀ Aᵀ C⁻¹ c|² - tᵀ Σ t)        t = (B - A Z)ᵀ C⁻¹ c
//! ```
//!
//! and all sums grow reading by reading.

use rayon::prelude::*;
use trueaxis_leastsquares::row_products::{add_product, append_product, dot};
use trueaxis_leastsquares::zeros;

use crate::baarda::CHECKED_TOL;
use crate::free_points::{PER_STATION, zero_column};
use crate::influence::Influence;
use crate::noise::whiten;

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

/// For every zero the instant at which a step of it is most significant, in a network of free points.
pub(crate) fn largest_steps(influence: &Influence<'_>) -> Vec<StepTest> {
    let network = influence.network();
    let mut turns: Vec<Vec<(usize, usize)>> = vec![Vec::new(); network.zeros()];
    for (number, visit) in network.visits.iter().enumerate() {
        for reading in visit.readings.clone() {
            turns[influence.model().zero_of(reading)].push((reading, number));
        }
    }
    let largest = turns.par_iter().map(|turn| largest_step(turn, influence));
    largest.collect::<Vec<_>>().into_iter().flatten().collect()
}

/// Adds the readings of a zero (with their visits) one by one from the last to the first; after each
/// of them the sum of their unit errors is the step that begins there.
fn largest_step(turn: &[(usize, usize)], influence: &Influence<'_>) -> Option<StepTest> {
    let width = influence.width();
    let sigma = influence.sigma();
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
        append_product(&mut through, &shared, sigma, [width; 2]);
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
                    station: influence.network().visits[visit].station,
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

/// Sums over the readings of a step.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    /// `cᵀC⁻¹v`, `cᵀC⁻¹c` and `Σ |R⁻ᵀ Aᵀ C⁻¹ c|²`.
    numerator: f64,
    squares: f64,
    own_squares: f64,
}

struct Sums {
    step: Step,
    /// `-t`, and `R⁻ᵀ Aᵀ C⁻¹ c` of all groups.
    shared: Vec<f64>,
    own: Vec<f64>,
    own_starts: Vec<usize>,
    /// The visit whose readings are being added.
    visit: Option<usize>,
    rows: VisitRows,
    /// Its readings that have been added.
    added: Vec<usize>,
}

impl Sums {
    fn new(influence: &Influence<'_>) -> Self {
        let mut own_starts = vec![0];
        for group in &influence.network().groups {
            own_starts.push(own_starts[own_starts.len() - 1] + 3 * group.len());
        }
        Self {
            step: Step::default(),
            shared: vec![0.0; influence.width()],
            own: vec![0.0; own_starts[own_starts.len() - 1]],
            own_starts,
            visit: None,
            rows: VisitRows::default(),
            added: Vec::new(),
        }
    }

    fn add(&mut self, influence: &Influence<'_>, reading: usize, visit: usize) {
        let content = &influence.network().visits[visit];
        if self.visit != Some(visit) {
            self.visit = Some(visit);
            self.rows.fill(influence, visit);
            self.added.clear();
        }
        let i = reading - content.readings.start;
        let (rows, count) = (&self.rows, content.readings.len());
        self.step.numerator += rows.weighted_residuals[i];
        let inverse = &rows.inverse[i * count..][..count];
        let with_others: f64 = self.added.iter().map(|&j| inverse[j]).sum();
        self.step.squares += inverse[i] + 2.0 * with_others;
        self.added.push(i);

        let range = self.own_starts[content.group]..self.own_starts[content.group + 1];
        let own = &mut self.own[range.clone()];
        let before = dot(own, own);
        add_to(own, &rows.own[i * range.len()..]);
        self.step.own_squares += dot(own, own) - before;
        let width = self.shared.len();
        add_to(&mut self.shared, &rows.shared[i * width..]);
    }
}

fn add_to(sum: &mut [f64], x: &[f64]) {
    for (sum, x) in sum.iter_mut().zip(x) {
        *sum += x;
    }
}

/// What the unit errors `e_i` of the readings of a visit are for the adjustment, rows contiguous.
#[derive(Default)]
struct VisitRows {
    /// `C⁻¹`, and `C⁻¹ v`.
    inverse: Vec<f64>,
    weighted_residuals: Vec<f64>,
    /// `e_iᵀ C⁻¹ A`, and the same times `R⁻¹`.
    coefficients: Vec<f64>,
    own: Vec<f64>,
    /// `-e_iᵀ C⁻¹ (B - A Z)`.
    shared: Vec<f64>,
    /// `L⁻¹ e_i`.
    whitened: Vec<f64>,
}

impl VisitRows {
    fn fill(&mut self, influence: &Influence<'_>, visit: usize) {
        let (network, model) = (influence.network(), influence.model());
        let (state, covariance) = (influence.state(), influence.covariance());
        let content = &network.visits[visit];
        let count = content.readings.len();
        self.fill_inverse(model.factor(visit), count);

        let unknowns = 3 * network.groups[content.group].len();
        let width = influence.width();
        zeros(&mut self.weighted_residuals, count);
        zeros(&mut self.coefficients, count * unknowns);
        zeros(&mut self.shared, count * width);
        let stations = network.stations.len();
        for (s, number) in content.readings.clone().enumerate() {
            let reading = &network.readings[number];
            let point = network.point(content.group, reading.point);
            let (u, distance_mm) = state.beam(content.station, point);
            let zero = model.zero_of(number);
            let residual = state.residual_mm(reading.length_mm, zero, distance_mm);
            for i in 0..count {
                let weight = self.inverse[i * count + s];
                self.weighted_residuals[i] += weight * residual;
                let own = &mut self.coefficients[i * unknowns + 3 * reading.point..];
                let shared = &mut self.shared[i * width..];
                shared[zero_column(zero, stations)] += weight;
                let station = &mut shared[PER_STATION * content.station..];
                for ((own, station), u) in own.iter_mut().zip(station).zip(u.iter()) {
                    *own += weight * u;
                    *station += weight * u;
                }
            }
        }
        let coupling = covariance.coupling_rows(content.group);
        add_product(
            &mut self.shared,
            &self.coefficients,
            coupling,
            [unknowns, width],
        );
        // R⁻¹ is upper triangular.
        let factor = covariance.inverse_factor_columns(content.group);
        self.own.clear();
        for row in self.coefficients.chunks_exact(unknowns) {
            let columns = factor.chunks_exact(unknowns).enumerate();
            self.own
                .extend(columns.map(|(k, column)| dot(&row[..=k], &column[..=k])));
        }
    }

    /// `C⁻¹ = L⁻ᵀ L⁻¹`.
    fn fill_inverse(&mut self, factor: &[f64], count: usize) {
        zeros(&mut self.whitened, count * count);
        for (i, unit) in self.whitened.chunks_exact_mut(count).enumerate() {
            unit[i] = 1.0;
            whiten(factor, unit);
        }
        self.inverse.clear();
        for unit in self.whitened.chunks_exact(count) {
            let others = self.whitened.chunks_exact(count);
            self.inverse.extend(others.map(|other| dot(unit, other)));
        }
    }
}

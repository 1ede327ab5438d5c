//! Many solutions of one network with other errors: one factorisation serves them all.
//!
//! A trial's lengths are those that follow from the solved network, plus errors. With the
//! derivatives `A`, `B` of the lengths to points and shared unknowns, the weights `P = C⁻¹` and the
//! residuals `r`, the gradient
//!
//! ```text
//! g = Aᵀ P r      b = Bᵀ P r
//! ```
//!
//! leads to a correction by elimination of the points, with `D = R⁻¹R⁻ᵀ` and `Σ` as the solution
//! left them ([`trueaxis_leastsquares::Covariance`]) and the datum `H`:
//!
//! ```text
//! y      = D g                              points, stations held
//! (s, λ) = Σ ( b - Bᵀ P A y, -Hᵀ y )        stations and dead paths; multipliers of the datum
//! dp     = D (g - Aᵀ P B s - H λ)           points
//! ```
//!
//! The first correction is the linear solution. Further ones, with the same factors, start from the
//! exact gradient where the ones before led, with the residuals and the beams there: that beams
//! turn under residuals of the size of the noise matters as much as the curvature of the lengths.
//! With errors of the size of the noise the second correction is some 4e-4 standard uncertainties, the third
//! some 1e-5, and what it leaves 1e-8.

#[cfg(test)]
mod against_full_solve;
mod coordinates;
mod correlated;
mod errors;
mod point_blocks;
mod tracks;
mod unknowns;

use nalgebra::Vector3;
use rand::Rng;
use trueaxis_leastsquares::{LANES, Lanes, in_widest_registers, lanes_only};

use self::coordinates::{Coordinates, dot, sum};
use self::correlated::CorrelatedVisits;
use self::errors::{ErrorNoise, is_correlated};
use self::point_blocks::PointBlocks;
use self::tracks::{Row, Tracks};
use self::unknowns::Unknowns;
use crate::datum::Datum;
use crate::free_points::{DATUM, FreePoints, PER_STATION, zero_column};
use crate::network::Network;
use crate::noise::unwhiten_row;
use crate::solution::Solution;

/// A solved network, ready to be solved again with other errors, from any number of threads.
///
/// Weights are held: those that belong to the solution serve all trials. Where they depend on the
/// beams (lengths that correlate, a part proportional to the distance), a full solve of the same
/// lengths weighs them by its own beams, which differ by 1e-6.
#[derive(Debug, Clone)]
pub struct Trials {
    noise: ErrorNoise,
    tracks: Tracks,
    correlated: CorrelatedVisits,
    blocks: PointBlocks,
    /// Lever arms of the rotations of the datum at the nominal points.
    levers: Coordinates,
    /// `Σ`, column by column, eight rows side by side and zeros below the last.
    reduced_inverse: Vec<Lanes>,
    shared: usize,
    stations: usize,
}

/// What the errors of one trial do to the solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Corrections {
    unknowns: Unknowns,
    stations: usize,
}

/// Storage of trials.
#[derive(Debug, Clone)]
pub struct Workspace {
    corrections: Corrections,
    errors: Vec<Lanes>,
    correlated: correlated::Storage,
    gradient: Unknowns,
    step: Unknowns,
    /// What is left of the gradient at the points.
    points: Coordinates,
    /// What is left of the gradient at the shared unknowns, and the right side of the datum.
    right_side: Vec<f64>,
    /// `(s, λ)`.
    solved: Vec<Lanes>,
    /// `λ`.
    multipliers: [f64; DATUM],
}

/// Most that the corrections left out may move any unknown, in standard uncertainties. It is
/// estimated from the last two; in thousands of trials it was up to four times as much.
const LEFT_OUT: f64 = 2e-7;

/// Errors that need more corrections are no noise.
const MAX_CORRECTIONS: usize = 20;

impl Trials {
    /// `network` must be the one that `solution` solved.
    pub fn new(network: &Network, solution: &Solution) -> Self {
        let state = solution.state();
        let model = FreePoints::new(network, &state);
        let stations = network.stations.len();
        let mut noise = ErrorNoise::default();
        let mut independent = Vec::new();
        let mut correlated = CorrelatedVisits::default();
        let mut is_coupled = vec![false; network.groups.len()];
        for (v, visit) in network.visits.iter().enumerate() {
            let factor = model.factor(v);
            let count = visit.readings.len();
            let rows = visit.readings.clone().map(|reading| {
                let point = network.point(visit.group, network.readings[reading].point);
                let (beam, distance_mm) = state.beam(visit.station, point);
                Row {
                    reading,
                    point,
                    station: PER_STATION * visit.station,
                    dead_path: zero_column(model.zero_of(reading), stations),
                    beam: beam.into(),
                    distance_mm,
                }
            });
            if is_correlated(factor, count) {
                is_coupled[visit.group] = true;
                noise.push_correlated(count, factor);
                correlated.push(rows, factor);
            } else {
                for (i, row) in rows.enumerate() {
                    let sigma_mm = unwhiten_row(factor, i)[i];
                    noise.push_independent(sigma_mm);
                    independent.push((row, sigma_mm));
                }
            }
        }
        let mut blocks = PointBlocks::default();
        for (g, points) in network.groups.iter().enumerate() {
            let block = solution.covariance.block_given_shared(g);
            blocks.push(points.clone(), &block, is_coupled[g]);
        }
        let datum = Datum::new(network);
        let levers = network.nominal_mm.iter().map(|&n| datum.lever(n));
        let sigma = solution.covariance.reduced_inverse();
        let shared = model.shared();
        let size = sigma.nrows();
        let eight = |j: usize, first: usize| {
            let row = |k: usize| (first + k < size).then(|| sigma[(first + k, j)]);
            Lanes::from_fn(|k| row(k).unwrap_or_default())
        };
        let columns = (0..size).flat_map(|j| (0..size).step_by(LANES).map(move |i| eight(j, i)));
        Self {
            noise,
            tracks: Tracks::new(independent),
            correlated,
            blocks,
            levers: Coordinates::from_vectors(levers),
            reduced_inverse: columns.collect(),
            shared,
            stations,
        }
    }

    /// Number of readings: a trial needs an error for each.
    pub fn readings(&self) -> usize {
        self.noise.readings()
    }

    /// Number of points of the network.
    pub fn points(&self) -> usize {
        self.levers.count()
    }

    /// Storage for trials, one for each thread. It carries nothing from one trial to the next.
    pub fn workspace(&self) -> Workspace {
        let points = self.points();
        let unknowns = Unknowns::zeros(points, self.shared);
        Workspace {
            corrections: Corrections {
                unknowns: unknowns.clone(),
                stations: self.stations,
            },
            errors: self.tracks.storage(),
            correlated: self.correlated.storage(),
            gradient: unknowns.clone(),
            step: unknowns,
            points: Coordinates::zeros(points),
            right_side: vec![0.0; self.shared + DATUM],
            solved: vec![Lanes::ZERO; (self.shared + DATUM).div_ceil(LANES)],
            multipliers: [0.0; DATUM],
        }
    }

    /// Draws the error of every reading from the noise of the network: a return of the machine for
    /// each visit, `N(0, σ_m² I)`, and a part of each length's own, `N(0, σ_l²)`.
    ///
    /// The return acts to first order, by its part along the beam (what is left out is 1e-6 of
    /// it). Lengths of a visit are then normal with the covariance `C = L Lᵀ` that weighs them, and
    /// are drawn as `L z`: one normal number for each reading, in measuring order.
    ///
    /// # Panics
    /// If there is not one error for each reading.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R, errors_mm: &mut [f64]) {
        assert_eq!(errors_mm.len(), self.readings(), "one error per reading");
        self.noise.draw(rng, errors_mm);
    }

    /// Solves the network for its computed lengths plus these errors (observed minus true), in the
    /// datum of the solution.
    ///
    /// The result is that of the full nonlinear adjustment with the same weights to 1e-6 standard
    /// uncertainties. Errors so large that no solution is found give NaN for all unknowns.
    ///
    /// # Panics
    /// If there is not one error for each reading.
    pub fn solve<'w>(&self, errors_mm: &[f64], workspace: &'w mut Workspace) -> &'w Corrections {
        in_widest_registers(
            #[inline(always)]
            || self.fill(errors_mm, workspace),
        );
        &workspace.corrections
    }

    #[inline(always)]
    fn fill(&self, errors_mm: &[f64], workspace: &mut Workspace) {
        self.start(errors_mm, workspace);
        // Corrections shrink by a constant factor: what is left out after the last is about its
        // square over the one before. The linear solution counts with one unknown's share, because
        // the direction that shrinks least is one of many.
        let mut before = self.correct(workspace) / (self.unknowns() as f64).sqrt();
        for _ in 0..MAX_CORRECTIONS {
            self.take_gradient(errors_mm, workspace);
            let length = self.correct(workspace);
            if length * length <= LEFT_OUT * before {
                return;
            }
            before = length;
        }
        workspace.corrections.unknowns.fill(f64::NAN);
    }

    fn unknowns(&self) -> usize {
        3 * self.points() + self.shared
    }

    /// Forgets the corrections of the trial before, and takes the gradient without any.
    #[inline(always)]
    fn start(&self, errors_mm: &[f64], workspace: &mut Workspace) {
        assert_eq!(errors_mm.len(), self.readings(), "one error per reading");
        let Workspace {
            corrections: Corrections { unknowns, .. },
            errors,
            correlated: storage,
            gradient,
            ..
        } = workspace;
        unknowns.fill(0.0);
        gradient.fill(0.0);
        self.tracks.arrange(errors_mm, errors);
        self.tracks.add_gradient_of_errors(errors, gradient);
        self.correlated
            .add_gradient(errors_mm, unknowns, gradient, storage);
    }

    /// Takes the exact gradient where the corrections have led.
    #[inline(always)]
    fn take_gradient(&self, errors_mm: &[f64], workspace: &mut Workspace) {
        let Workspace {
            corrections: Corrections { unknowns, .. },
            errors,
            correlated: storage,
            gradient,
            ..
        } = workspace;
        gradient.fill(0.0);
        self.tracks.add_gradient(errors, unknowns, gradient);
        self.correlated
            .add_gradient(errors_mm, unknowns, gradient, storage);
    }

    /// Adds the correction that follows from the gradient; its length in standard uncertainties.
    #[inline(always)]
    fn correct(&self, workspace: &mut Workspace) -> f64 {
        let Workspace {
            corrections: Corrections { unknowns, .. },
            correlated: storage,
            gradient,
            step,
            points,
            right_side,
            solved,
            multipliers,
            ..
        } = workspace;
        // Points with the stations held, and what they leave for the stations.
        self.blocks.times(&gradient.points, &mut step.points);
        let (shared, datum) = right_side.split_at_mut(self.shared);
        shared.copy_from_slice(&gradient.shared);
        self.tracks.reduce_shared(&step.points, shared);
        self.correlated.reduce_shared(&step.points, shared, storage);
        self.close_datum(&step.points, datum);
        self.solve_reduced(right_side, solved);
        let values = solved.iter().flat_map(|eight| eight.0);
        for (value, solved) in step.shared.iter_mut().chain(&mut *multipliers).zip(values) {
            *value = solved;
        }

        // Points with the stations moved.
        points.copy_from(&gradient.points);
        self.tracks.reduce_points(&step.shared, points);
        self.correlated.reduce_points(&step.shared, points, storage);
        self.reduce_by_datum(multipliers, points);
        self.blocks.times(points, &mut step.points);

        unknowns.add(step);
        gradient.dot(step).abs().sqrt()
    }

    /// `Σ` times the right side.
    #[inline(always)]
    fn solve_reduced(&self, right_side: &[f64], solved: &mut [Lanes]) {
        solved.fill(Lanes::ZERO);
        let columns = self.reduced_inverse.chunks_exact(solved.len());
        for (column, value) in columns.zip(right_side) {
            let value = Lanes::splat(*value);
            for (sum, element) in solved.iter_mut().zip(column) {
                lanes_only();
                *sum += *element * value;
            }
        }
    }

    /// `-Hᵀ y`: takes translations and rotations out of the points.
    #[inline(always)]
    fn close_datum(&self, points: &Coordinates, right_side: &mut [f64]) {
        let [x, y, z] = points.eights();
        let [rx, ry, rz] = self.levers.eights();
        let motions = [
            sum(x),
            sum(y),
            sum(z),
            dot(ry, z) - dot(rz, y),
            dot(rz, x) - dot(rx, z),
            dot(rx, y) - dot(ry, x),
        ];
        for (value, motion) in right_side.iter_mut().zip(motions) {
            *value = -motion.sum();
        }
    }

    /// Takes `H λ` off `points`.
    #[inline(always)]
    fn reduce_by_datum(&self, multipliers: &[f64; DATUM], points: &mut Coordinates) {
        let splat = |i: usize| Lanes::splat(multipliers[i]);
        let (tx, ty, tz) = (splat(0), splat(1), splat(2));
        let (ax, ay, az) = (splat(3), splat(4), splat(5));
        let [rx, ry, rz] = self.levers.eights();
        let [x, y, z] = points.eights_mut();
        let levers = rx.iter().zip(ry).zip(rz);
        for (((rx, ry), rz), ((x, y), z)) in levers.zip(x.iter_mut().zip(y).zip(z)) {
            lanes_only();
            let (rx, ry, rz) = (Lanes(*rx), Lanes(*ry), Lanes(*rz));
            *x = (Lanes(*x) - (tx + ay * rz - az * ry)).0;
            *y = (Lanes(*y) - (ty + az * rx - ax * rz)).0;
            *z = (Lanes(*z) - (tz + ax * ry - ay * rx)).0;
        }
    }
}

impl Corrections {
    /// Of all points: x, y and z, in the order of the network, mm.
    pub fn points_mm(&self) -> [&[f64]; 3] {
        self.unknowns.points.all()
    }

    /// Of one point, mm.
    ///
    /// # Panics
    /// If the network has no such point.
    pub fn point_mm(&self, point: usize) -> Vector3<f64> {
        Vector3::from(self.points_mm().map(|values| values[point]))
    }

    /// Of the position of a station, mm.
    ///
    /// # Panics
    /// If the network has no such station.
    pub fn station_mm(&self, station: usize) -> Vector3<f64> {
        assert!(station < self.stations, "no station {station}");
        let first = PER_STATION * station;
        Vector3::from_column_slice(&self.unknowns.shared[first..first + PER_STATION - 1])
    }

    /// Of a dead path, mm. They are numbered by station, then by interruption.
    ///
    /// # Panics
    /// If the network has no such dead path.
    pub fn dead_path_mm(&self, dead_path: usize) -> f64 {
        self.unknowns.shared[zero_column(dead_path, self.stations)]
    }
}

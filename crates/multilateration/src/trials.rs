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
//! With errors of the size of the noise the second correction is some 1e-4 standard uncertainties,
//! the third some 1e-7, and mostly not needed.

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

use self::coordinates::{Coordinates, Lanes, dot, sum};
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
    /// `Σ`, row by row.
    reduced_inverse: Vec<f64>,
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
        let rows = (0..sigma.nrows()).flat_map(|i| (0..sigma.ncols()).map(move |j| sigma[(i, j)]));
        Self {
            noise,
            tracks: Tracks::new(independent),
            correlated,
            blocks,
            levers: Coordinates::from_vectors(levers),
            reduced_inverse: rows.collect(),
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
        self.start(errors_mm, workspace);
        // Corrections shrink by a constant factor: what is left out after the last is about its
        // square over the one before. The linear solution counts with one unknown's share, because
        // the direction that shrinks least is one of many.
        let mut before = self.correct(workspace) / (self.unknowns() as f64).sqrt();
        for _ in 0..MAX_CORRECTIONS {
            self.take_gradient(errors_mm, workspace);
            let length = self.correct(workspace);
            if length * length <= LEFT_OUT * before {
                return &workspace.corrections;
            }
            before = length;
        }
        workspace.corrections.unknowns.fill(f64::NAN);
        &workspace.corrections
    }

    fn unknowns(&self) -> usize {
        3 * self.points() + self.shared
    }

    /// Forgets the corrections of the trial before, and takes the gradient without any.
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
    fn correct(&self, workspace: &mut Workspace) -> f64 {
        let Workspace {
            corrections: Corrections { unknowns, .. },
            correlated: storage,
            gradient,
            step,
            points,
            right_side,
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
        let rows = self.reduced_inverse.chunks_exact(right_side.len());
        let solved = step.shared.iter_mut().chain(&mut *multipliers);
        for (value, row) in solved.zip(rows) {
            *value = dot(row, right_side);
        }

        // Points with the stations moved.
        points.clone_from(&gradient.points);
        self.tracks.reduce_points(&step.shared, points);
        self.correlated.reduce_points(&step.shared, points, storage);
        self.reduce_by_datum(multipliers, points);
        self.blocks.times(points, &mut step.points);

        unknowns.add(step);
        gradient.dot(step).abs().sqrt()
    }

    /// `-Hᵀ y`: takes translations and rotations out of the points.
    fn close_datum(&self, points: &Coordinates, right_side: &mut [f64]) {
        let [x, y, z] = points.all();
        let [rx, ry, rz] = self.levers.all();
        let motions = [
            sum(x),
            sum(y),
            sum(z),
            dot(ry, z) - dot(rz, y),
            dot(rz, x) - dot(rx, z),
            dot(rx, y) - dot(ry, x),
        ];
        for (value, motion) in right_side.iter_mut().zip(motions) {
            *value = -motion;
        }
    }

    /// Takes `H λ` off `points`.
    fn reduce_by_datum(&self, multipliers: &[f64; DATUM], points: &mut Coordinates) {
        let [tx, ty, tz, ax, ay, az] = *multipliers;
        let [rx, ry, rz] = self.levers.all();
        let [x, y, z] = points.all_mut();
        for i in 0..x.len() {
            x[i] -= tx + ay * rz[i] - az * ry[i];
            y[i] -= ty + az * rx[i] - ax * rz[i];
            z[i] -= tz + ax * ry[i] - ay * rx[i];
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

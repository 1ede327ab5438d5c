//! The adjustment with rigid stages, from lengths to stations, poses and shapes.

use nalgebra::{Isometry3, Point3};
use trueaxis_leastsquares::{
    Adjusted, Covariance, Error as LeastSquaresError, Termination, adjust,
};

use crate::batch_influence::BatchInfluence;
use crate::bodies::Bodies;
use crate::components::{Components, components};
use crate::estimate_noise::{Weighted, estimate};
use crate::free_points::State;
use crate::passes::{GroupModel, within_pool};
use crate::reweighting::reweight;
use crate::rigid_adjustment::RigidAdjustment;
use crate::rigid_stages::RigidState;
use crate::{Error, Network, Noise, NoiseEstimate, Settings, Solution, Station};

/// Adjusted stations, poses and shapes in the datum of the nominal points.
#[derive(Debug, Clone)]
pub struct RigidSolution {
    /// Stations in the order of the network.
    pub stations: Vec<Station>,
    /// Poses of the bodies at each group: reference frame from home.
    pub poses: Vec<Isometry3<f64>>,
    /// Home positions of the targets of each body, mm.
    pub shapes_mm: Vec<Vec<Point3<f64>>>,
    /// Points in the order of the network, mm.
    pub points_mm: Vec<Point3<f64>>,
    /// Observed minus computed length of every reading, mm.
    pub residuals_mm: Vec<f64>,
    /// Sum of squares of the whitened residuals.
    pub squares: f64,
    /// Number of lengths.
    pub observations: usize,
    /// Number of unknowns less the six that the datum fixes.
    pub unknowns: usize,
    /// Iterations of the adjustment.
    pub iterations: usize,
    /// Why it stopped. Look at it: a result that is not converged is returned, not hidden.
    pub termination: Termination,
    /// Covariance for the noise as given: blocks are the groups (translation, mm, and rotation, rad,
    /// about the centroid of the points), shared unknowns the stations (x y z L of each) and behind
    /// them the deformations of the bodies.
    pub covariance: Covariance,
}

impl RigidSolution {
    /// Redundancy of the whole: lengths minus unknowns.
    pub fn degrees_of_freedom(&self) -> usize {
        self.observations.saturating_sub(self.unknowns)
    }

    pub(crate) fn state(&self) -> RigidState {
        RigidState {
            free: State {
                stations: self.stations.iter().map(|s| s.position_mm).collect(),
                dead_paths_mm: self.stations.iter().map(|s| s.dead_path_mm).collect(),
                points: self.points_mm.clone(),
            },
            poses: self.poses.clone(),
            shapes_mm: self.shapes_mm.clone(),
        }
    }
}

/// Adjusts the lengths of a network with its points tied to rigid bodies. The start is the solution
/// with free points; interruptions of the network are ignored.
///
/// # Errors
/// Those of [`crate::solve`], and [`Error::NotRigid`].
pub fn solve_rigid(
    network: &Network,
    bodies: &Bodies,
    start: &Solution,
    settings: &Settings,
) -> Result<RigidSolution, Error> {
    let mut stations = start.state();
    stations.dead_paths_mm.truncate(network.stations.len());
    stations
        .points
        .resize(network.nominal_mm.len(), Point3::origin());
    adjust_from(
        network,
        bodies,
        RigidState::nominal(network, bodies, stations),
        settings,
    )
}

impl RigidSolution {
    /// Solves a similar network from this solution: other lengths, other noise.
    ///
    /// # Errors
    /// Those of [`crate::solve`].
    pub fn solve_again(
        &self,
        network: &Network,
        bodies: &Bodies,
        settings: &Settings,
    ) -> Result<Self, Error> {
        adjust_from(network, bodies, self.state(), settings)
    }
}

fn adjust_from(
    network: &Network,
    bodies: &Bodies,
    start: RigidState,
    settings: &Settings,
) -> Result<RigidSolution, Error> {
    let mut model = RigidAdjustment::new(network, bodies, &start.free);
    let run = |model: &RigidAdjustment<'_>, start| {
        adjust(model, start, &settings.iteration).map_err(|error| match error {
            LeastSquaresError::BlockRank { block, .. }
            | LeastSquaresError::TooFewRows { block, .. } => Error::NotRigid {
                group: block,
                points: network.groups[block].len(),
            },
            other => Error::LeastSquares(other),
        })
    };
    within_pool(model.batches().len(), || {
        let first = run(&model, start.clone())?;
        let (adjusted, iterations) = reweight(&mut model, start, first, run)?;
        let covariance = adjusted.covariance(&model).map_err(Error::LeastSquares)?;
        Ok(solution(network, adjusted, covariance, iterations))
    })
}

fn solution(
    network: &Network,
    adjusted: Adjusted<RigidState>,
    covariance: Covariance,
    iterations: usize,
) -> RigidSolution {
    let state = adjusted.state;
    let residuals_mm = state.free.residuals_mm(network);
    let stations = state.free.stations.iter().zip(&state.free.dead_paths_mm);
    RigidSolution {
        stations: stations
            .map(|(&position_mm, &dead_path_mm)| Station {
                position_mm,
                dead_path_mm,
            })
            .collect(),
        residuals_mm,
        squares: adjusted.squares,
        observations: adjusted.observations,
        unknowns: adjusted.unknowns,
        iterations,
        termination: adjusted.termination,
        covariance,
        poses: state.poses,
        shapes_mm: state.shapes_mm,
        points_mm: state.free.points,
    }
}

/// Estimates the noise from the residuals with rigid stages and solves with it; `declared` says
/// whether the network's noise is more than a guess.
///
/// # Errors
/// Those of [`solve_rigid`].
pub fn estimate_rigid_noise(
    network: &mut Network,
    bodies: &Bodies,
    solution: &mut RigidSolution,
    declared: bool,
    settings: &Settings,
) -> Result<NoiseEstimate, Error> {
    estimate(
        &mut RigidNoise {
            network,
            bodies,
            solution,
            settings,
        },
        declared,
    )
}

struct RigidNoise<'a> {
    network: &'a mut Network,
    bodies: &'a Bodies,
    solution: &'a mut RigidSolution,
    settings: &'a Settings,
}

impl Weighted for RigidNoise<'_> {
    fn noise(&self) -> Noise {
        self.network.noise
    }

    fn solve_with(&mut self, noise: Noise) -> Result<(), Error> {
        self.network.noise = noise;
        *self.solution = self
            .solution
            .solve_again(self.network, self.bodies, self.settings)?;
        Ok(())
    }

    fn degrees_of_freedom(&self) -> f64 {
        self.solution.degrees_of_freedom() as f64
    }

    fn squares(&self) -> f64 {
        self.solution.squares
    }

    fn components(&self) -> Option<Components> {
        let (network, bodies) = (&*self.network, self.bodies);
        components(&BatchInfluence::rigid(network, bodies, self.solution))
    }
}

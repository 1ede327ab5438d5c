//! The only place that calls the adjustment: what is compared with the peers.

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::Campaign;
use trueaxis_multilateration::{
    Bodies, Network, Refined, RigidSolution, Settings, Solution, Station, Trials,
    network_from_campaign, refine, solve, solve_rigid,
};

/// What the points of a step have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Nothing: nine coordinates a step.
    Free,
    /// The pose of a rigid stage: six unknowns a step, and the shape of the targets.
    Joint,
}

/// A network with the start that all solvers get: points at their nominal places, stations some 5 mm off.
pub struct Problem {
    /// The lengths, and the nominal points.
    pub network: Network,
    /// Where the iteration starts.
    pub stations: Vec<Station>,
    bodies: Bodies,
    /// The start in the words of the joint adjustment.
    start: Solution,
}

/// What an adjustment found.
pub enum Solved<'a> {
    /// With free points.
    Free(Box<Refined<'a>>),
    /// With rigid stages, and the covariance.
    Joint(Box<RigidSolution>),
}

impl Model {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Free, Self::Joint];

    /// As the peers call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Joint => "joint",
        }
    }
}

impl Problem {
    /// The problem of a campaign.
    ///
    /// # Panics
    /// If the campaign cannot be solved.
    pub fn of(campaign: &Campaign) -> Self {
        let lengths = campaign.lengths.as_ref().expect("lengths");
        let named = network_from_campaign(campaign, lengths, false);
        let bodies =
            Bodies::of_campaign(campaign, &named.groups).expect("three targets at every step");
        let mut start = solve(&named.network, &Settings::default()).expect("a solution");
        for (station, sign) in start
            .stations
            .iter_mut()
            .zip([1.0, -1.0].into_iter().cycle())
        {
            station.position_mm += sign * Vector3::new(3.0, -3.0, 2.5);
            station.dead_path_mm += sign * 5.0;
        }
        Self {
            network: named.network,
            stations: start.stations.clone(),
            bodies,
            start,
        }
    }

    /// Adjusts from the start. Today the joint adjustment cannot leave the covariance out.
    ///
    /// # Panics
    /// If there is no solution.
    pub fn adjust(&self, model: Model) -> Solved<'_> {
        let (network, settings) = (&self.network, Settings::default());
        match model {
            Model::Free => {
                let refined = refine(network, &self.stations, &network.nominal_mm, &settings);
                Solved::Free(Box::new(refined.expect("a solution")))
            }
            Model::Joint => {
                let solved = solve_rigid(network, &self.bodies, &self.start, &settings);
                Solved::Joint(Box::new(solved.expect("a solution")))
            }
        }
    }

    /// Adjusts from nothing but nominal points, with the covariance: what a calibration does. Sum of squares.
    ///
    /// # Panics
    /// If there is no solution.
    pub fn solve(&self, model: Model) -> f64 {
        let (network, settings) = (&self.network, Settings::default());
        let solution = solve(network, &settings).expect("a solution");
        match model {
            Model::Free => solution.squares,
            Model::Joint => {
                solve_rigid(network, &self.bodies, &solution, &settings)
                    .expect("a solution")
                    .squares
            }
        }
    }

    /// Its Monte Carlo trials.
    ///
    /// # Panics
    /// If there is no solution.
    pub fn trials(&self) -> Trials {
        Trials::new(
            &self.network,
            &solve(&self.network, &Settings::default()).expect("a solution"),
        )
    }
}

impl Solved<'_> {
    /// Computes the covariance of all steps, and returns the trace of it so that nothing is left out.
    ///
    /// # Panics
    /// If the solution has none.
    pub fn covariance(self, steps: usize) -> f64 {
        let covariance = match self {
            Self::Free(refined) => refined.solution().expect("a covariance").covariance,
            Self::Joint(solution) => solution.covariance,
        };
        let trace = |step| {
            covariance
                .block(step)
                .diagonal()
                .column_vector()
                .iter()
                .sum::<f64>()
        };
        (0..steps).map(trace).sum()
    }

    /// Points and stations, and how many iterations it took.
    ///
    /// # Panics
    /// If the solution has no covariance.
    pub fn found(self) -> (Vec<Point3<f64>>, Vec<Station>, usize) {
        match self {
            Self::Free(refined) => {
                let solution = refined.solution().expect("a covariance");
                (solution.points_mm, solution.stations, solution.iterations)
            }
            Self::Joint(solution) => (solution.points_mm, solution.stations, solution.iterations),
        }
    }
}

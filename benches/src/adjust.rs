//! The only place that calls the adjustment: what is compared with the peers.

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::Campaign;
use trueaxis_multilateration::{Network, Refined, Solution, Station, Trials, refine, solve};
use trueaxis_poses::network_from_campaign;

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
    /// The lengths, the nominal points, and the bodies that the joint adjustment ties them to.
    pub network: Network,
    /// Where the iteration starts: nominal points that are free, and stations.
    pub start: Solution,
    /// The same lengths without bodies.
    free: Network,
}

/// What an adjustment found, yet without covariance.
pub struct Solved<'a>(Refined<'a>);

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
        // The peers have no constants of reflectors.
        let network = Network {
            reflectors: None,
            ..network_from_campaign(campaign, lengths, false).network
        };
        let free = Network {
            bodies: None,
            ..network.clone()
        };
        let mut start = solve(&free).expect("a solution");
        start.points_mm.clone_from(&network.nominal_mm);
        for (station, sign) in start
            .stations
            .iter_mut()
            .zip([1.0, -1.0].into_iter().cycle())
        {
            station.position_mm += sign * Vector3::new(3.0, -3.0, 2.5);
            station.dead_path_mm += sign * 5.0;
        }
        Self {
            free,
            network,
            start,
        }
    }

    fn network_of(&self, model: Model) -> &Network {
        match model {
            Model::Free => &self.free,
            Model::Joint => &self.network,
        }
    }

    /// Adjusts from the start.
    ///
    /// # Panics
    /// If there is no solution.
    pub fn adjust(&self, model: Model) -> Solved<'_> {
        let network = self.network_of(model);
        let refined = refine(network, &self.start);
        Solved(refined.expect("a solution"))
    }

    /// Adjusts from nothing but nominal points, with the covariance: what a calibration does. Sum of squares.
    ///
    /// # Panics
    /// If there is no solution.
    pub fn solve(&self, model: Model) -> f64 {
        let solution = solve(self.network_of(model));
        solution.expect("a solution").squares
    }

    /// Its Monte Carlo trials, with rigid stages.
    ///
    /// # Panics
    /// If there is no solution.
    pub fn trials(&self) -> Trials {
        let solution = solve(&self.network);
        Trials::new(&self.network, &solution.expect("a solution"))
    }
}

impl Solved<'_> {
    /// Computes the covariance of all steps, and returns the trace of it so that nothing is left out.
    ///
    /// # Panics
    /// If the solution has none.
    pub fn covariance(self) -> f64 {
        let covariance = self.0.solution().expect("a covariance").covariance;
        covariance.blocks().map(|step| step.trace()).sum()
    }

    /// Points and stations, and how many iterations it took.
    ///
    /// # Panics
    /// If the solution has no covariance.
    pub fn found(self) -> (Vec<Point3<f64>>, Vec<Station>, usize) {
        let solution = self.0.solution().expect("a covariance");
        (solution.points_mm, solution.stations, solution.iterations)
    }
}

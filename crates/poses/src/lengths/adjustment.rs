//! Lengths to poses or to points, with errors in the words of the campaign.

use nalgebra::{DMatrix, Matrix6, Matrix6xX, Point3};
use rayon::prelude::*;
use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_multilateration::{
    self as multilateration, BlockNoise, CampaignNetwork, Group, Network, Screened, Solution,
    adjust_as_a_set, network_from_campaign, screen, solve_as_a_set,
};

use crate::Error;
use crate::lengths::refused::{adjustment_error, contradictory};
use crate::lengths::weak_stations::weak_stations;
use crate::points::{MeasuredPoints, PointGroup, PointNoise, centroid};
use crate::poses::{PoseNoise, PoseObservation, Poses, TargetBody};
use crate::settings::{Method, Settings};
use crate::words::{step_in_words, target_names, too_few_targets};

/// The adjustment of a campaign's lengths: the only one that there is.
#[derive(Debug, Clone)]
pub struct LengthsAdjustment<'a> {
    pub(crate) campaign: &'a Campaign,
    pub(crate) lengths: &'a Lengths,
    /// With rigid stages for [`Method::Joint`], with free points otherwise.
    pub method: Method,
    /// Whether the sides of approach have poses of their own.
    pub by_direction: bool,
    pub(crate) groups: Vec<Group>,
    /// The number in the campaign ([`Campaign::reflectors`]) of each reflector that was measured.
    pub(crate) reflectors: Vec<usize>,
    /// The screened network with its solution and noise.
    pub screened: Screened,
}

/// A residual this many times its noise in the mean is no noise: something in the data is wrong.
const CONTRADICTORY_SIGMA0: f64 = 100.0;

/// Groups that one thread takes at a time.
const PIECE: usize = 32;

impl<'a> LengthsAdjustment<'a> {
    /// Adjusts the lengths, and says what a user must know of the stations.
    pub(crate) fn new(
        campaign: &'a Campaign,
        lengths: &'a Lengths,
        settings: &Settings,
    ) -> Result<(Self, Vec<String>), Error> {
        let CampaignNetwork {
            mut network,
            groups,
            reflectors,
        } = network_from_campaign(campaign, lengths, settings.by_direction);
        if settings.method != Method::Joint {
            network.bodies = None;
        }
        let adjust = if settings.robust {
            screen
        } else {
            Screened::plain
        };
        let declared = is_noise_declared(campaign);
        let iteration = multilateration::Settings::default();
        let adjusted = adjust_as_a_set(
            &mut network,
            |screened: &Screened| &screened.solution,
            |network| adjust(network, declared, &iteration),
        );
        let screened =
            adjusted.map_err(|error| adjustment_error(campaign, lengths, &groups, error))?;
        let adjustment = Self {
            campaign,
            lengths,
            method: settings.method,
            by_direction: settings.by_direction,
            groups,
            reflectors,
            screened,
        };
        let weak = adjustment.check()?;
        Ok((adjustment, weak))
    }

    /// Refuses an adjustment that cannot be trusted. Contradictions come first: they make the stations look
    /// weak.
    fn check(&self) -> Result<Vec<String>, Error> {
        let (campaign, lengths, solution) = (self.campaign, self.lengths, &self.screened.solution);
        let residuals_mm = self.screened.residuals_mm();
        let sigma0 = self.given_sigma0();
        if sigma0 > CONTRADICTORY_SIGMA0 {
            return Err(contradictory(campaign, lengths, sigma0, &residuals_mm));
        }
        let weak = weak_stations(campaign, lengths, solution, &residuals_mm)?;
        if !solution.termination.is_converged() {
            return Err(Error::NotConverged {
                iterations: solution.iterations,
                termination: solution.termination.to_string(),
            });
        }
        self.check_targets()?;
        Ok(weak)
    }

    /// Standard deviation of unit weight with the declared noise.
    pub(crate) fn given_sigma0(&self) -> f64 {
        match self.screened.solution.degrees_of_freedom() {
            0 => 1.0,
            degrees_of_freedom => (self.screened.given_squares / degrees_of_freedom as f64).sqrt(),
        }
    }

    pub(crate) fn is_noise_declared(&self) -> bool {
        is_noise_declared(self.campaign)
    }

    /// The groups of the targets that move with the axes under test, in order.
    pub(crate) fn moved(&self) -> Vec<usize> {
        let groups = 0..self.groups.len();
        groups.filter(|&g| self.groups[g].moved).collect()
    }

    /// The poses of the stages under test in an adjustment with rigid stages.
    pub(crate) fn poses(&self) -> Result<Poses, Error> {
        let Screened {
            network, solution, ..
        } = &self.screened;
        let moved = self.moved();
        let observation = |&g: &usize| {
            let group = &self.groups[g];
            Ok(PoseObservation {
                step: group.step,
                direction: group.direction,
                body: group.body.ok_or_else(|| self.without_body(group))?,
                datum_from_home: solution.poses[g],
                pivot_mm: centroid(&solution.points_mm[network.groups[g].clone()]),
            })
        };
        let shapes = solution.shapes_mm.iter().enumerate();
        let bodies = shapes.map(|(body, home_mm)| TargetBody {
            targets: self.targets_of(body, home_mm),
            home_mm: home_mm.clone(),
        });
        // What only the instrument's part needs is the largest, and gone before the rest is made.
        let instrument = pose_noise(&solution.length_noise(network), &moved);
        Ok(Poses {
            observations: moved.iter().map(observation).collect::<Result<_, _>>()?,
            bodies: bodies.collect(),
            noise: pose_noise(&solution.noise(), &moved),
            instrument,
            relative_covariance: self.screened.noise.relative_covariance,
        })
    }

    /// The targets of a body, in its order.
    fn targets_of(&self, body: usize, home_mm: &[Point3<f64>]) -> Vec<usize> {
        let mut targets = vec![0; home_mm.len()];
        let bodies = self.screened.network.bodies.iter();
        let placed = bodies.flat_map(|bodies| &bodies.of_groups);
        for (placed, group) in placed.zip(&self.groups) {
            if placed.body == Some(body) {
                for (&place, &target) in placed.places.iter().zip(&group.targets) {
                    targets[place] = target;
                }
            }
        }
        targets
    }

    /// Why a group that the axis under test moves has no body.
    fn without_body(&self, group: &Group) -> Error {
        if group.targets.len() < 3 {
            return too_few_targets(self.campaign, group.step, group.targets.len());
        }
        Error::not_identifiable(
            format!(
                "{}: targets {} are on one line: no rotation about it is seen",
                step_in_words(self.campaign, group.step),
                target_names(self.campaign, &group.targets)
            ),
            "place one target well away from the line through the others",
        )
    }

    /// The points of the stages under test, free of each other, where the same lengths have them. Those of
    /// an adjustment with rigid stages follow from its solution in an iteration or two; they come without the
    /// instrument's own part of the noise.
    pub(crate) fn points(&self) -> Result<MeasuredPoints, Error> {
        let Screened {
            network, solution, ..
        } = &self.screened;
        if network.bodies.is_none() {
            let mut points = self.measured_points(network, solution);
            points.instrument = point_noise(&solution.length_noise(network), &self.moved());
            return Ok(points);
        }
        let mut network = Network {
            bodies: None,
            ..network.clone()
        };
        let iteration = multilateration::Settings::default();
        let words = |error| adjustment_error(self.campaign, self.lengths, &self.groups, error);
        let free = solve_as_a_set(&mut network, Some(solution), &iteration).map_err(words)?;
        Ok(self.measured_points(&network, &free))
    }

    fn measured_points(&self, network: &Network, solution: &Solution) -> MeasuredPoints {
        let moved = self.moved();
        let group = |&g: &usize| PointGroup {
            step: self.groups[g].step,
            direction: self.groups[g].direction,
            targets: self.groups[g].targets.clone(),
            points_mm: solution.points_mm[network.groups[g].clone()].to_vec(),
        };
        MeasuredPoints {
            groups: moved.iter().map(group).collect(),
            noise: point_noise(&solution.noise(), &moved),
            instrument: PointNoise::default(),
            relative_covariance: self.screened.noise.relative_covariance,
            repeat_scatter: (0.0, 0),
        }
    }
}

/// Whether both parts of the noise are declared: one alone can be tested against nothing.
fn is_noise_declared(campaign: &Campaign) -> bool {
    let instrument = &campaign.instrument;
    instrument.length_sigma_um.is_some() && instrument.repeatability_um.is_some()
}

fn pose_noise(noise: &BlockNoise<'_>, groups: &[usize]) -> PoseNoise {
    let fixed = |(own, coupling): (DMatrix<f64>, DMatrix<f64>)| {
        (
            Matrix6::from_column_slice(own.as_slice()),
            Matrix6xX::from_column_slice(coupling.as_slice()),
        )
    };
    let (own, coupling) = blocks(noise, groups).into_iter().map(fixed).unzip();
    PoseNoise {
        own,
        coupling,
        shared: noise.shared().clone(),
        of_stations: noise.shared().nrows(),
    }
}

fn point_noise(noise: &BlockNoise<'_>, groups: &[usize]) -> PointNoise {
    let (own, coupling) = blocks(noise, groups).into_iter().unzip();
    PointNoise {
        own,
        coupling,
        shared: noise.shared().clone(),
    }
}

/// `D` and `Z` of some groups.
fn blocks(noise: &BlockNoise<'_>, groups: &[usize]) -> Vec<(DMatrix<f64>, DMatrix<f64>)> {
    let groups = groups.par_iter().with_min_len(PIECE);
    groups.map(|&g| noise.block(g)).collect()
}

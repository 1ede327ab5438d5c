//! Lengths to poses or to points, with errors in the words of the campaign.

use std::sync::Arc;

use nalgebra::{Matrix6, Matrix6xX};
use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_multilateration::{
    BlockNoise, CampaignNetwork, Group, MOST_OF_A_PART, Network, Screened, Solution,
    network_from_campaign, screen, solve_from,
};

use crate::lengths_in_words::{adjustment_error, contradictory};
use crate::points::{MeasuredPoints, PointGroup, PointNoise};
use crate::poses::{PoseNoise, PoseObservation, Poses, TargetBody};
use crate::rigid_fit::centroid;
use crate::settings::{Method, Settings};
use crate::weak_stations::weak_stations;
use crate::{Error, describe, in_order};

/// The adjustment of a campaign's lengths: the only one that there is.
pub(crate) struct AdjustedLengths<'a> {
    campaign: &'a Campaign,
    lengths: &'a Lengths,
    pub(crate) groups: Vec<Group>,
    pub(crate) screened: Arc<Screened>,
}

/// A residual this many times its noise in the mean is no noise: something in the data is wrong.
const CONTRADICTORY_SIGMA0: f64 = 100.0;

impl<'a> AdjustedLengths<'a> {
    /// Adjusts the lengths, with rigid stages for [`Method::Joint`] and with free points otherwise, and
    /// adds what a user must know of it to `notices`.
    pub(crate) fn new(
        campaign: &'a Campaign,
        lengths: &'a Lengths,
        settings: &Settings,
        notices: &mut Vec<String>,
    ) -> Result<Self, Error> {
        let CampaignNetwork {
            mut network,
            groups,
        } = network_from_campaign(campaign, lengths, settings.by_direction);
        if settings.method != Method::Joint {
            network.bodies = None;
        }
        let declared = is_noise_declared(campaign);
        let adjust = if settings.robust {
            screen
        } else {
            Screened::plain
        };
        let screened = adjust(&network, declared, &adjustment_settings())
            .map(Arc::new)
            .map_err(|error| adjustment_error(campaign, lengths, &groups, error))?;
        let solution = &screened.solution;
        let residuals_mm = screened.residuals_mm();
        let sigma0 = given_sigma0(&screened);
        if sigma0 > CONTRADICTORY_SIGMA0 {
            return Err(contradictory(campaign, lengths, sigma0, &residuals_mm));
        }
        // Contradictions come first: they make the stations look weak.
        notices.extend(weak_stations(campaign, lengths, solution, &residuals_mm)?);
        if !solution.termination.is_converged() {
            let termination = solution.termination.to_string();
            return Err(Error::NotConverged {
                iterations: solution.iterations,
                termination,
            });
        }
        removed_targets(campaign, lengths, &screened)?;
        Ok(Self {
            campaign,
            lengths,
            groups,
            screened,
        })
    }

    /// The poses of the stages under test in an adjustment with rigid stages.
    pub(crate) fn poses(&self) -> Result<Poses, Error> {
        let Screened {
            network, solution, ..
        } = &*self.screened;
        let mut observations = Vec::new();
        for g in self.moved() {
            let group = &self.groups[g];
            observations.push(PoseObservation {
                step: group.step,
                direction: group.direction,
                body: group.body.ok_or_else(|| self.too_few_targets(group))?,
                datum_from_home: solution.poses[g],
                pivot_mm: centroid(&solution.points_mm[network.groups[g].clone()]),
            });
        }
        let shapes = solution.shapes_mm.iter().enumerate();
        let bodies = shapes.map(|(body, home_mm)| TargetBody {
            targets: self.targets_of(body, home_mm.len()),
            home_mm: home_mm.clone(),
        });
        Ok(Poses {
            bodies: bodies.collect(),
            observations,
            noise: self.pose_noise(&solution.noise()),
            instrument: self.pose_noise(&solution.length_noise(network)),
            relative_covariance: self.screened.noise.relative_covariance,
        })
    }

    fn pose_noise(&self, noise: &BlockNoise<'_>) -> PoseNoise {
        let moved = self.moved();
        let blocks = in_order::map(moved.len(), |i| {
            let (own, coupling) = noise.block(moved[i]);
            (
                Matrix6::from_column_slice(own.as_slice()),
                Matrix6xX::from_column_slice(coupling.as_slice()),
            )
        });
        let (own, coupling) = blocks.into_iter().unzip();
        PoseNoise {
            own,
            coupling,
            shared: noise.shared().clone(),
            of_stations: noise.shared().nrows(),
        }
    }

    /// The targets of a body, in its order.
    fn targets_of(&self, body: usize, count: usize) -> Vec<usize> {
        let mut targets = vec![0; count];
        let bodies = self.screened.network.bodies.iter();
        let placed = bodies
            .flat_map(|bodies| &bodies.of_groups)
            .zip(&self.groups);
        for (placed, group) in placed.filter(|(placed, _)| placed.body == Some(body)) {
            for (&place, &target) in placed.places.iter().zip(&group.targets) {
                targets[place] = target;
            }
        }
        targets
    }

    /// Why a group that the axis under test moves has no body.
    fn too_few_targets(&self, group: &Group) -> Error {
        let step = describe::step(self.campaign, group.step);
        if group.targets.len() >= 3 {
            let name = |&target: &usize| self.campaign.targets[target].name.as_str();
            let names = group
                .targets
                .iter()
                .map(name)
                .collect::<Vec<_>>()
                .join(", ");
            return Error::NotIdentifiable {
                what: format!(
                    "{step}: targets {names} are on one line: no rotation about it is seen"
                ),
                mend: "place one target well away from the line through the others".to_owned(),
            };
        }
        let axis = self.campaign.runs[self.campaign.steps[group.step].run].axis;
        Error::NotIdentifiable {
            what: format!(
                "{step}: {} of the targets that {} moves were measured, three are needed to see its six \
                 component errors",
                group.targets.len(),
                self.campaign.machine.axes()[axis].name(),
            ),
            mend: "measure the missing targets there, or leave out the rows of this step"
                .to_owned(),
        }
    }

    /// The points of the stages under test, free of each other, where the same lengths have them. Those of
    /// an adjustment with rigid stages follow from its solution in an iteration or two; they come without the
    /// instrument's own part of the noise.
    pub(crate) fn points(&self) -> Result<MeasuredPoints, Error> {
        let Screened {
            network, solution, ..
        } = &*self.screened;
        if network.bodies.is_none() {
            let mut points = self.measured_points(network, solution);
            points.instrument = point_noise(&solution.length_noise(network), &self.moved());
            return Ok(points);
        }
        let network = Network {
            bodies: None,
            ..network.clone()
        };
        let free = solve_from(&network, solution, &adjustment_settings());
        let words = |error| adjustment_error(self.campaign, self.lengths, &self.groups, error);
        Ok(self.measured_points(&network, &free.map_err(words)?))
    }

    /// The groups of the targets that move with the axes under test, in order.
    pub(crate) fn moved(&self) -> Vec<usize> {
        (0..self.groups.len())
            .filter(|&g| self.groups[g].moved)
            .collect()
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

fn point_noise(noise: &BlockNoise<'_>, groups: &[usize]) -> PointNoise {
    let blocks = in_order::map(groups.len(), |i| noise.block(groups[i]));
    let (own, coupling) = blocks.into_iter().unzip();
    PointNoise {
        own,
        coupling,
        shared: noise.shared().clone(),
    }
}

fn adjustment_settings() -> trueaxis_multilateration::Settings {
    trueaxis_multilateration::Settings::default()
}

/// Standard deviation of unit weight with the declared noise.
pub(crate) fn given_sigma0(screened: &Screened) -> f64 {
    match screened.solution.degrees_of_freedom() {
        0 => 1.0,
        degrees_of_freedom => (screened.given_squares / degrees_of_freedom as f64).sqrt(),
    }
}

/// Whether both parts of the noise are declared: one alone can be tested against nothing.
pub(crate) fn is_noise_declared(campaign: &Campaign) -> bool {
    let instrument = &campaign.instrument;
    instrument.length_sigma_um.is_some() && instrument.repeatability_um.is_some()
}

/// So many removals, and more than half of all, of one target from one station are no accident: there
/// are at least twelve such pairs.
const FEW: usize = 10;

/// Refuses removals that concentrate on a target: it moved, and which half of its lengths is wrong
/// nothing tells.
fn removed_targets(
    campaign: &Campaign,
    lengths: &Lengths,
    screened: &Screened,
) -> Result<(), Error> {
    let (targets, stations) = (campaign.targets.len(), campaign.stations.len());
    // For each target, then for each target as seen from each station: removed, all, first and last
    // line removed.
    let mut counts = vec![(0_usize, 0_usize, [usize::MAX, 0]); targets * (1 + stations)];
    let mut is_removed = vec![false; lengths.readings.len()];
    for removed in &screened.removed {
        is_removed[removed.reading] = true;
    }
    for stop in &lengths.stops {
        for i in stop.readings.clone() {
            let reading = &lengths.readings[i];
            for place in [
                reading.target,
                targets * (1 + stop.station) + reading.target,
            ] {
                let (removed, all, [first, last]) = &mut counts[place];
                *all += 1;
                if is_removed[i] {
                    *removed += 1;
                    *first = (*first).min(reading.line);
                    *last = (*last).max(reading.line);
                }
            }
        }
    }
    let all_removed = screened.removed.len();
    for (place, (removed, all, [first, last])) in counts.into_iter().enumerate() {
        let seen_from_one_station = place >= targets;
        let concentrated = seen_from_one_station && removed >= FEW && 2 * removed > all_removed;
        if removed as f64 > MOST_OF_A_PART * all as f64 || concentrated {
            let from = match (place / targets).checked_sub(1) {
                Some(station) => format!(" from station {}", campaign.stations[station].name),
                None => String::new(),
            };
            return Err(Error::NotTrustworthy {
                what: format!(
                    "{removed} of the {all} lengths to target {}{from} contradict the others (lines \
                     {first} to {last}): it probably moved",
                    campaign.targets[place % targets].name
                ),
                mend: "check that it sat firmly, and measure again; --no-robust adjusts all lengths as \
                       they are"
                    .to_owned(),
            });
        }
    }
    Ok(())
}

//! The network of a measuring campaign.

use rayon::prelude::*;
use trueaxis_campaign::{Campaign, Direction, Lengths};
use trueaxis_kinematics::Ideal;

use crate::{Network, Noise, Reading, Visit};

/// A campaign's network and what its groups are.
#[derive(Debug, Clone, PartialEq)]
pub struct CampaignNetwork {
    /// The network; its readings are the campaign's, in the same order.
    pub network: Network,
    /// What each group of the network stands for.
    pub groups: Vec<Group>,
}

/// The targets of one step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The campaign's step.
    pub step: usize,
    /// Side of approach, where directions are kept apart.
    pub direction: Option<Direction>,
    /// The targets that its points are, in the order of the campaign.
    pub targets: Vec<usize>,
}

/// Noise where none is declared: the weights then say that all lengths are equally good.
const UNDECLARED_LENGTH_SIGMA_UM: f64 = 1.0;

const MM_PER_UM: f64 = 1e-3;

/// Makes the network of a campaign's lengths; one group for each step, or with `by_direction` one
/// for each step and side of approach. The noise is the declared one; 1 µm for each length where
/// none is declared.
pub fn network_from_campaign(
    campaign: &Campaign,
    lengths: &Lengths,
    by_direction: bool,
) -> CampaignNetwork {
    // The group of each step, or of each side of approach to it.
    let mut number_of = vec![[None; 2]; campaign.steps.len()];
    let mut groups: Vec<Group> = Vec::new();
    let mut group_of_stop = Vec::with_capacity(lengths.stops.len());
    for stop in &lengths.stops {
        let side = usize::from(by_direction && stop.direction == Direction::Backward);
        let number = *number_of[stop.step][side].get_or_insert_with(|| {
            groups.push(Group {
                step: stop.step,
                direction: by_direction.then_some(stop.direction),
                targets: Vec::new(),
            });
            groups.len() - 1
        });
        let targets = &mut groups[number].targets;
        for reading in &lengths.readings[stop.readings.clone()] {
            if let Err(place) = targets.binary_search(&reading.target) {
                targets.insert(place, reading.target);
            }
        }
        group_of_stop.push(number);
    }

    let positions_of = |group: &Group| {
        let positions = &campaign.steps[group.step].positions;
        let position = |&target: &usize| {
            let target = &campaign.targets[target];
            let (carrier, home_mm) = (target.carrier, target.home_mm);
            campaign
                .machine
                .position(&Ideal, carrier, positions, home_mm)
        };
        group.targets.iter().map(position).collect::<Vec<_>>()
    };
    let mut network = Network {
        stations: campaign.stations.iter().map(|s| s.approx_mm).collect(),
        noise: declared_noise(campaign),
        nominal_mm: groups.par_iter().flat_map_iter(positions_of).collect(),
        readings: Vec::with_capacity(lengths.readings.len()),
        visits: Vec::with_capacity(lengths.stops.len()),
        ..Network::default()
    };
    let mut first = 0;
    for group in &groups {
        network.groups.push(first..first + group.targets.len());
        first += group.targets.len();
    }
    for (stop, &group) in lengths.stops.iter().zip(&group_of_stop) {
        let first = network.readings.len();
        for reading in &lengths.readings[stop.readings.clone()] {
            let point = groups[group]
                .targets
                .partition_point(|&t| t < reading.target);
            network.readings.push(Reading {
                point,
                length_mm: reading.length_mm,
            });
        }
        let readings = first..network.readings.len();
        network.visits.push(Visit {
            station: stop.station,
            group,
            readings,
        });
    }
    CampaignNetwork { network, groups }
}

fn declared_noise(campaign: &Campaign) -> Noise {
    let instrument = &campaign.instrument;
    let length_sigma_um = instrument
        .length_sigma_um
        .unwrap_or(UNDECLARED_LENGTH_SIGMA_UM);
    Noise {
        length_sigma_mm: length_sigma_um * MM_PER_UM,
        // µm per m and mm per mm differ by a million.
        length_sigma_relative: instrument.length_sigma_ppm.unwrap_or(0.0) * 1e-6,
        return_sigma_mm: instrument.repeatability_um.unwrap_or(0.0) * MM_PER_UM,
    }
}

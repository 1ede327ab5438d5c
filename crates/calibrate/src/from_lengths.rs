//! Lengths to points, with errors in the words of the campaign.

use std::ops::Range;
use std::sync::Arc;

use trueaxis_campaign::{Campaign, Lengths};
use trueaxis_multilateration::{
    CampaignNetwork, MOST_OF_A_PART, Screened, batches_of_groups, network_from_campaign, screen,
};

use crate::Error;
use crate::lengths_in_words::{adjustment_error, contradictory};
use crate::measured::{Measured, MeasuredGroup};
use crate::point_noise::{NoiseSource, PointNoise};
use crate::settings::Settings;
use crate::weak_stations::weak_stations;

/// A residual this many times its noise in the mean is no noise: something in the data is wrong.
const CONTRADICTORY_SIGMA0: f64 = 100.0;

/// The adjusted points, the adjustment they come from, and notices.
pub(crate) fn measure(
    campaign: &Campaign,
    lengths: &Lengths,
    settings: &Settings,
) -> Result<(Measured, Arc<Screened>, Vec<String>), Error> {
    let CampaignNetwork {
        mut network,
        groups,
    } = network_from_campaign(campaign, lengths, settings.by_direction);
    network.bodies = None;
    let declared = is_noise_declared(campaign);
    let adjustment = trueaxis_multilateration::Settings::default();
    let adjust = if settings.robust {
        screen
    } else {
        Screened::plain
    };
    let screened = adjust(&network, declared, &adjustment)
        .map(Arc::new)
        .map_err(|error| adjustment_error(campaign, lengths, &groups, error))?;
    let solution = &screened.solution;
    let residuals_mm = screened.residuals_mm();
    let sigma0 = given_sigma0(&screened);
    if sigma0 > CONTRADICTORY_SIGMA0 {
        return Err(contradictory(campaign, lengths, sigma0, &residuals_mm));
    }
    // Contradictions come first: they make the stations look weak.
    let weak = weak_stations(campaign, lengths, solution, &residuals_mm)?;
    if !solution.termination.is_converged() {
        let termination = solution.termination.to_string();
        return Err(Error::NotConverged {
            iterations: solution.iterations,
            termination,
        });
    }
    removed_targets(campaign, lengths, &screened)?;
    let mut measured_groups = Vec::new();
    for (group, points) in groups.into_iter().zip(&network.groups) {
        measured_groups.push(MeasuredGroup {
            step: group.step,
            direction: group.direction,
            targets: group.targets,
            points: points.clone(),
        });
    }
    let measured = Measured {
        groups: measured_groups,
        points_mm: solution.points_mm.clone(),
        noise: PointNoise {
            source: NoiseSource::Adjusted(Arc::clone(&screened)),
            variance_factor: 1.0,
            batches: Arc::new(batches_of_groups(network.groups.iter().map(Range::len))),
        },
        without_return: Vec::new(),
        relative_covariance: screened.noise.relative_covariance,
        repeat_scatter: (0.0, 0),
    };
    Ok((measured, screened, weak))
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

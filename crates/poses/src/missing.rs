//! What a campaign lacks for a calibration, by its layout alone: nothing is adjusted.

use std::collections::BTreeSet;

use trueaxis_campaign::Campaign;
use trueaxis_files::counted;
use trueaxis_multilateration::{MIN_STATIONS, are_in_line};

use crate::words::target_names;

/// Least number of positions that separates the direction of an axis from its errors, and from its straightness.
const POSITIONS: usize = 3;

/// What is missing, as notices: stations, targets that show how a stage turns, positions of an axis.
pub fn missing(campaign: &Campaign) -> Vec<String> {
    let mut missing = Vec::new();
    if let Some(lengths) = &campaign.lengths {
        let stations: BTreeSet<usize> = lengths.stops.iter().map(|stop| stop.station).collect();
        if stations.len() < MIN_STATIONS {
            missing.push(format!(
                "lengths from {}: a calibration needs {MIN_STATIONS}, spread in all directions",
                counted(stations.len(), "station")
            ));
        }
    }
    let coverage = campaign.coverage();
    for (number, run) in campaign.runs.iter().enumerate() {
        let own = coverage.iter().filter(|row| row.run == Some(number));
        let targets: Vec<usize> = own.map(|row| row.target).collect();
        let home: Vec<_> = targets
            .iter()
            .map(|&t| campaign.targets[t].home_mm)
            .collect();
        if targets.is_empty() {
            missing.push(format!("run {}: no row belongs to it", run.name));
        } else if are_in_line(&home) {
            missing.push(format!(
                "run {}: targets {} are fewer than three or on one line by their position_mm: a calibration needs three that are not, \
                 or it does not see how the stage turns",
                run.name,
                target_names(campaign, &targets)
            ));
        }
        let steps = campaign.steps.iter();
        let of_axis = steps.filter(|step| {
            step.run
                .is_some_and(|own| campaign.runs[own].axis == run.axis)
        });
        let at: BTreeSet<u64> = of_axis
            .map(|step| step.positions[run.axis].to_bits())
            .collect();
        let is_first = campaign.runs[..number]
            .iter()
            .all(|earlier| earlier.axis != run.axis);
        if is_first && at.len() < POSITIONS {
            missing.push(format!(
                "axis {}: measured at {} positions; its straightness needs {POSITIONS} at least, its direction 2",
                campaign.machine.axes()[run.axis].name(),
                at.len()
            ));
        }
    }
    missing
}

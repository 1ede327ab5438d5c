//! Whether a replay measures what the campaign measured, in the same order.

use std::collections::HashMap;

use trueaxis_campaign::{Campaign, Direction};

use super::ReplayError;

/// Station, repeat, run (none on the bed), side of approach, number of the position in its run (on the bed how often
/// the target was read from there before), target.
type Key = (usize, u32, Option<usize>, Direction, usize, usize);

/// For each reading of the campaign its place among those of the replay, which may have more.
pub(super) fn places_in_replay(
    campaign: &Campaign,
    replay: &Campaign,
) -> Result<Vec<usize>, ReplayError> {
    let place_of: HashMap<Key, usize> = keys(replay).into_iter().zip(0..).collect();
    let mut places: Vec<usize> = Vec::new();
    for key in keys(campaign) {
        match (place_of.get(&key), places.last()) {
            (Some(place), last) if last.is_none_or(|last| last < place) => places.push(*place),
            _ => return Err(ReplayError::OtherOrder),
        }
    }
    Ok(places)
}

/// In measuring order.
fn keys(campaign: &Campaign) -> Vec<Key> {
    let numbers = position_numbers(campaign);
    let mut keys = Vec::new();
    let mut of_bed: HashMap<(usize, usize), usize> = HashMap::new();
    if let Some(lengths) = &campaign.lengths {
        for stop in &lengths.stops {
            let run = campaign.steps[stop.step].run;
            let readings = &lengths.readings[stop.readings.clone()];
            keys.extend(readings.iter().map(|reading| {
                let target = reading.target;
                let (repeat, position) = match run {
                    Some(_) => (stop.repeat, numbers[stop.step]),
                    None => {
                        let before = of_bed.entry((stop.station, target)).or_default();
                        *before += 1;
                        (0, *before - 1)
                    }
                };
                (stop.station, repeat, run, stop.direction, position, target)
            }));
        }
    }
    keys
}

/// For each step, its number among those of its run by position.
fn position_numbers(campaign: &Campaign) -> Vec<usize> {
    let position = |step: usize| {
        let axis = campaign.axis_under_test(step);
        axis.map_or(0.0, |axis| campaign.steps[step].positions[axis])
    };
    let mut numbers = vec![0; campaign.steps.len()];
    for run in 0..campaign.runs.len() {
        let mut steps: Vec<usize> = (0..campaign.steps.len())
            .filter(|&step| campaign.steps[step].run == Some(run))
            .collect();
        steps.sort_by(|&a, &b| position(a).total_cmp(&position(b)));
        for (number, step) in steps.into_iter().enumerate() {
            numbers[step] = number;
        }
    }
    numbers
}

//! Points that a calibration is better without: it does not look at one point against the others itself.

use std::collections::{BTreeSet, HashMap};

use trueaxis_campaign::{Campaign, Points};
use trueaxis_poses::{at_one_temperature, scene_of};

use crate::Rejected;
use crate::points::gross_errors::Gross;
use crate::points::screened::{Screened, without};

/// Targets that a pose needs.
const LEAST_TARGETS: usize = 3;

/// A campaign without the points that contradict all others, and what these are; `None` if there are none, or more than accidents.
///
/// They are those that [`crate::diagnose`] leaves out where it finds no cause. A point without which its step, approached from that side,
/// has fewer than three targets stays.
pub fn without_wrong_points(campaign: &Campaign) -> Option<(Campaign, Vec<Rejected>)> {
    let points = campaign.points.as_ref()?;
    let at_one = at_one_temperature(campaign);
    let scene = scene_of(&at_one);
    let mut gross = Screened::beside(&at_one, at_one.points.as_ref()?, &scene, &[]).gross;
    let mut removed: Vec<usize> = Vec::new();
    gross.retain(|own| {
        let with_own: Vec<usize> = removed.iter().copied().chain(numbers(own)).collect();
        let is_possible = has_poses(points, &with_own);
        if is_possible {
            removed = with_own;
        }
        is_possible
    });
    let kept = Campaign {
        points: Some(without(points, &removed)),
        ..campaign.clone()
    };
    let rejected: Vec<Rejected> = gross.iter().flat_map(Gross::rejected).collect();
    (!rejected.is_empty()).then_some((kept, rejected))
}

fn numbers(gross: &Gross) -> impl Iterator<Item = usize> {
    gross.points.iter().map(|point| point.number)
}

/// Whether every step and side that had three targets has them still.
fn has_poses(points: &Points, removed: &[usize]) -> bool {
    let mut targets: HashMap<_, [BTreeSet<usize>; 2]> = HashMap::new();
    for stop in &points.stops {
        let own = targets.entry((stop.step, stop.direction)).or_default();
        for number in stop.readings.clone() {
            let target = points.readings[number].target;
            own[0].insert(target);
            if !removed.contains(&number) {
                own[1].insert(target);
            }
        }
    }
    let mut all = targets.values();
    all.all(|[before, after]| after.len() >= LEAST_TARGETS.min(before.len()))
}

//! Points that a calibration should leave out: it does not itself compare one point with the others.

use std::collections::{BTreeMap, BTreeSet};

use trueaxis_campaign::{Campaign, Points};
use trueaxis_poses::{MIN_TARGETS, at_one_temperature, scene_of};

use crate::Rejected;
use crate::points::gross_errors::Gross;
use crate::points::screened::{Screened, without};

/// A campaign without the points that contradict all others, and these; `None` without any, or with too many.
///
/// They are the points that [`crate::diagnose`] leaves out if it finds no cause. Where points or stops contradict
/// each other and nothing shows which is wrong, all of them leave. Points of a step stay if the run would otherwise
/// have fewer than three targets at all of its steps.
pub fn without_wrong_points(campaign: &Campaign) -> Option<(Campaign, Vec<Rejected>)> {
    let points = campaign.points.as_ref()?;
    let at_one = at_one_temperature(campaign);
    let scene = scene_of(&at_one);
    let mut gross = Screened::beside(&at_one, at_one.points.as_ref()?, &scene, &[]).gross;
    gross.sort_by_key(|own| own.step);
    let mut removed: Vec<usize> = Vec::new();
    let mut rejected: Vec<Rejected> = Vec::new();
    for of_step in gross.chunk_by(|a, b| a.step == b.step) {
        let own = of_step.iter().flat_map(|own| &own.points);
        let with_own: Vec<usize> = removed
            .iter()
            .copied()
            .chain(own.map(|p| p.number))
            .collect();
        if has_poses(campaign, points, &with_own) {
            removed = with_own;
            rejected.extend(of_step.iter().flat_map(Gross::rejected));
        }
    }
    if rejected.is_empty() {
        return None;
    }
    rejected.sort_by_key(|own| own.row);
    let kept = Campaign {
        points: Some(without(points, &removed)),
        ..campaign.clone()
    };
    Some((kept, rejected))
}

/// Whether every run keeps the targets that it has at all of its steps, from each side, or three of them.
fn has_poses(campaign: &Campaign, points: &Points, removed: &[usize]) -> bool {
    let mut seen: BTreeMap<Place, [BTreeSet<usize>; 2]> = BTreeMap::new();
    for stop in &points.stops {
        let run = campaign.steps[stop.step].run;
        let place = (run, stop.step, stop.direction.sign() > 0);
        let own = seen.entry(place).or_default();
        for number in stop.readings.clone() {
            let target = points.readings[number].target;
            own[0].insert(target);
            if !removed.contains(&number) {
                own[1].insert(target);
            }
        }
    }
    let all: Vec<_> = seen.into_iter().collect();
    let mut runs = all.chunk_by(|(a, _), (b, _)| a.0 == b.0);
    runs.all(|of_run| {
        let [before, after] = [0, 1].map(|k| {
            let sets = of_run.iter().map(|(_, sets)| sets[k].clone());
            sets.reduce(|a, b| &a & &b).map_or(0, |common| common.len())
        });
        after >= MIN_TARGETS.min(before)
    })
}

/// Run, step and whether the step was approached from below.
type Place = (Option<usize>, usize, bool);

//! Points that a calibration should leave out: it does not itself compare one point with the others.

use std::collections::{BTreeMap, BTreeSet};

use trueaxis_campaign::{Campaign, Points};
use trueaxis_poses::{MIN_TARGETS, at_one_temperature, scene_of, step_in_words};

use crate::Rejected;
use crate::points::gross_errors::Gross;
use crate::points::screened::{Screened, without};

/// A campaign without its wrong points.
pub struct WithoutWrongPoints {
    /// The campaign with the points that may be believed, and those that have to stay.
    pub campaign: Campaign,
    /// Points that left, by line.
    pub left_out: Vec<Rejected>,
    /// Points that contradict the others as much, and stay: their run would have too few targets, by line.
    pub kept: Vec<KeptWrongPoint>,
}

/// A wrong point that stays.
pub struct KeptWrongPoint {
    /// The point, and by how much it is off.
    pub wrong: Rejected,
    /// Its step, as `run x at X = 40 mm, Y = 0 mm`.
    pub place: String,
}

impl KeptWrongPoint {
    /// The notice about it.
    pub fn in_words(&self) -> String {
        let (wrong, place) = (&self.wrong, &self.place);
        format!(
            "{} line {}: off by {:.1} µm (u = {:.1} µm): {}; it was kept, since a pose of {place} would have fewer than three \
             targets without it: do not trust the results there until the step is measured again",
            wrong.file, wrong.row, wrong.error_um, wrong.u_um, wrong.reason
        )
    }
}

/// A campaign without the points that contradict all others, and these; `None` if no point does, or too many do.
///
/// They are the points that [`crate::diagnose`] leaves out if it finds no cause. Where points or stops contradict
/// each other and nothing shows which is wrong, all of them leave. Points of a step stay if the run would otherwise
/// have fewer than three targets at all of its steps; `by_direction` says whether each side of a step has a pose of
/// its own.
pub fn without_wrong_points(campaign: &Campaign, by_direction: bool) -> Option<WithoutWrongPoints> {
    let points = campaign.points.as_ref()?;
    let at_one = at_one_temperature(campaign);
    let scene = scene_of(&at_one);
    let mut gross = Screened::beside(&at_one, at_one.points.as_ref()?, &scene, &[]).gross;
    if gross.is_empty() {
        return None;
    }
    gross.sort_by_key(|own| own.step);
    let mut removed: Vec<usize> = Vec::new();
    let mut left_out: Vec<Rejected> = Vec::new();
    let mut kept: Vec<KeptWrongPoint> = Vec::new();
    for of_step in gross.chunk_by(|a, b| a.step == b.step) {
        let own = of_step.iter().flat_map(|own| &own.points);
        let own: Vec<usize> = own.map(|point| point.number).collect();
        let with_own = [&removed[..], &own].concat();
        let wrong = of_step.iter().flat_map(Gross::rejected);
        if has_poses(campaign, points, &with_own, by_direction) {
            removed = with_own;
            left_out.extend(wrong);
        } else {
            let place = step_in_words(campaign, of_step[0].step);
            kept.extend(wrong.map(|wrong| KeptWrongPoint {
                wrong,
                place: place.clone(),
            }));
        }
    }
    left_out.sort_by_key(|own| own.row);
    kept.sort_by_key(|own| own.wrong.row);
    Some(WithoutWrongPoints {
        campaign: Campaign {
            points: Some(without(points, &removed)),
            ..campaign.clone()
        },
        left_out,
        kept,
    })
}

/// Whether every run keeps the targets that it has for all of its poses, or three of them.
fn has_poses(campaign: &Campaign, points: &Points, removed: &[usize], by_direction: bool) -> bool {
    let mut seen: BTreeMap<Place, [BTreeSet<usize>; 2]> = BTreeMap::new();
    for stop in &points.stops {
        let run = campaign.steps[stop.step].run;
        let side = by_direction.then(|| stop.direction.sign() > 0);
        let place = (run, stop.step, side);
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

/// Run, step and, if that has a pose of its own, whether the step was approached from below.
type Place = (Option<usize>, usize, Option<bool>);

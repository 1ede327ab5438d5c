//! The quantities with which the points are tested to vary ([`crate::engine`]).
//!
//! | varies with | columns |
//! | --- | --- |
//! | `time` | twelve half waves of time, for each direction and about each (the frame, or the machine) |
//! | `target` | four half waves of time for each target and direction |
//! | `position` | four half waves of the position of each axis for each target and direction |
//! | `direction` | the side of approach, alone and times two half waves of the position, the same way |

use nalgebra::Vector3;

use crate::engine::{Family, MOST_OF_FREEDOM, Omnibus, waves_of, whitened};
use crate::numbers::extremes;
use crate::points::base::Base;
use crate::points::model::Model;
use crate::points::readings::Reading;

const OF_TIME: usize = 12;
const OF_TARGET: usize = 4;
const OF_POSITION: usize = 4;
const OF_DIRECTION: usize = 2;

/// All families, whitened like the points of a model.
pub(crate) fn families(base: &Base<'_>, model: &Model) -> Vec<Family> {
    let (all, targets) = (&base.readings.all, base.scene.targets.len());
    let sum: Vector3<f64> = all.iter().map(|r| r.measured_mm.coords).sum();
    let centre = sum / all.len().max(1) as f64;
    let arms: Vec<Vector3<f64>> = all.iter().map(|r| r.measured_mm.coords - centre).collect();
    let arm_mm = arms.iter().map(Vector3::norm).fold(1.0, f64::max);
    // Along each direction, and about it.
    let moved = |course: &[f64], motion: usize| -> Vec<f64> {
        let of_point = |(x, arm): (&f64, &Vector3<f64>)| match motion.checked_sub(3) {
            None => Vector3::ith(motion, *x),
            Some(about) => Vector3::ith(about, *x).cross(&(arm / arm_mm)),
        };
        let points = course.iter().zip(&arms).map(of_point).enumerate();
        points
            .flat_map(|(i, v)| <[f64; 3]>::from(base.in_rows(i, v)))
            .collect()
    };
    let family = |varies_with, courses: Vec<Vec<f64>>, motions: usize| {
        let of_course = |course: &Vec<f64>| (0..motions).map(|m| moved(course, m)).collect();
        let columns: Vec<Vec<Vec<f64>>> = courses.iter().map(of_course).collect();
        Family {
            varies_with,
            columns: whitened(base, model, columns.concat()),
        }
    };
    let over_time = |r: &Reading| Some((0, r.progress));
    let of_target = |r: &Reading| Some((r.target, r.progress));
    let travelled = travelled(base);
    let of_axis = |(r, x): (&Reading, &f64)| Some((r.axis? * targets + r.target, *x));
    let of_axes = || all.iter().zip(&travelled).map(of_axis);
    let mut sides = waves_of(of_axes(), true, OF_DIRECTION);
    for column in &mut sides {
        column.iter_mut().zip(all).for_each(|(x, r)| *x *= r.side);
    }
    vec![
        family(
            "time",
            waves_of(all.iter().map(over_time), false, OF_TIME),
            6,
        ),
        family(
            "target",
            waves_of(all.iter().map(of_target), false, OF_TARGET),
            3,
        ),
        family("position", waves_of(of_axes(), false, OF_POSITION), 3),
        family("direction", sides, 3),
    ]
}

/// The tests of what a model leaves.
pub(crate) fn omnibus(model: &Model, families: &[Family]) -> Vec<Omnibus> {
    Omnibus::of_all(&model.projection, families, MOST_OF_FREEDOM)
}

/// Range of the positions at which an axis was measured, mm or rad.
pub(crate) fn range(base: &Base<'_>, axis: usize) -> [f64; 2] {
    let own = base.readings.all.iter().filter(|r| r.axis == Some(axis));
    extremes(own.map(|r| base.campaign.steps[r.step].positions[axis]))
}

/// Position of the axis of each point in that range, 0 to 1.
pub(crate) fn travelled(base: &Base<'_>) -> Vec<f64> {
    let axes = 0..base.scene.machine.axes().len();
    let ranges: Vec<[f64; 2]> = axes.map(|axis| range(base, axis)).collect();
    let part = |r: &Reading| {
        let axis = r.axis?;
        let [low, high] = ranges[axis];
        let position = base.campaign.steps[r.step].positions[axis];
        (high > low).then(|| (position - low) / (high - low))
    };
    let all = base.readings.all.iter();
    all.map(|r| part(r).unwrap_or(0.0)).collect()
}

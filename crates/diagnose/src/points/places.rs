//! The misfit of the points by groups of readings.

use crate::Place;
use crate::engine::{Misfits, side};
use crate::points::base::Base;
use crate::points::readings::Reading;

/// The misfit by target, axis, side and repeat.
pub(crate) fn places(base: &Base<'_>, misfits: &Misfits<'_>) -> Vec<Place> {
    let scene = base.scene;
    let by = |name, group: &dyn Fn(&Reading) -> Option<(usize, String)>| {
        misfits.places(name, base.readings.all.iter().map(group))
    };
    let target = |r: &Reading| (r.target, scene.targets[r.target].name.clone());
    let axis = |axis: usize| (axis, scene.axis_name(axis).to_owned());
    [
        by("target", &|r| Some(target(r))),
        by("axis", &|r| r.axis.map(axis)),
        by("direction", &|r| r.axis.map(|_| side(r.side))),
        by("repeat", &|r| {
            Some((r.repeat as usize, r.repeat.to_string()))
        }),
    ]
    .concat()
}

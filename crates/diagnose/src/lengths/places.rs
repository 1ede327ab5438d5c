//! The misfit of the lengths by groups of readings.

use trueaxis_poses::LengthCircumstances as Reading;

use crate::Place;
use crate::engine::{Misfits, side};
use crate::lengths::base::Base;
use crate::lengths::omnibus::travelled;

/// Number of parts of the travel and of the campaign's time.
const PARTS: usize = 4;

/// The misfit by station, target, axis, direction, repeat, position and time.
pub(crate) fn places(base: &Base<'_>, misfits: &Misfits<'_>) -> Vec<Place> {
    let scene = &base.scene;
    let bounds = (1..PARTS).map(|k| k as f64 / PARTS as f64);
    let quarter = |x: f64| bounds.clone().filter(|bound| x >= *bound).count();
    let first_s = base.readings.first().map_or(0.0, |r| r.time_s);
    let last_s = base.readings.last().map_or(0.0, |r| r.time_s);
    let of_travel = |r: &Reading| {
        let k = quarter(travelled(base, r));
        let axis = scene.axis_name(r.axis);
        let name = format!("{axis}, quarter {} of its travel", k + 1);
        (PARTS * r.axis + k, name)
    };
    let of_time = |r: &Reading| {
        let k = quarter((r.time_s - first_s) / (last_s - first_s));
        let at = |k: usize| first_s + (last_s - first_s) * k as f64 / PARTS as f64;
        (k, format!("{:.0} to {:.0} s", at(k), at(k + 1)))
    };
    let by = |name, group: &dyn Fn(&Reading) -> (usize, String)| {
        let groups = base.readings.iter().map(|r| Some(group(r)));
        misfits.places(name, groups)
    };
    [
        by("station", &|r| {
            (r.station, scene.stations[r.station].clone())
        }),
        by("target", &|r| {
            (r.target, scene.targets[r.target].name.clone())
        }),
        by("axis", &|r| (r.axis, scene.axis_name(r.axis).to_owned())),
        by("direction", &|r| side(r.sign())),
        by("repeat", &|r| (r.repeat as usize, r.repeat.to_string())),
        by("position", &of_travel),
        by("time", &of_time),
    ]
    .concat()
}

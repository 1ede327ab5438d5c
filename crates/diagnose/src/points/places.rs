//! The misfit of the points by groups of readings.

use crate::Place;
use crate::engine::{places as places_by, side};
use crate::points::base::Base;
use crate::points::model::Model;
use crate::points::readings::Reading;

/// The misfit by target, axis, side and repeat.
pub(crate) fn places(base: &Base<'_>, before: &Model, after: &Model, noise_um: f64) -> Vec<Place> {
    let scene = base.scene;
    let rms_um = |rows: &[usize]| {
        [before, after].map(|model| {
            let e = &model.projection.residuals;
            let own = rows.iter().flat_map(|i| &e[3 * i..3 * i + 3]);
            let squares: f64 = own.map(|e| e * e).sum();
            // The share of these rows in the degrees of freedom.
            let share = model.projection.degrees_of_freedom / base.misfit_mm.len() as f64;
            noise_um * (squares / (3.0 * rows.len() as f64 * share)).sqrt()
        })
    };
    let by = |name, group: &dyn Fn(&Reading) -> Option<(usize, String)>| {
        places_by(name, base.readings.all.iter().map(group), &rms_um)
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

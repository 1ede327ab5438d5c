//! Where the misfit lives.

use crate::Place;
use crate::points::base::Base;
use crate::points::model::Model;
use crate::points::readings::Reading;

/// The name of the group that a reading is in; none if in none.
type Group<'a> = Box<dyn Fn(&Reading) -> Option<String> + 'a>;

/// Where the misfit lives: by target, axis, side and repeat.
pub(crate) fn places(base: &Base<'_>, before: &Model, after: &Model, noise_um: f64) -> Vec<Place> {
    let scene = base.scene;
    let of_axis = |r: &Reading| r.axis.map(|axis| scene.axis_name(axis).to_owned());
    let of_side = |r: &Reading| r.axis.map(|_| format!("{:+}", r.side));
    let all: [(&'static str, Group<'_>); 4] = [
        (
            "target",
            Box::new(|r| Some(scene.targets[r.target].name.clone())),
        ),
        ("axis", Box::new(of_axis)),
        ("direction", Box::new(of_side)),
        ("repeat", Box::new(|r| Some(r.repeat.to_string()))),
    ];
    let rows = base.misfit_mm.len() as f64;
    let mut places: Vec<Place> = Vec::new();
    for (by, name) in &all {
        let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
        for (i, reading) in base.readings.all.iter().enumerate() {
            let Some(name) = name(reading) else { continue };
            match groups.iter_mut().find(|(other, _)| *other == name) {
                Some((_, own)) => own.push(i),
                None => groups.push((name, vec![i])),
            }
        }
        let rms = |model: &Model, own: &[usize]| {
            let e = &model.projection.residuals;
            let squares: f64 = own
                .iter()
                .flat_map(|i| &e[3 * i..3 * i + 3])
                .map(|e| e * e)
                .sum();
            // Their share of the degrees of freedom.
            let share = model.projection.degrees_of_freedom / rows;
            noise_um * (squares / (3.0 * own.len() as f64 * share)).sqrt()
        };
        if groups.len() > 1 {
            places.extend(groups.into_iter().map(|(name, own)| Place {
                by,
                name,
                readings: own.len(),
                before_um: rms(before, &own),
                after_um: rms(after, &own),
            }));
        }
    }
    places
}

//! Effects that these points cannot show. They may be there all the same.

use crate::NotObservable;
use trueaxis_effects::Level;

use crate::engine::{of_catalogue, scans};
use crate::lengths::in_words;
use crate::points::base::Base;
use crate::points::model::Model;

/// Effects without a trace in these points.
pub(crate) fn not_observable(base: &Base<'_>, model: &Model) -> Vec<NotObservable> {
    let all = of_catalogue(Level::Points, base.scene, |_| true);
    let unseen = scans(base, model, &model.bare, &all).without_trace;
    let mut list: Vec<NotObservable> = Vec::new();
    for hypothesis in unseen {
        let effect = hypothesis.effect;
        let name = match in_words(&hypothesis.subject, base.scene) {
            name if name.is_empty() => "all alike".to_owned(),
            name => name,
        };
        if let Some(same) = list.iter_mut().find(|other| other.effect == effect.id) {
            same.subject += &format!(", {name}");
            continue;
        }
        list.push(NotObservable {
            effect: effect.id,
            subject: name,
            reason: match effect.id {
                "backlash" => "all its stops are approached from one side",
                "timestamp_offset" => {
                    "the machine stands still at the stops, or all are approached from one side"
                }
                _ => "poses and shapes of the targets absorb all of it",
            }
            .to_owned(),
            bias_per_unit: vec![(
                "calibration".to_owned(),
                effect.explanation.consequence.to_owned(),
            )],
            measure: match effect.id {
                "backlash" => "measure the axis from both sides",
                _ => effect.explanation.separate_by,
            }
            .to_owned(),
        });
    }
    let scale = trueaxis_effects::effect("length_scale");
    list.extend(scale.map(|effect| NotObservable {
        effect: effect.id,
        subject: String::new(),
        reason: "poses and shapes of the targets stretch with the coordinates".to_owned(),
        bias_per_unit: vec![("calibration".to_owned(), "1 um per m per ppm".to_owned())],
        measure: effect.explanation.separate_by.to_owned(),
    }));
    list
}

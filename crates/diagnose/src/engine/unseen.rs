//! Effects that data cannot show. They may still be there.

use trueaxis_campaign::Campaign;
use trueaxis_effects::{Effect, Level, Scene, Subject};
use trueaxis_selection::Hypothesis;

use crate::NotObservable;
use crate::engine::{is_tested, of_catalogue};

/// An effect that the data cannot show, with the effect of a unit of it on results; the measurement to make is the one
/// that distinguishes it from its rivals.
pub(crate) fn unseen<S: Into<String>>(
    effect: &Effect,
    subject: String,
    reason: impl Into<String>,
    bias_per_unit: impl IntoIterator<Item = (S, S)>,
) -> NotObservable {
    let bias = bias_per_unit.into_iter();
    NotObservable {
        effect: effect.id,
        subject,
        reason: reason.into(),
        bias_per_unit: bias.map(|(of, by)| (of.into(), by.into())).collect(),
        measure: effect.explanation.separate_by.to_owned(),
    }
}

/// Hypotheses without a trace in the data, effect after effect, each with its reason.
pub(crate) fn without_trace(
    scene: &Scene,
    hypotheses: &[Hypothesis],
    reason: impl Fn(&Effect) -> &'static str,
) -> Vec<NotObservable> {
    let alike = hypotheses.chunk_by(|a, b| a.effect == b.effect);
    let of_effect = |own: &[Hypothesis]| {
        let effect = own[0].effect;
        let names = own.iter().map(|h| match in_words(&h.subject, scene) {
            name if name.is_empty() => "all alike".to_owned(),
            name => name,
        });
        let names: Vec<String> = names.collect();
        let bias = [("calibration", effect.explanation.consequence)];
        let unseen = unseen(effect, names.join(", "), reason(effect), bias);
        match effect.is_lost_motion() {
            true => NotObservable {
                measure: "measure the axis from both sides".to_owned(),
                ..unseen
            },
            false => unseen,
        }
    };
    alike.map(of_effect).collect()
}

/// Effects whose law the steps of a campaign do not test.
pub(crate) fn untested(level: Level, campaign: &Campaign, scene: &Scene) -> Vec<NotObservable> {
    let all = of_catalogue(level, scene, |subject| !is_tested(campaign, subject));
    let why = "its axis stood at two positions only, which agree with any law";
    let unseen = without_trace(scene, &all, |_| why).into_iter();
    let said = unseen.map(|unseen| NotObservable {
        measure: "measure at three positions of the axis or more".to_owned(),
        ..unseen
    });
    said.collect()
}

/// The name of a subject, such as `station S2` or `axis X, target P`.
pub(crate) fn in_words(subject: &Subject, scene: &Scene) -> String {
    let axis = |axis: usize| scene.axis_name(axis);
    let component = subject.component.zip(subject.axis);
    let parts = [
        subject
            .station
            .map(|k| format!("station {}", scene.stations[k])),
        subject.axis.map(|k| format!("axis {}", axis(k))),
        subject.other_axis.map(|k| format!("by axis {}", axis(k))),
        subject
            .target
            .map(|k| format!("target {}", scene.targets[k].name)),
        subject.carrier.map(|k| format!("what {} carries", axis(k))),
        subject
            .column
            .map(|k| format!("with {}", scene.temperatures[k].column)),
        component.map(|(component, k)| component.name(axis(k))),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    parts.join(", ")
}

//! Effects that these lengths cannot show.

use trueaxis_effects::{Level, Medium, Scene, Subject, catalogue};
use trueaxis_kinematics::AxisKind;

use crate::NotObservable;
use crate::selection::Hypothesis;

/// What no data of this kind show, and what these data have no trace of.
pub(crate) fn not_observable(
    scene: &Scene,
    without_trace: &[Hypothesis],
    both_sides: bool,
) -> Vec<NotObservable> {
    let mut list = vec![length_scale(scene), dead_path_offset()];
    for effect in catalogue() {
        let missing: Vec<&Hypothesis> = without_trace
            .iter()
            .filter(|h| h.effect.id == effect.id)
            .collect();
        if missing.is_empty() {
            continue;
        }
        let names: Vec<String> = missing
            .iter()
            .map(|h| in_words(&h.subject, scene))
            .map(|words| {
                if words.is_empty() {
                    "all alike".to_owned()
                } else {
                    words
                }
            })
            .collect();
        let explanation = effect.explanation;
        list.push(NotObservable {
            effect: effect.id,
            subject: names.join(", "),
            reason: match effect.id {
                "backlash" => "all its stops are approached from one side".to_owned(),
                "thermal_growth" => "the logged temperature hardly changes".to_owned(),
                "timestamp_offset" => "the machine stands still at the stops".to_owned(),
                _ => "stations, poses and shapes of the targets absorb all of it".to_owned(),
            },
            bias_per_unit: vec![("calibration".to_owned(), explanation.consequence.to_owned())],
            measure: match effect.id {
                "backlash" => "measure the axis from both sides".to_owned(),
                _ => explanation.separate_by.to_owned(),
            },
        });
    }
    list.extend(thermal_growth(scene));
    let mut absorbed = absorbed_by_poses(scene);
    // Poses are common to both sides of approach: what differs between them does contradict.
    absorbed.retain(|entry| !both_sides || entry.effect != "position_dependent_backlash");
    list.extend(absorbed);
    list
}

fn length_scale(scene: &Scene) -> NotObservable {
    let linear = scene.moving_axes(AxisKind::Linear);
    let bias = linear.map(|axis| {
        let content = &scene.machine.axes()[axis];
        let letter = ['X', 'Y', 'Z'][content.principal()];
        (
            format!("E{letter}{}", content.name()),
            "1 um per m per ppm".to_owned(),
        )
    });
    let explanation = trueaxis_effects::effect("length_scale").map(|e| e.explanation);
    NotObservable {
        effect: "length_scale",
        subject: String::new(),
        reason: "stations and points stretch with the lengths, so that all of them still fit"
            .to_owned(),
        bias_per_unit: bias.collect(),
        measure: explanation.map_or(String::new(), |e| e.separate_by.to_owned()),
    }
}

/// Without a logged temperature nothing can be found to go with one.
fn thermal_growth(scene: &Scene) -> Option<NotObservable> {
    let is_logged = |medium: Medium| scene.temperatures.iter().any(|t| t.medium == medium);
    let effect =
        trueaxis_effects::effect("thermal_growth").filter(|_| !is_logged(Medium::Machine))?;
    Some(NotObservable {
        effect: effect.id,
        subject: String::new(),
        reason: "no temperature of the machine is logged with the lengths: what grows with one is seen as a drift in \
                 time, if at all"
            .to_owned(),
        bias_per_unit: vec![(
            "calibration".to_owned(),
            effect.explanation.consequence.to_owned(),
        )],
        measure: "log temperatures of the machine with the lengths (columns machine_temp_<name>_c)".to_owned(),
    })
}

fn dead_path_offset() -> NotObservable {
    NotObservable {
        effect: "dead_path_offset",
        subject: String::new(),
        reason: "the dead path of each station is unknown and takes it up".to_owned(),
        bias_per_unit: vec![(
            "dead path".to_owned(),
            "1 um per um; no error of the machine".to_owned(),
        )],
        measure: "not needed: it does no harm".to_owned(),
    }
}

/// Errors that belong to the pose of a step: every station sees the same pose, whatever it is. Those that
/// have a curve of their own are looked for in the calibrated curves.
fn absorbed_by_poses(scene: &Scene) -> Vec<NotObservable> {
    let of_machine = catalogue().iter().filter(|effect| {
        let levels = effect.levels;
        let elsewhere = levels.contains(&Level::Lengths) || levels.contains(&Level::Components);
        !levels.is_empty() && !elsewhere
    });
    of_machine
        .filter(|effect| !effect.subjects(scene).is_empty())
        .map(|effect| NotObservable {
            effect: effect.id,
            subject: String::new(),
            reason: "the pose of every step is free in the adjustment, so it is in the calibrated \
                     curves and does not contradict the lengths; verification readings can show it"
                .to_owned(),
            bias_per_unit: vec![(
                "component errors".to_owned(),
                "1 um per um, as part of the curve".to_owned(),
            )],
            measure: effect.explanation.separate_by.to_owned(),
        })
        .collect()
}

/// A subject in words, as `station S2` or `axis X, target P`.
pub(crate) fn in_words(subject: &Subject, scene: &Scene) -> String {
    let mut parts = Vec::new();
    if let Some(station) = subject.station {
        parts.push(format!("station {}", scene.stations[station]));
    }
    if let Some(axis) = subject.axis {
        parts.push(format!("axis {}", scene.axis_name(axis)));
    }
    if let Some(other) = subject.other_axis {
        parts.push(format!("by axis {}", scene.axis_name(other)));
    }
    if let Some(target) = subject.target {
        parts.push(format!("target {}", scene.targets[target].name));
    }
    if let Some(carrier) = subject.carrier {
        parts.push(format!("what {} carries", scene.axis_name(carrier)));
    }
    if let Some(column) = subject.column {
        parts.push(format!("with {}", scene.temperatures[column].column));
    }
    if let (Some(component), Some(axis)) = (subject.component, subject.axis) {
        parts.push(component.name(scene.axis_name(axis)));
    }
    parts.join(", ")
}

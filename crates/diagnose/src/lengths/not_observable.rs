//! Effects that these lengths cannot show.

use trueaxis_effects::{Effect, Level, Medium, Scene, Shape, catalogue, effect};
use trueaxis_kinematics::AxisKind;
use trueaxis_selection::Hypothesis;

use crate::NotObservable;
use crate::engine::{unseen, without_trace};

/// An effect that is an unknown of the adjustment.
const REFLECTOR_OFFSET: &str = "reflector_offset";

/// Effects that no data of this kind show, and effects without a trace in these data.
pub(crate) fn not_observable(scene: &Scene, unseen_here: &[Hypothesis]) -> Vec<NotObservable> {
    let linear = scene.moving_axes(AxisKind::Linear);
    let of_scale = linear.map(|axis| {
        let content = &scene.machine.axes()[axis];
        let letter = ['X', 'Y', 'Z'][content.principal()];
        let name = format!("E{letter}{}", content.name());
        (name, "1 um per m per ppm".to_owned())
    });
    let why = "stations and points stretch with the lengths, so that all of them still fit";
    let scale = effect("length_scale").map(|scale| unseen(scale, String::new(), why, of_scale));
    let mut list = Vec::from_iter(scale);
    list.extend(effect("dead_path_offset").map(|effect| NotObservable {
        measure: "not needed: it does no harm".to_owned(),
        ..unseen(
            effect,
            String::new(),
            "the dead path of each station is unknown and takes it up",
            [("dead path", "1 um per um; no error of the machine")],
        )
    }));
    list.extend(without_trace(scene, unseen_here, |effect| match effect.shape {
        Shape::Lag => "the logged temperature hardly changes",
        _ if effect.is_lost_motion() => "all its stops are approached from one side",
        _ if effect.is_delay() => "the machine stands still at the stops",
        _ if effect.id == REFLECTOR_OFFSET => {
            "the constant of its reflector is an unknown of the adjustment: `reflectors` of calibration.json has it"
        }
        _ => "stations, poses and shapes of the targets absorb all of it",
    }));
    for entry in list.iter_mut().filter(|e| e.effect == REFLECTOR_OFFSET) {
        let bias = "1 um per um; nothing else";
        entry.bias_per_unit = vec![("constant".to_owned(), bias.to_owned())];
        entry.measure = "not needed: it is estimated".to_owned();
    }
    list.extend(thermal_growth(scene));
    list.extend(absorbed_by_poses(scene));
    list
}

/// Without a logged temperature no effect can depend on one.
fn thermal_growth(scene: &Scene) -> Option<NotObservable> {
    let is_logged = |medium: Medium| scene.temperatures.iter().any(|t| t.medium == medium);
    let effect = effect("thermal_growth").filter(|_| !is_logged(Medium::Machine))?;
    let why = "no temperature of the machine is logged with the lengths: what grows with one is seen as a drift in \
               time, if at all";
    let bias = [("calibration", effect.explanation.consequence)];
    Some(NotObservable {
        measure: "log temperatures of the machine with the lengths (columns machine_temp_<name>_c)"
            .to_owned(),
        ..unseen(effect, String::new(), why, bias)
    })
}

/// Errors that belong to the pose of a step: all stations see the same pose, whatever it is. Errors with a curve of
/// their own are sought in the calibrated curves.
fn absorbed_by_poses(scene: &Scene) -> Vec<NotObservable> {
    let is_of_pose = |effect: &&&Effect| {
        let levels = effect.levels;
        let elsewhere = levels.contains(&Level::Lengths) || levels.contains(&Level::Components);
        !levels.is_empty() && !elsewhere && !effect.subjects(scene).is_empty()
    };
    let why = "the pose of every step is free in the adjustment, so it is in the calibrated curves and does not \
               contradict the lengths; verification readings can show it";
    let bias = [("component errors", "1 um per um, as part of the curve")];
    let all = catalogue().iter().filter(is_of_pose);
    all.map(|effect| unseen(effect, String::new(), why, bias))
        .collect()
}

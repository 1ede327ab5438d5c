//! What holds for every effect of the catalogue, those to come included.

use std::collections::BTreeSet;

use trueaxis_effects::{Displaced, Effect, Shape, catalogue, effect, shape_parameter};
use trueaxis_kinematics::Component;

use crate::scene::{every_effect, for_each_reading, scene};

/// Files name effects by these: none changes.
const IDS: &[&str] = &[
    "dead_path_drift",
    "dead_path_jump",
    "refraction_drift",
    "station_drift",
    "station_settling",
    "reflector_offset",
    "thermal_growth",
    "station_scale",
    "station_jump",
    "target_slip",
    "target_creep",
    "fixture_expansion",
    "machine_drift",
    "warm_up",
    "machine_shift",
    "axis_expansion",
    "backlash",
    "position_dependent_backlash",
    "stage_bending",
    "cross_coupling",
    "cyclic_error",
    "scale_error",
    "guideway_bow",
    "encoder_eccentricity",
    "encoder_ellipticity",
    "worm_gear",
    "axis_wobble",
    "axis_runout",
    "length_scale",
    "dead_path_offset",
    "timestamp_offset",
    "squareness_error",
    "instrument_drift",
    "instrument_jump",
];

#[test]
fn ids_are_the_fixed_ones_and_unique() {
    let ids: BTreeSet<&str> = catalogue().iter().map(|effect| effect.id).collect();
    assert_eq!(ids.len(), catalogue().len());
    for id in ids {
        assert!(IDS.contains(&id), "{id} is not a fixed id");
        assert_eq!(effect(id).map(|effect| effect.id), Some(id));
    }
    assert!(effect("Machine_shift").is_none());
}

#[test]
fn instrument_and_set_up_come_before_the_machine() {
    assert!(catalogue().is_sorted_by_key(|effect| effect.layer));
}

/// All three components and the length, as one row.
fn row(by: &Displaced) -> Vec<f64> {
    let parts = by.point_mm.iter().chain(&by.station_mm);
    parts.copied().chain([by.length_mm]).collect()
}

/// Every parameter has a form of its own that is finite everywhere and not zero everywhere.
#[test]
fn each_parameter_has_a_form() {
    let scene = scene();
    for given in every_effect(&scene) {
        let what = (given.effect.id, given.subject);
        let parameters = given.effect.parameters(&scene, &given.subject);
        assert!(!parameters.is_empty(), "{what:?}");
        let mut forms = vec![Vec::new(); parameters.len()];
        for_each_reading(&scene, |at| {
            for (k, form) in forms.iter_mut().enumerate() {
                let unit = given.effect.form(&given.subject, k, given.shape, at);
                form.extend(row(&unit));
            }
        });
        for (k, form) in forms.iter().enumerate() {
            assert!(form.iter().all(|d| d.is_finite()), "{what:?} {k}");
            assert!(form.iter().any(|d| d.abs() > 0.0), "{what:?} {k} is zero");
            assert!(!forms[..k].contains(form), "{what:?} {k} is there twice");
        }
    }
}

/// What a file says about a parameter identifies it, beside its shape.
#[test]
fn names_of_parameters_are_unique_and_have_units() {
    let scene = scene();
    for given in every_effect(&scene) {
        let mut parameters = given.effect.parameters(&scene, &given.subject);
        parameters.extend(shape_parameter(given.effect, &scene, &given.subject));
        let names: BTreeSet<&str> = parameters.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names.len(), parameters.len(), "{}", given.effect.id);
        assert!(parameters.iter().all(|p| !p.unit.is_empty()));
    }
}

/// Forms add up, and an effect of no size does nothing.
#[test]
fn displacements_are_linear() {
    let scene = scene();
    for given in every_effect(&scene) {
        let doubled: Vec<f64> = given.parameters.iter().map(|value| 2.0 * value).collect();
        let zero = vec![0.0; given.parameters.len()];
        for_each_reading(&scene, |at| {
            let scaled = |values: &[f64]| {
                let effect = given.effect;
                row(&effect.displacement(&given.subject, values, given.shape, at))
            };
            let once = row(&given.displaced(at));
            // Doubling is exact in f64.
            let twice: Vec<f64> = once.iter().map(|d| 2.0 * d).collect();
            assert_eq!(scaled(&doubled), twice, "{}", given.effect.id);
            assert_eq!(scaled(&zero), [0.0; 7], "{}", given.effect.id);
        });
    }
}

/// Another station or target than that of the subject sees nothing of an effect, nor does anything up to
/// its instant.
#[test]
fn effects_stay_with_their_subject_and_instant() {
    let scene = scene();
    for given in every_effect(&scene) {
        let subject = given.subject;
        for_each_reading(&scene, |at| {
            let early = given.effect.shape == Shape::Instant && at.time_s <= given.shape;
            let elsewhere = !subject.has_station(at.station)
                || !subject.has_target(at.target)
                || subject.carrier.is_some_and(|axis| !at.is_carried_by(axis));
            if early || elsewhere {
                assert_eq!(given.displaced(at), Displaced::default(), "{given:?}");
            }
        });
    }
}

#[test]
fn what_effects_have_in_common() {
    let all = |is_wanted: fn(&Effect) -> bool| -> Vec<&str> {
        let wanted = catalogue().iter().filter(|effect| is_wanted(effect));
        wanted.map(|effect| effect.id).collect()
    };
    let scales = ["refraction_drift", "station_scale", "length_scale"];
    assert_eq!(all(Effect::scales_lengths), scales);
    let lost_motion = ["backlash", "position_dependent_backlash"];
    assert_eq!(all(Effect::is_lost_motion), lost_motion);
    assert_eq!(all(Effect::is_delay), ["timestamp_offset"]);
    assert_eq!(all(Effect::grows_axis), ["axis_expansion"]);
    assert_eq!(all(Effect::is_scale_of_axis), ["scale_error"]);
    let machine = ["machine_drift", "warm_up", "machine_shift"];
    assert_eq!(all(Effect::moves_machine), machine);
    let station = ["station_drift", "station_settling", "station_jump"];
    assert_eq!(all(Effect::moves_station), station);
}

/// Each curve of a linear and of a rotary axis shows those effects by itself that change nothing else.
#[test]
fn what_a_curve_tells() {
    let scene = scene();
    let told = |axis: usize, component: Component| -> Vec<&str> {
        let axis = &scene.machine.axes()[axis];
        let own = catalogue()
            .iter()
            .filter(|e| e.is_of_curve(axis, component));
        own.map(|effect| effect.id).collect()
    };
    let [y, c] = [1, 4];
    assert_eq!(told(y, Component::Y), ["scale_error", "cyclic_error"]);
    for other in [Component::X, Component::Z, Component::A, Component::B] {
        assert_eq!(told(y, other), ["cyclic_error"]);
    }
    let about = ["encoder_eccentricity", "encoder_ellipticity", "worm_gear"];
    assert_eq!(told(c, Component::C), about);
    assert_eq!(told(c, Component::Z), ["cyclic_error"]);
    assert_eq!(told(c, Component::X), ["axis_runout"]);
    assert_eq!(told(c, Component::B), ["axis_wobble"]);
    let waves = |id: &str| effect(id).and_then(|effect| effect.waves(5.0));
    let waves = about.map(waves);
    assert_eq!(waves, [1.0, 2.0, 5.0].map(Some));
}

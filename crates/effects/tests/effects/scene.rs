//! A five-axis machine with two stations and two targets, and readings all over it.

use nalgebra::{Point3, Vector3};
use trueaxis_effects::{Circumstances, Effect, ResolvedEffect, Scene, SceneTarget, Shape, Subject};
use trueaxis_effects::{Medium, SceneTemperature, TemperatureHistory};
use trueaxis_kinematics::{Axis, AxisKind, Ideal, Machine};

/// X Y Z carry the tool with the target P, A C the workpiece with V.
pub(crate) fn scene() -> Scene {
    let linear = |name, direction| Axis::linear(name, direction, [0.0, 400.0]).unwrap();
    let rotary = |name, direction, point| {
        Axis::rotary(name, direction, [-3.0, 3.0], Point3::from(point)).unwrap()
    };
    let axes = vec![
        linear("X", Vector3::x()),
        linear("Y", Vector3::y()),
        linear("Z", Vector3::z()),
        rotary("A", Vector3::x(), [0.0, 200.0, 40.0]),
        rotary("C", Vector3::z(), [200.0, 200.0, 0.0]),
    ];
    let target = |name: &str, carrier| SceneTarget {
        name: name.to_owned(),
        carrier: Some(carrier),
    };
    let temperature = |column: &str, medium| SceneTemperature {
        column: column.to_owned(),
        medium,
    };
    Scene {
        machine: Machine::new(axes, vec![0, 1, 2], vec![3, 4]).unwrap(),
        stations: vec!["S1".to_owned(), "S2".to_owned()],
        targets: vec![target("P", 2), target("V", 4)],
        moving: vec![0, 1, 2, 3, 4],
        temperatures: vec![
            temperature("machine_temp_spindle_c", Medium::Machine),
            temperature("air_temp_c", Medium::Air),
        ],
    }
}

const HOME_MM: [[f64; 3]; 2] = [[22.0, 61.5, 402.0], [311.7, 158.4, 112.9]];
const STATIONS_MM: [[f64; 3]; 2] = [[-720.0, -380.0, 310.0], [1240.0, -520.0, 480.0]];

/// Calls `see` with readings of every target from every station after motions of every axis that
/// carries it, both ways.
pub(crate) fn for_each_reading(scene: &Scene, mut see: impl FnMut(&Circumstances<'_>)) {
    let machine = &scene.machine;
    let visits = [0.13, 0.37, 0.71, 0.93];
    let temperatures = [[20.0, 21.5, 23.0], [22.0, 21.0, 23.5]]
        .map(|values| TemperatureHistory::new(0.0, 4000.0, values.into()));
    for (visit, part) in (0_u8..).zip(visits) {
        let positions: Vec<f64> = machine
            .axes()
            .iter()
            .enumerate()
            .map(|(axis, content)| {
                // Incommensurable, so that nothing periodic vanishes at all of them.
                let part = (part + 0.618 * axis as f64).fract();
                let [low, high] = content.travel();
                low + part * (high - low)
            })
            .collect();
        for (station, station_mm) in STATIONS_MM.iter().enumerate() {
            for (target, content) in scene.targets.iter().enumerate() {
                let home = Point3::from(HOME_MM[target]);
                let point_mm = machine.position(&Ideal, content.carrier, &positions, home);
                for &axis in machine.chain(content.carrier) {
                    for direction in [1.0, -1.0] {
                        see(&Circumstances {
                            time_s: 100.0 + 2000.0 * f64::from(visit),
                            elapsed_s: 50.0 + 2000.0 * f64::from(visit),
                            progress: part,
                            occupation_progress: (3.0 * part).fract(),
                            occupation_elapsed_s: 800.0 * (3.0 * part).fract(),
                            station,
                            target,
                            carrier: content.carrier,
                            axis,
                            direction,
                            speed_per_s: 0.5 * direction,
                            positions: &positions,
                            point_mm,
                            centroid_mm: point_mm + Vector3::new(40.0, -70.0, 90.0),
                            temperatures: &temperatures,
                            distance_mm: (point_mm - Point3::from(*station_mm)).norm(),
                            ..Circumstances::new(machine)
                        });
                    }
                }
            }
        }
    }
}

/// A shape that an effect may have, in the units of its form.
pub(crate) fn some_shape(effect: &Effect, scene: &Scene, subject: &Subject) -> f64 {
    let axis = subject.axis.map(|axis| scene.machine.axes()[axis].kind());
    match (effect.shape, axis) {
        (Shape::Fixed, _) => 0.0,
        (Shape::Instant, _) => 1500.25,
        (Shape::TimeConstant | Shape::SettlingTime | Shape::Lag, _) => 1800.5,
        (Shape::Period, Some(AxisKind::Rotary)) => 0.7,
        (Shape::Period, _) => 43.1,
        (Shape::Waves(_), _) => 5.0,
    }
}

/// Every effect of the catalogue on every subject, with values that are all different.
pub(crate) fn every_effect(scene: &Scene) -> Vec<ResolvedEffect> {
    let mut all = Vec::new();
    for &effect in trueaxis_effects::catalogue() {
        for subject in effect.subjects(scene) {
            let count = effect.parameters(scene, &subject).len();
            let numbers = std::iter::successors(Some(1.0 / 3.0), |value| Some(value * -1.7));
            all.push(ResolvedEffect {
                effect,
                subject,
                parameters: numbers.take(count).collect(),
                shape: some_shape(effect, scene, &subject),
            });
        }
    }
    all
}

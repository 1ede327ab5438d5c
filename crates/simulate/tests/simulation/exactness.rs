//! Lengths against a second computation, written with plain arrays from the published formulas
//! and from the JSON text: nothing of it is shared with the crate or with nalgebra.

use serde_json::{Value, json};
use trueaxis_campaign::Direction;
use trueaxis_simulate::simulate;

use crate::shipped;

/// Lengths are about 1500 mm, where f64 resolves 2e-13 mm.
const LENGTH_TOL_MM: f64 = 1e-10;

#[test]
fn five_axis_lengths_agree_with_plain_rotation_matrices() {
    let mut json = shipped::json("five-axis");
    shipped::make_exact(&mut json);
    json["gauge"] = json!("none");
    // Every axis away from home, so that errors of all axes of a chain act at once.
    let parked = [
        json!({ "Y": 210, "Z": 85, "A": -30, "C": 75 }),
        json!({ "X": 330, "Z": 140 }),
        json!({ "X": 45, "Y": 390 }),
        json!({ "C": 222 }),
        json!({ "A": 35 }),
    ];
    for (run, parked) in parked.into_iter().enumerate() {
        json["runs"][run]["parked"] = parked;
    }

    let campaign = simulate(&shipped::scenario(&json), 1).unwrap().campaign;
    let lengths = campaign.lengths.clone().unwrap();
    let axes = campaign.machine.axes();
    for stop in &lengths.stops {
        let step = &campaign.steps[stop.step];
        let moving = axes[campaign.axis_under_test(stop.step).unwrap()].name();
        let side = match stop.direction {
            Direction::Forward => -0.5,
            Direction::Backward => 0.5,
        };
        let commanded = |name: &str| step.positions[campaign.machine.axis_index(name).unwrap()];
        let station = &json["stations"][stop.station];
        for reading in &lengths.readings[stop.readings.clone()] {
            let target = &json["targets"][reading.target];
            let chain: &[&str] = match target["carried_by"].as_str().unwrap() {
                "Z" => &["X", "Y", "Z"],
                _ => &["A", "C"],
            };
            let home = add(
                vector(&target["position_mm"]),
                vector(&target["mounting_error_mm"]),
            );
            let p = chain.iter().rev().fold(home, |p, name| {
                let side = if *name == moving { side } else { 0.0 };
                stage_motion(&json, name, commanded(name), side, p)
            });
            let line = sub(p, vector(&station["position_mm"]));
            let expected = dot(line, line).sqrt() - station["dead_path_mm"].as_f64().unwrap();
            let off_mm = reading.length_mm - expected;
            assert!(
                off_mm.abs() < LENGTH_TOL_MM,
                "line {}: {off_mm} mm",
                reading.line
            );
        }
    }
    assert_eq!(lengths.readings.len(), 2736);
}

/// Forward arrival is late, backward arrival is early: by half the lost motion, in µm.
#[test]
fn lost_motion_holds_the_stage_back_on_arrival() {
    let json = json!({
        "format": "trueaxis-scenario", "version": 1, "name": "slide",
        "machine": {
            "name": "slide", "kinematics": { "tool": ["X"] },
            "axes": [ { "name": "X", "kind": "linear", "direction": [1, 0, 0], "travel": [0, 100] } ]
        },
        "targets": [ { "name": "P", "position_mm": [0, 0, 0], "carried_by": "X" } ],
        "stations": [ { "name": "S", "position_mm": [1000, 0, 0], "dead_path_mm": 1000 } ],
        "errors": { "X": { "lost_motion_um": 4.0 } },
        "runs": [ { "name": "x", "axis": "X", "positions": [0, 100], "directions": [1, -1] } ]
    });
    let campaign = simulate(&shipped::scenario(&json), 1).unwrap().campaign;
    let readings = campaign.lengths.unwrap().readings;
    let lengths_mm: Vec<f64> = readings.iter().map(|r| r.length_mm).collect();
    assert_eq!(lengths_mm, [0.002, -99.998, -100.002, -0.002]);
}

pub(crate) type Vector = [f64; 3];
type Matrix = [Vector; 3];

/// `linear p = q d' + δ + E h`, `rotary p = c' + δ + E R(d', q) (h - c' + l)`.
pub(crate) fn stage_motion(json: &Value, name: &str, q: f64, side: f64, h: Vector) -> Vector {
    let axes = json["machine"]["axes"].as_array().unwrap();
    let axis = axes.iter().find(|axis| axis["name"] == name).unwrap();
    let errors = &json["errors"][name];
    let direction = vector(&axis["direction"]);
    let rotary = axis["kind"] == "rotary";
    let q_in_file = if rotary {
        q * 180.0 / std::f64::consts::PI
    } else {
        q
    };

    let component = |letter: &str| {
        curve(
            &errors["components"][format!("E{letter}{name}")],
            axis,
            q_in_file,
        )
    };
    let mut delta = ["X", "Y", "Z"].map(|letter| component(letter) * 1e-3);
    let mut epsilon = ["A", "B", "C"].map(|letter| component(letter) * ARCSEC);
    if let Some(b) = errors["lost_motion_um"].as_f64() {
        delta = add(delta, scale(direction, side * b * 1e-3));
    }
    if let Some(b) = errors["lost_motion_arcsec"].as_f64() {
        epsilon = add(epsilon, scale(direction, side * b * ARCSEC));
    }

    let location = |letter: &str, unit: &str| {
        let value = &errors["location_errors"][format!("{letter}0{name}")][unit];
        value.as_f64().unwrap_or(0.0)
    };
    let tilt = ["A", "B", "C"].map(|letter| location(letter, "value_arcsec") * ARCSEC);
    let average_direction = apply(rotation(tilt), direction);
    if !rotary {
        let moved = add(scale(average_direction, q), delta);
        return add(moved, apply(rotation(epsilon), h));
    }
    let offset = ["X", "Y", "Z"].map(|letter| location(letter, "value_mm"));
    let centre = add(vector(&axis["position_mm"]), offset);
    let axial = scale(direction, dot(direction, offset));
    let r = add(sub(h, centre), axial);
    let turned = apply(rotation(scale(average_direction, q)), r);
    add(add(centre, delta), apply(rotation(epsilon), turned))
}

pub(crate) const ARCSEC: f64 = std::f64::consts::PI / 180.0 / 3600.0;

/// The sum of the terms, in their unit.
fn curve(terms: &Value, axis: &Value, q: f64) -> f64 {
    let number = |value: &Value| value.as_f64().unwrap();
    let numbers =
        |value: &Value| -> Vec<f64> { value.as_array().unwrap().iter().map(number).collect() };
    let mut sum = 0.0;
    for term in terms.as_array().into_iter().flatten() {
        sum += match term["kind"].as_str().unwrap() {
            "polynomial" => {
                let travel = numbers(&axis["travel"]);
                let s = (q - (travel[0] + travel[1]) / 2.0) / ((travel[1] - travel[0]) / 2.0);
                let powers = (0..).map(|power| s.powi(power));
                let terms = numbers(&term["coefficients"]).into_iter().zip(powers);
                terms.map(|(c, power)| c * power).sum::<f64>()
            }
            "sine" => {
                let period = term["period_mm"].as_f64().or(term["period_deg"].as_f64());
                let degrees = 360.0 * q / period.unwrap() + number(&term["phase_deg"]);
                number(&term["amplitude"]) * (degrees * std::f64::consts::PI / 180.0).sin()
            }
            "table" => {
                let (at, values) = (numbers(&term["positions"]), numbers(&term["values"]));
                let k = (1..at.len() - 1).take_while(|&k| at[k] < q).count();
                let weight = (q - at[k]) / (at[k + 1] - at[k]);
                values[k] * (1.0 - weight) + values[k + 1] * weight
            }
            kind => panic!("no formula for {kind}"),
        };
    }
    sum
}

/// Rodrigues: `I + sin θ K + (1 - cos θ) K²` for the unit axis of the rotation vector.
fn rotation(v: Vector) -> Matrix {
    let angle = dot(v, v).sqrt();
    let [x, y, z] = if angle > 0.0 {
        scale(v, 1.0 / angle)
    } else {
        [0.0; 3]
    };
    let (s, c) = angle.sin_cos();
    let t = 1.0 - c;
    [
        [c + t * x * x, t * x * y - s * z, t * x * z + s * y],
        [t * x * y + s * z, c + t * y * y, t * y * z - s * x],
        [t * x * z - s * y, t * y * z + s * x, c + t * z * z],
    ]
}

fn apply(m: Matrix, v: Vector) -> Vector {
    m.map(|row| dot(row, v))
}

pub(crate) fn vector(value: &Value) -> Vector {
    [0, 1, 2].map(|i| value[i].as_f64().unwrap())
}

pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    add(a, scale(b, -1.0))
}

pub(crate) fn scale(v: Vector, factor: f64) -> Vector {
    v.map(|c| c * factor)
}

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

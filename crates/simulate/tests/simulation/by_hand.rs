//! Readings of the five-axis machine computed with plain arrays, to compare effects with their formulas.
//!
//! The expected lengths are those of the displaced points; the first-order form `u·D` must agree with
//! them to second order, `|D|²/l`.

use serde_json::{Value, json};
use trueaxis_campaign::Direction;
use trueaxis_simulate::simulate;

use crate::exactness::{Vector, add, dot, scale, stage_motion, sub, vector};
use crate::shipped;

/// Lengths are about 1500 mm, where f64 resolves 2e-13 mm.
const LENGTH_TOL_MM: f64 = 1e-10;

pub(crate) const UM: f64 = 1e-3;

/// A reading, computed without the crate.
pub(crate) struct Reading<'a> {
    pub(crate) json: &'a Value,
    /// On the clock of the campaign, s.
    pub(crate) time_s: f64,
    /// Since the first reading, s.
    pub(crate) elapsed_s: f64,
    /// Over the campaign and over the occupation, 0 to 1.
    pub(crate) progress: f64,
    pub(crate) occupation_progress: f64,
    /// Since the first reading of the occupation, s.
    pub(crate) occupation_elapsed_s: f64,
    pub(crate) station: &'a str,
    pub(crate) target: &'a str,
    pub(crate) direction: f64,
    /// The axis that moves.
    pub(crate) axis: &'a str,
    /// Axes that move the target, from the bed outwards, with their positions in mm or rad.
    pub(crate) chain: Vec<(&'a str, f64)>,
    /// The target, without any effect.
    pub(crate) p: Vector,
    /// Centroid of the three targets of the stop.
    pub(crate) centroid: Vector,
    pub(crate) station_mm: Vector,
}

/// Displacement of target and station and change of the display, mm.
pub(crate) type Displaced = (Vector, Vector, f64);

pub(crate) const NONE: Vector = [0.0; 3];

pub(crate) fn of_target(d: Vector) -> Displaced {
    (d, NONE, 0.0)
}

pub(crate) fn of_station(d: Vector) -> Displaced {
    (NONE, d, 0.0)
}

pub(crate) fn of_length(d: f64) -> Displaced {
    (NONE, NONE, d)
}

impl Reading<'_> {
    /// 1 if it holds, else 0.
    pub(crate) fn when(holds: bool) -> f64 {
        f64::from(u8::from(holds))
    }

    /// Where the stage carries a point that is at `home` when all axes are at home.
    fn carried(&self, home: Vector) -> Vector {
        carried(self.json, &self.chain, home)
    }

    /// A vector that is fixed in the target's stage, as it stands now.
    pub(crate) fn turned(&self, v: Vector) -> Vector {
        sub(self.carried(v), self.carried(NONE))
    }

    pub(crate) fn position(&self, axis: &str) -> Option<f64> {
        let found = self.chain.iter().find(|(name, _)| *name == axis);
        found.map(|&(_, position)| position)
    }

    pub(crate) fn distance_mm(&self) -> f64 {
        length(sub(self.p, self.station_mm))
    }
}

fn carried(json: &Value, chain: &[(&str, f64)], home: Vector) -> Vector {
    let outwards = chain.iter().rev();
    outwards.fold(home, |p, (name, q)| stage_motion(json, name, *q, 0.0, p))
}

fn length(v: Vector) -> f64 {
    dot(v, v).sqrt()
}

/// Temperatures that rise evenly, longer than the campaign lasts: at the first second, °C, and K/s.
pub(crate) const AIR: [f64; 2] = [19.0, 3e-4];
pub(crate) const SPINDLE: [f64; 2] = [22.0, 1e-3];

fn ramp([start_c, slope]: &[f64; 2]) -> Value {
    let end_s = 1e6;
    json!({ "kind": "table", "times_s": [0.0, end_s], "values_c": [start_c, start_c + slope * end_s] })
}

/// The five-axis machine without errors and noise, every axis away from home.
fn faultless() -> Value {
    let mut json = shipped::json("five-axis");
    shipped::make_exact(&mut json);
    // So that the clock of the campaign is not the time since the first reading.
    json["timing"] = json!({ "start_s": 500.0 });
    json["errors"] = json!({});
    json["instrument"]["air_compensated"] = json!(false);
    json["temperatures"] = json!([
        { "column": "air_temp_c", "course": [ramp(&AIR)] },
        { "column": "machine_temp_spindle_c", "course": [ramp(&SPINDLE)] },
    ]);
    json["repeats"] = json!(1);
    let parked = [
        json!({ "Y": 210, "Z": 85 }),
        json!({ "X": 330, "Z": 140 }),
        json!({ "X": 45, "Y": 390 }),
        json!({ "C": 222 }),
        json!({ "A": 35 }),
    ];
    for (run, parked) in parked.into_iter().enumerate() {
        json["runs"][run]["parked"] = parked;
    }
    json
}

/// Simulates with one effect and compares every length with the formula.
pub(crate) fn assert_formula(effect: &Value, formula: &dyn Fn(&Reading<'_>) -> Displaced) {
    let mut json = faultless();
    json["effects"] = json!([effect]);
    let campaign = simulate(&shipped::scenario(&json), 1).unwrap().campaign;
    let lengths = campaign.lengths.clone().unwrap();
    let axes = campaign.machine.axes();
    let times_s: Vec<f64> = lengths.readings.iter().map(|r| r.time_s).collect();
    let part = |times_s: &[f64], time_s: f64| {
        let (first, last) = (times_s[0], times_s[times_s.len() - 1]);
        (time_s - first) / (last - first)
    };
    // Every occupation has as many readings.
    let occupation = times_s.len() / 4;

    let mut largest = 0.0_f64;
    for stop in &lengths.stops {
        let step = &campaign.steps[stop.step];
        let station = &json["stations"][stop.station];
        let home_and_chain = |target: usize| {
            let target = &json["targets"][target];
            let names: &[&str] = match target["carried_by"].as_str().unwrap() {
                "Z" => &["X", "Y", "Z"],
                _ => &["A", "C"],
            };
            let position = |name: &&'static str| {
                let index = campaign.machine.axis_index(name).unwrap();
                (*name, step.positions[index])
            };
            let chain: Vec<(&'static str, f64)> = names.iter().map(position).collect();
            let nominal = vector(&target["position_mm"]);
            let home = add(nominal, vector(&target["mounting_error_mm"]));
            (carried(&json, &chain, home), chain)
        };
        let readings = &lengths.readings[stop.readings.clone()];
        let points = readings.iter().map(|r| home_and_chain(r.target).0);
        let centroid = scale(points.fold(NONE, add), 1.0 / 3.0);
        assert_eq!(readings.len(), 3);
        for reading in readings {
            let (p, chain) = home_and_chain(reading.target);
            let here = Reading {
                json: &json,
                time_s: reading.time_s,
                elapsed_s: reading.time_s - times_s[0],
                progress: part(&times_s, reading.time_s),
                occupation_progress: part(
                    &times_s[stop.station * occupation..][..occupation],
                    reading.time_s,
                ),
                occupation_elapsed_s: reading.time_s - times_s[stop.station * occupation],
                station: station["name"].as_str().unwrap(),
                target: json["targets"][reading.target]["name"].as_str().unwrap(),
                direction: match stop.direction {
                    Direction::Forward => 1.0,
                    Direction::Backward => -1.0,
                },
                axis: axes[campaign.axis_under_test(stop.step).unwrap()].name(),
                chain,
                p,
                centroid,
                station_mm: vector(&station["position_mm"]),
            };
            let (d_p, d_s, d_l) = formula(&here);
            let dead_path_mm = station["dead_path_mm"].as_f64().unwrap();
            let distance_mm = here.distance_mm();
            let displaced_mm = length(sub(add(p, d_p), add(here.station_mm, d_s)));
            let off_mm = reading.length_mm - (displaced_mm - dead_path_mm + d_l);
            assert!(
                off_mm.abs() < LENGTH_TOL_MM,
                "{effect} line {}: {off_mm} mm",
                reading.line
            );

            let u = scale(sub(p, here.station_mm), 1.0 / distance_mm);
            let d = sub(d_p, d_s);
            let change_mm = reading.length_mm - (distance_mm - dead_path_mm);
            let off_mm = change_mm - (dot(u, d) + d_l);
            let second_order_mm = dot(d, d) / distance_mm;
            assert!(
                off_mm.abs() <= second_order_mm + LENGTH_TOL_MM,
                "{effect} line {}: {off_mm} mm beyond u·D",
                reading.line
            );
            largest = largest.max(change_mm.abs());
        }
    }
    // The case shows something: an effect of some micrometres is there, save that of a moving axis.
    let still = effect["effect"] == "timestamp_offset";
    assert_eq!(largest < 0.5 * UM, still, "{effect}: {largest} mm");
}

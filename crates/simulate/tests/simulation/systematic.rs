//! What is off in all readings alike, temperatures, and runs of one axis at different places.

use serde_json::{Value, json};
use trueaxis_campaign::{Campaign, read, write};
use trueaxis_simulate::{Simulated, simulate};

use crate::refusals::refused;
use crate::shipped;

/// Lengths are rounded to this.
const LENGTH_STEP_MM: f64 = 1e-7;

const UM: f64 = 1e-3;

fn measured(json: &Value, seed: u64) -> Simulated {
    simulate(&shipped::scenario(json), seed).unwrap()
}

fn lengths_mm(campaign: &Campaign) -> Vec<f64> {
    let lengths = campaign.lengths.as_ref().unwrap();
    lengths.readings.iter().map(|r| r.length_mm).collect()
}

/// How much longer each length is than without the changes, with its target.
fn longer_mm(json: &Value, seed: u64) -> Vec<(usize, f64)> {
    let plain = measured(&shipped::json("fxyz"), seed).campaign;
    let other = measured(json, seed).campaign;
    let readings = &plain.lengths.as_ref().unwrap().readings;
    let both = lengths_mm(&plain).into_iter().zip(lengths_mm(&other));
    let targets = readings.iter().map(|r| r.target);
    targets.zip(both.map(|(a, b)| b - a)).collect()
}

/// `values` of a standard deviation `sigma`: their rms is within 4 standard errors.
fn assert_spread(values: &[f64], sigma: f64) {
    let count = values.len() as f64;
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / count).sqrt();
    let standard_error = sigma / (2.0 * count).sqrt();
    assert!(
        (rms - sigma).abs() < 4.0 * standard_error,
        "{rms} of {count} values, expected {sigma}"
    );
}

#[test]
fn listed_constants_lengthen_the_lengths_of_their_targets() {
    let mut json = shipped::json("fxyz");
    json["targets"][0]["reflector"] = json!("R1");
    json["targets"][2]["reflector"] = json!("R1");
    json["reflectors"] = json!([
        { "name": "R1", "constant_um": 3.0 }, { "name": "Q", "constant_um": -1.5 }
    ]);
    for (target, longer_mm) in longer_mm(&json, 4) {
        let expected_mm = [3.0, -1.5, 3.0][target] * UM;
        assert!((longer_mm - expected_mm).abs() < 1.5 * LENGTH_STEP_MM);
    }
    let simulated = measured(&json, 4);
    let names = ["R1", "Q"].map(str::to_owned);
    assert_eq!(
        simulated.campaign.reflectors(),
        (names.to_vec(), vec![0, 1, 0])
    );
    let truth = serde_json::to_value(&simulated.truth).unwrap();
    assert_eq!(
        truth["reflectors"],
        json!([{ "name": "R1", "constant_um": 3.0 }, { "name": "Q", "constant_um": -1.5 }])
    );
}

#[test]
fn constants_are_drawn_with_the_declared_or_the_true_sigma() {
    for (declared, own, sigma_um) in [(Some(2.0), None, 2.0), (Some(2.0), Some(5.0), 5.0)] {
        let mut json = shipped::json("fxyz");
        json["repeats"] = json!(1);
        json["instrument"]["reflector_sigma_um"] = json!(declared);
        json["systematic"] = json!({ "reflector_sigma_um": own });
        let mut drawn_um = Vec::new();
        for seed in 0..40 {
            let simulated = measured(&json, seed);
            assert_eq!(simulated.campaign.instrument.reflector_sigma_um, declared);
            drawn_um.extend(simulated.truth.reflectors.iter().map(|r| r.constant_um));
        }
        assert_eq!(drawn_um.len(), 3 * 40);
        assert_spread(&drawn_um, sigma_um);
    }
    // What is drawn is what is seen, and a listed one changes no other.
    let mut json = shipped::json("fxyz");
    json["instrument"]["reflector_sigma_um"] = json!(2.0);
    let drawn = measured(&json, 7).truth.reflectors;
    for (target, longer_mm) in longer_mm(&json, 7) {
        assert!((longer_mm - drawn[target].constant_um * UM).abs() < 1.5 * LENGTH_STEP_MM);
    }
    json["reflectors"] = json!([{ "name": "P", "constant_um": 1.0 }]);
    let listed = measured(&json, 7).truth.reflectors;
    assert_eq!((listed[0].constant_um, &listed[1..]), (1.0, &drawn[1..]));
}

#[test]
fn the_scale_of_an_instrument_is_drawn_once() {
    let mut json = shipped::json("fxyz");
    json["instrument"]["scale_sigma_ppm"] = json!(2.0);
    let simulated = measured(&json, 3);
    let scale_ppm = simulated.truth.scale_ppm;
    let plain = measured(&shipped::json("fxyz"), 3).campaign;
    let lengths = plain.lengths.as_ref().unwrap();
    let scaled = lengths_mm(&simulated.campaign);
    for stop in &lengths.stops {
        let dead_path_mm = simulated.truth.stations[stop.station].dead_path_mm;
        for i in stop.readings.clone() {
            let length_mm = lengths.readings[i].length_mm;
            let expected_mm = 1e-6 * scale_ppm * (length_mm + dead_path_mm);
            // The noise is part of the length that is scaled here and not there: µm of ppm.
            let off_mm = scaled[i] - length_mm - expected_mm;
            assert!(off_mm.abs() < 1.5 * LENGTH_STEP_MM, "{off_mm}");
        }
    }
    json["repeats"] = json!(1);
    let drawn: Vec<f64> = (0..100)
        .map(|seed| measured(&json, seed).truth.scale_ppm)
        .collect();
    assert_spread(&drawn, 2.0);
    let truth = serde_json::to_value(&simulated.truth).unwrap();
    assert!((truth["scale_ppm"].as_f64().unwrap() - scale_ppm).abs() < 1e-9);
}

#[test]
fn nests_are_off_by_what_is_declared() {
    let mut json = shipped::json("fxyz");
    json["repeats"] = json!(1);
    for target in 0..3 {
        json["targets"][target]["position_sigma_mm"] = json!(0.5);
    }
    let mut off_mm = Vec::new();
    for seed in 0..40 {
        let plain = measured(&shipped::json("fxyz"), seed).truth;
        let simulated = measured(&json, seed);
        let pairs = plain.targets.iter().zip(&simulated.truth.targets);
        off_mm.extend(pairs.flat_map(|(a, b)| <[f64; 3]>::from(b.home_mm - a.home_mm)));
        let declared = &simulated.campaign.targets[1];
        assert_eq!(declared.position_sigma_mm, Some(0.5));
        let nominal: [f64; 3] = declared.home_mm.into();
        assert_eq!(json!(nominal), json["targets"][1]["position_mm"]);
    }
    assert_eq!(off_mm.len(), 40 * 9);
    assert_spread(&off_mm, 0.5);
    json["systematic"] = json!({ "position_sigma_mm": 0 });
    let exactly_set = measured(&json, 1).truth.targets;
    assert_eq!(
        exactly_set,
        measured(&shipped::json("fxyz"), 1).truth.targets
    );
}

#[test]
fn dead_paths_and_known_lengths_are_declared_with_their_errors() {
    let mut json = shipped::json("fxyz");
    json["repeats"] = json!(1);
    json["stations"][2]["dead_path_sigma_mm"] = json!(0.02);
    json["known_lengths"] = json!([{ "targets": ["K", "P"], "sigma_um": 0.5 }]);
    let (mut dead_paths_mm, mut lengths_um) = (Vec::new(), Vec::new());
    for seed in 0..60 {
        let Simulated { campaign, truth } = measured(&json, seed);
        let stations = &campaign.stations;
        assert_eq!((stations[1].dead_path, stations[3].dead_path), (None, None));
        let known = stations[2].dead_path.unwrap();
        dead_paths_mm.push(known.length_mm - truth.stations[2].dead_path_mm);
        let bar = &campaign.known_lengths[0];
        assert_eq!((bar.targets, bar.sigma_um), ([2, 0], 0.5));
        let [p, _, k] = [0, 1, 2].map(|i: usize| truth.targets[i].home_mm);
        lengths_um.push((bar.length_mm - (k - p).norm()) / UM);
    }
    assert_spread(&dead_paths_mm, 0.02);
    assert_spread(&lengths_um, 0.5);
}

/// A machine in which everything can be declared, written and read.
#[test]
fn what_is_declared_is_in_the_campaign_file() {
    let mut json = shipped::json("fxyz");
    json["repeats"] = json!(1);
    json["instrument"]["reflector_sigma_um"] = json!(2.0);
    json["instrument"]["scale_sigma_ppm"] = json!(1.0);
    json["targets"][0]["reflector"] = json!("R1");
    json["targets"][1]["position_sigma_mm"] = json!(0.1);
    json["stations"][0]["dead_path_sigma_mm"] = json!(0.01);
    json["known_lengths"] = json!([{ "targets": ["P", "Q"], "sigma_um": 0.5 }]);
    json["machine"]["axes"][0]["expansion_ppm_per_k"] = json!(11.5);
    json["temperatures"] = json!([
        { "column": "machine_temp_c", "course": [{ "kind": "table", "times_s": [0], "values_c": [21] }] }
    ]);
    let campaign = measured(&json, 1).campaign;
    let folder = tempfile::tempdir().unwrap();
    let copy = read(&write(&campaign, folder.path()).unwrap()).unwrap();
    assert_eq!(copy, campaign);
    assert_eq!(copy.expansions.len(), 1);
}

#[test]
fn temperatures_follow_their_course() {
    let mut json = shipped::json("fxyz");
    let warming =
        json!({ "kind": "exponential", "change_k": 4, "time_constant_s": 1800, "start_s": 600 });
    let day = json!({ "kind": "sine", "amplitude_k": 1.5, "period_s": 86400, "phase_deg": 30 });
    let line = json!({ "kind": "table", "times_s": [0, 10000], "values_c": [19, 21] });
    json["temperatures"] = json!([
        { "column": "machine_temp_spindle_c", "course": [line, warming] },
        { "column": "air_temp_c", "course": [line, day], "sigma_k": 0.1 }
    ]);
    let simulated = measured(&json, 2).campaign;
    let lengths = simulated.lengths.as_ref().unwrap();
    let of = |name: &str| {
        let values = &lengths.logged_column(name).unwrap().values;
        values.iter().map(|v| v.unwrap())
    };
    let mut noise_k = Vec::new();
    let both = of("machine_temp_spindle_c").zip(of("air_temp_c"));
    for (reading, (spindle_c, air_c)) in lengths.readings.iter().zip(both) {
        let t = reading.time_s;
        let line_c = 19.0 + 2.0 * (t / 10_000.0).min(1.0);
        let warming_k = 4.0 * (1.0 - (-(t - 600.0).max(0.0) / 1800.0).exp());
        assert!((spindle_c - line_c - warming_k).abs() < 0.6e-3);
        let turn = std::f64::consts::TAU * t / 86_400.0 + 30_f64.to_radians();
        noise_k.push(air_c - line_c - 1.5 * turn.sin());
    }
    assert_spread(&noise_k, 0.1);
    // Thermometers change no length.
    let plain = measured(&shipped::json("fxyz"), 2).campaign;
    assert_eq!(lengths_mm(&plain), lengths_mm(&simulated));
}

/// X stands at 20 µm per m and K times 10 K more than commanded.
#[test]
fn an_axis_expands_with_its_temperature() {
    let mut json = shipped::json("fxyz");
    shipped::make_exact(&mut json);
    json["errors"] = json!({});
    for target in 0..3 {
        json["targets"][target]["mounting_error_mm"] = json!([0, 0, 0]);
    }
    json["machine"]["axes"][0]["expansion_ppm_per_k"] = json!(20);
    json["machine"]["axes"][0]["temperature_column"] = json!("machine_temp_x_c");
    json["temperatures"] = json!([
        { "column": "machine_temp_x_c", "course": [{ "kind": "table", "times_s": [0], "values_c": [30] }] }
    ]);
    let campaign = measured(&json, 1).campaign;
    let lengths = campaign.lengths.as_ref().unwrap();
    let vector = |value: &Value| [0, 1, 2].map(|i| value[i].as_f64().unwrap());
    for stop in &lengths.stops {
        let station = &json["stations"][stop.station];
        let from = vector(&station["position_mm"]);
        let [x, y, z] = campaign.steps[stop.step].positions[..] else {
            panic!("three axes")
        };
        let reached = [x * (1.0 + 200e-6), y, z];
        for reading in &lengths.readings[stop.readings.clone()] {
            let home = vector(&json["targets"][reading.target]["position_mm"]);
            let beam = [0, 1, 2].map(|i| home[i] + reached[i] - from[i]);
            let distance_mm = beam.iter().map(|c| c * c).sum::<f64>().sqrt();
            let expected_mm = distance_mm - station["dead_path_mm"].as_f64().unwrap();
            assert!((reading.length_mm - expected_mm).abs() < 1e-9);
        }
    }
}

/// Y at X = 0 and at X = 400 with a coupling of both: the poses differ by their product.
#[test]
fn runs_of_one_axis_at_other_places_differ_by_a_cross_coupling() {
    let mut json = shipped::json("fxyz");
    shipped::make_exact(&mut json);
    json["errors"] = json!({});
    json["repeats"] = json!(1);
    json["runs"] = json!([
        { "name": "y", "axis": "Y", "sweep": { "start": 0, "stop": 400, "step": 100 } },
        { "name": "x", "axis": "X", "sweep": { "start": 0, "stop": 400, "step": 100 } },
        { "name": "y far", "axis": "Y", "sweep": { "start": 0, "stop": 400, "step": 100 },
          "parked": { "X": 400 } }
    ]);
    let plain = measured(&json, 1).campaign;
    json["effects"] = json!([
        { "effect": "cross_coupling", "subject": { "axis": "X", "other_axis": "Y" }, "parameters": [
            { "name": "coupling_x", "value": 0, "unit": "um/m2" },
            { "name": "coupling_y", "value": 0, "unit": "um/m2" },
            { "name": "coupling_z", "value": 75, "unit": "um/m2" } ] }
    ]);
    let Simulated { campaign, truth } = measured(&json, 1);
    let lengths = campaign.lengths.as_ref().unwrap();
    let before = lengths_mm(&plain);
    for stop in &lengths.stops {
        let [x, y, _] = campaign.steps[stop.step].positions[..] else {
            panic!("three axes")
        };
        let station = truth.stations[stop.station].position_mm;
        for i in stop.readings.clone() {
            let reading = &lengths.readings[i];
            let home = truth.targets[reading.target].home_mm;
            let beam = home + nalgebra::Vector3::new(x, y, 0.0) - station;
            let rise_mm = 75e-3 * (x * y * 1e-6);
            let expected_mm = rise_mm * beam.z / beam.norm();
            let seen_mm = reading.length_mm - before[i];
            assert!(
                (seen_mm - expected_mm).abs() < 1e-6,
                "{seen_mm} {expected_mm}"
            );
        }
    }
    assert!(
        campaign
            .steps
            .iter()
            .any(|s| s.run == Some(2) && s.positions[..2] == [400.0, 400.0])
    );
}

#[test]
fn what_cannot_be() {
    let course = json!([{ "kind": "table", "times_s": [0], "values_c": [20] }]);
    let cases = [
        (
            "/reflectors",
            json!([{ "name": "p", "constant_um": 1 }]),
            "unknown reflector `p`; did you mean `P`?",
        ),
        (
            "/reflectors",
            json!([{ "name": "P", "constnat_um": 1 }]),
            "did you mean `constant_um`?",
        ),
        (
            "/systematic",
            json!({ "scale_sigma_ppm": -1 }),
            "systematic.scale_sigma_ppm: expected zero or more",
        ),
        (
            "/systematic",
            json!({ "reflector_sigma": 1 }),
            "did you mean `reflector_sigma_um`?",
        ),
        (
            "/instrument/reflector_sigma_um",
            json!(0),
            "instrument.reflector_sigma_um: a standard deviation of 0; expected more than zero",
        ),
        (
            "/instrument/scale_sigma_ppm",
            json!(0),
            "instrument.scale_sigma_ppm: a standard deviation of 0; expected more than zero",
        ),
        (
            "/targets/1/reflector",
            json!("P"),
            "targets[1].reflector: `P` is a target (targets[0]) that names no reflector",
        ),
        (
            "/bed",
            json!({ "readings": 5 }),
            "bed: expected a target on the bed (`carried_by` null), or no field `bed`",
        ),
        (
            "/targets/0/position_sigma_mm",
            json!(0),
            "targets[0].position_sigma_mm: expected more than zero",
        ),
        (
            "/stations/0/dead_path_sigma_mm",
            json!(-1),
            "stations[0].dead_path_sigma_mm: expected more",
        ),
        (
            "/known_lengths",
            json!([{ "targets": ["P", "R"], "sigma_um": 1 }]),
            "unknown target `R`",
        ),
        (
            "/known_lengths",
            json!([{ "targets": ["P", "P"], "sigma_um": 1 }]),
            "two targets of one stage",
        ),
        (
            "/temperatures",
            json!([{ "column": "spindle", "course": course }]),
            "a column `spindle`; expected machine_temp_c",
        ),
        (
            "/temperatures",
            json!([{ "column": "machine_temp_c", "course": course }, { "column": "machine_temp_c", "course": course }]),
            "temperatures[1].column: column `machine_temp_c` has this name already",
        ),
        (
            "/temperatures",
            json!([{ "column": "machine_temp_c", "course": [{ "kind": "table", "times_s": [0, 1], "values_c": [20] }] }]),
            "as many values as times, found 1 and 2",
        ),
        (
            "/machine/axes/0/expansion_ppm_per_k",
            json!(11.5),
            "unknown column of temperatures `machine_temp_c`",
        ),
    ];
    for (pointer, value, says) in cases {
        let message = refused("fxyz", &[(pointer, value)]);
        assert!(message.contains(says), "{pointer}: {message}");
    }
}

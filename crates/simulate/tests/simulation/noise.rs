//! The noise has the size, the correlation and the reproducibility that it should have.

use nalgebra::{Matrix3, Vector3};
use serde_json::{Value, json};
use trueaxis_simulate::{Noise, Simulated, simulate};

use crate::shipped;

/// Statistics may be off by this many standard errors: for a normal statistic the probability of a
/// failure is 6e-5, and with the fixed seed it happens always or never.
const STANDARD_ERRORS: f64 = 4.0;

/// A slide with four targets, a near and a far station, 4200 stops.
fn slide(noise: Value) -> Value {
    json!({
        "format": "trueaxis-scenario", "version": 1, "name": "slide",
        "machine": {
            "name": "slide", "kinematics": { "tool": ["X"] },
            "axes": [ { "name": "X", "kind": "linear", "direction": [1, 0, 0], "travel": [0, 400] } ]
        },
        "targets": [
            { "name": "P", "position_mm": [0, 0, 0], "carried_by": "X" },
            { "name": "Q", "position_mm": [300, 0, 50], "carried_by": "X" },
            { "name": "K", "position_mm": [0, 400, 0], "carried_by": "X" },
            { "name": "R", "position_mm": [100, 50, 350], "carried_by": "X" }
        ],
        "stations": [
            { "name": "near", "position_mm": [-300, -300, 300], "dead_path_mm": 500 },
            { "name": "far", "position_mm": [2500, 2000, 1000], "dead_path_mm": 3300 }
        ],
        "runs": [ { "name": "x", "axis": "X", "sweep": { "start": 0, "stop": 400, "step": 20 } } ],
        "repeats": 100,
        "noise": noise
    })
}

const SEED: u64 = 20_260_101;

/// For each stop, station and each target: the distance, the unit vector from station to target
/// and the noise, mm.
struct Stop {
    station: usize,
    distance_mm: Vec<f64>,
    unit: Vec<Vector3<f64>>,
    noise_mm: Vec<f64>,
}

fn stops(noise: Value) -> Vec<Stop> {
    let Simulated { campaign, truth } = simulate(&shipped::scenario(&slide(noise)), SEED).unwrap();
    let lengths = campaign.lengths.unwrap();
    let stops = lengths.stops.iter().map(|stop| {
        let station = &truth.stations[stop.station];
        let x_mm = Vector3::x() * campaign.steps[stop.step].positions[0];
        let readings = &lengths.readings[stop.readings.clone()];
        let lines = readings
            .iter()
            .map(|reading| truth.targets[reading.target].home_mm + x_mm - station.position_mm);
        let exact = lines.clone().map(|line| line.norm() - station.dead_path_mm);
        Stop {
            station: stop.station,
            distance_mm: lines.clone().map(|line| line.norm()).collect(),
            unit: lines.map(|line| line.normalize()).collect(),
            noise_mm: readings
                .iter()
                .zip(exact)
                .map(|(r, exact)| r.length_mm - exact)
                .collect(),
        }
    });
    stops.collect()
}

/// Mean 0 and standard deviation 1 within their standard errors.
fn assert_standard_normal(values: &[f64]) {
    let count = f64::from(u32::try_from(values.len()).unwrap());
    let mean = values.iter().sum::<f64>() / count;
    let sigma = (values.iter().map(|v| v * v).sum::<f64>() / count).sqrt();
    assert!(mean.abs() < STANDARD_ERRORS / count.sqrt(), "mean {mean}");
    assert!(
        (sigma - 1.0).abs() < STANDARD_ERRORS / (2.0 * count).sqrt(),
        "sigma {sigma}"
    );
}

/// Correlation of two standard normal samples; its standard error is 1/√n if they are independent.
fn assert_uncorrelated(pairs: &[(f64, f64)]) {
    let count = f64::from(u32::try_from(pairs.len()).unwrap());
    let correlation = pairs.iter().map(|(a, b)| a * b).sum::<f64>() / count;
    assert!(
        correlation.abs() < STANDARD_ERRORS / count.sqrt(),
        "{correlation}"
    );
}

#[test]
fn instrument_noise_grows_with_the_distance_and_is_independent() {
    let noise = Noise {
        length_sigma_um: 0.5,
        length_sigma_ppm: 0.8,
        repeatability_um: 0.0,
    };
    let stops = stops(json!({ "length_sigma_um": 0.5, "length_sigma_ppm": 0.8 }));
    for station in [0, 1] {
        let at_station = stops.iter().filter(|stop| stop.station == station);
        let standardised = at_station.flat_map(|stop| {
            let readings = stop.noise_mm.iter().zip(&stop.distance_mm);
            readings.map(|(n, &l)| n / noise.length_sigma_mm(l))
        });
        assert_standard_normal(&standardised.collect::<Vec<_>>());
    }
    let z = |stop: &Stop, i: usize| stop.noise_mm[i] / noise.length_sigma_mm(stop.distance_mm[i]);
    let within: Vec<_> = stops.iter().map(|stop| (z(stop, 0), z(stop, 3))).collect();
    assert_uncorrelated(&within);
    let next: Vec<_> = stops
        .windows(2)
        .map(|two| (z(&two[0], 0), z(&two[1], 0)))
        .collect();
    assert_uncorrelated(&next);
}

#[test]
fn a_length_sigma_is_the_root_of_both_squares() {
    let noise = Noise {
        length_sigma_um: 0.3,
        length_sigma_ppm: 0.2,
        repeatability_um: 0.0,
    };
    assert!((noise.length_sigma_mm(2000.0) - 0.5e-3).abs() < 1e-18);
}

#[test]
fn all_targets_of_a_stop_share_one_deviation_of_the_machine() {
    let sigma_mm = 1.5e-3;
    let mut coordinates = Vec::new();
    for stop in stops(json!({ "repeatability_um": 1.5 })) {
        // The lengths of three targets give the deviation; the fourth must see the same.
        let unit = Matrix3::from_rows(&[0, 1, 2].map(|i| stop.unit[i].transpose()));
        let inverse = unit.try_inverse().unwrap();
        let deviation = inverse * Vector3::from_row_slice(&stop.noise_mm[..3]);
        let predicted_mm = stop.unit[3].dot(&deviation);

        // A length differs from the projection by its rounding and by its curvature d²/2l.
        let nearest_mm = stop.distance_mm.iter().copied().fold(f64::MAX, f64::min);
        let tolerance_mm = 0.5e-7 + deviation.norm_squared() / (2.0 * nearest_mm);
        let weights = inverse.transpose() * stop.unit[3];
        let bound_mm = tolerance_mm * (1.0 + weights.abs().sum());
        assert!((stop.noise_mm[3] - predicted_mm).abs() < bound_mm);
        if stop.station == 0 {
            assert!(
                bound_mm < 1e-3 * sigma_mm,
                "the bound must be far below the noise"
            );
            coordinates.push(deviation / sigma_mm);
        }
    }
    for i in 0..3 {
        let values: Vec<f64> = coordinates.iter().map(|d| d[i]).collect();
        assert_standard_normal(&values);
        let pairs: Vec<_> = coordinates.iter().map(|d| (d[i], d[(i + 1) % 3])).collect();
        assert_uncorrelated(&pairs);
    }
}

#[test]
fn the_seed_decides_and_later_stops_do_not_matter() {
    let mut json = shipped::json("rotary-stage");
    let lengths = |json: &Value, seed| {
        let simulated = simulate(&shipped::scenario(json), seed).unwrap();
        simulated.campaign.lengths.unwrap().readings
    };
    let whole = lengths(&json, 7);
    assert_eq!(whole, lengths(&json, 7));
    let other = lengths(&json, 8);
    let pairs = whole.iter().zip(&other);
    let equal = pairs.filter(|(a, b)| (a.length_mm - b.length_mm).abs() < 1e-9);
    // Noise of 1 µm in steps of 1e-4 µm: a few of the 684 agree by chance.
    assert!(equal.count() < 10);

    json["stations"].as_array_mut().unwrap().truncate(2);
    assert_eq!(whole[..whole.len() / 2], lengths(&json, 7));
}

#[test]
fn noise_overrides_the_declaration_one_by_one() {
    let mut json = shipped::json("five-axis");
    json["noise"] = json!({ "repeatability_um": 0.25 });
    let simulated = simulate(&shipped::scenario(&json), 1).unwrap();
    let expected = Noise {
        length_sigma_um: 0.269,
        length_sigma_ppm: 0.2,
        repeatability_um: 0.25,
    };
    assert_eq!(simulated.truth.noise, expected);
    assert_eq!(simulated.campaign.instrument.repeatability_um, Some(1.0));
}

#[test]
fn lengths_are_rounded_unless_exact() {
    let mut json = slide(json!({}));
    let off_grid = |json: &Value| {
        let campaign = simulate(&shipped::scenario(json), 1).unwrap().campaign;
        let readings = campaign.lengths.unwrap().readings.into_iter();
        let steps = readings.map(|reading| reading.length_mm * 1e7);
        steps
            .map(|steps| (steps - steps.round()).abs())
            .fold(0.0, f64::max)
    };
    // 4e10 steps of 1e-7 mm are themselves resolved to 1e-5 steps.
    assert!(off_grid(&json) < 1e-4);
    shipped::make_exact(&mut json);
    assert!(off_grid(&json) > 0.1);
}

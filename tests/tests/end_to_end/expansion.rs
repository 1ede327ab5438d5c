//! Thermal expansion of an axis: referred to 20 °C where it is declared, said where it is not.

use trueaxis_calibrate::{AxisResult, Calibration, Settings, calibrate, calibrate_for_replay};
use trueaxis_diagnose::{Verdict, diagnose};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_montecarlo::{Trials, propagate};
use trueaxis_poses::at_one_temperature;
use trueaxis_simulate::{Scenario, Simulated, TrueLocation, simulate};

use crate::round_trip::SHIPPED;

/// Coefficient of steel, ppm/K, how well its temperature is known, K, and the temperature of the hall, °C.
const PPM_PER_K: f64 = 11.5;
const SIGMA_K: f64 = 0.3;
const HALL_C: f64 = 24.0;

/// The three-axis machine in a hall at 24 °C, X expanding.
fn in_a_warm_hall() -> Simulated {
    let [(_, text), ..] = SHIPPED;
    let mut scenario: serde_json::Value = serde_json::from_str(text).unwrap();
    scenario["machine"]["axes"][0]["expansion_ppm_per_k"] = PPM_PER_K.into();
    scenario["machine"]["axes"][0]["temperature_sigma_k"] = SIGMA_K.into();
    scenario["temperatures"] = serde_json::json!([{
        "column": "machine_temp_c",
        "course": [{ "kind": "table", "times_s": [0], "values_c": [HALL_C] }],
    }]);
    simulate(&Scenario::from_json(&scenario.to_string()).unwrap(), 2).unwrap()
}

/// Its calibration, the expansion `declared` in the campaign or kept from it, and the last EXX, mm.
fn calibrated(declared: bool) -> (Calibration, f64) {
    let mut simulated = in_a_warm_hall();
    if !declared {
        simulated.campaign.expansions.clear();
    }
    let truth = &simulated.truth.axes[0];
    let last = truth.errors.last().unwrap().translation_mm.x;
    let settings = Settings {
        covariance: true,
        ..Settings::default()
    };
    (calibrate(&simulated.campaign, &settings).unwrap(), last)
}

fn end_of(axis: &AxisResult) -> (f64, f64, f64) {
    let node = axis.nodes.last().unwrap();
    let [share] = node.budget[0].shares().map(|shares| [shares[3]]).unwrap();
    (node.error.translation_mm.x, node.u[0], share)
}

/// A campaign of all three axes that expand while the hall warms up by 5 K.
fn warming(seed: u64) -> Simulated {
    let [(_, text), ..] = SHIPPED;
    let mut scenario: serde_json::Value = serde_json::from_str(text).unwrap();
    for axis in scenario["machine"]["axes"].as_array_mut().unwrap() {
        axis["expansion_ppm_per_k"] = PPM_PER_K.into();
    }
    scenario["temperatures"] = serde_json::json!([{
        "column": "machine_temp_c",
        "course": [{ "kind": "table", "times_s": [0, 10500], "values_c": [20, 25] }],
    }]);
    simulate(&Scenario::from_json(&scenario.to_string()).unwrap(), seed).unwrap()
}

/// The temperature of each reading counts, not the mean at each position: the stations see the machine at different
/// temperatures, which squareness would show. Three squarenesses and three positioning errors in four campaigns are within
/// 4 u (the probability of more is 1.5e-3), nothing looks like an interrupted beam, and nothing is named.
#[test]
fn a_hall_that_warms_up_is_taken_out_of_each_length() {
    for seed in 2..6 {
        let Simulated { campaign, truth } = warming(seed);
        let calibration = calibrate(&campaign, &Settings::default()).unwrap();
        assert!(calibration.adjustment.interruptions.is_empty(), "{seed}");
        for (axis, true_axis) in calibration.axes.iter().zip(&truth.axes) {
            for location in &axis.location_errors {
                let name = location.component.name(&axis.name);
                let is_own = |t: &&TrueLocation| t.name == name;
                let is_true = truth.location_errors.iter().find(is_own).unwrap();
                let off = location.value - is_true.value;
                assert!(off.abs() <= 4.0 * location.u, "{seed} {location:?} {off}");
            }
            let (node, errors) = (axis.nodes.last().unwrap(), true_axis.errors.last().unwrap());
            let k = axis.axis;
            let off = node.error.translation_mm[k] - errors.translation_mm[k];
            assert!(off.abs() < 4.0 * node.u[k], "{seed} {} {off}", axis.name);
        }
    }
    let diagnosis = diagnose(
        &warming(2).campaign,
        &trueaxis_diagnose::Settings::default(),
    );
    assert_eq!(diagnosis.unwrap().verdict, Verdict::Clean);
}

/// At the end of the travel the expansion is 20 µm. Declared, EXX is that of 20 °C within 4 u (the probability of more is
/// 6e-5), and u contains what the temperature is not known; else EXX is off by all of it, and a notice says at what
/// temperature the scale holds.
#[test]
fn declared_expansion_is_taken_out() {
    let (declared, true_mm) = calibrated(true);
    let (silent, _) = calibrated(false);
    let travel_mm = 440.0;
    let expansion_mm = PPM_PER_K * 1e-6 * (HALL_C - 20.0) * travel_mm;
    let of_temperature_mm = PPM_PER_K * 1e-6 * SIGMA_K * travel_mm;
    let (at_20_mm, u_mm, share) = end_of(declared.axis("X").unwrap());
    let (as_it_is_mm, noise_mm, none) = end_of(silent.axis("X").unwrap());
    println!("{true_mm} {at_20_mm} {u_mm} {as_it_is_mm} {noise_mm}");
    assert!((at_20_mm - true_mm).abs() < 4.0 * u_mm);
    assert!((as_it_is_mm - true_mm - expansion_mm).abs() < 4.0 * u_mm);
    assert!(expansion_mm > 8.0 * u_mm && expansion_mm > 20.0 * MICROMETRE);
    assert!((u_mm - noise_mm.hypot(of_temperature_mm)).abs() < 1e-3 * u_mm);
    assert!((share - (of_temperature_mm / u_mm).powi(2)).abs() < 1e-3 && none.abs() < 1e-12);
    let covariance = declared.covariance.as_ref().unwrap();
    for (i, result) in declared.results().iter().enumerate() {
        let u = covariance.matrix[(i, i)].sqrt() * result.output.unit().size();
        assert!(
            (u - result.u).abs() <= 1e-6 * result.u,
            "{:?}",
            result.output
        );
    }
    let said = |calibration: &Calibration, what: &str| {
        let mut notices = calibration.notices.iter();
        notices.any(|notice| notice.contains(what))
    };
    assert!(said(&declared, "the scale of Y, Z holds at 24.0 °C"));
    assert!(said(&silent, "the scale of X, Y, Z holds at 24.0 °C"));
}

/// The trials of a Monte Carlo scatter about what was calibrated, and that holds at 20 °C: the mean of 400 is within 0.3 u of
/// each result, six of its own standard deviations (the probability of more is 1e-6 for some 400 results). At 24 °C the
/// last EXX is 20 µm off.
#[test]
fn trials_of_an_axis_that_expands_are_referred_to_20_degrees() {
    let campaign = in_a_warm_hall().campaign;
    let campaign = at_one_temperature(&campaign);
    let (_, replay) = calibrate_for_replay(&campaign, &Settings::default()).unwrap();
    let settings = trueaxis_montecarlo::Settings {
        trials: Trials::Fixed(400),
        ..Default::default()
    };
    let trials = propagate(&replay, &settings, &|_| {}).unwrap();
    let named = replay.results().iter().zip(&trials.outputs);
    for (result, of_trials) in named {
        let off = of_trials.mean * result.output.unit().size() - result.value;
        let of_u = off / of_trials.u / result.output.unit().size();
        assert!(of_u.abs() < 0.3, "{:?}: {of_u:.2} u", result.output);
    }
}

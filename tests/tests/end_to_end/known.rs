//! What is known beside the lengths: the scale of the instrument, known lengths, known dead paths. U contains it,
//! and what contradicts the lengths is said and not used.

use trueaxis_calibrate::{Calibration, Method, calibrate, calibrate_for_replay};
use trueaxis_campaign::{Campaign, KnownLength};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_montecarlo::{Settings as Trials, Trials as Count, propagate};
use trueaxis_poses::ScaleBasis;
use trueaxis_simulate::{KnownLengthSpec, Scenario, simulate};
use trueaxis_tests::estimators::{SCENARIOS, settings};

use crate::coverage::assert_scatter_is_as_stated;

const PPM: f64 = 1e-6;

fn scenario(name: &str) -> Scenario {
    let (_, text) = SCENARIOS.iter().find(|(n, _)| *n == name).unwrap();
    Scenario::from_json(text).unwrap()
}

fn calibrated(campaign: &Campaign, scenario: &Scenario, method: Method) -> Calibration {
    calibrate(campaign, &settings(scenario, method)).unwrap()
}

fn bar(targets: [&str; 2], sigma_um: f64) -> KnownLengthSpec {
    KnownLengthSpec {
        targets: targets.map(str::to_owned),
        sigma_um,
    }
}

fn lacks_scale(calibration: &Calibration) -> bool {
    let mut lacks = calibration.uncertainty.lacks.iter();
    lacks.any(|part| part.starts_with("scale"))
}

/// The declared scale is no noise: values and noise stay, and the variance of a positioning error grows by the square
/// of what the scale makes of its position; angles do not know it.
#[test]
fn a_declared_scale_enters_u_and_the_budget() {
    const SCALE_PPM: f64 = 2.0;
    let scenario = scenario("three-axis");
    let mut campaign = simulate(&scenario, 1).unwrap().campaign;
    for method in [Method::Joint, Method::Nine] {
        campaign.instrument.scale_sigma_ppm = None;
        let without = calibrated(&campaign, &scenario, method);
        assert!(without.scale.is_none() && lacks_scale(&without));
        campaign.instrument.scale_sigma_ppm = Some(SCALE_PPM);
        let with = calibrated(&campaign, &scenario, method);
        let scale = with.scale.unwrap();
        assert_eq!(scale.basis, ScaleBasis::Declared);
        assert!(scale.value.abs() < 1e-15 && (scale.u / PPM - SCALE_PPM).abs() < 1e-9);
        assert!(!lacks_scale(&with));
        for (axis, before) in with.axes.iter().zip(&without.axes) {
            // EXX of X, EYY of Y, EZZ of Z.
            let along = ["X", "Y", "Z"]
                .iter()
                .position(|name| *name == axis.name)
                .unwrap();
            for (node, before) in axis.nodes.iter().zip(&before.nodes) {
                let moved = node.error.to_vector() - before.error.to_vector();
                for c in 0..6 {
                    // The weights of the nine equations are those of points that may be larger or smaller.
                    assert!(
                        moved[c].abs() <= 0.02 * before.u[c],
                        "{method:?} {}",
                        moved[c]
                    );
                    let by_scale = match c == along {
                        true => SCALE_PPM * PPM * node.position,
                        false => 0.0,
                    };
                    let added = node.u[c].powi(2) - before.u[c].powi(2);
                    // The nine equations are weighted with the covariance, which has the scale: a part in 1e5.
                    let of_weights = match method {
                        Method::Joint => 1e-6,
                        _ => 1e-5,
                    };
                    let tolerance = 1e-3 * by_scale.powi(2) + of_weights * before.u[c].powi(2);
                    assert!(
                        (added - by_scale.powi(2)).abs() <= tolerance,
                        "{method:?} {} {c} at {}: {added:e}",
                        axis.name,
                        node.position
                    );
                    let systematic = node.budget[c].systematic;
                    assert!((systematic - by_scale.powi(2)).abs() <= tolerance);
                    assert!(node.dof[c] >= before.dof[c] * 0.99);
                    if let Some(shares) = node.budget[c].shares() {
                        assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                    }
                }
            }
        }
    }
}

/// A known length determines the scale: 20 ppm are found, and taken out of the results.
#[test]
fn a_known_length_tells_the_scale() {
    let mut scenario = scenario("three-axis");
    scenario.systematic.scale_sigma_ppm = Some(20.0);
    scenario.known_lengths = vec![bar(["P", "K"], 0.3)];
    let simulated = simulate(&scenario, 3).unwrap();
    let truth_ppm = simulated.truth.scale_ppm;
    assert!(truth_ppm.abs() > 5.0, "{truth_ppm}");
    for method in [Method::Joint, Method::Nine] {
        let found = calibrated(&simulated.campaign, &scenario, method);
        let scale = found.scale.unwrap();
        assert_eq!(scale.basis, ScaleBasis::KnownLengths);
        let (error_ppm, u_ppm) = (scale.value / PPM - truth_ppm, scale.u / PPM);
        println!("{method:?}: scale {truth_ppm:.2} ppm found {error_ppm:+.2} ± {u_ppm:.2} off");
        // 0.3 µm of 400 mm.
        assert!(u_ppm < 1.0 && error_ppm.abs() < 3.0 * u_ppm);
        let x = found.axis("X").unwrap();
        let last = x.nodes.last().unwrap();
        let truth = simulated.truth.axes[0].errors.last().unwrap();
        let error_mm = last.error.translation_mm.x - truth.translation_mm.x;
        // The scale alone would be more than 2 µm.
        assert!(
            error_mm.abs() < 3.5 * last.u[0],
            "{error_mm:e} {:e}",
            last.u[0]
        );
        assert!(last.u[0] < 1.5e-3, "{:e}", last.u[0]);
    }
}

/// Stated uncertainties are the scatter over campaigns with a scale, a bar and dead paths of their own, and 95 % of
/// the intervals hold the truth.
#[test]
fn uncertainties_are_the_scatter_with_all_that_is_known() {
    for (name, _) in SCENARIOS {
        let mut scenario = scenario(name);
        scenario.instrument.scale_sigma_ppm = Some(5.0);
        assert_scatter_is_as_stated(&format!("{name}, declared scale"), &scenario);
        let targets = [0, 2].map(|t: usize| scenario.targets[t].name.clone());
        scenario.known_lengths = vec![bar([&targets[0], &targets[1]], 0.5)];
        scenario.systematic.reflector_sigma_um = Some(2.0);
        for station in &mut scenario.stations {
            station.dead_path_sigma_mm = Some(0.005);
        }
        assert_scatter_is_as_stated(&format!("{name}, all"), &scenario);
    }
}

/// Known dead paths tell all constants of the reflectors, and make the stations better.
#[test]
fn dead_paths_tell_what_reflectors_have_in_common() {
    let mut scenario = scenario("three-axis");
    scenario.systematic.reflector_sigma_um = Some(2.0);
    let unknown = simulate(&scenario, 1).unwrap().campaign;
    for station in &mut scenario.stations {
        station.dead_path_sigma_mm = Some(0.001);
    }
    let simulated = simulate(&scenario, 1).unwrap();
    let found = calibrated(&simulated.campaign, &scenario, Method::Joint);
    assert!(!found.reflectors_are_relative && found.known_misfits.is_empty());
    for (found, truth) in found.reflectors.iter().zip(&simulated.truth.reflectors) {
        let (error_um, u_um) = (
            found.constant_mm / MICROMETRE - truth.constant_um,
            found.u_mm / MICROMETRE,
        );
        println!(
            "{}: {:+.2} µm found {error_um:+.2} ± {u_um:.2} off",
            truth.name, truth.constant_um
        );
        assert!(u_um < 3.0 && error_um.abs() < 3.5 * u_um);
    }
    let without = calibrated(&unknown, &scenario, Method::Joint);
    assert!(without.reflectors_are_relative);
    for (a, b) in found.stations.iter().zip(&without.stations) {
        assert!(a.u_dead_path_mm < b.u_dead_path_mm, "{}", a.name);
    }
}

/// A dead path and a known length that are wrong are named and not used; the right ones are.
#[test]
fn what_contradicts_the_lengths_is_named_and_left_out() {
    let mut scenario = scenario("three-axis");
    scenario.instrument.scale_sigma_ppm = Some(2.0);
    scenario.known_lengths = vec![bar(["P", "K"], 0.3)];
    for station in &mut scenario.stations {
        station.dead_path_sigma_mm = Some(0.01);
    }
    let good = simulate(&scenario, 1).unwrap().campaign;
    for method in [Method::Joint, Method::Nine] {
        let clean = calibrated(&good, &scenario, method);
        assert!(clean.known_misfits.is_empty(), "{:?}", clean.known_misfits);
        let mut bad = good.clone();
        if let Some(dead_path) = &mut bad.stations[1].dead_path {
            dead_path.length_mm += 2.0;
        }
        bad.known_lengths[0].length_mm += 0.02;
        let found = calibrated(&bad, &scenario, method);
        let what: Vec<&str> = found
            .known_misfits
            .iter()
            .map(|m| m.what.as_str())
            .collect();
        assert_eq!(what, ["dead path of S2", "known length P-K"]);
        let [dead_path, length] = [0, 1].map(|i| found.known_misfits[i].difference_mm);
        assert!((dead_path - 2.0).abs() < 0.1 && (length - 0.02).abs() < 5e-3);
        assert_eq!(found.scale.unwrap().basis, ScaleBasis::Declared);
        let named = |n: &&String| n.contains("dead path of S2") || n.contains("known length P-K");
        assert_eq!(found.notices.iter().filter(named).count(), 2);
        // As if they had not been declared.
        bad.known_lengths.clear();
        bad.stations[1].dead_path = None;
        let without = calibrated(&bad, &scenario, method);
        for (a, b) in found.stations.iter().zip(&without.stations) {
            assert!((a.position_mm - b.position_mm).norm() < 1e-4 * a.u_mm[0]);
        }
    }
    // A metre for 1.001 m: no scale is that wrong, whatever is declared.
    let mut absurd = good.clone();
    absurd.instrument.scale_sigma_ppm = None;
    absurd.known_lengths[0].length_mm *= 1.001;
    let found = calibrated(&absurd, &scenario, Method::Joint);
    assert!(found.scale.is_none() && found.known_misfits.len() == 1);
    // Two bars that contradict each other: nothing tells which is wrong.
    let first = good.known_lengths[0].clone();
    absurd.known_lengths = vec![
        first.clone(),
        KnownLength {
            length_mm: first.length_mm + 0.01,
            ..first
        },
    ];
    let found = calibrated(&absurd, &scenario, Method::Joint);
    assert_eq!(found.known_misfits.len(), 2);
}

/// Monte Carlo draws the scale: the scatter of 400 trials is u within 5.4 standard errors of 3.5 %.
#[test]
fn trials_contain_the_scale() {
    let mut scenario = scenario("three-axis");
    scenario.instrument.scale_sigma_ppm = Some(5.0);
    const COUNT: usize = 400;
    for (known, method) in [
        (false, Method::Joint),
        (true, Method::Joint),
        (true, Method::Nine),
    ] {
        if known {
            scenario.known_lengths = vec![bar(["P", "K"], 1.0)];
        }
        let campaign = simulate(&scenario, 1).unwrap().campaign;
        let (_, replay) = calibrate_for_replay(&campaign, &settings(&scenario, method)).unwrap();
        let trials = Trials {
            trials: Count::Fixed(COUNT),
            seed: 7,
            ..Trials::default()
        };
        let found = propagate(&replay, &trials, &|_| ()).unwrap();
        let outputs = found.outputs.iter().zip(replay.results());
        let ratios: Vec<f64> = outputs
            .map(|(output, result)| output.u * result.output.unit().size() / result.u)
            .collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        println!("known {known}, {method:?}: {mean:.3}");
        for (ratio, result) in ratios.iter().zip(replay.results()) {
            assert!((ratio - 1.0).abs() < 0.19, "{:?}: {ratio}", result.output);
        }
    }
}

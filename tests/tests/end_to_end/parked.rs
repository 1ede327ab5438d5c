//! Axes measured while others stand away from home, and several runs of one axis.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_kinematics::{ARCSEC, MICROMETRE};
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::{components, locations};

use crate::coverage::{assert_each_scatter_is_as_stated, assert_scatter_is_as_stated};
use crate::round_trip::{SHIPPED, largest, without_noise};

/// The three-axis machine with Y and Z measured away from home, and a second run of X elsewhere
/// that does not contain home; the five-axis machine with the linear axes parked.
fn parked_scenarios() -> [(&'static str, Scenario); 2] {
    let [(_, fxyz), (_, five_axis), _] = SHIPPED;
    let mut three = Scenario::from_json(fxyz).unwrap();
    let mut second_x = three.runs[0].clone();
    second_x.name = "x2".to_owned();
    second_x.parked = [("Y".to_owned(), 200.0), ("Z".to_owned(), 100.0)].into();
    if let Some(sweep) = &mut second_x.sweep {
        sweep.start = 100.0;
    }
    three.runs[1].parked = [("X".to_owned(), 220.0), ("Z".to_owned(), 400.0)].into();
    three.runs[2].parked = [("X".to_owned(), 440.0), ("Y".to_owned(), 120.0)].into();
    three.runs.push(second_x);

    let mut five = Scenario::from_json(five_axis).unwrap();
    let y = five.runs.iter_mut().find(|run| run.axis == "Y").unwrap();
    y.parked = [("X".to_owned(), 200.0), ("Z".to_owned(), 80.0)].into();
    [("three-axis", three), ("five-axis", five)]
}

#[test]
fn errors_of_parked_axes_are_taken_out() {
    for (name, scenario) in parked_scenarios() {
        let simulated = simulate(&without_noise(scenario), 1).unwrap();
        let mut settings = Settings::default();
        settings.poses.by_direction = true;
        let calibration = calibrate(&simulated.campaign, &settings).unwrap();
        let mut all = components(&calibration, &simulated.truth);
        all.extend(locations(&calibration, &simulated.truth));
        let (mm, where_mm) = largest(&all, false);
        let (rad, where_rad) = largest(&all, true);
        println!(
            "{name}: {:.1e} µm ({where_mm}), {:.1e}\" ({where_rad})",
            mm / MICROMETRE,
            rad / ARCSEC
        );
        assert!(mm < 1e-4 * MICROMETRE, "{name}: {where_mm}");
        assert!(rad < 1e-4 * ARCSEC, "{name}: {where_rad}");
    }
}

#[test]
fn uncertainties_hold_with_parked_axes() {
    for (name, scenario) in parked_scenarios() {
        assert_scatter_is_as_stated(&format!("{name}, parked"), &scenario);
    }
}

#[test]
#[ignore = "study: 120 calibrations"]
fn each_uncertainty_holds_with_parked_axes() {
    for (name, scenario) in parked_scenarios() {
        assert_each_scatter_is_as_stated(&format!("{name}, parked"), &scenario);
    }
}

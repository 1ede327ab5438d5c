//! Targets that move in one plane leave the sides of the stations open.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::{components, locations};

use crate::round_trip::{SHIPPED, largest};

/// The rotary stage with all targets at one height, the second station below the plane, the true
/// side of one station told or not.
fn scenario(below: bool, told: bool) -> Scenario {
    let (_, rotary) = SHIPPED[2];
    let mut scenario = Scenario::from_json(rotary).unwrap();
    for target in &mut scenario.targets {
        target.position_mm[2] = 20.0;
        target.mounting_error_mm = [0.0; 3];
    }
    let height = |z: f64| if below { 40.0 - z } else { z };
    for station in &mut scenario.stations {
        station.position_mm[2] = height(station.position_mm[2]);
    }
    scenario.stations[1].position_mm[2] = height(-200.0);
    scenario.stations[0].declare_approx = told;
    scenario
}

fn agrees(scenario: &Scenario, seed: u64) -> (bool, bool) {
    let simulated = simulate(scenario, seed).unwrap();
    let calibration = calibrate(&simulated.campaign, &Settings::default()).unwrap();
    let mut all = components(&calibration, &simulated.truth);
    all.extend(locations(&calibration, &simulated.truth));
    assert!(largest(&all, false).0.is_finite());
    let right = all
        .iter()
        .filter(|d| d.u > 1e-9)
        .all(|d| d.error.abs() < 5.0 * d.u);
    let open = calibration
        .notices
        .iter()
        .any(|notice| notice.contains("`approx_mm`"));
    (right, open)
}

/// One rough position decides the side of all stations, whichever it is.
#[test]
fn one_rough_position_decides_all_sides() {
    for below in [false, true] {
        for seed in 0..5 {
            let (right, open) = agrees(&scenario(below, true), seed);
            assert!(right && !open, "below {below}, seed {seed}");
        }
    }
}

/// Without it the stations are on the right sides of each other, but the mirror image of the whole
/// may be the truth; the result says so.
#[test]
fn an_open_mirror_image_is_said() {
    for below in [false, true] {
        let (right, open) = agrees(&scenario(below, false), 1);
        assert!(open);
        assert_eq!(right, !below, "the side to which the normal leads is taken");
    }
}

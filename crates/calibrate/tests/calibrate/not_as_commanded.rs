//! Axes that move otherwise than commanded.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_simulate::Term;

use crate::{simulated, two_branches};

/// An encoder that is off by eight degrees, four times in a turn: direction, sign and unit are right, and the message does not stop
/// there.
#[test]
fn an_encoder_that_is_off_by_degrees_is_no_wrong_sign_alone() {
    let mut scenario = two_branches();
    let errors = scenario.errors.entry("C".to_owned()).or_default();
    let off = Term::Sine {
        amplitude: 8.0 * 3600.0,
        period_mm: None,
        period_deg: Some(90.0),
        phase_deg: 0.0,
    };
    errors.components.insert("ECC".to_owned(), vec![off]);
    let error = calibrate(&simulated(&scenario), &Settings::default()).unwrap_err();
    let said = error.to_string();
    for part in [
        "axis C does not move as commanded: in run c at ",
        // 8° sin(4 · 75°), the most of the five positions.
        "C = 75° the points deviate by 0.0 mm and 6.9° from it",
        "repaired",
    ] {
        assert!(said.contains(part), "{said}");
    }
}

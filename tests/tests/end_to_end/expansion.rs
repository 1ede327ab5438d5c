//! Thermal expansion of an axis: referred to 20 °C where it is declared, said where it is not.

use trueaxis_calibrate::{AxisResult, Calibration, Settings, calibrate};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_simulate::{Scenario, simulate};

use crate::round_trip::SHIPPED;

/// Coefficient of steel, ppm/K, how well its temperature is known, K, and the temperature of the hall, °C.
const PPM_PER_K: f64 = 11.5;
const SIGMA_K: f64 = 0.3;
const HALL_C: f64 = 24.0;

/// The three-axis machine in a hall at 24 °C, X expanding; `declared` in the campaign or kept from it.
fn calibrated(declared: bool) -> (Calibration, f64) {
    let [(_, text), ..] = SHIPPED;
    let mut scenario: serde_json::Value = serde_json::from_str(text).unwrap();
    scenario["machine"]["axes"][0]["expansion_ppm_per_k"] = PPM_PER_K.into();
    scenario["machine"]["axes"][0]["temperature_sigma_k"] = SIGMA_K.into();
    scenario["temperatures"] = serde_json::json!([{ "column": "machine_temp_c", "start_c": HALL_C }]);
    let scenario = Scenario::from_json(&scenario.to_string()).unwrap();
    let mut simulated = simulate(&scenario, 2).unwrap();
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

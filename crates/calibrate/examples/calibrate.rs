//! The tilt of a rotary axis from a simulated campaign.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_simulate::{Scenario, simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = Scenario::from_json(include_str!(
        "../../../campaigns/rotary-stage/scenario.json"
    ))?;
    let simulated = simulate(&scenario, 1)?;
    let calibration = calibrate(&simulated.campaign, &Settings::default())?;
    let c = calibration.axis("C").ok_or("C was not measured")?;
    let tilt = c.location_error("A0C").ok_or("no A0C")?;
    println!(
        "A0C = {:.2e} rad, standard uncertainty {:.1e} rad",
        tilt.value, tilt.u
    );
    assert!(tilt.u < 1e-5);
    Ok(())
}

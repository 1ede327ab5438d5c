//! Writes `campaigns/fxyz-lines`, `campaigns/fxyz-compensated`, `campaigns/rotary-bars` and
//! `campaigns/five-axis-lines`: `cargo run -p trueaxis-tests --example verification`.

use std::error::Error;
use std::path::Path;

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_campaign::{read, write};
use trueaxis_simulate::Scenario;
use trueaxis_tests::verification::{bars_on_the_stage, five_axis_readings, verification_campaign};

fn main() -> Result<(), Box<dyn Error>> {
    let campaigns = Path::new(env!("CARGO_MANIFEST_DIR")).join("../campaigns");
    let campaign = read(&campaigns.join("fxyz/campaign.json"))?;
    let scenario = std::fs::read_to_string(campaigns.join("fxyz/scenario.json"))?;
    let truth = Scenario::from_json(&scenario)?.true_machine()?;
    let calibrated = calibrate(&campaign, &Settings::default())?.calibrated_machine();
    for (folder, name, compensated_by) in [
        ("fxyz-lines", "FXYZ lines", None),
        ("fxyz-compensated", "FXYZ compensated", Some(&calibrated)),
    ] {
        let verification = verification_campaign(&campaign, &truth, compensated_by, name)?;
        write(&verification, &campaigns.join(folder))?;
    }
    let campaign = read(&campaigns.join("rotary-stage/campaign.json"))?;
    let scenario = std::fs::read_to_string(campaigns.join("rotary-stage/scenario.json"))?;
    let truth = Scenario::from_json(&scenario)?.true_machine()?;
    let bars = bars_on_the_stage(&campaign, &truth, "Rotary stage, ball bars")?;
    write(&bars, &campaigns.join("rotary-bars"))?;
    let campaign = read(&campaigns.join("five-axis/campaign.json"))?;
    let scenario = std::fs::read_to_string(campaigns.join("five-axis/scenario.json"))?;
    let truth = Scenario::from_json(&scenario)?.true_machine()?;
    let readings = five_axis_readings(&campaign, &truth, "Five-axis machine, readings")?;
    write(&readings, &campaigns.join("five-axis-lines"))?;
    Ok(())
}

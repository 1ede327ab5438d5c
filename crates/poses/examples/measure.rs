//! The poses of a rotary stage from a simulated campaign.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use trueaxis_poses::{Settings, measure};
use trueaxis_simulate::{Scenario, simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = Scenario::from_json(include_str!(
        "../../../campaigns/rotary-stage/scenario.json"
    ))?;
    let campaign = simulate(&scenario, 1)?.campaign;
    let measured = measure(&campaign, &Settings::default())?;
    let (poses, noise) = (&measured.poses.observations, &measured.poses.noise);
    let (turned, u) = (
        poses[9].datum_from_home.rotation.angle(),
        noise.own[9][(5, 5)].sqrt(),
    );
    println!(
        "step 9: turned by {:.4}°, own standard uncertainty {u:.1e} rad",
        turned.to_degrees()
    );
    assert_eq!(poses.len(), campaign.steps.len());
    Ok(())
}

//! Tests of whole calibrations.
#![expect(
    clippy::print_stdout,
    reason = "the figures of a test are worth reading"
)]

mod compare;
mod covariance_files;
mod machine;
mod not_as_commanded;
mod propagation;
mod replay;
mod residuals_csv;
mod tracker_points;
mod undeclared_noise;
mod volume;
mod with_effects;

use trueaxis_campaign::Campaign;
use trueaxis_simulate::{Scenario, simulate};

/// X and Y carry the tool, C the workpiece; X and Y are measured while the other one stands between
/// its measured positions, X from both sides, Y twice at different places of X. No noise.
fn two_branches() -> Scenario {
    Scenario::from_json(include_str!("two_branches.json")).unwrap()
}

fn simulated(scenario: &Scenario) -> Campaign {
    simulate(scenario, 1).unwrap().campaign
}

/// One reflector is moved from nest to nest. So few lengths would not determine how several differ, and what is
/// known of them beforehand is in no length.
fn with_one_reflector(scenario: &Scenario) -> Campaign {
    let mut campaign = simulated(scenario);
    for target in &mut campaign.targets {
        target.reflector = Some("R".to_owned());
    }
    campaign
}

//! How many of the stated 95 % intervals hold the truth, over thousands of simulated campaigns.
//!
//! ```text
//! cargo run --release -p trueaxis-tests --example coverage -- 2000
//! ```
//!
//! prints the table of docs/method.md (the number is that of the campaigns of each scenario). The
//! noise is drawn by the simulation, which knows nothing of the calibration; the calibration
//! estimates it from each campaign's residuals.

#![expect(clippy::print_stdout, reason = "prints a table")]

use rayon::prelude::*;
use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::Tally;

const SCENARIOS: [(&str, &str); 3] = [
    (
        "three-axis",
        include_str!("../../campaigns/fxyz/scenario.json"),
    ),
    (
        "rotary",
        include_str!("../../campaigns/rotary-stage/scenario.json"),
    ),
    (
        "five-axis, by direction",
        include_str!("../../campaigns/five-axis/scenario.json"),
    ),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let campaigns: u64 = match std::env::args().nth(1) {
        Some(text) => text.parse()?,
        None => 2000,
    };
    println!(
        "{:<26}{:>22}{:>20}{:>20}",
        "", "components", "locations", "stations"
    );
    for (name, text) in SCENARIOS {
        let scenario = Scenario::from_json(text)?;
        let settings = Settings {
            by_direction: scenario.runs.iter().any(|run| run.directions.len() > 1),
            ..Settings::default()
        };
        let tallies = (0..campaigns)
            .into_par_iter()
            .map(|seed| {
                let simulated = simulate(&scenario, seed).map_err(|error| error.to_string())?;
                let calibration =
                    calibrate(&simulated.campaign, &settings).map_err(|error| error.to_string())?;
                Ok(Tally::of(&calibration, &simulated.truth))
            })
            .collect::<Result<Vec<Tally>, String>>()?;
        let mut sum = Tally::default();
        tallies.into_iter().for_each(|tally| sum.add(tally));
        println!(
            "{name:<26}{:>22}{:>20}{:>20}",
            sum.components.to_string(),
            sum.locations.to_string(),
            sum.stations.to_string()
        );
    }
    Ok(())
}

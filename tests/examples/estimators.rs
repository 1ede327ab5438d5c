//! How good the estimators are over any number of campaigns.
//!
//! ```text
//! cargo run --release -p trueaxis-tests --example estimators -- [CAMPAIGNS] [METHOD ...]
//! ```
//!
//! prints for each shipped scenario, method and kind of result the rms error against the truth, also in
//! parts of the bound, the rms of error / u, and the share of the 95 % intervals that hold the truth, each
//! with its standard error from the scatter between campaigns. The noise is drawn by the simulation, which
//! knows nothing of the calibration; the calibration estimates it from each campaign's residuals. Without
//! arguments: 200 campaigns with all methods.

#![expect(clippy::print_stdout, reason = "prints a table")]

use trueaxis_tests::estimators::{METHODS, study};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let campaigns: u64 = arguments.next().as_deref().unwrap_or("200").parse()?;
    let names: Vec<String> = arguments.collect();
    let wanted = |name: &str| names.is_empty() || names.iter().any(|n| n == name);
    let methods = METHODS.into_iter().filter(|(name, _)| wanted(name));
    for study in study(&methods.collect::<Vec<_>>(), &(0..campaigns))? {
        println!("{study}");
    }
    Ok(())
}

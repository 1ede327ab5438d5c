//! First-order uncertainties against Monte Carlo.

use std::path::Path;

use trueaxis_calibrate::{Settings, calibrate_for_replay};
use trueaxis_campaign::read;
use trueaxis_montecarlo::{Settings as MonteCarlo, Trials, propagate};

/// Every result of the shipped campaigns: first order and Monte Carlo agree within four standard
/// errors of the Monte Carlo. By chance one of the 529 results does not with a probability of 3 %; the
/// seed is fixed.
fn assert_agreement(trials: usize) {
    for name in ["fxyz", "rotary-stage"] {
        let campaigns = Path::new(env!("CARGO_MANIFEST_DIR")).join("../campaigns");
        let campaign = read(&campaigns.join(name).join("campaign.json")).unwrap();
        let (_, replay) = calibrate_for_replay(&campaign, &Settings::default()).unwrap();
        let settings = MonteCarlo {
            trials: Trials::Fixed(trials),
            seed: 3,
            ..MonteCarlo::default()
        };
        let propagation = propagate(&replay, &settings, &|_| {}).unwrap();
        let mut largest = 0.0_f64;
        for (result, found) in replay.results().iter().zip(&propagation.outputs) {
            let unit = result.output.unit().size();
            let entry = &result.output;
            // The mean, too: what is not linear is far below the noise.
            let bias = (found.mean - result.value / unit).abs() / found.scatter.mean;
            let off = (found.u - result.u / unit).abs() / found.scatter.u;
            assert!(
                off < 4.0,
                "{name}: {entry:?}: u {} by first order, {} by trials",
                result.u / unit,
                found.u
            );
            assert!(
                bias < 4.5,
                "{name}: {entry:?}: mean off by {bias:.1} standard errors"
            );
            largest = largest.max(off);
        }
        println!(
            "{name}: {} results, u differs by {largest:.1} standard errors of {trials} trials at most",
            replay.results().len()
        );
    }
}

/// A standard deviation from 3,000 trials is good to 1.3 %.
#[test]
fn uncertainties_agree_with_monte_carlo() {
    assert_agreement(3000);
}

/// To 0.4 %. `trueaxis montecarlo` does the same.
#[test]
#[ignore = "study: 60,000 trials"]
fn uncertainties_agree_with_many_trials() {
    assert_agreement(30_000);
}

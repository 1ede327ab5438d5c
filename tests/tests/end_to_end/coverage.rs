//! Stated uncertainties against the scatter of simulated campaigns.

use std::collections::BTreeMap;

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::{components, locations, stations};

use crate::round_trip::SHIPPED;

/// Campaigns simulated for each scenario.
const CAMPAIGNS: u32 = 60;

/// What is zero by definition (gauge at home, frame) has no uncertainty, mm or rad.
const ZERO: f64 = 1e-9;

/// Simulates, calibrates and compares; prints the share of 95 % intervals that hold the truth.
///
/// For every single number (each component at each position, each location error, each station
/// coordinate) the rms over the campaigns of error / u must be one within 0.5: with 60 campaigns
/// its standard error is 0.091, so one of a thousand such numbers leaves 5.4 standard errors with
/// a probability below 1e-4. An overstated uncertainty fails as an understated one does.
pub(crate) fn assert_scatter_is_as_stated(name: &str, scenario: &Scenario, settings: &Settings) {
    let mut squares: BTreeMap<String, (f64, u32)> = BTreeMap::new();
    let mut counts = [
        ("components", 0_u32, 0_u32),
        ("locations", 0, 0),
        ("stations", 0, 0),
    ];
    for seed in 100..100 + u64::from(CAMPAIGNS) {
        let simulated = simulate(scenario, seed).unwrap();
        let calibration = calibrate(&simulated.campaign, settings).unwrap();
        let kinds = [
            components(&calibration, &simulated.truth),
            locations(&calibration, &simulated.truth),
            stations(&calibration, &simulated.truth),
        ];
        for ((_, inside, all), kind) in counts.iter_mut().zip(kinds) {
            for d in kind {
                if d.u < ZERO {
                    assert!(
                        d.error.abs() < ZERO,
                        "{name}: {} = {:e}, u = 0",
                        d.name,
                        d.error
                    );
                    continue;
                }
                *all += 1;
                *inside += u32::from(d.error.abs() < 1.96 * d.u);
                let (sum, count) = squares.entry(d.name).or_default();
                *sum += (d.error / d.u).powi(2);
                *count += 1;
            }
        }
    }
    for (kind, inside, all) in counts {
        let share = 100.0 * f64::from(inside) / f64::from(all);
        println!("{name}: {kind}: {inside} of {all} inside, {share:.1} %");
    }
    for (what, (sum, count)) in squares {
        let rms = (sum / f64::from(count)).sqrt();
        assert_eq!(count, CAMPAIGNS, "{name}: {what}");
        let within = (rms - 1.0).abs() < 0.5;
        assert!(
            within,
            "{name}: {what}: scatter is {rms:.2} of the stated u"
        );
    }
}

#[test]
fn stated_uncertainties_are_the_scatter() {
    for (name, text) in SHIPPED {
        let scenario = Scenario::from_json(text).unwrap();
        let by_direction = scenario.runs.iter().any(|run| run.directions.len() > 1);
        let settings = Settings {
            by_direction,
            ..Settings::default()
        };
        assert_scatter_is_as_stated(name, &scenario, &settings);
    }
}

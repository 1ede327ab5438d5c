//! Stated uncertainties against the scatter of simulated campaigns.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::{Deviation, components, locations, stations};

use crate::round_trip::SHIPPED;

/// Campaigns simulated for each shipped scenario.
const CAMPAIGNS: u64 = 60;

/// 95 % intervals, counted over all numbers of a kind in all campaigns.
///
/// Numbers of one campaign correlate (they share its stations), so the count scatters as if there
/// were far fewer: for location errors and stations, a few independent ones in each campaign. With
/// at least 60 × 3 of those a coverage of 95 % is found between 88 % and 100 % with a failure
/// probability below 1e-4 (4.3 standard errors of 1.6 %).
#[test]
fn intervals_of_95_percent_hold_the_truth() {
    for (name, text) in SHIPPED {
        let scenario = Scenario::from_json(text).unwrap();
        let mut counts = [
            ("components", 0_u32, 0_u32),
            ("locations", 0, 0),
            ("stations", 0, 0),
        ];
        for seed in 100..100 + CAMPAIGNS {
            let simulated = simulate(&scenario, seed).unwrap();
            let by_direction = simulated
                .truth
                .axes
                .iter()
                .any(|axis| axis.directions.is_some());
            let settings = Settings {
                by_direction,
                ..Settings::default()
            };
            let calibration = calibrate(&simulated.campaign, &settings).unwrap();
            let kinds: [Vec<Deviation>; 3] = [
                components(&calibration, &simulated.truth),
                locations(&calibration, &simulated.truth),
                stations(&calibration, &simulated.truth),
            ];
            for ((_, inside, all), kind) in counts.iter_mut().zip(&kinds) {
                for d in kind.iter().filter(|d| d.u > 1e-9) {
                    *all += 1;
                    *inside += u32::from(d.error.abs() < 1.96 * d.u);
                }
            }
        }
        for (kind, inside, all) in counts {
            let share = f64::from(inside) / f64::from(all);
            println!(
                "{name}: {kind}: {inside} of {all} inside, {:.1} %",
                100.0 * share
            );
            assert!(share > 0.88, "{name}: {kind}: {share}");
        }
    }
}

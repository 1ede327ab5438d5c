//! Stated uncertainties against the scatter of simulated campaigns.

use std::collections::BTreeMap;

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_campaign::Instrument;
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::{Tally, components, locations, stations};

use crate::round_trip::SHIPPED;

/// Campaigns simulated for each scenario.
const CAMPAIGNS: u32 = 60;

/// Simulates, calibrates and compares; prints the share of 95 % intervals that hold the truth.
///
/// For every single number (each component at each position, each location error, each station
/// coordinate) the rms over the campaigns of error / u must be one within 0.5: with 60 campaigns
/// its standard error is 0.091, so one of a thousand such numbers leaves 5.4 standard errors with
/// a probability below 1e-4. An overstated uncertainty fails as an understated one does.
pub(crate) fn assert_scatter_is_as_stated(name: &str, scenario: &Scenario, settings: &Settings) {
    let mut squares: BTreeMap<String, (f64, u32)> = BTreeMap::new();
    let mut tally = Tally::default();
    for seed in 100..100 + u64::from(CAMPAIGNS) {
        let simulated = simulate(scenario, seed).unwrap();
        let calibration = calibrate(&simulated.campaign, settings).unwrap();
        tally.add(Tally::of(&calibration, &simulated.truth));
        let mut all = components(&calibration, &simulated.truth);
        all.extend(locations(&calibration, &simulated.truth));
        all.extend(stations(&calibration, &simulated.truth));
        for d in all.into_iter().filter(|d| d.is_inside().is_some()) {
            let (sum, count) = squares.entry(d.name).or_default();
            *sum += (d.error / d.u).powi(2);
            *count += 1;
        }
    }
    let Tally {
        components,
        locations,
        stations,
    } = tally;
    println!("{name}: components {components}, locations {locations}, stations {stations}");
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

/// Few degrees of freedom, noise not declared: six places of a rotary table seen once from each of four
/// stations leave eight. The intervals are Student's; with k = 1.96 some 91 % would hold the truth.
///
/// Component errors of a campaign share its estimate of the noise, so that it counts as one number: a
/// share of 95 % scatters by some 1.5 % over 300 campaigns.
#[test]
fn intervals_widen_with_few_degrees_of_freedom() {
    let [_, _, (_, text)] = SHIPPED;
    let mut scenario = Scenario::from_json(text).unwrap();
    scenario.noise.repeatability_um = Some(0.0);
    scenario.noise.length_sigma_um = Some(0.5);
    scenario.repeats = 1;
    for run in &mut scenario.runs {
        if let Some(sweep) = &mut run.sweep {
            (sweep.stop, sweep.step) = (300.0, 60.0);
        }
    }
    let mut tally = Tally::default();
    let mut narrow = 0;
    let mut degrees_of_freedom = 0;
    for seed in 0..300 {
        let mut simulated = simulate(&scenario, seed).unwrap();
        simulated.campaign.instrument = Instrument::default();
        let calibration = calibrate(&simulated.campaign, &Settings::default()).unwrap();
        degrees_of_freedom = calibration.adjustment.degrees_of_freedom;
        tally.add(Tally::of(&calibration, &simulated.truth));
        let all = components(&calibration, &simulated.truth);
        let within = all
            .iter()
            .filter(|d| d.is_inside().is_some() && d.error.abs() < 1.96 * d.u);
        narrow += within.count();
    }
    let share = 100.0 * narrow as f64 / tally.components.all as f64;
    println!(
        "{degrees_of_freedom} degrees of freedom: components {}, with k = 1.96 {share:.1} %; locations {}, \
         stations {}",
        tally.components, tally.locations, tally.stations
    );
    assert!((tally.components.per_cent() - 95.0).abs() < 5.0);
    assert!(share < tally.components.per_cent() - 2.0);
}

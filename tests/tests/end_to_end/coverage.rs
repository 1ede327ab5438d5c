//! Stated uncertainties against the scatter of simulated campaigns.

use trueaxis_calibrate::{Method, Settings, calibrate};
use trueaxis_campaign::Instrument;
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::estimators::{METHODS, SCENARIOS, scatter, settings, study};
use trueaxis_tests::{Kind, Scatter};

const SEED: u64 = 100;

/// Fails unless error / u and the share of the 95 % intervals that hold the truth, pooled over the results
/// of the machine and over those of the set-up, are one and 95 % within 5 of their standard errors, which
/// follow from the scatter between the campaigns.
///
/// With 12 campaigns (Student's, 11 degrees of freedom) one of the four numbers is off by chance with a
/// probability of 2e-3. An overstated uncertainty fails as an understated one does.
pub(crate) fn assert_scatter_is_as_stated(name: &str, scenario: &Scenario) -> Scatter {
    let settings = settings(scenario, Method::default());
    let scatter = scatter(scenario, &settings, SEED..SEED + 12).unwrap();
    for (what, of_machine) in [("machine", true), ("set-up", false)] {
        let pooled = scatter.pooled(|d| d.kind.is_of_machine() == of_machine);
        println!("{name}, {what}: {pooled}");
        assert!(pooled.is_as_stated(5.0), "{name}, {what}: {pooled}");
    }
    scatter
}

/// The check itself is checked: with every u 30 % too small or too large it fails.
#[test]
fn stated_uncertainties_are_the_scatter() {
    for (name, text) in SCENARIOS {
        let scenario = Scenario::from_json(text).unwrap();
        let scatter = assert_scatter_is_as_stated(name, &scenario);
        for factor in [0.7, 1.3] {
            let wrong = scatter.with_u(|deviation| factor * deviation.u);
            let pooled = wrong.pooled(|d| d.kind.is_of_machine());
            println!("{name}, u times {factor}: {pooled}");
            assert!(
                !pooled.is_as_stated(5.0),
                "{name}, u times {factor}: {pooled}"
            );
        }
    }
}

/// For every single number (each component at each position, each location error, each coordinate of a
/// station) the rms over 60 campaigns of error / u is one within 0.5: its standard error is 0.091, so one
/// of a thousand such numbers leaves 5.4 standard errors with a probability below 1e-4.
pub(crate) fn assert_each_scatter_is_as_stated(name: &str, scenario: &Scenario) {
    let settings = settings(scenario, Method::default());
    let scatter = scatter(scenario, &settings, SEED..SEED + 60).unwrap();
    for (what, ratio) in scatter.single_ratios() {
        assert!((ratio - 1.0).abs() < 0.5, "{name}: {what}: {ratio:.2}");
    }
}

#[test]
#[ignore = "study: 180 calibrations"]
fn each_stated_uncertainty_is_the_scatter() {
    for (name, text) in SCENARIOS {
        assert_each_scatter_is_as_stated(name, &Scenario::from_json(text).unwrap());
    }
}

/// 200 campaigns of each scenario with each method: each kind of result scatters as stated, and 95 % of the
/// intervals hold the truth, within 3 standard errors. The joint adjustment reaches the bound: pooled over
/// all results of a scenario within 1.5 %, each result within 4 of its own standard errors.
///
/// By chance one of the 60 numbers of a method is off with a probability of 15 %; the seeds are fixed.
#[test]
#[ignore = "study: 600 calibrations with each method"]
fn estimators_are_as_good_as_they_say() {
    let campaigns = 200;
    for study in study(&METHODS, &(0..campaigns)).unwrap() {
        println!("{study}");
        for kind in study.stated.kinds() {
            let pooled = study.stated.pooled(|d| d.kind == kind);
            assert!(pooled.is_as_stated(3.0), "{}: {kind}: {pooled}", study.name);
        }
        if study.name.ends_with("joint") {
            let pooled = study.bound.pooled(|_| true).ratio.value;
            assert!((pooled - 1.0).abs() < 0.015, "{}: {pooled}", study.name);
            let standard_error = 1.0 / (2.0 * campaigns as f64).sqrt();
            for (what, ratio) in study.bound.single_ratios() {
                let off = (ratio - 1.0) / standard_error;
                assert!(off.abs() < 4.0, "{}: {what}: {ratio:.3}", study.name);
            }
        }
    }
}

/// Few degrees of freedom, noise not declared: six places of a turntable seen once from each of four
/// stations leave eight. The intervals are Student's; with k = 1.96 some 91 % would hold the truth.
fn few_degrees_of_freedom(campaigns: u64) -> (Scatter, f64) {
    let [_, (_, text), _] = SCENARIOS;
    let mut scenario = Scenario::from_json(text).unwrap();
    scenario.noise.repeatability_um = Some(0.0);
    scenario.noise.length_sigma_um = Some(0.5);
    scenario.repeats = 1;
    for run in &mut scenario.runs {
        if let Some(sweep) = &mut run.sweep {
            (sweep.stop, sweep.step) = (270.0, 90.0);
        }
    }
    let mut scatter = Scatter::default();
    for seed in 0..campaigns {
        let mut simulated = simulate(&scenario, seed).unwrap();
        simulated.campaign.instrument = Instrument::default();
        let calibration = calibrate(&simulated.campaign, &Settings::default()).unwrap();
        scatter.add(&calibration, &simulated.truth);
    }
    let mut narrow = scatter.clone();
    let all = narrow.campaigns.iter_mut().flatten();
    all.for_each(|deviation| deviation.dof = f64::INFINITY);
    let is_component = |kind| matches!(kind, Kind::Component(_));
    let narrow = narrow.pooled(|d| is_component(d.kind)).coverage.value;
    (scatter, narrow)
}

/// The share of intervals that hold the truth is 95 % within 3 standard errors, with a probability of 99.7 %, and larger by
/// `margin` than with k = 1.96.
fn assert_intervals_widen(campaigns: u64, margin: f64) {
    let (scatter, narrow) = few_degrees_of_freedom(campaigns);
    let pooled = scatter.pooled(|d| matches!(d.kind, Kind::Component(_)));
    println!(
        "components: {pooled}; {:.1} % with k = 1.96",
        100.0 * narrow
    );
    assert!(pooled.coverage.off(0.95).abs() < 3.0, "{pooled}");
    assert!(narrow < pooled.coverage.value - margin);
}

#[test]
fn intervals_widen_with_few_degrees_of_freedom() {
    assert_intervals_widen(60, 0.0);
}

#[test]
#[ignore = "study: 300 calibrations"]
fn intervals_widen_with_few_degrees_of_freedom_in_300_campaigns() {
    assert_intervals_widen(300, 0.02);
}

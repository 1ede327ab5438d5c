//! The adaptive number of trials (JCGM 101, 7.9).

use trueaxis_montecarlo::{Propagation, Settings, Summary, Trials, propagate};

use crate::model::{gaussian, model_of};

/// Gaussian outputs with these standard uncertainties, independent.
fn gaussians<const N: usize>(u: [f64; N], significant_digits: u32, most: usize) -> Propagation {
    let model = model_of(|rng| u.map(|u| gaussian(rng, 100.0, u)));
    let settings = Settings {
        trials: Trials::Adaptive {
            significant_digits,
            most,
        },
        seed: 79,
        ..Settings::default()
    };
    propagate(&model, &settings, &|_| {}).unwrap()
}

#[test]
fn stops_when_every_output_has_stabilised() {
    // 8.0 to two digits tolerates 0.05. An end of the interval scatters by 2.67 u in one trial, so
    // 2 × 2.67 × 8.0/√M ≤ 0.05 takes 730 000 trials; s from 73 blocks is good to 8 %, and the
    // first time that a wandering s is small enough comes early, so half to one and a half of that.
    // The second output alone, 0.20 with the tolerance 0.005, would be done after some 50 000.
    let found = gaussians([8.0, 0.2], 2, 3_000_000);
    let stability = found.stability.as_ref().unwrap();
    assert!(stability.stabilised);
    assert_eq!(stability.block_trials, 10_000);
    assert_eq!(stability.blocks * 10_000, found.trials);
    assert!(
        (365_000..1_100_000).contains(&found.trials),
        "{}",
        found.trials
    );

    let [wide, narrow] = &stability.outputs[..] else {
        panic!("two outputs");
    };
    assert!((wide.tolerance - 0.05).abs() < 1e-15);
    assert!((narrow.tolerance - 0.005).abs() < 1e-15);
    assert!(wide.is_stabilised() && narrow.is_stabilised());
    assert!(2.0 * wide.scatter.largest() <= wide.tolerance);

    // The scatter between blocks and that of the sorted values say the same.
    for (blocks, Summary { scatter, .. }) in stability.outputs.iter().zip(&found.outputs) {
        for (from_blocks, from_values) in [
            (blocks.scatter.mean, scatter.mean),
            (blocks.scatter.u, scatter.u),
            (blocks.scatter.low, scatter.low),
            (blocks.scatter.high, scatter.high),
        ] {
            let ratio = from_blocks / from_values;
            assert!((0.6..1.5).contains(&ratio), "{blocks:?} {scatter:?}");
        }
    }
}

/// The trials are those of a fixed number.
#[test]
fn values_are_those_of_a_fixed_number() {
    let found = gaussians([0.2], 2, 3_000_000);
    assert!(found.trials < 200_000);
    let model = model_of(|rng| [gaussian(rng, 100.0, 0.2)]);
    let settings = Settings {
        trials: Trials::Fixed(found.trials),
        seed: 79,
        ..Settings::default()
    };
    let fixed = propagate(&model, &settings, &|_| {}).unwrap();
    assert_eq!(fixed.outputs, found.outputs);
    assert!(fixed.stability.is_none());
}

#[test]
fn most_trials_end_what_does_not_stabilise() {
    // 8.0 to three digits would take 73 million. The cap holds four whole blocks.
    let found = gaussians([8.0], 3, 49_999);
    let stability = found.stability.unwrap();
    assert!(!stability.stabilised);
    assert_eq!((stability.blocks, found.trials), (4, 40_000));
    assert!(!stability.outputs[0].is_stabilised());
}

#[test]
fn output_that_does_not_vary_is_stable_after_two_blocks() {
    let settings = Settings {
        trials: Trials::Adaptive {
            significant_digits: 2,
            most: 1_000_000,
        },
        ..Settings::default()
    };
    let found = propagate(&model_of(|_| [0.1]), &settings, &|_| {}).unwrap();
    assert_eq!(found.trials, 20_000);
    let stability = found.stability.unwrap();
    assert!(stability.stabilised);
    assert!(stability.outputs[0].tolerance < f64::MIN_POSITIVE);
}

/// A block has to hold 100 values outside the interval (7.9.4).
#[test]
fn wide_coverage_takes_larger_blocks() {
    let settings = Settings {
        trials: Trials::Adaptive {
            significant_digits: 1,
            most: 500_000,
        },
        coverage: 0.999,
        ..Settings::default()
    };
    let model = model_of(|rng| [gaussian(rng, 0.0, 1.0)]);
    let found = propagate(&model, &settings, &|_| {}).unwrap();
    assert_eq!(found.stability.unwrap().block_trials, 100_000);
}

//! What is refused, and that the messages carry the numbers.

use std::num::NonZeroUsize;

use trueaxis_montecarlo::{ChaCha8Rng, Error, Model, Settings, Trials, propagate};

use crate::model::{gaussian, model_of};

fn refused(settings: Settings) -> Error {
    let model = model_of(|rng| [gaussian(rng, 0.0, 1.0), 0.0, 1.0]);
    propagate(&model, &settings, &|_| {}).unwrap_err()
}

/// Fails in every trial from `first` on whose stream says so; `first` itself always.
struct Failing {
    first: u64,
}

impl Model for Failing {
    type Workspace = ();

    fn outputs(&self) -> usize {
        3
    }

    fn workspace(&self) {}

    fn trial(&self, rng: &mut ChaCha8Rng, _: &mut (), outputs: &mut [f64]) {
        let trial = rng.get_stream();
        outputs.fill(1.0);
        if trial >= self.first && trial % 7 == self.first % 7 {
            outputs[1] = f64::NEG_INFINITY;
            outputs[2] = f64::NAN;
        }
    }
}

#[test]
fn first_failed_trial_is_reported_on_any_number_of_threads() {
    for threads in [1, 2, 3, 5] {
        let settings = Settings {
            trials: Trials::Fixed(50_000),
            threads: NonZeroUsize::new(threads),
            ..Settings::default()
        };
        let error = propagate(&Failing { first: 12_345 }, &settings, &|_| {}).unwrap_err();
        assert_eq!(
            error,
            Error::NotFinite {
                trial: 12_345,
                output: 1,
                value: f64::NEG_INFINITY
            }
        );
        assert_eq!(error.to_string(), "trial 12345: output 1 is -inf");
    }
}

/// A model that forgets an output must not pass with what the trial before left there.
#[test]
fn output_that_is_not_written_is_a_failure() {
    struct Forgetful;
    impl Model for Forgetful {
        type Workspace = ();

        fn outputs(&self) -> usize {
            2
        }

        fn workspace(&self) {}

        fn trial(&self, rng: &mut ChaCha8Rng, _: &mut (), outputs: &mut [f64]) {
            outputs[0] = 1.0;
            if rng.get_stream() != 150 {
                outputs[1] = 2.0;
            }
        }
    }
    let error = propagate(&Forgetful, &Settings::default(), &|_| {}).unwrap_err();
    assert_eq!(error.to_string(), "trial 150: output 1 is NaN");
}

#[test]
fn too_much_memory_is_refused_before_it_is_taken() {
    for trials in [
        Trials::Fixed(1_000_000),
        Trials::Adaptive {
            significant_digits: 1,
            most: 1_000_000,
        },
    ] {
        let error = refused(Settings {
            trials,
            memory_limit_bytes: 10_000_000,
            ..Settings::default()
        });
        assert_eq!(
            error.to_string(),
            "1000000 trials of 3 outputs take 24000000 bytes, but the limit is 10000000; 416666 \
             trials fit"
        );
    }
    // Without a limit, what no machine has is an error all the same.
    let trials = usize::MAX / 32;
    let error = refused(Settings {
        trials: Trials::Fixed(trials),
        memory_limit_bytes: u64::MAX,
        ..Settings::default()
    });
    let outputs = 3;
    assert_eq!(error, Error::Allocation { outputs, trials });
}

#[test]
fn settings_without_a_meaning_are_refused() {
    for coverage in [0.0, 1.0, -0.5, f64::NAN] {
        let error = refused(Settings {
            coverage,
            ..Settings::default()
        });
        assert!(matches!(error, Error::Coverage { .. }), "{error}");
    }
    let error = refused(Settings {
        trials: Trials::Fixed(10),
        ..Settings::default()
    });
    let (trials, coverage) = (10, 0.95);
    assert_eq!(error, Error::TooFewTrials { trials, coverage });
    for trials in [0, 1] {
        let error = refused(Settings {
            trials: Trials::Fixed(trials),
            coverage: 0.1,
            ..Settings::default()
        });
        assert!(matches!(error, Error::TooFewTrials { .. }), "{error}");
    }
    let adaptive = |significant_digits, most| {
        refused(Settings {
            trials: Trials::Adaptive {
                significant_digits,
                most,
            },
            ..Settings::default()
        })
    };
    let error = adaptive(0, 100_000);
    assert!(matches!(error, Error::SignificantDigits { .. }), "{error}");
    let (most, block) = (19_999, 10_000);
    assert_eq!(adaptive(1, most), Error::TooFewForBlocks { most, block });
    let nothing = model_of(|_| []);
    let error = propagate(&nothing, &Settings::default(), &|_| {}).unwrap_err();
    assert_eq!(error, Error::NoOutputs);
}

#[test]
fn values_whose_squares_overflow_are_refused() {
    let model = model_of(|rng| [1.0, 1e200 * gaussian(rng, 0.0, 1.0)]);
    for trials in [
        Trials::Fixed(1000),
        Trials::Adaptive {
            significant_digits: 1,
            most: 20_000,
        },
    ] {
        let settings = Settings {
            trials,
            ..Settings::default()
        };
        let error = propagate(&model, &settings, &|_| {}).unwrap_err();
        assert_eq!(error, Error::Overflow { output: 1 });
    }
}

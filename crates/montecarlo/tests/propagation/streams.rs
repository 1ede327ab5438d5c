//! Same seed, same bits: on any number of threads, for any split of the trials.

use std::num::NonZeroUsize;
use std::sync::Mutex;

use rand::{RngExt, SeedableRng};
use trueaxis_montecarlo::{ChaCha8Rng, Model, Propagation, Settings, Trials, propagate};

/// A model that draws more or less from its stream and leaves its workspace dirty.
struct Uneven;

impl Uneven {
    fn outputs_of(rng: &mut ChaCha8Rng) -> [f64; 3] {
        let draws = rng.random_range(1..40);
        let sum = (0..draws).map(|_| rng.random::<f64>()).sum::<f64>();
        [sum, f64::from(draws), rng.random::<f64>().ln()]
    }
}

impl Model for Uneven {
    type Workspace = [f64; 3];

    fn outputs(&self) -> usize {
        3
    }

    fn workspace(&self) -> [f64; 3] {
        [f64::NAN; 3]
    }

    fn trial(&self, rng: &mut ChaCha8Rng, workspace: &mut [f64; 3], outputs: &mut [f64]) {
        *workspace = Self::outputs_of(rng);
        outputs.copy_from_slice(workspace);
    }
}

fn run(trials: Trials, threads: Option<usize>) -> Propagation {
    let settings = Settings {
        trials,
        seed: 7,
        threads: threads.and_then(NonZeroUsize::new),
        ..Settings::default()
    };
    propagate(&Uneven, &settings, &|_| {}).unwrap()
}

/// Every number of a propagation, as bits.
fn bits(found: &Propagation) -> Vec<u64> {
    let mut numbers = Vec::new();
    for (output, o) in found.outputs.iter().enumerate() {
        numbers.extend([o.mean, o.u, o.symmetric.low, o.symmetric.high]);
        numbers.extend([o.shortest.low, o.shortest.high]);
        numbers.extend([o.scatter.mean, o.scatter.u, o.scatter.low, o.scatter.high]);
        numbers.extend(found.values(output));
    }
    for o in found.stability.iter().flat_map(|s| &s.outputs) {
        numbers.extend([o.tolerance, o.scatter.mean, o.scatter.u]);
        numbers.extend([o.scatter.low, o.scatter.high]);
    }
    numbers.push(found.correlation(0, 1));
    numbers.into_iter().map(f64::to_bits).collect()
}

#[test]
fn number_of_threads_does_not_change_a_bit() {
    // 20 011 is prime: the last chunk is not full.
    let fixed = Trials::Fixed(20_011);
    let adaptive = Trials::Adaptive {
        significant_digits: 1,
        most: 60_000,
    };
    for trials in [fixed, adaptive] {
        let reference = bits(&run(trials, Some(1)));
        for threads in [None, Some(2), Some(3), Some(5)] {
            assert!(bits(&run(trials, threads)) == reference, "{threads:?}");
        }
    }
}

/// The trial's number is its stream: any trial can be repeated alone, and more trials leave those
/// that were made as they are.
#[test]
fn every_trial_has_a_stream_of_its_own() {
    let found = run(Trials::Fixed(1000), None);
    let longer = run(Trials::Fixed(1500), None);
    for output in 0..3 {
        assert_eq!(found.values(output).count(), 1000);
        let alone = (0..1000).map(|trial| {
            let mut rng = ChaCha8Rng::seed_from_u64(7);
            rng.set_stream(trial);
            Uneven::outputs_of(&mut rng)[output].to_bits()
        });
        assert!(found.values(output).map(f64::to_bits).eq(alone));
        let longer = longer.values(output).take(1000);
        assert!(
            found
                .values(output)
                .map(f64::to_bits)
                .eq(longer.map(f64::to_bits))
        );
    }
}

#[test]
fn seed_changes_every_value() {
    let settings = Settings {
        trials: Trials::Fixed(1000),
        seed: 8,
        ..Settings::default()
    };
    let other = propagate(&Uneven, &settings, &|_| {}).unwrap();
    let found = run(Trials::Fixed(1000), None);
    let mut pairs = found.values(2).zip(other.values(2));
    assert!(pairs.all(|(a, b)| a.to_bits() != b.to_bits()));
}

#[test]
fn progress_counts_the_trials() {
    let told = Mutex::new(Vec::new());
    let settings = Settings {
        trials: Trials::Fixed(10_007),
        threads: NonZeroUsize::new(3),
        ..Settings::default()
    };
    propagate(&Uneven, &settings, &|done| told.lock().unwrap().push(done)).unwrap();
    let mut told = told.into_inner().unwrap();
    told.sort_unstable();
    assert_eq!(told.last(), Some(&10_007));
    assert!(told.len() > 20);
    told.dedup();
    assert!(told.len() > 20, "each call brings more");
}

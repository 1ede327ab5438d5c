//! One Monte Carlo trial of a solved network: drawing the errors, solving with them, both; and many
//! trials, each from its own random stream, on one thread and on two.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use trueaxis_benches::network;
use trueaxis_multilateration::{Network, Settings, Trials, Visit, solve};

/// Every length in a visit of its own: none depend on each other.
fn with_single_visits(mut network: Network) -> Network {
    let visits = network.visits.iter().flat_map(|visit| {
        visit.readings.clone().map(|reading| Visit {
            readings: reading..reading + 1,
            ..visit.clone()
        })
    });
    network.visits = visits.collect();
    network
}

fn one_trial(c: &mut Criterion) {
    for (part, draws, solves) in [
        ("draw", true, false),
        ("solve", false, true),
        ("trial", true, true),
    ] {
        let mut group = c.benchmark_group(format!("montecarlo/{part}"));
        group.throughput(Throughput::Elements(1));
        for (visits, network) in [
            ("single-length", with_single_visits(network(195, 1e-3))),
            ("three-length", network(195, 1e-3)),
        ] {
            let solution = solve(&network, &Settings::default()).unwrap();
            let trials = Trials::new(&network, &solution);
            let mut workspace = trials.workspace();
            let mut errors_mm = vec![0.0; trials.readings()];
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            trials.draw(&mut rng, &mut errors_mm);
            group.bench_function(BenchmarkId::new(visits, 195), |b| {
                b.iter(|| {
                    if draws {
                        trials.draw(&mut rng, black_box(&mut errors_mm));
                    }
                    if solves {
                        black_box(trials.solve(black_box(&errors_mm), &mut workspace));
                    }
                });
            });
        }
        group.finish();
    }
}

fn many_trials(c: &mut Criterion) {
    const TRIALS: usize = 4_096;
    let network = with_single_visits(network(195, 1e-3));
    let solution = solve(&network, &Settings::default()).unwrap();
    let trials = Trials::new(&network, &solution);
    let root = ChaCha8Rng::seed_from_u64(1);
    let memory = || (trials.workspace(), vec![0.0; trials.readings()]);
    let mut group = c.benchmark_group("montecarlo/threads");
    group.throughput(Throughput::Elements(TRIALS as u64));
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.unwrap();
        group.bench_function(BenchmarkId::new("single-length", threads), |b| {
            b.iter(|| {
                pool.install(|| {
                    (0..TRIALS).into_par_iter().with_min_len(128).for_each_init(
                        memory,
                        |(workspace, errors_mm), trial| {
                            let mut rng = root.clone();
                            rng.set_stream(trial as u64);
                            trials.draw(&mut rng, errors_mm);
                            black_box(trials.solve(errors_mm, workspace));
                        },
                    );
                });
            });
        });
    }
    group.finish();
}

criterion_group!(benches, one_trial, many_trials);
criterion_main!(benches);

//! One Monte Carlo trial of a solved network, visits correlated: drawing the errors, solving with them, both;
//! and many trials, each from its own random stream, on one thread and on two.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use trueaxis_benches::problem;

const TRIALS: usize = 4_096;

fn trials(c: &mut Criterion) {
    for name in ["P-A", "P-B"] {
        let trials = problem(name).trials();
        let memory = || (trials.workspace(), vec![0.0; trials.errors()]);
        let (mut workspace, mut errors_mm) = memory();
        let root = ChaCha8Rng::seed_from_u64(1);
        let mut rng = root.clone();
        trials.draw(&mut rng, &mut errors_mm);

        let mut group = c.benchmark_group("montecarlo");
        group.throughput(Throughput::Elements(1));
        for (part, draws, solves) in [
            ("draw", true, false),
            ("solve", false, true),
            ("trial", true, true),
        ] {
            group.bench_function(BenchmarkId::new(part, name), |b| {
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
        group.throughput(Throughput::Elements(TRIALS as u64));
        group.sample_size(10);
        for threads in [1, 2] {
            let pool = ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let one = |(workspace, errors_mm): &mut (_, Vec<f64>), trial: usize| {
                let mut rng = root.clone();
                rng.set_stream(trial as u64);
                trials.draw(&mut rng, errors_mm);
                black_box(trials.solve(errors_mm, workspace));
            };
            let all = || {
                (0..TRIALS)
                    .into_par_iter()
                    .with_min_len(128)
                    .for_each_init(memory, one);
            };
            group.bench_function(BenchmarkId::new(format!("{threads} threads"), name), |b| {
                pool.install(|| b.iter(all));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, trials);
criterion_main!(benches);

//! One self-calibrating solve with free points and with rigid stages: from a given start, over the size of the
//! campaign and the number of threads, without and with the covariance of all steps; and from nothing but
//! nominal points.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::ThreadPoolBuilder;
use trueaxis_benches::{Model, SIZES, problem};

fn solve(c: &mut Criterion) {
    for model in Model::ALL {
        let mut group = c.benchmark_group(format!("solve/{}", model.name()));
        group.sample_size(10);
        for (name, stations, steps) in SIZES {
            let problem = problem(name);
            group.throughput(Throughput::Elements((3 * stations * steps) as u64));
            for threads in [1, 2] {
                let pool = ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                let id = |what: &str| BenchmarkId::new(format!("{what}, {threads} threads"), name);
                group.bench_function(id("from a start"), |b| {
                    pool.install(|| b.iter(|| drop(black_box(problem.adjust(model)))));
                });
                group.bench_function(id("with covariance"), |b| {
                    pool.install(|| b.iter(|| problem.adjust(model).covariance()));
                });
                group.bench_function(id("from nothing"), |b| {
                    pool.install(|| b.iter(|| problem.solve(model)));
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, solve);
criterion_main!(benches);

//! One self-calibrating solve, start and covariance included, over the number of points.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use trueaxis_benches::network;
use trueaxis_multilateration::{Settings, solve};

fn one_solve(c: &mut Criterion) {
    let mut group = c.benchmark_group("solve");
    for points in [195, 9_999, 99_999] {
        group.throughput(Throughput::Elements(4 * points as u64));
        if points > 1_000 {
            group.sample_size(10);
        }
        for (noise, return_sigma_mm) in [("independent", 0.0), ("per-stop", 1e-3)] {
            let network = network(points, return_sigma_mm);
            group.bench_with_input(BenchmarkId::new(noise, points), &network, |b, network| {
                b.iter(|| solve(black_box(network), &Settings::default()).unwrap());
            });
        }
    }
    group.finish();
}

criterion_group!(benches, one_solve);
criterion_main!(benches);

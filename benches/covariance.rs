//! The covariance of all that a solve reports, from what the solve leaves, over the number of
//! points.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use trueaxis_benches::network;
use trueaxis_multilateration::{Settings, solve};

fn covariance(c: &mut Criterion) {
    let mut group = c.benchmark_group("covariance");
    for points in [195, 1_950, 19_500] {
        group.throughput(Throughput::Elements(points as u64));
        if points > 1_000 {
            group.sample_size(10);
        }
        for (noise, return_sigma_mm) in [("independent", 0.0), ("per-stop", 1e-3)] {
            let network = network(points, return_sigma_mm);
            let solution = solve(&network, &Settings::default()).unwrap();
            group.bench_function(BenchmarkId::new(noise, points), |b| {
                b.iter(|| {
                    for block in 0..network.groups.len() {
                        black_box(solution.group_covariance(block));
                    }
                    for station in 0..network.stations.len() {
                        black_box(solution.station_covariance(station));
                    }
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, covariance);
criterion_main!(benches);

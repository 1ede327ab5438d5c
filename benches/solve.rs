//! One self-calibrating solve: from a given start, over the size of the network and the number of
//! threads, without and with the covariance of everything; and with the search for a start.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::ThreadPoolBuilder;
use trueaxis_benches::{network, network_from, stations_near};
use trueaxis_multilateration::{Settings, refine, solve};

/// Name, stations, points.
const SIZES: [(&str, usize, usize); 4] = [
    ("A", 4, 195),
    ("B", 4, 1_950),
    ("C", 4, 99_999),
    ("D", 8, 99_999),
];

const NOISES: [(&str, f64); 2] = [("independent", 0.0), ("per-stop", 1e-3)];

/// From where the peers start, stations 5 mm and points 20 µm off, with exact lengths.
fn from_a_start(c: &mut Criterion) {
    for (noise, return_sigma_mm) in NOISES {
        let mut group = c.benchmark_group(format!("refine/{noise}"));
        for (name, stations, points) in SIZES {
            let network = network_from(stations, points, return_sigma_mm);
            let near = stations_near(stations);
            group.throughput(Throughput::Elements((stations * points) as u64));
            if points > 10_000 {
                group.sample_size(10);
            }
            for threads in [1, 2] {
                let pool = ThreadPoolBuilder::new().num_threads(threads);
                let pool = pool.build().unwrap();
                let settings = Settings::default();
                let from_start =
                    || refine(black_box(&network), &near, &network.nominal_mm, &settings).unwrap();
                let id = BenchmarkId::new(name, format!("{threads} threads"));
                group.bench_function(id, |b| {
                    pool.install(|| b.iter(|| black_box(from_start().termination())));
                });
                let id = BenchmarkId::new(name, format!("{threads} threads, with covariance"));
                group.bench_function(id, |b| {
                    pool.install(|| b.iter(|| from_start().solution().unwrap()));
                });
            }
        }
        group.finish();
    }
}

/// Nothing is known but nominal points: what a calibration does.
fn from_nothing(c: &mut Criterion) {
    let mut group = c.benchmark_group("solve");
    for points in [195, 9_999, 99_999] {
        group.throughput(Throughput::Elements(4 * points as u64));
        if points > 1_000 {
            group.sample_size(10);
        }
        for (noise, return_sigma_mm) in NOISES {
            let network = network(points, return_sigma_mm);
            group.bench_with_input(BenchmarkId::new(noise, points), &network, |b, network| {
                b.iter(|| solve(black_box(network), &Settings::default()).unwrap());
            });
        }
    }
    group.finish();
}

criterion_group!(benches, from_a_start, from_nothing);
criterion_main!(benches);

//! Reading and checking a campaign, over the number of lengths.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use trueaxis_benches::{measured, scenario};
use trueaxis_campaign::{read as read_campaign, write};

fn read(c: &mut Criterion) {
    let mut group = c.benchmark_group("csv");
    group.sample_size(10);
    for steps in [65, 650, 6_500, 83_333] {
        let campaign = measured(&scenario(4, steps));
        let folder = tempfile::tempdir().unwrap();
        let path = write(&campaign, folder.path()).unwrap();
        let rows = 12 * steps;
        group.throughput(Throughput::Elements(rows as u64));
        group.bench_function(BenchmarkId::new("read", rows), |b| {
            b.iter(|| read_campaign(black_box(&path)).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, read);
criterion_main!(benches);

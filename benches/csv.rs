//! Reading and checking a campaign, over the number of lengths.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use trueaxis_benches::fxyz;
use trueaxis_campaign::{read as read_campaign, write};
use trueaxis_simulate::{Scenario, simulate};

/// Lengths of one repeat: 65 steps, three targets, four stations.
const PER_REPEAT: u32 = 780;

fn read(c: &mut Criterion) {
    let mut group = c.benchmark_group("csv");
    group.sample_size(10);
    for lengths in [1_000, 10_000, 100_000, 1_000_000_u32] {
        let scenario = Scenario {
            repeats: lengths.div_ceil(PER_REPEAT),
            ..fxyz()
        };
        let campaign = simulate(&scenario, 1).unwrap().campaign;
        let folder = tempfile::tempdir().unwrap();
        let path = write(&campaign, folder.path()).unwrap();
        let rows = campaign.lengths.map_or(0, |lengths| lengths.readings.len());
        group.throughput(Throughput::Elements(rows as u64));
        group.bench_function(BenchmarkId::new("read", rows), |b| {
            b.iter(|| read_campaign(black_box(&path)).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, read);
criterion_main!(benches);

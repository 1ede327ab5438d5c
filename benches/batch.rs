//! Many campaigns of one machine, each with noise of its own, solved one after the other and on
//! all threads.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::prelude::*;
use trueaxis_benches::fxyz;
use trueaxis_multilateration::{Network, Settings, Solution, network_from_campaign, solve};
use trueaxis_simulate::simulate;

/// The network of the campaign that a seed gives.
fn simulated(seed: u64) -> Network {
    let campaign = simulate(&fxyz(), seed).unwrap().campaign;
    let lengths = campaign.lengths.as_ref().unwrap();
    network_from_campaign(&campaign, lengths, false).network
}

fn batch(c: &mut Criterion) {
    let solve = |network: &Network| solve(network, &Settings::default()).unwrap();
    let mut group = c.benchmark_group("batch");
    group.sample_size(10);
    for campaigns in [4, 32] {
        let networks: Vec<Network> = (0..campaigns).map(simulated).collect();
        group.throughput(Throughput::Elements(campaigns));
        group.bench_function(BenchmarkId::new("one thread", campaigns), |b| {
            b.iter(|| -> Vec<Solution> { black_box(&networks).iter().map(solve).collect() });
        });
        group.bench_function(BenchmarkId::new("all threads", campaigns), |b| {
            b.iter(|| -> Vec<Solution> { black_box(&networks).par_iter().map(solve).collect() });
        });
    }
    group.finish();
}

criterion_group!(benches, batch);
criterion_main!(benches);

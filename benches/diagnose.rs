//! The whole catalogue of causes on the shipped campaign of 2,340 lengths: without a cause and with
//! one.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use trueaxis_benches::{fxyz, measured};
use trueaxis_diagnose::{Settings, diagnose as find_causes};
use trueaxis_simulate::Scenario;

/// A target slips in its nest by 8 µm in the middle of the campaign.
const SLIP: &str = r#"[{
    "effect": "target_slip", "subject": { "target": "Q" },
    "parameters": [ { "name": "slip_x", "value": 5, "unit": "um" },
                    { "name": "slip_y", "value": -6, "unit": "um" },
                    { "name": "slip_z", "value": 2, "unit": "um" },
                    { "name": "time", "value": 5000, "unit": "s" } ]
}]"#;

fn diagnose(c: &mut Criterion) {
    let clean = fxyz();
    let slip = Scenario {
        effects: serde_json::from_str(SLIP).unwrap(),
        ..clean.clone()
    };
    let mut group = c.benchmark_group("diagnose");
    group.sample_size(10);
    for (name, scenario) in [("clean", clean), ("one cause", slip)] {
        let campaign = measured(&scenario);
        group.bench_with_input(BenchmarkId::new(name, 2_340), &campaign, |b, campaign| {
            b.iter(|| find_causes(black_box(campaign), &Settings::default()).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, diagnose);
criterion_main!(benches);

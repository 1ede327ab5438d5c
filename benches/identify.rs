//! Six component errors of each step: one shared design (linear axis), and one design per step.
//!
//! A thousand steps stay in the processor's caches; a million come from memory, 72 bytes each for the
//! volumetric errors and 72 for the targets, and 48 go back. How fast that can be at all is seen by
//! copying 48 of each 72 bytes.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_benches::TARGETS_MM;
use trueaxis_identify::{closed_form, nine, nine_closed_form, nine_steps};
use trueaxis_kinematics::MotionError;

fn identify(c: &mut Criterion) {
    let r = TARGETS_MM.map(Vector3::from);
    let mut group = c.benchmark_group("identify");
    group.sample_size(10);
    for steps in [1_000, 1_000_000] {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut micrometres = || Vector3::from_fn(|_, _| (rng.random::<f64>() - 0.5) * 0.02);
        let deltas: Vec<[Vector3<f64>; 3]> = (0..steps)
            .map(|_| [micrometres(), micrometres(), micrometres()])
            .collect();
        // A rotary axis: the targets of every step.
        let turned: Vec<[Vector3<f64>; 3]> = (0..steps)
            .map(|step| Rotation3::from_axis_angle(&Vector3::z_axis(), step as f64 * 1e-5))
            .map(|turn| r.map(|r| turn * r))
            .collect();
        let operator = nine(&r).unwrap();
        let mut errors = vec![MotionError::default(); steps];

        group.throughput(Throughput::Elements(steps as u64));
        group.bench_function(BenchmarkId::new("nine, one design", steps), |b| {
            b.iter(|| {
                let deltas = black_box(&deltas).as_flattened();
                operator.apply_steps(deltas, black_box(&mut errors));
            });
        });
        group.bench_function(BenchmarkId::new("nine, a design per step", steps), |b| {
            b.iter(|| {
                nine_steps(black_box(&turned), &deltas, black_box(&mut errors)).unwrap();
            });
        });
        group.bench_function(BenchmarkId::new("copy of the bytes", steps), |b| {
            b.iter(|| {
                for (delta, error) in black_box(&deltas).iter().zip(black_box(&mut errors)) {
                    *error = MotionError::new(delta[0], delta[2]);
                }
            });
        });
        for (name, of_step) in [
            ("nine, step by step", nine_closed_form as fn(&_, &_) -> _),
            ("six, step by step", closed_form),
        ] {
            group.bench_function(BenchmarkId::new(name, steps), |b| {
                b.iter(|| {
                    let steps = black_box(&turned).iter().zip(&deltas);
                    for ((r, delta), error) in steps.zip(black_box(&mut errors)) {
                        *error = of_step(r, delta).unwrap();
                    }
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, identify);
criterion_main!(benches);

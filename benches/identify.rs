//! A million identifications: one shared design (linear axis), and one design per step.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_benches::TARGETS_MM;
use trueaxis_identify::{Error, closed_form, nine, nine_closed_form};
use trueaxis_kinematics::MotionError;

type OfStep = fn(&[Vector3<f64>; 3], &[Vector3<f64>; 3]) -> Result<MotionError, Error>;

const STEPS: usize = 1_000_000;

fn identify(c: &mut Criterion) {
    let r = TARGETS_MM.map(Vector3::from);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut micrometres = || Vector3::from_fn(|_, _| (rng.random::<f64>() - 0.5) * 0.02);
    let deltas: Vec<[Vector3<f64>; 3]> = (0..STEPS)
        .map(|_| [micrometres(), micrometres(), micrometres()])
        .collect();
    // Folded so that no result can be dropped.
    let sum = |total: MotionError, error: MotionError| {
        MotionError::new(
            total.translation_mm + error.translation_mm,
            total.rotation_rad + error.rotation_rad,
        )
    };

    let mut group = c.benchmark_group("identify");
    group
        .throughput(Throughput::Elements(STEPS as u64))
        .sample_size(10);
    group.bench_function("nine, one design", |b| {
        let operator = nine(&r).unwrap();
        b.iter(|| {
            let errors = black_box(&deltas).iter().map(|delta| operator.apply(delta));
            errors.fold(MotionError::default(), sum)
        });
    });
    // A rotary axis: the targets of every step.
    let turned: Vec<[Vector3<f64>; 3]> = (0..STEPS)
        .map(|step| Rotation3::from_axis_angle(&Vector3::z_axis(), step as f64 * 1e-5))
        .map(|turn| r.map(|r| turn * r))
        .collect();
    for (name, of_step) in [
        ("nine, a design per step", nine_closed_form as OfStep),
        ("six, a design per step", closed_form),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| {
                let steps = black_box(&turned).iter().zip(black_box(&deltas));
                let errors = steps.map(|(r, delta)| of_step(r, delta).unwrap());
                errors.fold(MotionError::default(), sum)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, identify);
criterion_main!(benches);

//! Disturbances that the catalogue does not have: no confident wrong cause.

use std::f64::consts::TAU;

use rand_distr::{Distribution, StandardNormal};

use trueaxis_diagnose::Verdict;

use crate::counts::summary;
use crate::iso_run::{Place, beyond_the_mean_curve, curve_um, places, table, values_um};
use crate::{found, generator, length, report};

const SIGMA_UM: f64 = 0.5;
const LAMBDA: f64 = 20.0;

/// Air conditioning, a scale that breathes with it, and a wandering zero.
fn assert_unknown(seeds: u64) {
    for what in ["air conditioning", "breathing scale", "wandering zero"] {
        let (mut unknown, mut odd) = (0, Vec::new());
        for seed in 0..seeds {
            let mut generator = generator(seed, 6);
            let places = places(5, &[0.0], &[2.0]);
            let mut zero = 0.0;
            let mut form = |p: &Place| {
                let step: f64 = StandardNormal.sample(&mut generator);
                zero += step;
                match what {
                    "air conditioning" => (TAU * p.time_s / 431.0 + seed as f64).sin(),
                    "breathing scale" => p.x_mm * (TAU * p.time_s / 431.0 + seed as f64).sin(),
                    _ => zero,
                }
            };
            let trace: Vec<f64> = places.iter().map(&mut form).collect();
            let size = LAMBDA * SIGMA_UM / length(&beyond_the_mean_curve(&places, &trace));
            let disturbance: Vec<f64> = trace.iter().map(|x| size * x).collect();
            let curve = curve_um(&mut generator);
            let values = values_um(&places, &curve, &disturbance, SIGMA_UM, &mut generator);
            let found = found(table(&places, &values, true));
            if found.verdict == Verdict::Unknown {
                unknown += 1;
            }
            if found.verdict != Verdict::Unknown || !found.causes.is_empty() {
                odd.push(summary(&found));
            }
        }
        let line = format!("{what}: {unknown} of {seeds} unknown; {odd:?}");
        report(&line);
        assert!(10 * unknown >= 9 * seeds, "{line}");
    }
}

#[test]
fn what_is_not_in_the_catalogue_gets_no_name() {
    assert_unknown(1);
}

#[test]
#[ignore = "study: 30 diagnoses"]
fn what_is_not_in_the_catalogue_hardly_ever_gets_a_name() {
    assert_unknown(10);
}

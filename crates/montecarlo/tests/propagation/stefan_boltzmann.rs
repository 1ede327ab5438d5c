//! Stefan–Boltzmann constant from five fundamental constants: NIST Uncertainty Machine user's
//! manual, example 10 (inputs CODATA 2010).

use std::f64::consts::PI;

use trueaxis_montecarlo::{Settings, Trials, propagate};

use crate::comparison::assert_printed;
use crate::model::{gaussian, model_of};

/// So many that the printed digits of u are more than 4 of its standard errors, u/√(2M).
const TRIALS: usize = 350_000;

#[test]
fn constant_with_two_coverage_probabilities() {
    // σ = 32 π⁵ h R⁴ R∞⁴ / (15 A⁴ M⁴ c⁶ α⁸)
    let model = model_of(|rng| {
        let h = gaussian(rng, 6.626_069_57e-34, 0.000_000_29e-34);
        let gas = gaussian(rng, 8.314_462_1, 0.000_007_5);
        let rydberg = gaussian(rng, 10_973_731.568_539, 0.000_055);
        let electron = gaussian(rng, 5.485_799_094_6e-4, 0.000_000_002_2e-4);
        let alpha = gaussian(rng, 7.297_352_569_8e-3, 0.000_000_002_4e-3);
        let numerator = 32.0 * PI.powi(5) * h * gas.powi(4) * rydberg.powi(4);
        let mass = (electron * 1e-3).powi(4);
        [numerator / (15.0 * mass * 299_792_458_f64.powi(6) * alpha.powi(8))]
    });
    for (coverage, low, high) in [
        (0.99, "5.67032e-8", "5.67043e-8"),
        (0.68, "5.67035e-8", "5.67039e-8"),
    ] {
        let settings = Settings {
            trials: Trials::Fixed(TRIALS),
            seed: 10,
            coverage,
            ..Settings::default()
        };
        let found = propagate(&model, &settings, &|_| {}).unwrap().outputs[0];
        assert_printed(found.mean, found.scatter.mean, "5.67037e-8");
        assert_printed(found.u, found.scatter.u, "2.05e-13");
        assert_printed(found.symmetric.low, found.scatter.low, low);
        assert_printed(found.symmetric.high, found.scatter.high, high);
    }
}

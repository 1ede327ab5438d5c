//! GUM H.2: resistance, reactance and impedance from simultaneous voltage, current and phase.

use trueaxis_montecarlo::{FirstOrder, Outcome, Settings, Trials, propagate, validate};

use crate::comparison::{STANDARD_ERRORS, TRIALS, assert_close};
use crate::model::{Gaussian3, model_of};

/// Table H.2: five simultaneous observations of voltage in V, current in A and phase in rad.
const OBSERVED: [[f64; 5]; 3] = [
    [5.007, 4.994, 5.005, 4.990, 4.999],
    [19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3],
    [1.0456, 1.0438, 1.0468, 1.0428, 1.0433],
];

/// R, X and Z.
fn impedance([voltage, current, phase]: [f64; 3]) -> [f64; 3] {
    let impedance = voltage / current;
    [impedance * phase.cos(), impedance * phase.sin(), impedance]
}

/// Means of the observations and the covariance of these means.
fn means_and_covariance() -> ([f64; 3], [[f64; 3]; 3]) {
    let mean = OBSERVED.map(|values| values.iter().sum::<f64>() / 5.0);
    let covariance = [0, 1, 2].map(|i| {
        [0, 1, 2].map(|k| {
            let pairs = OBSERVED[i].iter().zip(&OBSERVED[k]);
            let products = pairs.map(|(a, b)| (a - mean[i]) * (b - mean[k]));
            products.sum::<f64>() / (5.0 * 4.0)
        })
    });
    (mean, covariance)
}

/// Standard uncertainties by the law of propagation, with sensitivities by differences.
fn first_order_u(mean: [f64; 3], covariance: [[f64; 3]; 3]) -> [f64; 3] {
    let sensitivity = [0, 1, 2].map(|k| {
        let step = 1e-6 * mean[k];
        let moved = |sign: f64| {
            let mut quantities = mean;
            quantities[k] += sign * step;
            impedance(quantities)
        };
        let (above, below) = (moved(1.0), moved(-1.0));
        [0, 1, 2].map(|i| (above[i] - below[i]) / (2.0 * step))
    });
    [0, 1, 2].map(|output| {
        let mut variance = 0.0;
        for i in 0..3 {
            for k in 0..3 {
                variance += sensitivity[i][output] * covariance[i][k] * sensitivity[k][output];
            }
        }
        variance.sqrt()
    })
}

#[test]
fn resistance_reactance_and_impedance_with_their_correlations() {
    let (mean, covariance) = means_and_covariance();
    let inputs = Gaussian3::new(mean, covariance);
    let model = model_of(|rng| impedance(inputs.draw(rng)));
    let settings = Settings {
        trials: Trials::Fixed(TRIALS),
        seed: 2,
        ..Settings::default()
    };
    let found = propagate(&model, &settings, &|_| {}).unwrap();

    // Table H.4, in units of its last digit. The observations give u(X) = 0.2956, which is printed as
    // 0.295.
    let printed = [
        (127.732, 0.071, 0.5),
        (219.847, 0.295, 0.7),
        (254.260, 0.236, 0.5),
    ];
    let value = impedance(mean);
    let u = first_order_u(mean, covariance);
    for (output, (printed_value, printed_u, units)) in printed.into_iter().enumerate() {
        let summary = &found.outputs[output];
        assert_close("printed", value[output], printed_value, 0.5e-3);
        assert_close("printed u", u[output], printed_u, units * 1e-3);
        // The model is linear over the uncertainties: first order holds.
        let scatter = summary.scatter;
        let allowed = [scatter.mean, scatter.u].map(|one| STANDARD_ERRORS * one);
        assert_close("mean", summary.mean, value[output], allowed[0]);
        assert_close("u", summary.u, u[output], allowed[1]);
        let first_order = FirstOrder::normal(value[output], u[output], 0.95);
        let validation = validate(&first_order, summary, 1).unwrap();
        assert_eq!(validation.outcome, Outcome::Validated, "{validation:?}");
    }

    for (output, other, printed) in [(0, 1, -0.588), (0, 2, -0.485), (1, 2, 0.993)] {
        let r = found.correlation(output, other);
        // Half of the printed digit and the standard error for normal quantities: that of the
        // first two is 0.0005, so that only their second digit is beyond doubt.
        let scatter = (1.0 - r * r) / (TRIALS as f64).sqrt();
        assert_close("correlation", r, printed, 0.0005 + 4.0 * scatter);
        assert_close("symmetry", found.correlation(other, output), r, 1e-12);
    }
    assert_close("own correlation", found.correlation(1, 1), 1.0, 1e-12);
}

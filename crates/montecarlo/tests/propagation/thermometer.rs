//! GUM H.3: calibration of a thermometer by a straight line; every trial draws readings and solves.

use trueaxis_montecarlo::{ChaCha8Rng, FirstOrder, Model, Outcome, Settings, propagate, validate};

use crate::comparison::assert_printed;
use crate::model::gaussian;

/// Table H.6: readings and corrections, °C.
const READINGS: [f64; 11] = [
    21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511,
];
const CORRECTIONS: [f64; 11] = [
    -0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160,
];

/// Intercept at 20 °C and slope of the least-squares line.
fn line(corrections: &[f64]) -> [f64; 2] {
    let count = READINGS.len() as f64;
    let mean_t = READINGS.iter().sum::<f64>() / count;
    let mean_b = corrections.iter().sum::<f64>() / count;
    let pairs = READINGS.iter().zip(corrections);
    let product: f64 = pairs.map(|(t, b)| (t - mean_t) * (b - mean_b)).sum();
    let square: f64 = READINGS.iter().map(|t| (t - mean_t).powi(2)).sum();
    let slope = product / square;
    [mean_b - slope * (mean_t - 20.0), slope]
}

/// Readings scatter by `s` about the fitted line.
struct Calibration {
    fitted: [f64; 2],
    s: f64,
}

impl Model for Calibration {
    type Workspace = Vec<f64>;

    fn outputs(&self) -> usize {
        3
    }

    fn workspace(&self) -> Vec<f64> {
        vec![0.0; READINGS.len()]
    }

    fn trial(&self, rng: &mut ChaCha8Rng, corrections: &mut Vec<f64>, outputs: &mut [f64]) {
        let [y1, y2] = self.fitted;
        for (correction, t) in corrections.iter_mut().zip(READINGS) {
            *correction = gaussian(rng, y1 + y2 * (t - 20.0), self.s);
        }
        let [y1, y2] = line(corrections);
        outputs.copy_from_slice(&[y1, y2, y1 + 10.0 * y2]);
    }
}

#[test]
fn intercept_slope_and_predicted_correction() {
    let fitted = line(&CORRECTIONS);
    let residuals = READINGS.iter().zip(CORRECTIONS);
    let squares: f64 = residuals
        .map(|(t, b)| (b - fitted[0] - fitted[1] * (t - 20.0)).powi(2))
        .sum();
    let s = (squares / 9.0).sqrt();
    assert_eq!(format!("{s:.4}"), "0.0035");

    let calibration = Calibration { fitted, s };
    let settings = Settings {
        seed: 3,
        ..Settings::default()
    };
    let found = propagate(&calibration, &settings, &|_| {}).unwrap();
    let printed = [
        ("-0.1712", "0.0029"),
        ("0.00218", "0.00067"),
        ("-0.1494", "0.0041"),
    ];
    for (summary, (value, u)) in found.outputs.iter().zip(printed) {
        assert_printed(summary.mean, summary.scatter.mean, value);
        assert_printed(summary.u, summary.scatter.u, u);
        let (value, u) = (value.parse().unwrap(), u.parse().unwrap());
        let validation = validate(&FirstOrder::normal(value, u, 0.95), summary, 1).unwrap();
        assert_eq!(validation.outcome, Outcome::Validated, "{validation:?}");
    }
    // The printed -0.930 needs 10⁶ trials; of 10⁵, the standard error is 0.0004.
    let r = found.correlation(0, 1);
    assert!((r + 0.930).abs() < 0.0005 + 4.0 * 0.000_43, "{r}");
}

//! The 27 models of NIST's nonlinear regression sets with their derivatives.
//!
//! Unknowns are `b[0]`, `b[1]`, … for NIST's b1, b2, …

use std::f64::consts::PI;

use nalgebra::DMatrix;
use trueaxis_leastsquares::dense::Model;

use crate::strd_file::{Row, Set};

/// Value of a model at the predictors `x` and its derivatives by the unknowns `b`.
type Function = fn(x: &[f64], b: &[f64]) -> (f64, Vec<f64>);

/// Every set with its model, in NIST's order of difficulty: lower, average, higher.
pub(crate) const MODELS: [(&str, Function); 27] = [
    ("Misra1a", saturation),
    ("Chwirut2", chwirut),
    ("Chwirut1", chwirut),
    ("Lanczos3", three_decays),
    ("Gauss1", two_peaks_on_a_decay),
    ("Gauss2", two_peaks_on_a_decay),
    ("DanWood", dan_wood),
    ("Misra1b", misra1b),
    ("Kirby2", kirby2),
    ("Hahn1", cubic_by_cubic),
    ("Nelson", nelson),
    ("MGH17", mgh17),
    ("Lanczos1", three_decays),
    ("Lanczos2", three_decays),
    ("Gauss3", two_peaks_on_a_decay),
    ("Misra1c", misra1c),
    ("Misra1d", misra1d),
    ("Roszman1", roszman1),
    ("ENSO", enso),
    ("MGH09", mgh09),
    ("Thurber", cubic_by_cubic),
    ("BoxBOD", saturation),
    ("Rat42", rat42),
    ("MGH10", mgh10),
    ("Eckerle4", eckerle4),
    ("Rat43", rat43),
    ("Bennett5", bennett5),
];

/// Model less data.
pub(crate) struct Regression {
    pub(crate) set: Set,
    pub(crate) function: Function,
}

impl Model for Regression {
    fn residuals(&self, unknowns: &[f64]) -> Vec<f64> {
        let residual = |row: &Row| {
            let (value, _) = (self.function)(&row.predictors, unknowns);
            value - self.response(row)
        };
        self.set.rows.iter().map(residual).collect()
    }

    fn jacobian(&self, unknowns: &[f64]) -> DMatrix<f64> {
        let rows: Vec<Vec<f64>> = self
            .set
            .rows
            .iter()
            .map(|row| (self.function)(&row.predictors, unknowns).1)
            .collect();
        DMatrix::from_fn(rows.len(), unknowns.len(), |i, j| rows[i][j])
    }
}

impl Regression {
    /// Nelson's model is of the logarithm of the response.
    fn response(&self, row: &Row) -> f64 {
        if self.set.name == "Nelson" {
            row.response.ln()
        } else {
            row.response
        }
    }
}

/// b1 (1 - exp(-b2 x))
fn saturation(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let (decay, rise) = ((-b[1] * x[0]).exp(), -(-b[1] * x[0]).exp_m1());
    (b[0] * rise, vec![rise, b[0] * x[0] * decay])
}

/// exp(-b1 x) / (b2 + b3 x)
fn chwirut(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let line = b[1] + b[2] * x;
    let value = (-b[0] * x).exp() / line;
    (value, vec![-x * value, -value / line, -x * value / line])
}

/// b1 exp(-b2 x) + b3 exp(-b4 x) + b5 exp(-b6 x)
fn three_decays(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let mut value = 0.0;
    let mut slopes = Vec::with_capacity(6);
    for pair in b.chunks_exact(2) {
        let decay = (-pair[1] * x[0]).exp();
        value += pair[0] * decay;
        slopes.extend([decay, -x[0] * pair[0] * decay]);
    }
    (value, slopes)
}

/// b1 exp(-b2 x) + b3 exp(-(x - b4)²/b5²) + b6 exp(-(x - b7)²/b8²)
fn two_peaks_on_a_decay(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let decay = (-b[1] * x).exp();
    let mut value = b[0] * decay;
    let mut slopes = vec![decay, -x * b[0] * decay];
    for peak in b[2..].chunks_exact(3) {
        let t = (x - peak[1]) / peak[2];
        let bell = (-t * t).exp();
        value += peak[0] * bell;
        let steep = 2.0 * peak[0] * bell * t / peak[2];
        slopes.extend([bell, steep, steep * t]);
    }
    (value, slopes)
}

/// b1 x^b2
fn dan_wood(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let power = x[0].powf(b[1]);
    (b[0] * power, vec![power, b[0] * power * x[0].ln()])
}

/// b1 (1 - (1 + b2 x/2)⁻²)
fn misra1b(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let base = 1.0 + b[1] * x / 2.0;
    let rise = 1.0 - base.powi(-2);
    (b[0] * rise, vec![rise, b[0] * x * base.powi(-3)])
}

/// b1 (1 - (1 + 2 b2 x)^(-1/2))
fn misra1c(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let base = 1.0 + 2.0 * b[1] * x;
    let rise = 1.0 - base.powf(-0.5);
    (b[0] * rise, vec![rise, b[0] * x * base.powf(-1.5)])
}

/// b1 b2 x / (1 + b2 x)
fn misra1d(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let base = 1.0 + b[1] * x;
    let rise = b[1] * x / base;
    (b[0] * rise, vec![rise, b[0] * x / (base * base)])
}

/// (b1 + b2 x + b3 x²) / (1 + b4 x + b5 x²)
fn kirby2(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    rational(x[0], &b[..3], &b[3..])
}

/// (b1 + b2 x + b3 x² + b4 x³) / (1 + b5 x + b6 x² + b7 x³)
fn cubic_by_cubic(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    rational(x[0], &b[..4], &b[4..])
}

/// Polynomial by polynomial that is one at zero; rising powers.
fn rational(x: f64, above: &[f64], below: &[f64]) -> (f64, Vec<f64>) {
    let horner = |c: &[f64]| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let below_value = 1.0 + x * horner(below);
    let value = horner(above) / below_value;
    let power = |k: usize| (0..k).fold(1.0, |power, _| power * x);
    let slopes = (0..above.len())
        .map(|k| power(k) / below_value)
        .chain((1..=below.len()).map(|k| -power(k) * value / below_value))
        .collect();
    (value, slopes)
}

/// b1 - b2 x1 exp(-b3 x2)
fn nelson(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let part = x[0] * (-b[2] * x[1]).exp();
    (b[0] - b[1] * part, vec![1.0, -part, b[1] * x[1] * part])
}

/// b1 + b2 exp(-x b4) + b3 exp(-x b5)
fn mgh17(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let (first, second) = ((-x * b[3]).exp(), (-x * b[4]).exp());
    (
        b[0] + b[1] * first + b[2] * second,
        vec![1.0, first, second, -x * b[1] * first, -x * b[2] * second],
    )
}

/// b1 - b2 x - arctan(b3/(x - b4))/π
fn roszman1(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let away = x - b[3];
    let below = PI * (away * away + b[2] * b[2]);
    (
        b[0] - b[1] * x - (b[2] / away).atan() / PI,
        vec![1.0, -x, -away / below, -b[2] / below],
    )
}

/// b1 + three waves: 12 months, b4, b7
fn enso(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let turn = 2.0 * PI * x[0];
    let wave = |c: f64, s: f64, period: f64| {
        let (sin, cos) = (turn / period).sin_cos();
        let by_period = (c * sin - s * cos) * turn / (period * period);
        (c * cos + s * sin, cos, sin, by_period)
    };
    let (year, cos1, sin1, _) = wave(b[1], b[2], 12.0);
    let (second, cos2, sin2, by_b4) = wave(b[4], b[5], b[3]);
    let (third, cos3, sin3, by_b7) = wave(b[7], b[8], b[6]);
    (
        b[0] + year + second + third,
        vec![1.0, cos1, sin1, by_b4, cos2, sin2, by_b7, cos3, sin3],
    )
}

/// b1 (x² + x b2) / (x² + x b3 + b4)
fn mgh09(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let (above, below) = (x * x + x * b[1], x * x + x * b[2] + b[3]);
    let value = b[0] * above / below;
    (
        value,
        vec![
            above / below,
            b[0] * x / below,
            -x * value / below,
            -value / below,
        ],
    )
}

/// b1 / (1 + exp(b2 - b3 x))
fn rat42(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let growth = (b[1] - b[2] * x).exp();
    let value = b[0] / (1.0 + growth);
    let steep = value * growth / (1.0 + growth);
    (value, vec![1.0 / (1.0 + growth), -steep, x * steep])
}

/// b1 / (1 + exp(b2 - b3 x))^(1/b4)
fn rat43(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let x = x[0];
    let growth = (b[1] - b[2] * x).exp();
    let root = (1.0 + growth).powf(-1.0 / b[3]);
    let value = b[0] * root;
    let steep = value * growth / (b[3] * (1.0 + growth));
    (
        value,
        vec![
            root,
            -steep,
            x * steep,
            value * growth.ln_1p() / (b[3] * b[3]),
        ],
    )
}

/// b1 exp(b2/(x + b3))
fn mgh10(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let sum = x[0] + b[2];
    let power = (b[1] / sum).exp();
    let value = b[0] * power;
    (value, vec![power, value / sum, -value * b[1] / (sum * sum)])
}

/// (b1/b2) exp(-((x - b3)/b2)²/2)
fn eckerle4(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let t = (x[0] - b[2]) / b[1];
    let bell = (-0.5 * t * t).exp() / b[1];
    let value = b[0] * bell;
    (
        value,
        vec![bell, value * (t * t - 1.0) / b[1], value * t / b[1]],
    )
}

/// b1 (b2 + x)^(-1/b3)
fn bennett5(x: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let sum = b[1] + x[0];
    let power = sum.powf(-1.0 / b[2]);
    let value = b[0] * power;
    (
        value,
        vec![
            power,
            -value / (b[2] * sum),
            value * sum.ln() / (b[2] * b[2]),
        ],
    )
}

//! The form of an unknown course, in functions of its argument.

use std::f64::consts::TAU;

use trueaxis_leastsquares::{half_waves, matern_roots};

/// Standard deviation of the change between two passes without a clock, in standard deviations of the smooth course.
const BETWEEN_PASSES: f64 = 0.5;

/// How a course proceeds over its argument from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Form {
    /// Matérn's process with this correlation length, and where it goes on in pauses of unknown duration.
    Smooth { length: f64, pauses: Pauses },
    /// `a sin 2πx/T + b cos 2πx/T` with this period. As a smooth process it would pay for every other course as quick
    /// as it, and what repeats in nearly the time of a cycle would look simpler as an error of the axis.
    Swing(f64),
}

impl Form {
    /// Correlation length, as a share of the range; after a quarter of a period nothing is alike.
    pub(crate) fn length(self) -> f64 {
        match self {
            Self::Smooth { length, .. } => length,
            Self::Swing(period) => 0.25 * period,
        }
    }
}

/// Where a course goes on without readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pauses {
    Nowhere,
    /// Between two cycles, or where an instrument was set to zero for the next one; the axis turned without a pause.
    BetweenCycles,
    BetweenPasses,
}

/// The functions that make up the course of each coordinate.
pub(crate) struct Functions {
    pub(crate) form: Form,
    pub(crate) waves: u32,
    /// Number of passes, and of cycles of more than one pass, that may have offsets.
    pub(crate) parts: [usize; 2],
}

impl Functions {
    /// Factors of the coefficients at an argument: `cos(πx), cos(2πx), ...`, or sine and cosine of a swing less their
    /// means, and where pauses are unknown one for the pass and one for the cycle.
    pub(crate) fn at(&self, x: f64, part: [usize; 2]) -> Vec<f64> {
        let mut all: Vec<f64> = match self.form {
            Form::Smooth { .. } => half_waves(x, self.waves).collect(),
            Form::Swing(period) => {
                let turn = TAU / period;
                let (sine, cosine) = (turn * x).sin_cos();
                vec![sine - (1.0 - turn.cos()) / turn, cosine - turn.sin() / turn]
            }
        };
        for (count, own) in self.parts.into_iter().zip(part) {
            all.extend((0..count).map(|k| f64::from(u8::from(k == own))));
        }
        all
    }

    /// Standard deviations of the coefficients; `S_k^½` for the waves.
    pub(crate) fn roots(&self) -> Vec<f64> {
        let (mut roots, pauses) = match self.form {
            Form::Smooth { length, pauses } => {
                (matern_roots(length, self.waves)[1..].to_vec(), pauses)
            }
            Form::Swing(_) => (vec![1.0; 2], Pauses::Nowhere),
        };
        let of_parts = [Pauses::BetweenPasses, Pauses::BetweenCycles];
        for (count, own) in self.parts.into_iter().zip(of_parts) {
            let root = if own == pauses { BETWEEN_PASSES } else { 0.0 };
            roots.extend(std::iter::repeat_n(root, count));
        }
        roots
    }
}

//! The functions that make up an unknown course while readings are taken.

use std::f64::consts::TAU;

use trueaxis_leastsquares::{half_waves, matern_roots};

use crate::engine::disturbance::{Form, Pauses};

/// Standard deviation of the change between two passes without a clock, in standard deviations of the smooth course.
const BETWEEN_PASSES: f64 = 0.5;

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
        let mut all: Vec<f64> = match self.form.period() {
            None => half_waves(x, self.waves).collect(),
            Some(period) => {
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
        let mut roots = match self.form.swings {
            false => matern_roots(self.form.length, self.waves)[1..].to_vec(),
            true => vec![1.0; 2],
        };
        let of_parts = [Pauses::BetweenPasses, Pauses::BetweenCycles];
        for (count, own) in self.parts.into_iter().zip(of_parts) {
            let root = if own == self.form.pauses {
                BETWEEN_PASSES
            } else {
                0.0
            };
            roots.extend(std::iter::repeat_n(root, count));
        }
        roots
    }
}

//! Readings that another sign or unit, or the compensation, would bring to the prediction.

use trueaxis_leastsquares::median;

use crate::{Point, Verified};

/// What may be mistaken about readings that contradict a prediction, or that agree with it only because their declared
/// uncertainty is large or missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistaken {
    /// They are commanded less measured.
    Sign,
    /// They are a thousand times too large, as those in nm are.
    TooLarge,
    /// They are a thousand times too small, as those in mm are.
    TooSmall,
    /// The compensation was on, and they are compared without it.
    WithCompensation,
    /// The compensation was off, and they are compared with it.
    WithoutCompensation,
}

/// Readings, at least: fewer agree with something by chance.
const LEAST_POINTS: usize = 6;

/// Part of the differences that are left, at most, where a mistake explains them.
const LEFT: f64 = 0.25;

impl Mistaken {
    /// As a question.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Sign => {
                "with the opposite sign they would agree: are they commanded less measured?"
            }
            Self::TooLarge => "a thousandth of them would agree: are they in nm?",
            Self::TooSmall => "a thousand times as large they would agree: are they in mm?",
            Self::WithCompensation => {
                "they agree with the prediction for a compensated machine: was the compensation on (--compensated)?"
            }
            Self::WithoutCompensation => {
                "they agree with the prediction without compensation: was it off (no --compensated)?"
            }
        }
    }
}

/// How much farther off a single place is than most, in their standard deviations and than any other.
const FAR_OFF: f64 = 15.0;
const FARTHER: f64 = 3.0;

/// Standard deviation of normal values over their median amount.
const OF_MEDIAN: f64 = 1.4826;

/// Part of the declared standard uncertainty within which readings in µm never agree with anything.
const FAR_BELOW: f64 = 0.01;

impl Verified {
    /// The one place whose difference from the prediction is far from that of all others, with how far, µm: a mistyped
    /// reading, which shifts all others with the zero.
    pub fn far_off(&self, is_compensated: bool) -> Option<(&Point, f64)> {
        let left = self.points.iter();
        let left: Vec<f64> = left
            .map(|p| p.reading_um - p.expected_um(is_compensated))
            .collect();
        let middle = median(&mut left.clone())?;
        let mut off: Vec<(&Point, f64)> = self
            .points
            .iter()
            .zip(left.iter().map(|x| x - middle))
            .collect();
        off.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let spread = median(&mut off.iter().map(|(_, um)| um.abs()).collect::<Vec<f64>>())?;
        let [first, second, ..] = off.as_slice() else {
            return None;
        };
        let um = first.1.abs();
        let is_far = um > FAR_OFF * OF_MEDIAN * spread && um > FARTHER * second.1.abs();
        (off.len() >= LEAST_POINTS && is_far).then_some(*first)
    }

    /// What would leave no more than a quarter of the differences; `is_compensated` as in [`crate::verify()`]. Readings in mm
    /// are so small that they agree with a compensated machine: a thousandth of the prediction without it reveals them.
    pub fn mistaken(&self, is_compensated: bool) -> Option<Mistaken> {
        if self.points.len() < LEAST_POINTS {
            return None;
        }
        let rms = |left: &dyn Fn(&Point) -> f64| {
            let squares: f64 = self.points.iter().map(|point| left(point).powi(2)).sum();
            (squares / self.points.len().max(1) as f64).sqrt()
        };
        let left = |factor: f64, is_compensated: bool| {
            rms(&|p| factor * p.reading_um - p.expected_um(is_compensated))
        };
        // A thousandth of anything is next to nothing: it must be what is predicted, too.
        let is_explained = |factor: f64, is_compensated: bool| {
            left(factor, is_compensated) < LEFT * rms(&|p| p.expected_um(is_compensated))
        };
        let own = left(1.0, is_compensated);
        let declared = rms(&|p| p.u_reading_um.unwrap_or(0.0));
        if own < FAR_BELOW * declared || is_explained(1e3, false) {
            return Some(Mistaken::TooSmall);
        }
        let compensation = match is_compensated {
            true => Mistaken::WithoutCompensation,
            false => Mistaken::WithCompensation,
        };
        let all = [
            (Mistaken::Sign, -1.0, is_compensated),
            (Mistaken::TooLarge, 1e-3, is_compensated),
            (Mistaken::TooSmall, 1e3, is_compensated),
            (compensation, 1.0, !is_compensated),
        ];
        let found = all.into_iter().find(|&(mistaken, factor, with)| {
            left(factor, with) < LEFT * own
                && (mistaken == compensation || is_explained(factor, with))
        });
        found.map(|(mistaken, ..)| mistaken)
    }
}

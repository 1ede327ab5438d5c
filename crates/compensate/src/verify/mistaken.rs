//! Readings that another sign or unit, or the compensation, would bring to the prediction.

use crate::{Point, Verified};

/// What may be mistaken about readings that contradict a prediction.
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

impl Verified {
    /// What would leave no more than a quarter of the differences, if anything does and they do not agree; `is_compensated` as in [`crate::verify()`].
    pub fn mistaken(&self, is_compensated: bool) -> Option<Mistaken> {
        let agrees = self.p_value.is_some() && !self.is_misfit();
        if agrees || self.points.len() < LEAST_POINTS {
            return None;
        }
        let rms = |left: &dyn Fn(&Point) -> f64| {
            let squares: f64 = self.points.iter().map(|point| left(point).powi(2)).sum();
            (squares / self.points.len().max(1) as f64).sqrt()
        };
        let compensated = |is_compensated: bool| {
            move |point: &Point| match is_compensated {
                true => point.compensated_um,
                false => point.predicted_um,
            }
        };
        let predicted = compensated(is_compensated);
        let other = compensated(!is_compensated);
        let compensation = match is_compensated {
            true => Mistaken::WithoutCompensation,
            false => Mistaken::WithCompensation,
        };
        let scaled = |factor: f64| rms(&|p| factor * p.reading_um - predicted(p));
        let own = scaled(1.0);
        let all = [
            (compensation, rms(&|p| p.reading_um - other(p))),
            (Mistaken::Sign, scaled(-1.0)),
            (Mistaken::TooLarge, scaled(1e-3)),
            (Mistaken::TooSmall, scaled(1e3)),
        ];
        // A thousandth of anything is next to nothing: it must be what is predicted, too.
        let is_of_prediction = |(mistaken, left): &(Mistaken, f64)| {
            *mistaken == compensation || *left < LEFT * rms(&|p| predicted(p))
        };
        let best = all.into_iter().filter(is_of_prediction);
        let best = best.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (best.1 < LEFT * own).then_some(best.0)
    }
}

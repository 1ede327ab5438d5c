//! The search: each mistake is undone, and what is left is calibrated.

use rayon::prelude::*;
use trueaxis_campaign::{Campaign, Stop};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_poses::AdjustmentReport;

use crate::mistake::{Mistake, What};
use crate::offsets::measured;
use crate::scope::{Scope, thinned, with_lengths};
use crate::suspects::{LeftOut, suspects};

/// Standard deviation of unit weight up to which lengths fit, if their noise is declared; the residuals up to
/// which they do otherwise, mm.
const FITTING_SIGMA0: f64 = 3.0;
const FITTING_MM: f64 = 20.0 * MICROMETRE;

/// Share of the lengths that may be accidents beside a mistake.
pub const MOST_ACCIDENTS: f64 = 0.01;

/// Undoing what explains a contradiction leaves less than this of the residuals: half of their squares.
const EXPLAINED: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Residuals within this ratio of the best fit as well.
const ALIKE: f64 = 1.5;

/// Explanations that are named.
const MOST_NAMED: usize = 3;

/// The lengths (mm) that a calibration predicts to a target at stops of its campaign; `None` if it does not know where the
/// target is.
pub type PredictedLengths = dyn Fn(&Campaign, usize, &[&Stop]) -> Option<Vec<f64>> + Send;

/// A calibration, as far as the search looks at it.
pub struct Trial {
    /// What the measurement says about itself.
    pub adjustment: AdjustmentReport,
    /// Whether its errors, and the places of its targets, are those of a machine.
    pub is_plausible: bool,
    /// What it predicts.
    pub lengths_mm: Box<PredictedLengths>,
}

/// A campaign that does not yield a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// Its data contradict each other or the machine, as after a mistake.
    Contradiction,
    /// It does not determine what is sought, or for another reason.
    Other,
}

/// The search for mistakes in a campaign.
pub struct Mistakes<'a> {
    /// The campaign.
    pub campaign: &'a Campaign,
    /// Whether gross errors are removed before a calibration.
    pub robust: bool,
    /// How a campaign is calibrated, with gross errors removed or not.
    pub calibrate: &'a (dyn Fn(&Campaign, bool) -> Result<Trial, Refused> + Sync),
}

impl Mistakes<'_> {
    /// A text about the mistakes that would explain data that contradict each other: where they were made, and what to
    /// change. `None` if none does.
    pub fn explanation(&self) -> Option<String> {
        self.campaign.lengths.as_ref()?;
        self.explanation_within(&Scope::default())
    }

    /// A text about what would explain the lengths of a part of the measurement.
    pub(crate) fn explanation_within(&self, within: &Scope) -> Option<String> {
        let fits = self.explanations(within);
        let words = fits.iter().map(|mistake| mistake.in_words(self.campaign));
        let words: Vec<String> = words.collect();
        (!words.is_empty()).then(|| words.join("; or "))
    }

    /// The mistakes after which the campaign fits, the best first: of those made in the largest part. None if the
    /// campaign fits already with fewer steps: then only lengths at the others are wrong, and no part as a whole.
    fn explanations(&self, within: &Scope) -> Vec<Mistake> {
        let small = thinned(self.campaign);
        let as_it_is = (self.calibrate)(&small, false);
        if *within == Scope::default() && as_it_is.as_ref().is_ok_and(Trial::fits) {
            return Vec::new();
        }
        let most_mm = as_it_is.map_or(f64::INFINITY, |found| EXPLAINED * found.rms_mm());
        let without = |scope: Scope| {
            let rest = with_lengths(&small, |stop, _| !scope.holds(&small, stop));
            match (self.calibrate)(&rest, false) {
                Err(Refused::Contradiction) => LeftOut::Contradicts,
                Err(Refused::Other) => LeftOut::Open,
                Ok(_) if self.good(&rest, most_mm).is_some() => LeftOut::Fits,
                Ok(_) => LeftOut::Contradicts,
            }
        };
        let tried = |suspects: Vec<Mistake>| -> Vec<(f64, Mistake)> {
            let suspects = suspects.into_par_iter();
            suspects
                .filter_map(|m| self.tried(&small, m, most_mm))
                .collect()
        };
        let by_size = suspects(&small, within, without).into_iter();
        let fits = by_size.map(tried).find(|fits| !fits.is_empty());
        let mut fits = fits.unwrap_or_default();
        // Stable: of equal ones the first.
        fits.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least_mm = fits.first().map_or(0.0, |(residual_mm, _)| *residual_mm);
        fits.retain(|(residual_mm, _)| *residual_mm <= ALIKE * least_mm);
        fits.truncate(MOST_NAMED);
        fits.into_iter().map(|(_, mistake)| mistake).collect()
    }

    /// A mistake with the residuals that are left when it is undone, mm; `None` if the campaign does not fit then.
    fn tried(
        &self,
        campaign: &Campaign,
        mut mistake: Mistake,
        most_mm: f64,
    ) -> Option<(f64, Mistake)> {
        if let What::Offset { target, .. } = mistake.what {
            let others = with_lengths(campaign, |stop, reading| {
                reading.target != target || !mistake.scope.holds(campaign, stop)
            });
            mistake.what = measured(
                campaign,
                &self.good(&others, most_mm)?,
                target,
                &mistake.scope,
            )?;
        }
        let trial = self.good(&mistake.undone(campaign), most_mm)?;
        Some((trial.adjustment.rms_residual_mm, mistake))
    }

    /// The calibration of a campaign, if nothing is left that a mistake would explain. Screening takes long where
    /// everything contradicts everything: it is only for what fits almost, with residuals below `most_mm`.
    fn good(&self, campaign: &Campaign, most_mm: f64) -> Option<Trial> {
        let mut trial = (self.calibrate)(campaign, false).ok()?;
        if self.robust && !trial.fits() && trial.rms_mm() < most_mm {
            trial = (self.calibrate)(campaign, true).ok()?;
        }
        let adjustment = &trial.adjustment;
        let accidents = adjustment.rejected.len() as f64;
        let few = accidents <= MOST_ACCIDENTS * (adjustment.observations as f64 + accidents);
        (trial.fits() && few && trial.is_plausible).then_some(trial)
    }
}

impl Trial {
    fn rms_mm(&self) -> f64 {
        self.adjustment.rms_residual_mm
    }

    /// Whether the residuals are noise, more or less.
    fn fits(&self) -> bool {
        let adjustment = &self.adjustment;
        match adjustment.noise_declared {
            true => adjustment.sigma0 < FITTING_SIGMA0,
            false => adjustment.rms_residual_mm < FITTING_MM,
        }
    }
}

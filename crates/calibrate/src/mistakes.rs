//! What people do wrong: for data that contradict each other, the mistakes that would explain it.
//!
//! Each [`mistake`] is undone in a copy of the campaign and that copy is calibrated ([`suspects()`] has all that are
//! tried; long runs are [`thinned()`]). One after which the lengths fit, nothing but single lengths is removed, and the
//! axes move as commanded, is named in the error with where it was made and what to change. Mistakes that fit
//! alike are all named. A prism constant is of any size: the lengths to one target are left out, and it is their
//! mean difference from what the others predict ([`offsets`]).

mod lost_sweeps;
mod mistake;
mod offsets;
mod scope;
mod suspects;

use rayon::prelude::*;
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::MICROMETRE;

use crate::mistakes::mistake::{Mistake, What};
use crate::mistakes::offsets::measured;
use crate::mistakes::scope::{Scope, thinned, with_lengths};
use crate::mistakes::suspects::{LeftOut, suspects};
use crate::report::nominal_positions::targets_elsewhere;
use crate::report::notices::is_absurd;
use crate::result::calibration::Calibration;
use crate::{Error, Settings};

/// Standard deviation of unit weight up to which lengths fit, if their noise is declared; the residuals up to
/// which they do otherwise, mm.
const FITTING_SIGMA0: f64 = 3.0;
const FITTING_MM: f64 = 20.0 * MICROMETRE;

/// Share of the lengths that may be accidents beside a mistake.
const ACCIDENTS: f64 = 0.01;

/// Residuals within this ratio of the best fit as well.
const ALIKE: f64 = 1.5;

/// Explanations that are named.
const MOST_NAMED: usize = 3;

/// How a campaign is calibrated.
type Calibrate<'a> = dyn Fn(&Campaign, &Settings) -> Result<Calibration, Error> + Sync + 'a;

/// The search for mistakes in a campaign.
pub(crate) struct Mistakes<'a> {
    campaign: &'a Campaign,
    settings: Settings,
    calibrate: &'a Calibrate<'a>,
}

impl<'a> Mistakes<'a> {
    pub(crate) fn new(
        campaign: &'a Campaign,
        settings: &Settings,
        calibrate: &'a Calibrate<'a>,
    ) -> Self {
        let settings = Settings {
            covariance: false,
            ..*settings
        };
        Self {
            campaign,
            settings,
            calibrate,
        }
    }

    /// The same error with the mistakes that would explain it, if there are any; other errors as they are.
    pub(crate) fn explained(&self, error: Error) -> Error {
        if self.campaign.lengths.is_none() || !error.is_contradiction() {
            return error;
        }
        match self.explanation_within(&Scope::default()) {
            None => error,
            Some(explanation) => Error::Mistaken {
                error: Box::new(error),
                explanation,
            },
        }
    }

    /// What would explain the lengths of a part of the measurement, in words.
    fn explanation_within(&self, within: &Scope) -> Option<String> {
        let fits = self.explanations(within);
        let words = fits.iter().map(|mistake| mistake.in_words(self.campaign));
        let words: Vec<String> = words.collect();
        (!words.is_empty()).then(|| words.join("; or "))
    }

    /// The mistakes after which the campaign fits, the best first: of those made in the largest part. None if the
    /// campaign fits already with fewer steps: then only lengths at the others are wrong, and no part as a whole.
    fn explanations(&self, within: &Scope) -> Vec<Mistake> {
        let small = thinned(self.campaign);
        let as_it_is = || (self.calibrate)(&small, &self.as_it_is());
        if *within == Scope::default() && as_it_is().is_ok_and(|found| Self::fits(&found)) {
            return Vec::new();
        }
        let without = |scope: Scope| {
            let rest = with_lengths(&small, |stop, _| !scope.holds(&small, stop));
            match (self.calibrate)(&rest, &self.as_it_is()) {
                Err(error) if error.is_contradiction() => LeftOut::Contradicts,
                Err(_) => LeftOut::Open,
                Ok(_) if self.good(&rest).is_some() => LeftOut::Fits,
                Ok(_) => LeftOut::Contradicts,
            }
        };
        let tried = |suspects: Vec<Mistake>| -> Vec<(f64, Mistake)> {
            let suspects = suspects.into_par_iter();
            suspects.filter_map(|m| self.tried(&small, m)).collect()
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
    fn tried(&self, campaign: &Campaign, mut mistake: Mistake) -> Option<(f64, Mistake)> {
        if let What::Offset { target, .. } = mistake.what {
            let others = with_lengths(campaign, |stop, reading| {
                reading.target != target || !mistake.scope.holds(campaign, stop)
            });
            mistake.what = measured(campaign, &self.good(&others)?, target, &mistake.scope)?;
        }
        let calibration = self.good(&mistake.undone(campaign))?;
        Some((calibration.adjustment.rms_residual_mm, mistake))
    }

    /// The calibration of a campaign, if nothing is left that a mistake would explain.
    fn good(&self, campaign: &Campaign) -> Option<Calibration> {
        let calibration = (self.calibrate)(campaign, &self.as_it_is()).ok()?;
        let calibration = match self.settings.robust && !Self::fits(&calibration) {
            true => (self.calibrate)(campaign, &self.settings).ok()?,
            false => calibration,
        };
        let adjustment = &calibration.adjustment;
        let accidents = adjustment.rejected.len() as f64;
        let few = accidents <= ACCIDENTS * (adjustment.observations as f64 + accidents);
        let plausible = !calibration.axes.iter().any(is_absurd)
            && targets_elsewhere(campaign, &calibration.targets).is_empty();
        (Self::fits(&calibration) && few && plausible).then_some(calibration)
    }

    /// Without screening, which takes long where everything contradicts everything: only for what fits almost.
    fn as_it_is(&self) -> Settings {
        Settings {
            robust: false,
            ..self.settings
        }
    }

    /// Whether the residuals are noise, more or less.
    fn fits(calibration: &Calibration) -> bool {
        let adjustment = &calibration.adjustment;
        match adjustment.noise_declared {
            true => adjustment.sigma0 < FITTING_SIGMA0,
            false => adjustment.rms_residual_mm < FITTING_MM,
        }
    }
}

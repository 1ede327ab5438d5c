//! The search: each mistake is undone, and what is left is calibrated.

use rayon::prelude::*;
use trueaxis_campaign::{Campaign, Stop};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_poses::AdjustmentReport;

use crate::mistake::{Mistake, What};
use crate::off_nominal::OffNominal;
use crate::offsets::measured;
use crate::scope::{Scope, thinned, with_readings};
use crate::suspects::{LeftOut, suspects};

/// Standard deviation of unit weight up to which lengths fit, if their noise is declared; the residuals up to
/// which they do otherwise, mm.
const FITTING_SIGMA0: f64 = 3.0;
const FITTING_MM: f64 = 20.0 * MICROMETRE;

/// The same of points, mm: a robot returns to some tenths, and what is exchanged or reversed is off by centimetres.
const FITTING_POINTS_MM: f64 = 0.3;

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
    /// How far targets and stations are from where the campaign has them.
    pub off_nominal: OffNominal,
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

/// A mistake that explains a contradiction.
struct Explanation {
    mistake: Mistake,
    /// What is left of the residuals when it is undone, mm.
    residual_mm: f64,
    off_nominal: OffNominal,
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
        if self.campaign.stops().is_empty() {
            return None;
        }
        self.explanation_within(&Scope::default())
    }

    /// A text about what would explain the lengths of a part of the measurement.
    pub(crate) fn explanation_within(&self, within: &Scope) -> Option<String> {
        let fits = self.explanations(within);
        let (first, others) = fits.split_first()?;
        let mut text = first.mistake.in_words(self.campaign);
        if others.is_empty() {
            return Some(text);
        }
        let aside = |fit: &Explanation| {
            let words = fit.off_nominal.in_words();
            words.map_or_else(String::new, |words| format!(" ({words})"))
        };
        text += &aside(first);
        let mut is_open = false;
        for other in others {
            let farther = other.off_nominal.is_clearly_farther(&first.off_nominal);
            is_open |= !farther;
            text += if farther {
                "; or, less likely, "
            } else {
                "; or "
            };
            text += &other.mistake.in_words(self.campaign);
            text += &aside(other);
        }
        text += match is_open {
            true => {
                "; the lengths, targets and stations fit each of them: look at the machine to see which it was"
            }
            false => {
                "; the data fit each of them, and only the nominal places of targets and stations distinguish them: look at the machine"
            }
        };
        Some(text)
    }

    /// The mistakes after which the campaign fits, the best first: of those made in the largest part. None if the
    /// campaign fits already with fewer steps: then only lengths at the others are wrong, and no part as a whole.
    fn explanations(&self, within: &Scope) -> Vec<Explanation> {
        let small = thinned(self.campaign);
        let as_it_is = (self.calibrate)(&small, false);
        if *within == Scope::default() && as_it_is.as_ref().is_ok_and(|trial| self.fits(trial)) {
            return Vec::new();
        }
        let most_mm = as_it_is.map_or(f64::INFINITY, |found| EXPLAINED * found.rms_mm());
        let without = |scope: Scope| {
            let rest = with_readings(&small, |stop, _| !scope.holds(&small, stop));
            match (self.calibrate)(&rest, false) {
                Err(Refused::Contradiction) => LeftOut::Contradicts,
                Err(Refused::Other) => LeftOut::Open,
                Ok(_) if self.good(&rest, most_mm).is_some() => LeftOut::Fits,
                Ok(_) => LeftOut::Contradicts,
            }
        };
        let tried = |suspects: Vec<Mistake>| -> Vec<Explanation> {
            let suspects = suspects.into_par_iter();
            suspects
                .filter_map(|m| self.tried(&small, m, most_mm))
                .collect()
        };
        let by_size = suspects(&small, within, without).into_iter();
        let fits = by_size.map(tried).find(|fits| !fits.is_empty());
        let mut fits = fits.unwrap_or_default();
        // Stable: of equal ones the first.
        fits.sort_by(|a, b| a.residual_mm.total_cmp(&b.residual_mm));
        let least_mm = fits.first().map_or(0.0, |fit| fit.residual_mm);
        fits.retain(|fit| fit.residual_mm <= ALIKE * least_mm);
        let misfit = |fit: &Explanation| fit.off_nominal.misfit();
        let nearest = fits
            .iter()
            .min_by(|a, b| misfit(a).total_cmp(&misfit(b)))
            .map(|fit| fit.off_nominal.clone());
        if let Some(nearest) = nearest {
            fits.sort_by_key(|fit| fit.off_nominal.is_clearly_farther(&nearest));
        }
        fits.truncate(MOST_NAMED);
        fits
    }

    /// A mistake with what is left when it is undone; `None` if the campaign does not fit then.
    fn tried(
        &self,
        campaign: &Campaign,
        mut mistake: Mistake,
        most_mm: f64,
    ) -> Option<Explanation> {
        if let What::Offset { target, .. } = mistake.what {
            let others = with_readings(campaign, |stop, of| {
                of != target || !mistake.scope.holds(campaign, stop)
            });
            mistake.what = measured(
                campaign,
                &self.good(&others, most_mm)?,
                target,
                &mistake.scope,
            )?;
        }
        let trial = self.good(&mistake.undone(campaign), most_mm)?;
        Some(Explanation {
            mistake,
            residual_mm: trial.rms_mm(),
            off_nominal: trial.off_nominal,
        })
    }

    /// The calibration of a campaign, if nothing is left that a mistake would explain. Screening takes long where
    /// everything contradicts everything: it is only for what fits almost, with residuals below `most_mm`.
    fn good(&self, campaign: &Campaign, most_mm: f64) -> Option<Trial> {
        let mut trial = (self.calibrate)(campaign, false).ok()?;
        if self.robust && !self.fits(&trial) && trial.rms_mm() < most_mm {
            trial = (self.calibrate)(campaign, true).ok()?;
        }
        let adjustment = &trial.adjustment;
        let accidents = adjustment.rejected.len() as f64;
        let few = accidents <= MOST_ACCIDENTS * (adjustment.observations as f64 + accidents);
        (self.fits(&trial) && few && trial.is_plausible).then_some(trial)
    }

    /// Whether the residuals are noise, more or less.
    fn fits(&self, trial: &Trial) -> bool {
        let adjustment = &trial.adjustment;
        match (adjustment.noise_declared, &self.campaign.lengths) {
            (true, _) => adjustment.sigma0 < FITTING_SIGMA0,
            (false, Some(_)) => adjustment.rms_residual_mm < FITTING_MM,
            (false, None) => adjustment.rms_residual_mm < FITTING_POINTS_MM,
        }
    }
}

impl Trial {
    fn rms_mm(&self) -> f64 {
        self.adjustment.rms_residual_mm
    }
}

//! A cause: the effect, its size and uncertainty, and what else it may be.

use trueaxis_effects::{
    Explanation, LOST_MOTION_OF_BOTH_SIGNS, Layer, Level, ResolvedEffect, Scene, WORN_IN_THE_MIDDLE,
};

use crate::numbers::extremes;
use crate::{Fitted, Wandering};

/// Probability of equal sizes scattering as much, below which they differ by more than chance.
pub(crate) const SIZES_DIFFER: f64 = 0.01;

/// Fewest positions that tell where lost motion is largest.
const POSITIONS_THAT_TELL_WEAR: usize = 5;

/// A cause.
#[derive(Debug, Clone)]
pub struct Cause {
    /// The effect with its subject and values.
    pub effect: ResolvedEffect,
    /// The level at which it was found.
    pub level: Level,
    /// The data in which it was found, as [`crate::LevelReport::data`]: several where verifications share the cause.
    pub data: Vec<String>,
    /// Probability that noise alone looks as much like any effect (family-wise).
    pub p_value: f64,
    /// BIC against the model with the other causes only; negative is better.
    pub delta_bic: f64,
    /// Rms of what it explains over all readings of the level, µm.
    pub explained_rms_um: f64,
    /// Relative drop of the held-out rms; `None` where nothing could be held out.
    pub heldout_gain: Option<f64>,
    /// Its share of the misfit of its level, 0 to 1 ([`crate::Shares`]); `None` for a cause of an error curve.
    pub share: Option<f64>,
    /// Its parameters, the shape (instant, time constant, period) last.
    pub parameters: Vec<EstimatedParameter>,
    /// Covariance of the linear parameters in their units, rows one after the other.
    pub covariance: Vec<f64>,
    /// Other explanations that fit nearly as well, disturbances first.
    pub rivals: Vec<Rival>,
    /// Changes of the calibration by the causes: name of the component or location error, largest amount and unit.
    pub changes: Vec<Change>,
    /// Lost motion that changes along an axis, at positions reached from both sides; empty for other causes.
    pub curve: Vec<LostMotionAt>,
    /// The mean of the curve: `lost_motion_mean` is the value in the middle of the travel, where the axis may not
    /// have been measured.
    pub mean_lost_motion: Option<EstimatedParameter>,
    /// For a cause of several data: p-value of the test that its size is the same in all of them.
    pub sizes_p_value: Option<f64>,
    /// For a cause of an error curve: its squares as a share of those of the curve, both after the gauge.
    pub share_of_curve: Option<f64>,
    /// The misfit without it beside what it explains of the misfit; `None` where single readings do not show it.
    pub fitted: Option<Fitted>,
}

/// Lost motion at a position of an axis, mm and µm, or degrees and arcsec.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LostMotionAt {
    /// The position.
    pub at: f64,
    /// The lost motion there.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
}

/// A value with standard uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct EstimatedParameter {
    /// Name, such as `shift_x`.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Standard uncertainty.
    pub u: f64,
    /// Unit, such as `um`.
    pub unit: &'static str,
}

/// Another explanation.
#[derive(Debug, Clone)]
pub enum Rival {
    /// An effect of the catalogue.
    Effect {
        /// With its subject and values.
        effect: ResolvedEffect,
        /// BIC against the model with the other causes only; negative is better.
        delta_bic: f64,
    },
    /// A disturbance.
    Disturbance {
        /// What wanders.
        whose: Wandering,
        /// 2 ln B, twice the logarithm of its Bayes factor against the same model; positive is better.
        two_ln_b: f64,
    },
}

/// A change of a result of the calibration by causes.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Name, such as `EXX` or `C0Y`.
    pub name: String,
    /// Largest amount over the positions.
    pub largest: f64,
    /// Unit: `um` or `arcsec`, `mm` for the location of a rotary axis.
    pub unit: &'static str,
}

/// How a cause depends on a logged temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follows<'a> {
    /// The column, such as `machine_temp_spindle_c`.
    pub column: &'a str,
    /// Whether each coefficient may lie in the range, within its expanded uncertainty (k = 2).
    pub is_plausible: bool,
    /// The range in which coefficients are plausible.
    pub range: [f64; 2],
    /// Unit of the coefficients, such as `um/K`.
    pub unit: &'static str,
}

impl Cause {
    /// Whether the data determine all its parameters. An effect that is seen only in part cannot be removed.
    pub fn is_seen_whole(&self) -> bool {
        self.parameters.iter().all(|p| p.u.is_finite())
    }

    /// Its rivals in the catalogue.
    pub fn rival_effects(&self) -> impl Iterator<Item = &ResolvedEffect> {
        self.rivals.iter().filter_map(|rival| match rival {
            Rival::Effect { effect, .. } => Some(effect),
            Rival::Disturbance { .. } => None,
        })
    }

    /// The explanation for a calibration engineer.
    pub fn explanation(&self) -> Explanation {
        let beyond_doubt = |sign: f64| {
            let mut points = self.curve.iter();
            points.any(|point| sign * point.value > 3.0 * point.u)
        };
        match &self.mean_lost_motion {
            _ if beyond_doubt(1.0) && beyond_doubt(-1.0) => LOST_MOTION_OF_BOTH_SIGNS,
            Some(mean) if mean.value > 0.0 && self.is_largest_in_the_middle() => WORN_IN_THE_MIDDLE,
            Some(mean) => self.effect.explanation_at(mean.value),
            None => self.effect.explanation(),
        }
    }

    /// Whether the middle half of its curve is clearly above the rest; fewer than five positions do not tell.
    fn is_largest_in_the_middle(&self) -> bool {
        let [low, high] = extremes(self.curve.iter().map(|point| point.at));
        let is_inside = |point: &&LostMotionAt| {
            let travelled = (point.at - low) / (high - low).max(f64::MIN_POSITIVE);
            (0.25..=0.75).contains(&travelled)
        };
        let (inside, outside): (Vec<_>, Vec<_>) = self.curve.iter().partition(is_inside);
        let mean = |points: &[&LostMotionAt], of: fn(&LostMotionAt) -> f64| {
            points.iter().map(|point| of(point)).sum::<f64>() / points.len().max(1) as f64
        };
        let more = mean(&inside, |point| point.value) - mean(&outside, |point| point.value);
        // Neighbours have errors in common, which a mean does not take away.
        let u = mean(&inside, |point| point.u).hypot(mean(&outside, |point| point.u));
        self.curve.len() >= POSITIONS_THAT_TELL_WEAR && more > 2.0 * u
    }

    /// Whether its curve is one of angles: lost motion of a rotary axis, arcsec over degrees, instead of µm over mm. `None`
    /// without a curve.
    pub fn has_angular_curve(&self) -> Option<bool> {
        let mean = self.mean_lost_motion.as_ref();
        mean.map(|mean| mean.unit == "arcsec")
    }

    /// Its parameters for the report: lost motion that changes along an axis by its mean where it was measured.
    pub fn told_parameters(&self) -> Vec<EstimatedParameter> {
        let mut told = self.parameters.clone();
        if let (Some(first), Some(mean)) = (told.first_mut(), &self.mean_lost_motion) {
            first.clone_from(mean);
        }
        told
    }

    /// The logged temperature on which it depends; `None` if it depends on time or position.
    pub fn follows<'a>(&self, scene: &'a Scene) -> Option<Follows<'a>> {
        let subject = &self.effect.subject;
        let column = &scene.temperatures.get(subject.column?)?.column;
        let known = self.effect.effect.parameters(scene, subject);
        let first = known.first()?;
        let range = first.plausible?;
        let mut coefficients = self.parameters.iter().take(known.len());
        let is_plausible = coefficients
            .all(|p| p.value + 2.0 * p.u >= range[0] && p.value - 2.0 * p.u <= range[1]);
        Some(Follows {
            column,
            is_plausible,
            range,
            unit: first.unit,
        })
    }

    /// The note that its sizes in several data differ by more than chance.
    pub fn note(&self) -> Option<String> {
        let p_value = self.sizes_p_value.filter(|p| *p < SIZES_DIFFER)?;
        let p_value = trueaxis_files::p_value(p_value);
        Some(format!(
            "its sizes in the data scatter about the common one by more than chance ({p_value}), though by less than a tenth \
             (rms); U of the common size follows from this scatter"
        ))
    }

    /// Whether it is the same effect on the same subject in the same data.
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.effect.is(&other.effect) && (self.level, &self.data) == (other.level, &other.data)
    }

    /// Its layer.
    pub fn layer(&self) -> Layer {
        self.effect.effect.layer
    }
}

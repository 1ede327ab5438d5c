//! The outcome: what is wrong, why, what the better model looks like, what was gained.

use schemars::JsonSchema;
use serde::Serialize;
use trueaxis_calibrate::Calibration;
use trueaxis_effects::{
    Explanation, LOST_MOTION_OF_BOTH_SIGNS, Layer, Level, ResolvedEffect, Scene,
};

use crate::json::rounded;
use crate::{CurvePoint, Disturbance, Fitted, Shares, Wandering};

/// A diagnosis of a campaign.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// Name of the campaign.
    pub campaign: String,
    /// What stations, targets and axes the subjects of causes refer to.
    pub scene: Scene,
    /// The verdict on the measured data.
    pub verdict: Verdict,
    /// Each level that there are data for.
    pub levels: Vec<LevelReport>,
    /// All causes, those of the data first, then those of the error curves; by rank.
    pub causes: Vec<Cause>,
    /// Smooth processes of unknown form that the data demand beside the causes, or instead of them.
    pub disturbances: Vec<Disturbance>,
    /// What no cause explains, of the first level where something is left ([`LevelReport::unexplained`]).
    pub unexplained: Option<Unexplained>,
    /// Points and readings of verifications that were left out as gross errors.
    pub rejected: Vec<Rejected>,
    /// Effects that these data cannot show.
    pub not_observable: Vec<NotObservable>,
    /// The calibration with causes and disturbances found in the lengths or points taken out of them; none if there is nothing
    /// to calibrate from.
    pub calibration: Option<Calibration>,
    /// What a user must know before using the outcome.
    pub notices: Vec<String>,
}

/// What the data say about the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing contradicts the model.
    Clean,
    /// A cause is clear: nothing else explains it nearly as well. More may be left ([`Unexplained`]).
    Named,
    /// Something is wrong, and for each cause there are others that explain it as well.
    Ambiguous,
    /// Something is wrong that no effect of the catalogue explains.
    Unknown,
    /// There is nothing that could contradict the model.
    NotJudged,
}

impl Verdict {
    /// As the result file names it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Named => "named",
            Self::Ambiguous => "ambiguous",
            Self::Unknown => "unknown",
            Self::NotJudged => "not_judged",
        }
    }

    /// Whether the data reject the model.
    pub fn is_misfit(self) -> bool {
        matches!(self, Self::Named | Self::Ambiguous | Self::Unknown)
    }

    /// That of several sets of data, the first that holds of any: a clear cause in one is no less clear for
    /// what the others leave open.
    pub(crate) fn of_all(verdicts: impl IntoIterator<Item = Self>) -> Self {
        let order = [Self::Named, Self::Ambiguous, Self::Unknown, Self::Clean];
        let all: Vec<Self> = verdicts.into_iter().collect();
        let first = order.into_iter().find(|verdict| all.contains(verdict));
        first.unwrap_or(Self::NotJudged)
    }

    /// That of one set of data from its causes and whether something is left beside them.
    pub(crate) fn of_causes(causes: &[Cause], is_left: bool) -> Self {
        match (causes, is_left) {
            ([], true) => Self::Unknown,
            ([], false) => Self::Clean,
            (causes, _) if causes.iter().any(|cause| cause.rivals.is_empty()) => Self::Named,
            _ => Self::Ambiguous,
        }
    }
}

/// One level of data: how far the prediction is off before and after.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelReport {
    /// The level.
    pub level: Level,
    /// What was compared, such as `2340 lengths` or `LI along X`.
    pub data: String,
    /// Standard deviation of one reading as the repeats show it, µm.
    pub noise_floor_um: f64,
    /// Misfit of the rigid, quasi-static model.
    pub before: Misfit,
    /// Misfit with the causes in the model.
    pub after: Misfit,
    /// Gain on data that were not used; none where nothing was named or could be held out.
    pub gain: Option<Gain>,
    /// What parts the misfit has.
    pub shares: Shares,
    /// What no cause of these data explains; none if nothing is left.
    pub unexplained: Option<Unexplained>,
    /// The tests whether anything is wrong at all, before the causes.
    pub tests: Vec<OmnibusTest>,
    /// The same after the causes.
    pub tests_after: Vec<OmnibusTest>,
    /// Where the misfit lives: groups of readings with their rms, before and after, µm.
    pub places: Vec<Place>,
}

/// Rms of measured minus predicted for one degree of freedom, µm: weighted with the noise, its
/// correlation within a stop included, and scaled so that noise alone gives the standard deviation of one
/// reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misfit {
    /// In the data that the model was fitted to.
    pub rms_um: f64,
    /// In data that it was not fitted to; none where nothing could be held out.
    pub heldout_rms_um: Option<f64>,
}

/// A ratio of held-out rms with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct HeldOutRatio {
    /// Rms after, divided by before.
    #[serde(rename = "heldout_rms_ratio", serialize_with = "rounded::fourth")]
    pub ratio: f64,
    /// Its 95 % interval, from a bootstrap of blocks.
    #[serde(serialize_with = "rounded::fourths")]
    pub interval: [f64; 2],
}

/// Gain on unused data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Held-out rms after, divided by before.
    pub heldout_rms_ratio: f64,
    /// Its 95 % interval, from a bootstrap of blocks.
    pub interval: [f64; 2],
    /// Share of the misfit above the noise floor that went away, in squares.
    pub share_of_excess_removed: f64,
    /// The same ratio and interval where each station in turn is the unused data; `None` with fewer than
    /// five stations. What happens at one station only cannot be predicted from the others.
    pub leave_one_station_out: Option<HeldOutRatio>,
}

impl Gain {
    /// Whether the interval excludes no gain.
    pub fn is_claimed(&self) -> bool {
        self.interval[1] < 1.0
    }
}

/// A test of whether anything is left in the residuals.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct OmnibusTest {
    /// What the residuals are tested to vary with, as `time` or `position`.
    pub varies_with: &'static str,
    /// The period that stands out, where the test looks for one, such as `1180 s`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detail: Option<String>,
    /// Columns of the test that the data see.
    pub columns: usize,
    /// Its p-value, all tests of the level together (family-wise).
    #[serde(serialize_with = "rounded::p")]
    pub p_value: f64,
}

/// A group of readings.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Place {
    /// By what the readings are grouped, as `station`.
    pub by: &'static str,
    /// The group, as `S2`.
    pub name: String,
    /// Its readings.
    pub readings: usize,
    /// Rms before, µm.
    #[serde(serialize_with = "rounded::sixth")]
    pub before_um: f64,
    /// Rms with the causes in the model, µm.
    #[serde(serialize_with = "rounded::sixth")]
    pub after_um: f64,
}

/// Probability of sizes that scatter as much, below which it is not taken for chance.
pub(crate) const SIZES_DIFFER: f64 = 0.01;

/// A cause.
#[derive(Debug, Clone)]
pub struct Cause {
    /// The effect with its subject and values.
    pub effect: ResolvedEffect,
    /// Where it was found.
    pub level: Level,
    /// The data in which it was found, as [`LevelReport::data`]: several where verifications have it in common.
    pub data: Vec<String>,
    /// Probability that noise alone looks as much like any effect (family-wise).
    pub p_value: f64,
    /// BIC against the model without it, the other causes in it; negative is better.
    pub delta_bic: f64,
    /// Rms of what it explains over all readings of the level, µm.
    pub explained_rms_um: f64,
    /// By what part the held-out rms falls; none where nothing could be held out.
    pub heldout_gain: Option<f64>,
    /// Its share of the misfit of its level, 0 to 1 ([`Shares`]); none for a cause of an error curve.
    pub share: Option<f64>,
    /// Its parameters, the shape (instant, time constant, period) last.
    pub parameters: Vec<EstimatedParameter>,
    /// Covariance of the linear parameters in their units, rows one after the other.
    pub covariance: Vec<f64>,
    /// What explains the data nearly as well, disturbances first.
    pub rivals: Vec<Rival>,
    /// By how much the calibration changes: name of the component or location error, largest amount and
    /// unit.
    pub changes: Vec<Change>,
    /// Its size as a function of the position, where that has a free form; else empty.
    pub curve: Vec<CurvePoint>,
    /// For a cause of several data: probability that chance alone lets its sizes in each scatter as much about the common one.
    pub sizes_p_value: Option<f64>,
    /// For a cause of an error curve: its share of the curve's squares.
    pub share_of_curve: Option<f64>,
    /// The misfit without it beside what it explains of it; none where single readings do not show it.
    pub fitted: Option<Fitted>,
}

/// A value with standard uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct EstimatedParameter {
    /// Name, as `shift_x`.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Standard uncertainty.
    pub u: f64,
    /// Unit, as `um`.
    pub unit: &'static str,
}

/// Another explanation.
#[derive(Debug, Clone)]
pub enum Rival {
    /// An effect of the catalogue.
    Effect {
        /// With its subject and values.
        effect: ResolvedEffect,
        /// BIC against the model without either, the other causes in it; negative is better.
        delta_bic: f64,
    },
    /// Something that wanders in a course that nobody knows.
    Disturbance {
        /// What wanders.
        whose: Wandering,
        /// Twice the logarithm of its marginal likelihood ratio against the same model; positive is better.
        evidence: f64,
    },
}

/// A change of a result of the calibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Name, as `EXX` or `C0Y`.
    pub name: String,
    /// Largest amount over the positions.
    pub largest: f64,
    /// Unit: `um` or `arcsec`, `mm` for the location of a rotary axis.
    pub unit: &'static str,
}

/// What is left when nothing of the catalogue explains it.
#[derive(Debug, Clone, PartialEq)]
pub struct Unexplained {
    /// The level.
    pub level: Level,
    /// The data, as [`LevelReport::data`].
    pub data: String,
    /// Its rms beyond the noise, µm.
    pub rms_um: f64,
    /// Its share of the misfit of its level, 0 to 1.
    pub share: f64,
    /// What it varies with: `time`, `position`, `station`, `target`, `direction`.
    pub varies_with: Vec<&'static str>,
    /// In words, with a period where there is one.
    pub note: String,
}

/// A reading that contradicts all others and was left out.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Rejected {
    /// The verification, by name, or `points.csv`.
    pub file: String,
    /// Its line in the table, from 1 (the header).
    pub row: usize,
    /// How far it is off, µm.
    #[serde(serialize_with = "rounded::sixth")]
    pub error_um: f64,
    /// Standard uncertainty of that, µm.
    #[serde(serialize_with = "rounded::sixth")]
    pub u_um: f64,
    /// In words.
    pub reason: String,
}

/// An effect that these data cannot show. It may be there all the same.
#[derive(Debug, Clone, PartialEq)]
pub struct NotObservable {
    /// Its id.
    pub effect: &'static str,
    /// What it concerns, such as `axis X`; empty if all.
    pub subject: String,
    /// Why the data do not show it.
    pub reason: String,
    /// What it would do to results: name and amount per unit, as text.
    pub bias_per_unit: Vec<(String, String)>,
    /// What to measure to see it.
    pub measure: String,
}

/// What a cause says about the logged temperature that it goes with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Follows<'a> {
    /// The column, as `machine_temp_spindle_c`.
    pub column: &'a str,
    /// Whether each coefficient may be in the range, its expanded uncertainty (k = 2) considered.
    pub is_plausible: bool,
    /// The range in which coefficients are plausible.
    pub range: [f64; 2],
    /// Their unit, as `um/K`.
    pub unit: &'static str,
}

impl Cause {
    /// Its rivals of the catalogue.
    pub fn rival_effects(&self) -> impl Iterator<Item = &ResolvedEffect> {
        self.rivals.iter().filter_map(|rival| match rival {
            Rival::Effect { effect, .. } => Some(effect),
            Rival::Disturbance { .. } => None,
        })
    }

    /// What to tell a calibration engineer about it.
    pub fn explanation(&self) -> Explanation {
        let beyond_doubt = |sign: f64| {
            let points = self.curve.iter();
            let clear = |(value, u): (&f64, &f64)| sign * value > 3.0 * u;
            points
                .flat_map(|p| p.value_um.iter().zip(&p.u_um))
                .any(clear)
        };
        match beyond_doubt(1.0) && beyond_doubt(-1.0) {
            true => LOST_MOTION_OF_BOTH_SIGNS,
            false => self.effect.explanation(),
        }
    }

    /// The logged temperature that it goes with; none if it goes with time or position.
    pub fn follows<'a>(&self, scene: &'a Scene) -> Option<Follows<'a>> {
        let subject = &self.effect.subject;
        let column = &scene.temperatures.get(subject.column?)?.column;
        let known = self.effect.effect.parameters(scene, subject);
        let first = known.first()?;
        let range = first.plausible?;
        let coefficients = self.parameters.iter().take(known.len());
        let is_plausible = coefficients.fold(true, |all, p| {
            all && p.value + 2.0 * p.u >= range[0] && p.value - 2.0 * p.u <= range[1]
        });
        Some(Follows {
            column,
            is_plausible,
            range,
            unit: first.unit,
        })
    }

    /// What there is to say about its sizes in several data: that they differ, where chance does not explain it.
    pub fn note(&self) -> Option<String> {
        let p_value = self.sizes_p_value.filter(|p| *p < SIZES_DIFFER)?;
        let p_value = match p_value > 1e-300 {
            true => format!("p = {p_value:.1e}"),
            false => "p < 1e-300".to_owned(),
        };
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

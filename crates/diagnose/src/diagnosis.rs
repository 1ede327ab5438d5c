//! The result: what is wrong, why, what the better model is, and what it gains.

use schemars::JsonSchema;
use serde::Serialize;
use trueaxis_calibrate::Calibration;
use trueaxis_effects::{Level, Scene};

use crate::json::rounded;
use crate::{Cause, Disturbance, Shares};

/// A diagnosis of a campaign.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// Name of the campaign.
    pub campaign: String,
    /// Stations, targets and axes to which subjects of causes refer.
    pub scene: Scene,
    /// The verdict on the measured data.
    pub verdict: Verdict,
    /// Each level with data.
    pub levels: Vec<LevelReport>,
    /// All causes, those of the data first, then those of the error curves; by rank.
    pub causes: Vec<Cause>,
    /// Disturbances that the data need beside the causes, or instead of them.
    pub disturbances: Vec<Disturbance>,
    /// The part without a cause, of the first level where something is left ([`LevelReport::unexplained`]).
    pub unexplained: Option<Unexplained>,
    /// Points and readings of verifications that were left out as gross errors.
    pub rejected: Vec<Rejected>,
    /// Effects that these data cannot show.
    pub not_observable: Vec<NotObservable>,
    /// The calibration without the causes and disturbances found in the lengths or points; `None` if there is nothing
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
    /// A cause is clear: no other explanation fits nearly as well. More may be left ([`Unexplained`]).
    Named,
    /// Something is wrong, and each cause has rivals that explain it as well.
    Ambiguous,
    /// Something is wrong that no effect in the catalogue explains.
    Unknown,
    /// No data could contradict the model.
    NotJudged,
}

impl Verdict {
    /// Its name in the result file.
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

    /// The verdict on several sets of data, the first in the order that any of them has: a clear cause in one is no
    /// less clear for what the others leave open.
    pub(crate) fn of_all(verdicts: impl IntoIterator<Item = Self>) -> Self {
        let order = [Self::Named, Self::Ambiguous, Self::Unknown, Self::Clean];
        let all: Vec<Self> = verdicts.into_iter().collect();
        let first = order.into_iter().find(|verdict| all.contains(verdict));
        first.unwrap_or(Self::NotJudged)
    }

    /// The verdict on one set of data from its causes and whether anything is left beside them.
    pub(crate) fn of_causes(causes: &[Cause], is_left: bool) -> Self {
        match (causes, is_left) {
            ([], true) => Self::Unknown,
            ([], false) => Self::Clean,
            (causes, _) if causes.iter().any(|cause| cause.rivals.is_empty()) => Self::Named,
            _ => Self::Ambiguous,
        }
    }
}

/// One level of data: its misfit before and after the causes.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelReport {
    /// The level.
    pub level: Level,
    /// What was compared, such as `2340 lengths` or `LI along X`.
    pub data: String,
    /// Standard deviation of one reading by the repeats, µm.
    pub noise_floor_um: f64,
    /// For verification readings the standard uncertainty of their prediction by the calibration, rms, µm.
    pub prediction_u_um: Option<f64>,
    /// Misfit of the rigid, quasi-static model.
    pub before: Misfit,
    /// Misfit with the causes in the model.
    pub after: Misfit,
    /// Gain on unused data; `None` where nothing was named or could be held out.
    pub gain: Option<Gain>,
    /// The parts of the misfit.
    pub shares: Shares,
    /// What no cause of these data explains; `None` if nothing is left.
    pub unexplained: Option<Unexplained>,
    /// The tests whether anything is wrong, without the causes.
    pub tests: Vec<OmnibusTest>,
    /// The same tests with the causes.
    pub tests_after: Vec<OmnibusTest>,
    /// The misfit by groups of readings: rms before and after, µm.
    pub places: Vec<Place>,
}

/// Rms of measured minus predicted for one degree of freedom, µm, weighted with the noise including its correlation
/// within a stop, and scaled so that noise alone gives the standard deviation of one reading. For a verification it
/// contains the error of the prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misfit {
    /// In the data used for the fit.
    pub rms_um: f64,
    /// In data not used for the fit; `None` where nothing could be held out.
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
    /// Share of the misfit above the noise floor that was removed, in squares.
    pub share_of_excess_removed: f64,
    /// The same ratio and interval with each station in turn as the unused data; `None` with fewer than five
    /// stations. What happens at only one station cannot be predicted from the others.
    pub leave_one_station_out: Option<HeldOutRatio>,
}

impl Gain {
    /// Whether the interval excludes a ratio of one.
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

/// What is left when no effect in the catalogue explains it.
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
    /// What it varies with: `time`, `position`, `station`, `target`, `direction`, `cycle`; `reading` where many
    /// single readings are off.
    pub varies_with: Vec<&'static str>,
    /// Whether the omnibus tests found it: structure of any kind, as opposed to single readings, another curve after
    /// a jump or a cause of impossible size.
    pub is_of_tests: bool,
    /// Description, with a period where there is one.
    pub note: String,
    /// What to do about it, where that is not plain from what it varies with.
    pub action: Option<&'static str>,
}

impl Unexplained {
    /// Found otherwise than by the omnibus tests, before its data and share are known.
    pub(crate) fn new(
        level: Level,
        rms_um: f64,
        varies_with: Vec<&'static str>,
        note: String,
    ) -> Self {
        Self {
            level,
            data: String::new(),
            rms_um,
            share: 0.0,
            varies_with,
            is_of_tests: false,
            note,
            action: None,
        }
    }

    /// Whether the repeats scatter by as much, so that their noise already contains most of it: its `share`, which
    /// counts only what exceeds that noise, is then less than a quarter of `(rms_um/before.rms_um)²`. `before` is the
    /// misfit of its level before any explanation. Only findings of the omnibus tests can be scatter.
    pub fn is_scatter(&self, before: &Misfit) -> bool {
        let of_misfit = (self.rms_um / before.rms_um).powi(2);
        self.is_of_tests && of_misfit > 0.01 && self.share < 0.25 * of_misfit
    }
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

impl Rejected {
    /// The notice about it.
    pub fn in_words(&self) -> String {
        format!(
            "{} line {}: left out; off by {:.1} µm (u = {:.1} µm): {}",
            self.file, self.row, self.error_um, self.u_um, self.reason
        )
    }
}

/// An effect that these data cannot show. It may still be there.
#[derive(Debug, Clone, PartialEq)]
pub struct NotObservable {
    /// Its id.
    pub effect: &'static str,
    /// Its subject, such as `axis X`; empty if it concerns everything.
    pub subject: String,
    /// Why the data do not show it.
    pub reason: String,
    /// Its effect on results: name and amount per unit, as text.
    pub bias_per_unit: Vec<(String, String)>,
    /// The measurement that would show it.
    pub measure: String,
}

//! `diagnosis.json`, version 1.
//!
//! Rms and noise are µm; every parameter and change names its unit; `u` is a standard uncertainty, the
//! p-values are family-wise. `heldout_rms_um`, `gain`, `heldout_gain` and `unexplained` are null where nothing
//! was held out, named or left.

mod cause;
mod disturbance;
mod fitted;

use schemars::JsonSchema;
use serde::Serialize;
use trueaxis_effects::{EffectsFile, Level};
use trueaxis_files::{Format, Ordered, round};

use crate::json::cause::CauseFile;
use crate::json::disturbance::DisturbanceFile;
use crate::{
    Cause, Diagnosis, Gain, HeldOutRatio, LevelReport, Misfit, NotObservable, OmnibusTest, Place,
    Rejected, Shares, Unexplained,
};

impl Diagnosis {
    /// The text of `diagnosis.json`, version 1.
    ///
    /// Noise floor, misfits and gain at the top are those of [`Diagnosis::headline`]; `levels` has all.
    pub fn to_json(&self) -> String {
        // Serialising plain structs of numbers and strings has no way to fail.
        trueaxis_files::to_json(&File::new(self)).expect("numbers and strings serialise")
    }

    /// The JSON Schema of `diagnosis.json`.
    pub fn schema() -> String {
        FORMAT.schema_of_result::<File<'_>>()
    }

    /// The level that represents the whole: the lengths or the points, otherwise the one with the largest misfit.
    pub fn headline(&self) -> Option<&LevelReport> {
        let of_targets = |l: &&LevelReport| [Level::Lengths, Level::Points].contains(&l.level);
        let lengths = self.levels.iter().find(of_targets);
        lengths.or_else(|| {
            let misfit = |l: &&LevelReport| l.before.rms_um;
            let levels = self.levels.iter();
            levels.max_by(|a, b| misfit(a).total_cmp(&misfit(b)))
        })
    }

    /// The causes found in the lengths that the data fully show, with the covariance of their parameters (block by
    /// block: causes count as independent of each other), for `simulate` and `calibrate --with-effects`.
    pub fn effects_file(&self) -> EffectsFile {
        let whole = |c: &&Cause| c.level == Level::Lengths && c.is_seen_whole();
        let causes = self.causes.iter().filter(whole);
        let causes = causes.map(|c| (cause::given(c, &self.scene), cause::covariance(c)));
        EffectsFile::of_independent(self.campaign.clone(), causes)
    }
}

const FORMAT: Format = Format {
    name: "trueaxis-diagnosis",
    version: 1,
    noun: "a diagnosis",
};

/// What the calibrated model gets wrong, and why (`docs/formats.md`).
#[derive(Serialize, JsonSchema)]
struct File<'a> {
    format: &'static str,
    version: u32,
    campaign: &'a str,
    verdict: &'static str,
    noise_floor_um: Option<f64>,
    before: MisfitFile,
    after: MisfitFile,
    gain: Option<GainFile>,
    causes: Vec<CauseFile<'a>>,
    disturbances: Vec<DisturbanceFile<'a>>,
    unexplained: Option<UnexplainedFile<'a>>,
    rejected: &'a [Rejected],
    not_observable: Vec<NotObservableFile<'a>>,
    levels: Vec<LevelFile<'a>>,
    notices: &'a [String],
}

#[derive(Serialize, Default, JsonSchema)]
struct MisfitFile {
    rms_um: Option<f64>,
    heldout_rms_um: Option<f64>,
}

#[derive(Serialize, JsonSchema)]
struct GainFile {
    heldout_rms_ratio: f64,
    interval: [f64; 2],
    share_of_excess_removed: f64,
    heldout_claimed: bool,
    leave_one_station_out: Option<HeldOutRatio>,
}

#[derive(Serialize, JsonSchema)]
struct UnexplainedFile<'a> {
    rms_um: f64,
    share: f64,
    varies_with: &'a [&'static str],
    note: &'a str,
    level: &'static str,
    data: &'a str,
}

#[derive(Serialize, JsonSchema)]
struct NotObservableFile<'a> {
    effect: &'static str,
    subject: &'a str,
    reason: &'a str,
    bias_per_unit: Ordered<&'a str>,
    measure: &'a str,
}

#[derive(Serialize, JsonSchema)]
struct LevelFile<'a> {
    level: &'static str,
    data: &'a str,
    noise_floor_um: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    prediction_u_um: Option<f64>,
    before: MisfitFile,
    after: MisfitFile,
    gain: Option<GainFile>,
    shares: &'a Shares,
    unexplained: Option<UnexplainedFile<'a>>,
    tests: &'a [OmnibusTest],
    tests_after: &'a [OmnibusTest],
    places: &'a [Place],
}

impl<'a> File<'a> {
    fn new(diagnosis: &'a Diagnosis) -> Self {
        let headline = diagnosis.headline();
        let scene = &diagnosis.scene;
        let causes = diagnosis.causes.iter().enumerate();
        let disturbances = diagnosis.disturbances.iter();
        Self {
            format: FORMAT.name,
            version: FORMAT.version,
            campaign: &diagnosis.campaign,
            verdict: diagnosis.verdict.name(),
            noise_floor_um: headline.map(|l| um(l.noise_floor_um)),
            before: headline.map(|l| misfit(&l.before)).unwrap_or_default(),
            after: headline.map(|l| misfit(&l.after)).unwrap_or_default(),
            gain: headline.and_then(|l| l.gain.as_ref()).map(gain),
            causes: causes
                .map(|(i, cause)| CauseFile::new(i + 1, cause, scene))
                .collect(),
            disturbances: disturbances
                .map(|own| DisturbanceFile::new(own, scene))
                .collect(),
            unexplained: diagnosis.unexplained.as_ref().map(unexplained),
            rejected: &diagnosis.rejected,
            not_observable: diagnosis.not_observable.iter().map(unseen).collect(),
            levels: diagnosis.levels.iter().map(level).collect(),
            notices: &diagnosis.notices,
        }
    }
}

fn unexplained(left: &Unexplained) -> UnexplainedFile<'_> {
    UnexplainedFile {
        rms_um: um(left.rms_um),
        share: round(left.share, 4),
        varies_with: &left.varies_with,
        note: &left.note,
        level: left.level.name(),
        data: &left.data,
    }
}

fn level(level: &LevelReport) -> LevelFile<'_> {
    LevelFile {
        level: level.level.name(),
        data: &level.data,
        noise_floor_um: um(level.noise_floor_um),
        prediction_u_um: level.prediction_u_um.map(um),
        before: misfit(&level.before),
        after: misfit(&level.after),
        gain: level.gain.as_ref().map(gain),
        shares: &level.shares,
        unexplained: level.unexplained.as_ref().map(unexplained),
        tests: &level.tests,
        tests_after: &level.tests_after,
        places: &level.places,
    }
}

fn misfit(misfit: &Misfit) -> MisfitFile {
    MisfitFile {
        rms_um: Some(um(misfit.rms_um)),
        heldout_rms_um: misfit.heldout_rms_um.map(um),
    }
}

fn gain(gain: &Gain) -> GainFile {
    GainFile {
        heldout_rms_ratio: round(gain.heldout_rms_ratio, 4),
        interval: gain.interval.map(|bound| round(bound, 4)),
        share_of_excess_removed: round(gain.share_of_excess_removed, 4),
        heldout_claimed: gain.is_claimed(),
        leave_one_station_out: gain.leave_one_station_out,
    }
}

fn unseen(unseen: &NotObservable) -> NotObservableFile<'_> {
    let bias = unseen.bias_per_unit.iter();
    let bias = bias.map(|(name, text)| (name.clone(), text.as_str()));
    NotObservableFile {
        effect: unseen.effect,
        subject: &unseen.subject,
        reason: &unseen.reason,
        bias_per_unit: Ordered(bias.collect()),
        measure: &unseen.measure,
    }
}

/// Rounded to a picometre.
fn um(value_um: f64) -> f64 {
    round(value_um, 6)
}

/// Numbers rounded for the file.
pub(crate) mod rounded {
    use serde::Serializer;
    use trueaxis_files::{round, significant};

    /// To a picometre; shares to one in a million.
    pub(crate) fn sixth<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(round(*value, 6))
    }

    pub(crate) fn sixths<S: Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(values.iter().map(|value| round(*value, 6)))
    }

    pub(crate) fn fourth<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(round(*value, 4))
    }

    pub(crate) fn fourths<S: Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(values.iter().map(|value| round(*value, 4)))
    }

    /// A probability.
    pub(crate) fn p<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(significant(*value))
    }
}

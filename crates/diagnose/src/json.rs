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
use trueaxis_files::{Format, Ordered, round, significant};

use crate::json::cause::CauseFile;
use crate::json::disturbance::DisturbanceFile;
use crate::{
    Cause, Diagnosis, Gain, LevelReport, Misfit, NotObservable, OmnibusTest, Place, Rejected,
    Shares, Unexplained,
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

    /// The level that stands for the whole: the lengths or the points, else the one with the largest misfit.
    pub fn headline(&self) -> Option<&LevelReport> {
        let of_targets = |l: &&LevelReport| [Level::Lengths, Level::Points].contains(&l.level);
        let lengths = self.levels.iter().find(of_targets);
        lengths.or_else(|| {
            let misfit = |l: &&LevelReport| l.before.rms_um;
            let levels = self.levels.iter();
            levels.max_by(|a, b| misfit(a).total_cmp(&misfit(b)))
        })
    }

    /// The causes found in the lengths whose parameters are all seen, with the covariance of their parameters (block by block: causes
    /// among each other are taken as independent), for `simulate` and `calibrate --with-effects`.
    pub fn effects_file(&self) -> EffectsFile {
        // What is seen in part only cannot be taken out of the lengths.
        let whole =
            |c: &&Cause| c.level == Level::Lengths && c.parameters.iter().all(|p| p.u.is_finite());
        let causes = || self.causes.iter().filter(whole);
        let size = causes().map(|cause| cause.effect.parameters.len()).sum();
        let mut covariance = vec![vec![0.0; size]; size];
        let mut first = 0;
        for cause in causes() {
            let count = cause.effect.parameters.len();
            for (k, value) in cause.covariance.iter().enumerate() {
                covariance[first + k / count][first + k % count] = *value;
            }
            first += count;
        }
        EffectsFile {
            campaign: self.campaign.clone(),
            effects: causes().map(|c| cause::given(c, &self.scene)).collect(),
            covariance: Some(covariance),
        }
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
    rejected: Vec<RejectedFile<'a>>,
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
    leave_one_station_out: Option<HeldOutRatioFile>,
}

#[derive(Serialize, JsonSchema)]
struct HeldOutRatioFile {
    heldout_rms_ratio: f64,
    interval: [f64; 2],
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
struct RejectedFile<'a> {
    file: &'a str,
    row: usize,
    error_um: f64,
    u_um: f64,
    reason: &'a str,
}

#[derive(Serialize, JsonSchema)]
struct SharesFile {
    causes: Vec<f64>,
    disturbances: Vec<f64>,
    unexplained: f64,
    noise: f64,
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
    before: MisfitFile,
    after: MisfitFile,
    gain: Option<GainFile>,
    shares: SharesFile,
    unexplained: Option<UnexplainedFile<'a>>,
    tests: Vec<TestFile<'a>>,
    tests_after: Vec<TestFile<'a>>,
    places: Vec<PlaceFile<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct TestFile<'a> {
    varies_with: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    detail: Option<&'a str>,
    columns: usize,
    p_value: f64,
}

#[derive(Serialize, JsonSchema)]
struct PlaceFile<'a> {
    by: &'static str,
    name: &'a str,
    readings: usize,
    before_um: f64,
    after_um: f64,
}

impl<'a> File<'a> {
    fn new(diagnosis: &'a Diagnosis) -> Self {
        let headline = diagnosis.headline();
        let ranked = diagnosis.causes.iter().enumerate();
        Self {
            format: FORMAT.name,
            version: FORMAT.version,
            campaign: &diagnosis.campaign,
            verdict: diagnosis.verdict.name(),
            noise_floor_um: headline.map(|l| um(l.noise_floor_um)),
            before: headline.map(|l| misfit(&l.before)).unwrap_or_default(),
            after: headline.map(|l| misfit(&l.after)).unwrap_or_default(),
            gain: headline.and_then(|l| l.gain.as_ref()).map(gain),
            causes: ranked
                .map(|(i, cause)| CauseFile::new(i + 1, cause, &diagnosis.scene))
                .collect(),
            disturbances: diagnosis
                .disturbances
                .iter()
                .map(|own| DisturbanceFile::new(own, &diagnosis.scene))
                .collect(),
            unexplained: diagnosis.unexplained.as_ref().map(unexplained),
            rejected: diagnosis.rejected.iter().map(rejected).collect(),
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

fn rejected(rejected: &Rejected) -> RejectedFile<'_> {
    RejectedFile {
        file: &rejected.file,
        row: rejected.row,
        error_um: um(rejected.error_um),
        u_um: um(rejected.u_um),
        reason: &rejected.reason,
    }
}

fn shares(shares: &Shares) -> SharesFile {
    let part = |share: &f64| round(*share, 6);
    SharesFile {
        causes: shares.causes.iter().map(part).collect(),
        disturbances: shares.disturbances.iter().map(part).collect(),
        unexplained: part(&shares.unexplained),
        noise: part(&shares.noise),
    }
}

fn level(level: &LevelReport) -> LevelFile<'_> {
    LevelFile {
        level: level.level.name(),
        data: &level.data,
        noise_floor_um: um(level.noise_floor_um),
        before: misfit(&level.before),
        after: misfit(&level.after),
        gain: level.gain.as_ref().map(gain),
        shares: shares(&level.shares),
        unexplained: level.unexplained.as_ref().map(unexplained),
        tests: level.tests.iter().map(test).collect(),
        tests_after: level.tests_after.iter().map(test).collect(),
        places: level.places.iter().map(place).collect(),
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
        leave_one_station_out: gain.leave_one_station_out.map(|out| HeldOutRatioFile {
            heldout_rms_ratio: round(out.ratio, 4),
            interval: out.interval.map(|bound| round(bound, 4)),
        }),
    }
}

fn test(test: &OmnibusTest) -> TestFile<'_> {
    TestFile {
        varies_with: test.varies_with,
        detail: test.detail.as_deref(),
        columns: test.columns,
        p_value: significant(test.p_value),
    }
}

fn place(place: &Place) -> PlaceFile<'_> {
    PlaceFile {
        by: place.by,
        name: &place.name,
        readings: place.readings,
        before_um: um(place.before_um),
        after_um: um(place.after_um),
    }
}

fn unseen(unseen: &NotObservable) -> NotObservableFile<'_> {
    let bias = unseen.bias_per_unit.iter();
    NotObservableFile {
        effect: unseen.effect,
        subject: &unseen.subject,
        reason: &unseen.reason,
        bias_per_unit: Ordered(
            bias.map(|(name, text)| (name.clone(), text.as_str()))
                .collect(),
        ),
        measure: &unseen.measure,
    }
}

/// To a picometre.
fn um(value_um: f64) -> f64 {
    round(value_um, 6)
}

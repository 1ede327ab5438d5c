//! Verbs that begin with a campaign.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};
use trueaxis_calibrate::{Method, ReferencePoint, Settings};
use trueaxis_identify::SixRows;

use super::{ResultArgs, point, seed, trials};

#[derive(Debug, ClapArgs)]
pub(crate) struct CheckArgs {
    /// The campaign file.
    #[arg(value_name = "CAMPAIGN.json")]
    pub(crate) campaign: PathBuf,

    /// Also print its contents and coverage as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct CalibrateArgs {
    /// The campaign file.
    #[arg(value_name = "CAMPAIGN.json")]
    pub(crate) campaign: PathBuf,

    #[command(flatten)]
    pub(crate) model: ModelArgs,

    /// Also write the covariance of all results: covariance.npy and covariance.json (the
    /// names and units of its rows).
    #[arg(long)]
    pub(crate) covariance: bool,

    /// Also write what an undetected error of each length would do: reliability.npy (lengths by
    /// results) and reliability.json (smallest detectable errors, names of rows and columns).
    #[arg(long)]
    pub(crate) reliability: bool,

    /// Take these effects out of the lengths first: an effects.json, or the causes that a
    /// diagnosis.json names in the lengths. Their uncertainty enters that of the results.
    #[arg(long, value_name = "FILE", conflicts_with = "reliability")]
    pub(crate) with_effects: Option<PathBuf>,

    /// Also list squareness and tilts with the signs of the paper (opposite for some of them).
    #[arg(long)]
    pub(crate) paper_signs: bool,

    /// Write no report.html.
    #[arg(long)]
    pub(crate) no_report: bool,

    #[command(flatten)]
    pub(crate) result: ResultArgs,

    /// End with exit code 6 if the residuals or the shape of the targets reject the model.
    #[arg(long)]
    pub(crate) fail_on_misfit: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct DiagnoseArgs {
    /// The campaign file.
    #[arg(value_name = "CAMPAIGN.json")]
    pub(crate) campaign: PathBuf,

    /// Judge the verification readings against this calibration (imported, or of another campaign), with
    /// its covariance.npz beside it. Lengths and points of the campaign are ignored.
    #[arg(long, value_name = "CALIBRATION.json")]
    pub(crate) calibration: Option<PathBuf>,

    /// The readings were taken with the compensation of that calibration switched on.
    #[arg(long, requires = "calibration")]
    pub(crate) compensated: bool,

    /// Write no report.html.
    #[arg(long)]
    pub(crate) no_report: bool,

    #[command(flatten)]
    pub(crate) result: ResultArgs,

    /// End with exit code 6 if the data contradict the model.
    #[arg(long)]
    pub(crate) fail_on_misfit: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct MontecarloArgs {
    /// The campaign file.
    #[arg(value_name = "CAMPAIGN.json")]
    pub(crate) campaign: PathBuf,

    /// Number of trials, 100 at least; with --digits the largest number [default: 10000; with --digits
    /// 1000000, or as many as 2 GiB hold].
    #[arg(long, value_name = "N", value_parser = trials, allow_negative_numbers = true)]
    pub(crate) trials: Option<usize>,

    /// Seed of the noise: the same seed gives the same file, on any number of threads.
    #[arg(long, default_value_t = 1, value_parser = seed, allow_negative_numbers = true)]
    pub(crate) seed: u64,

    /// Stop when this many significant digits of every uncertainty are stable (JCGM 101, 7.9).
    #[arg(long, value_name = "DIGITS", value_parser = clap::value_parser!(u32).range(1..=3), allow_negative_numbers = true)]
    pub(crate) digits: Option<u32>,

    /// Number of threads [default: all].
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub(crate) threads: Option<NonZeroUsize>,

    #[command(flatten)]
    pub(crate) model: ModelArgs,

    #[command(flatten)]
    pub(crate) result: ResultArgs,
}

/// How a campaign is calibrated.
#[derive(Debug, ClapArgs)]
pub(crate) struct ModelArgs {
    /// How component errors follow from the measurement.
    #[arg(long, value_enum, default_value_t = MethodArg::Joint)]
    pub(crate) method: MethodArg,

    /// Give each side of approach a curve of its own.
    #[arg(long)]
    pub(crate) by_direction: bool,

    /// Point of the stage whose translation is reported: `origin`, `centroid` of the targets, or
    /// its coordinates at home in mm, such as `100,250,50`.
    #[arg(long, value_name = "POINT", default_value = "origin", value_parser = reference_point, allow_hyphen_values = true)]
    pub(crate) reference_point: ReferencePoint,

    /// Adjust all lengths as they are: remove no gross errors, split no interrupted occupations.
    #[arg(long)]
    pub(crate) no_robust: bool,
}

impl ModelArgs {
    /// The settings that these arguments mean.
    pub(crate) fn settings(&self) -> Settings {
        let mut settings = Settings {
            reference_point: self.reference_point,
            ..Settings::default()
        };
        settings.poses.method = match self.method {
            MethodArg::Joint => Method::Joint,
            MethodArg::Nine => Method::Nine,
            MethodArg::Six => Method::Six(SixRows::PAPER),
        };
        settings.poses.by_direction = self.by_direction;
        settings.poses.robust = !self.no_robust;
        settings
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum MethodArg {
    /// All lengths in one adjustment with rigid stages.
    Joint,
    /// Free points first, then all nine equations of each step, weighted.
    Nine,
    /// Free points first, then six equations of each step (the paper's closed path).
    Six,
}

fn threads(text: &str) -> Result<NonZeroUsize, &'static str> {
    text.parse().map_err(|_| "expected a whole number from 1")
}

fn reference_point(text: &str) -> Result<ReferencePoint, String> {
    match text {
        "origin" => return Ok(ReferencePoint::Origin),
        "centroid" => return Ok(ReferencePoint::Centroid),
        _ => {}
    }
    let at = point(text).map(ReferencePoint::At);
    at.map_err(|_| {
        "expected `origin`, `centroid` or three numbers in mm, as `100,250,50`".to_owned()
    })
}

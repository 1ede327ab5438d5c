//! The command line.

mod about;
mod campaign;
mod import;
mod init;

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args as ClapArgs, Parser, Subcommand};
use nalgebra::Point3;
use trueaxis_compensate::{Format, TableSign};

use crate::output::{OutputError, Results};

pub(crate) use about::{ExplainArgs, SchemaArgs, SchemaName};
pub(crate) use campaign::{CalibrateArgs, CheckArgs, DiagnoseArgs, MontecarloArgs};
pub(crate) use import::{ImportArgs, ImportTableArgs, ImportWhat};
pub(crate) use init::{InitArgs, MachineType};

/// Every geometric error of a machine tool from the lengths that one laser tracker measures to
/// three targets.
///
/// Exit codes: 0 good; 2 usage; 3 an input file is wrong; 4 no answer fits the data; 5 the data do
/// not determine what is sought; 6 the data reject the model (--fail-on-misfit); 70 internal error.
#[derive(Debug, Parser)]
#[command(name = "trueaxis", version, max_term_width = 100)]
pub(crate) struct Args {
    /// Print nothing but errors.
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,

    #[command(subcommand)]
    pub(crate) verb: Verb,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Begins a campaign: writes campaign.json, a table of the rows to measure, and a map for exports.
    Init(InitArgs),
    /// Makes a table of a campaign from the export of an instrument, or a calibration from tables for a control.
    Import(ImportArgs),
    /// Reads a campaign, checks it, and says what is in it.
    Check(CheckArgs),
    /// Finds all component and location errors; writes calibration.json.
    ///
    /// Beside it: covariance.npz, residuals.csv, report.html.
    Calibrate(CalibrateArgs),
    /// Predicts the error of the tool at any positions from a calibration; writes predicted.csv.
    Predict(PredictArgs),
    /// Finds the volumetric error over the working volume of a calibration; writes volume.json.
    ///
    /// Beside it: volumetric.csv and volumetric.vti.
    Volume(VolumeArgs),
    /// Writes compensation tables for a control from a calibration, and says what they can correct.
    Export(ExportArgs),
    /// Compares a campaign's verification readings with what a calibration predicts; writes
    /// verification.json.
    Verify(VerifyArgs),
    /// Says how two calibrations of one machine differ; writes comparison.json.
    ///
    /// Beside it: report.html.
    Compare(CompareArgs),
    /// Says what the calibrated model gets wrong and why; writes diagnosis.json.
    ///
    /// Beside it: report.html, and effects.json and replay.json if the lengths show causes.
    Diagnose(DiagnoseArgs),
    /// Shows the results in a folder as one page; writes report.html and its figures.
    Report(ReportArgs),
    /// Checks the uncertainties of a calibration by redrawing its noise; writes montecarlo.json.
    Montecarlo(MontecarloArgs),
    /// Makes a campaign with known errors from a scenario; writes the campaign and truth.json.
    Simulate(SimulateArgs),
    /// Prints the JSON Schema of a document, for editors and other programs.
    Schema(SchemaArgs),
    /// Says what the code of an error means, and how to correct it.
    Explain(ExplainArgs),
    /// Prints the completion script for a shell.
    Completions(CompletionsArgs),
    /// Reproduces Table 1 of the paper: how multilateration propagates noise, by Monte Carlo.
    Table1(Table1Args),
}

/// Where the result of a verb goes.
#[derive(Debug, ClapArgs)]
pub(crate) struct ResultArgs {
    /// Folder for the results [default: one in the current directory, named after the campaign].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Also print the result as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

impl ResultArgs {
    /// The folder for the results of this campaign.
    pub(crate) fn folder(&self, campaign: &str) -> Result<Results, OutputError> {
        Results::new(self.out.as_deref(), campaign)
    }
}

#[derive(Debug, ClapArgs)]
pub(crate) struct PredictArgs {
    /// The calibration, with covariance.npz beside it.
    #[arg(value_name = "CALIBRATION.json")]
    pub(crate) calibration: PathBuf,

    /// Table with a column for each axis (mm, degrees), and optionally `x_mm,y_mm,z_mm`: the point of
    /// the tool in the reference frame at home [default: the reference point of the tool's last axis].
    #[arg(value_name = "POSITIONS.csv")]
    pub(crate) positions: PathBuf,

    #[command(flatten)]
    pub(crate) result: ResultArgs,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct VolumeArgs {
    /// The calibration, with covariance.npz beside it.
    #[arg(value_name = "CALIBRATION.json")]
    pub(crate) calibration: PathBuf,

    /// Nodes of the grid along each linear axis, from its first to its last step; the positions of
    /// all other axes are spread over their steps.
    #[arg(long, value_name = "N", default_value_t = 21, value_parser = points, allow_negative_numbers = true)]
    pub(crate) points: u8,

    /// The tool point in the reference frame at home, mm, as `100,250,50` [default: the reference
    /// point of the tool's last axis].
    #[arg(long, value_name = "POINT", value_parser = point, allow_hyphen_values = true)]
    pub(crate) tool: Option<Point3<f64>>,

    /// Number of draws of the calibration's errors for the intervals, 100 at least; 0 for no intervals.
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = draws, allow_negative_numbers = true)]
    pub(crate) draws: u16,

    /// Seed of the draws: the same seed gives the same files, on any number of threads.
    #[arg(long, default_value_t = 1, value_parser = seed, allow_negative_numbers = true)]
    pub(crate) seed: u64,

    #[command(flatten)]
    pub(crate) result: ResultArgs,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct ExportArgs {
    /// The control, or the format of the tables.
    #[arg(value_name = "FORMAT", value_parser = named(Format::ALL, Format::name, Format::description))]
    pub(crate) format: Format,

    /// The calibration, with covariance.npz beside it.
    #[arg(value_name = "CALIBRATION.json")]
    pub(crate) calibration: PathBuf,

    /// Folder for the tables [default: one in the current directory, named after the campaign].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Export only this axis [default: all that were measured].
    #[arg(long, value_name = "NAME")]
    pub(crate) axis: Option<String>,

    /// Spacing of the points, mm (rotary axes: degrees) [default: the steps of the measurement].
    #[arg(long, value_name = "MM", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,

    /// The tool point in the reference frame at home, mm, as `100,250,50`: one-dimensional tables are
    /// right for the lines along which the axes move it from home [default: the reference point of
    /// the tool's last axis].
    #[arg(long, value_name = "POINT", value_parser = point, allow_hyphen_values = true)]
    pub(crate) at: Option<Point3<f64>>,

    /// The tables that were active while the machine was measured, as their folder or file: the new ones
    /// contain what the targets saw of them (grid, linuxcnc, sinumerik, heidenhain).
    #[arg(long, value_name = "OLD")]
    pub(crate) onto: Option<PathBuf>,

    /// Required for heidenhain, and only there: which way the control moves the axis for a positive value; if
    /// it is left out, the message says how to find out.
    #[arg(long, value_name = "SIGN", value_parser = named(TableSign::ALL, TableSign::name, TableSign::description))]
    pub(crate) sign: Option<TableSign>,

    /// Only for sinumerik, experimental: also write products of tables, the angles of the linear axes times
    /// the positions of the others, so that the tables are right away from their lines, too; and a
    /// small trial to load first.
    #[arg(long)]
    pub(crate) levers: bool,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct CompareArgs {
    /// The calibration to start from, with its covariance.npz beside it.
    #[arg(value_name = "A.json")]
    pub(crate) first: PathBuf,

    /// The calibration to compare with it, of the same machine, with its covariance.npz beside it.
    #[arg(value_name = "B.json")]
    pub(crate) second: PathBuf,

    /// Write no report.html.
    #[arg(long)]
    pub(crate) no_report: bool,

    #[command(flatten)]
    pub(crate) result: ResultArgs,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct VerifyArgs {
    /// The calibration, with covariance.npz beside it.
    #[arg(value_name = "CALIBRATION.json")]
    pub(crate) calibration: PathBuf,

    /// The campaign with the readings (`verification`), of the same machine.
    #[arg(value_name = "CAMPAIGN.json")]
    pub(crate) campaign: PathBuf,

    /// The readings were taken with the compensation switched on: compare them with the prediction
    /// for corrected commands.
    #[arg(long)]
    pub(crate) compensated: bool,

    /// Write no report.html.
    #[arg(long)]
    pub(crate) no_report: bool,

    #[command(flatten)]
    pub(crate) result: ResultArgs,

    /// End with exit code 6 if more readings differ from the prediction by more than U (k = 2) than
    /// chance explains.
    #[arg(long)]
    pub(crate) fail_on_misfit: bool,
}

/// Values by their names, with what they mean.
fn named<T: Copy + Send + Sync + 'static, const N: usize>(
    all: [T; N],
    name: fn(T) -> &'static str,
    meaning: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let names = all.map(|one| PossibleValue::new(name(one)).help(meaning(one)));
    PossibleValuesParser::new(names).try_map(move |given| {
        let found = all.into_iter().find(|one| name(*one) == given);
        found.ok_or("there is no such name")
    })
}

#[derive(Debug, ClapArgs)]
pub(crate) struct ReportArgs {
    /// The folder that `calibrate`, `diagnose`, `verify`, `compare` and `volume` wrote.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,

    /// Your own template instead of the program's, which is crates/report/src/report.html (minijinja).
    #[arg(long, value_name = "FILE")]
    pub(crate) template: Option<PathBuf>,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct SimulateArgs {
    /// The scenario file.
    #[arg(value_name = "SCENARIO.json")]
    pub(crate) scenario: PathBuf,

    /// Folder for the campaign [default: one in the current directory, named after the campaign].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Seed of the noise: the same seed gives the same files.
    #[arg(long, default_value_t = 1, value_parser = seed, allow_negative_numbers = true)]
    pub(crate) seed: u64,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct Table1Args {
    /// Number of trials for each row of the table.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(100..), allow_negative_numbers = true)]
    pub(crate) trials: u32,

    /// Seed of the noise: the same seed gives the same table, on any number of threads.
    #[arg(long, default_value_t = 1, value_parser = seed, allow_negative_numbers = true)]
    pub(crate) seed: u64,

    /// Also print the table as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok();
    let positive = number.filter(|x: &f64| x.is_finite() && *x > 0.0);
    positive.ok_or_else(|| "expected a number above zero".to_owned())
}

/// Fewer draws, or trials, leave too few outside an interval of 95 % to say where it ends.
const LEAST_DRAWS: usize = 100;

fn draws(text: &str) -> Result<u16, String> {
    let number = text.parse().ok();
    let enough = number.filter(|&n| n == 0 || usize::from(n) >= LEAST_DRAWS);
    enough.ok_or_else(|| {
        format!(
            "expected 0, or {LEAST_DRAWS} to {}: fewer give no interval of 95 %",
            u16::MAX
        )
    })
}

fn points(text: &str) -> Result<u8, &'static str> {
    let number = text.parse().ok().filter(|n| (2..=128).contains(n));
    number.ok_or("expected a whole number from 2 to 128")
}

fn seed(text: &str) -> Result<u64, &'static str> {
    text.parse().map_err(|_| "expected a whole number from 0")
}

fn trials(text: &str) -> Result<usize, String> {
    let number = text.parse().ok();
    let enough = number.filter(|&n| n >= LEAST_DRAWS);
    enough.ok_or_else(|| {
        format!(
            "expected a whole number from {LEAST_DRAWS}, such as 200000 as recommended (JCGM 101, 7.2.2): fewer give no interval of 95 %"
        )
    })
}

fn point(text: &str) -> Result<Point3<f64>, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|x: &f64| x.is_finite()))
        .collect::<Option<_>>()
        .unwrap_or_default();
    match numbers.as_slice() {
        &[x, y, z] => Ok(Point3::new(x, y, z)),
        _ => Err("expected three numbers in mm, as `100,250,50`".to_owned()),
    }
}

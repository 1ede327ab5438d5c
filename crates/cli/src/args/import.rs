//! `import`: one form for each kind of file that comes from elsewhere.

use std::path::PathBuf;

use clap::{Args as ClapArgs, Subcommand};

use crate::import::calibration::ImportCalibrationArgs;

#[derive(Debug, ClapArgs)]
pub(crate) struct ImportArgs {
    #[command(subcommand)]
    pub(crate) what: ImportWhat,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ImportWhat {
    /// Tables that another system wrote for a control; writes calibration.json.
    Calibration(ImportCalibrationArgs),
    /// Lengths of an interferometer; writes lengths.csv.
    Lengths(ImportTableArgs),
    /// Coordinates of targets by any 3D instrument; writes points.csv.
    Points(ImportTableArgs),
}

#[derive(Debug, ClapArgs)]
pub(crate) struct ImportTableArgs {
    /// The export of the instrument: any text with a line for each reading.
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,

    /// What its columns mean (docs/import.md).
    #[arg(long, value_name = "MAP.toml")]
    pub(crate) map: PathBuf,

    /// The table to write, which must not exist yet [default: lengths.csv or points.csv in the
    /// current directory].
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

//! `trueaxis import`: what other systems measured.

pub(crate) mod calibration;

use clap::Subcommand;

use crate::exit::Exit;

#[derive(Debug, Subcommand)]
pub(crate) enum ImportVerb {
    /// Makes a calibration of the tables that another system wrote for a control.
    Calibration(calibration::ImportCalibrationArgs),
}

pub(crate) fn run(verb: &ImportVerb) -> anyhow::Result<Exit> {
    match verb {
        ImportVerb::Calibration(args) => calibration::run(args),
    }
}

//! `init`.

use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};

#[derive(Debug, ClapArgs)]
pub(crate) struct InitArgs {
    /// Folder for the files, made if it is not there; no file in it is overwritten. Its name
    /// becomes that of the campaign.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,

    /// The machine to start from.
    #[arg(long = "type", value_name = "TYPE", value_enum, default_value_t = MachineType::Fxyz)]
    pub(crate) machine_type: MachineType,

    /// Coordinates of the targets are measured, not lengths from several stations.
    #[arg(long)]
    pub(crate) points: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum MachineType {
    /// X, Y and Z move the tool.
    Fxyz,
    /// X, Y and Z move the tool, A and C the table.
    FiveAxis,
    /// A table that turns, C.
    RotaryStage,
}

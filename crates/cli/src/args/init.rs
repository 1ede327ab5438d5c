//! `init`.

use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};

#[derive(Debug, ClapArgs)]
pub(crate) struct InitArgs {
    /// Folder for the files, created if it does not exist; no file in it is overwritten. The campaign
    /// takes its name.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,

    /// The machine to start from.
    #[arg(long = "type", value_name = "TYPE", value_enum, default_value_t = MachineType::Fxyz)]
    pub(crate) machine_type: MachineType,

    /// The instrument measures coordinates of the targets, not lengths from several stations.
    #[arg(long)]
    pub(crate) points: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum MachineType {
    /// X, Y and Z move the tool.
    Fxyz,
    /// X, Y and Z move the tool, A and C the workpiece.
    FiveAxis,
    /// A rotary table, C.
    RotaryStage,
}

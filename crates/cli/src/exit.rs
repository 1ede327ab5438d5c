//! Exit codes.

use std::process::ExitCode;

use trueaxis_calibrate::{Error as Calibrate, ReadError};
use trueaxis_diagnose::Error as Diagnose;
use trueaxis_poses::Error as Poses;

use crate::effects_input::EffectsInputError;
use crate::export::OldTablesError;
use crate::import::calibration::ImportError;
use crate::output::OutputError;
use crate::report::TemplateUnreadable;

/// How the program ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exit {
    /// 0.
    Good,
    /// 2: the command line is wrong (clap's own code), or what it asks for cannot be written or made.
    Usage,
    /// 3: an input file is wrong.
    Input,
    /// 4: the adjustment did not reach an answer that fits the data.
    NotConverged,
    /// 5: the data do not determine what is sought.
    NotIdentifiable,
    /// 6: the data reject the model, and the user asked to fail then.
    Misfit,
    /// 70: a bug.
    Internal,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.code())
    }
}

impl Exit {
    /// What the shell sees.
    pub(crate) fn code(self) -> u8 {
        match self {
            Self::Good => 0,
            Self::Usage => 2,
            Self::Input => 3,
            Self::NotConverged => 4,
            Self::NotIdentifiable => 5,
            Self::Misfit => 6,
            Self::Internal => 70,
        }
    }

    /// The code for an error, by its innermost known kind.
    pub(crate) fn of(error: &anyhow::Error) -> Self {
        use trueaxis_campaign::{Error as Campaign, Problem};
        for cause in error.chain() {
            if let Some(error) = cause.downcast_ref::<Campaign>() {
                return match error.problem {
                    Problem::Unwritable { .. } => Self::Usage,
                    _ => Self::Input,
                };
            }
            if let Some(error) = cause.downcast_ref::<trueaxis_simulate::Error>() {
                return match *error.problem {
                    trueaxis_simulate::Problem::Write(_) => Self::Usage,
                    _ => Self::Input,
                };
            }
            if let Some(error) = cause.downcast_ref::<trueaxis_montecarlo::Error>() {
                return match error {
                    trueaxis_montecarlo::Error::NotFinite { .. } => Self::NotConverged,
                    _ => Self::Usage,
                };
            }
            if cause.is::<OutputError>() || cause.is::<TemplateUnreadable>() {
                return Self::Usage;
            }
            if cause.is::<ReadError>()
                || cause.is::<trueaxis_calibrate::OtherMachine>()
                || cause.is::<ImportError>()
                || cause.is::<trueaxis_files::DocumentError>()
                || cause.is::<trueaxis_import::Error>()
            {
                return Self::Input;
            }
            if let Some(error) = cause.downcast_ref::<trueaxis_compensate::Error>() {
                return match error {
                    trueaxis_compensate::Error::NotContracting { .. } => Self::NotConverged,
                    trueaxis_compensate::Error::NothingRead => Self::NotIdentifiable,
                    trueaxis_compensate::Error::OtherMachine(_)
                    | trueaxis_compensate::Error::Table { .. } => Self::Input,
                    _ => Self::Usage,
                };
            }
            if let Some(error) = cause.downcast_ref::<trueaxis_report::Error>() {
                return match error {
                    trueaxis_report::Error::Template { .. } => Self::Usage,
                    _ => Self::Input,
                };
            }
            if cause.is::<OldTablesError>() {
                return Self::Input;
            }
            if cause.is::<EffectsInputError>() || cause.is::<trueaxis_effects::Error>() {
                return Self::Input;
            }
            if let Some(error) = cause.downcast_ref::<Diagnose>() {
                return match error {
                    Diagnose::Calibrate(error) => Self::of_calibration(error),
                    Diagnose::Adjustment(_) => Self::NotConverged,
                    Diagnose::NothingMeasured | Diagnose::NothingRead => Self::NotIdentifiable,
                    Diagnose::OtherMachine(_) => Self::Input,
                };
            }
            if let Some(error) = cause.downcast_ref::<Calibrate>() {
                return Self::of_calibration(error);
            }
        }
        Self::Internal
    }

    fn of_calibration(error: &Calibrate) -> Self {
        match error {
            Calibrate::Poses(error) => Self::of_poses(error),
            Calibrate::Mistaken { error, .. } => Self::of_calibration(error),
            Calibrate::NotIdentifiable { .. } => Self::NotIdentifiable,
            Calibrate::NotThatMotion { .. }
            | Calibrate::SeveralAxesMove { .. }
            | Calibrate::OtherReferencePoint { .. } => Self::Input,
            Calibrate::NotSettled { .. } => Self::NotConverged,
            Calibrate::CovarianceTooLarge { .. } | Calibrate::ReliabilityTooLarge { .. } => {
                Self::Usage
            }
        }
    }

    fn of_poses(error: &Poses) -> Self {
        match error {
            Poses::NothingMeasured | Poses::NotIdentifiable { .. } => Self::NotIdentifiable,
            Poses::EffectsWithoutLengths => Self::Input,
            Poses::NotConverged { .. }
            | Poses::NotTrustworthy { .. }
            | Poses::Contradictory { .. }
            | Poses::RanAway { .. }
            | Poses::StationUnexplained { .. } => Self::NotConverged,
            Poses::Numerical { .. } => Self::Internal,
        }
    }
}

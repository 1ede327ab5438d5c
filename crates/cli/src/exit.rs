//! Exit codes.

use std::process::ExitCode;

use crate::codes;
use crate::talk::say;

/// How the program ends, with what the shell sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Exit {
    Good = 0,
    /// The command line is wrong (clap's own code), or what it asks for cannot be written or made.
    Usage = 2,
    /// An input file is wrong.
    Input = 3,
    /// The adjustment did not reach an answer that fits the data.
    NotConverged = 4,
    /// The data do not determine what is sought.
    NotIdentifiable = 5,
    /// The data reject the model, and the user asked to fail then.
    Misfit = 6,
    /// A bug.
    Internal = 70,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

impl Exit {
    /// How a verb ends with `--fail-on-misfit` if the data reject the model.
    pub(crate) fn of_misfit(is_rejected: bool) -> Self {
        if !is_rejected {
            return Self::Good;
        }
        say("the data reject the model (--fail-on-misfit)");
        Self::Misfit
    }

    /// How an error ends the program, by its code: that of what nobody foresaw is a bug.
    pub(crate) fn of(error: &anyhow::Error) -> Self {
        let Some(code) = codes::of(error) else {
            return Self::Internal;
        };
        match (code, &code[..2]) {
            ("E306", _) => Self::Internal,
            ("E601", _) | (_, "E3") => Self::NotConverged,
            ("E401" | "E404", _) => Self::NotIdentifiable,
            // Tables that --onto names.
            ("E604" | "E609", _) => Self::Input,
            ("E004" | "E005", _) | (_, "E6") => Self::Usage,
            _ => Self::Input,
        }
    }
}

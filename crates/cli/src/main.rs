//! `trueaxis`: from lengths to every geometric error of a machine tool.
//!
//! Data go to standard output only when asked for with `--json`, messages to standard error. Exit
//! codes are part of the interface: see [`exit`].

mod args;
mod calibrate;
mod check;
mod codes;
mod compare;
mod completions;
mod diagnose;
mod drawing;
mod effects_input;
mod error_json;
mod exit;
mod explain;
mod export;
mod given_campaign;
mod given_file;
mod import;
mod init;
mod montecarlo;
mod montecarlo_file;
mod other_machine;
mod output;
mod predict;
mod progress;
mod report;
mod schema;
mod simulate;
mod summary;
mod table1;
mod talk;
mod traceability;
mod verify;
mod volume;

use std::process::ExitCode;

use clap::Parser;

use crate::args::{Args, Verb};
use crate::exit::Exit;

fn main() -> ExitCode {
    let args = Args::try_parse().unwrap_or_else(|error| misused(&error));
    match args.quiet {
        true => talk::be_quiet(),
        false => progress::start_clock(),
    }
    let verb = || match &args.verb {
        Verb::Check(args) => check::execute(args),
        Verb::Calibrate(args) => calibrate::execute(args),
        Verb::Compare(args) => compare::execute(args),
        Verb::Completions(args) => completions::execute(args),
        Verb::Diagnose(args) => diagnose::execute(args),
        Verb::Explain(args) => explain::execute(args),
        Verb::Export(args) => export::execute(args),
        Verb::Import(args) => import::execute(args),
        Verb::Init(args) => init::execute(args),
        Verb::Montecarlo(args) => montecarlo::execute(args),
        Verb::Predict(args) => predict::execute(args),
        Verb::Report(args) => report::execute(args),
        Verb::Schema(args) => schema::execute(args),
        Verb::Simulate(args) => simulate::execute(args),
        Verb::Table1(args) => table1::execute(args),
        Verb::Verify(args) => verify::execute(args),
        Verb::Volume(args) => volume::execute(args),
    };
    // A panic is a bug of ours: the default hook says where, the exit code says so.
    let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(verb));
    let exit = match outcome {
        Ok(Ok(exit)) => exit,
        Ok(Err(error)) => failed(&error, Exit::of(&error)),
        Err(_) => {
            let text = "internal error: please report it with the campaign that causes it";
            failed(&anyhow::Error::msg(text), Exit::Internal)
        }
    };
    exit.into()
}

/// Ends the program with clap's words for a wrong command line, or with the help asked for.
fn misused(error: &clap::Error) -> ! {
    if error.use_stderr() {
        let text = error.render().to_string();
        let what = text.split("\n\n").next().unwrap_or_default();
        let what = what.trim_start_matches("error: ").to_owned();
        tell_programs(&anyhow::Error::msg(what), Exit::Usage);
    }
    error.exit()
}

/// Says why there is no result.
fn failed(error: &anyhow::Error, exit: Exit) -> Exit {
    talk::error(error);
    tell_programs(error, exit);
    exit
}

/// The same for programs, where they asked for data.
fn tell_programs(error: &anyhow::Error, exit: Exit) {
    if std::env::args_os().any(|arg| arg == "--json") {
        // That standard output cannot be written does not change why there is no result.
        let _ = output::print(&error_json::text(error, exit));
    }
}

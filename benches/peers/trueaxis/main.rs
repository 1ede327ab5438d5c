//! The side of trueaxis in the comparison with other solvers; `benches/peers/run` calls it.
//!
//! ```text
//! peers write FOLDER                        writes the problems
//! peers solve FOLDER MODEL SOLVER TIMES     solves one: iterations, then seconds of each solve
//! peers table FOLDER                        compares times and solutions
//! ```
#![expect(clippy::print_stdout, reason = "standard output is what it is for")]

mod files;
mod solution;
mod solve;
mod table;

use std::path::Path;

use anyhow::{Result, bail};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["write", folder] => files::write_all(Path::new(folder)),
        ["solve", folder, model, solver, times] => {
            solve::run(Path::new(folder), model, solver, times.parse()?)
        }
        ["table", folder] => table::print(Path::new(folder)),
        _ => bail!("usage: peers write FOLDER | solve FOLDER MODEL SOLVER TIMES | table FOLDER"),
    }
}

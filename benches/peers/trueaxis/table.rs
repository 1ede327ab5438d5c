//! The tables of all times and differences: solvers down, problems across.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Result;
use trueaxis_benches::{Model, SIZES};

use crate::files::read_rows;
use crate::solution::Solution;

const OURS: &str = "trueaxis";

/// Prints medians, ratios to trueaxis (of the same turn, and of these the median), iterations, and largest
/// differences of the solutions.
pub(crate) fn print(folder: &Path) -> Result<()> {
    let problems = SIZES.map(|(name, ..)| name).into_iter();
    let columns: Vec<(String, PathBuf)> = problems
        .flat_map(|problem| Model::ALL.map(|model| (problem, model.name())))
        .map(|(problem, model)| {
            (
                format!("{problem} {model}"),
                folder.join(problem).join(model),
            )
        })
        .collect();
    let mut solvers = BTreeSet::new();
    for (_, path) in &columns {
        let Some((folder, model)) = path.parent().zip(path.file_name()) else {
            continue;
        };
        for entry in fs::read_dir(folder)? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            let solver = name.strip_prefix(&format!("{}.", model.to_string_lossy()));
            solvers.extend(
                solver
                    .and_then(|s| s.strip_suffix(".times"))
                    .map(str::to_owned),
            );
        }
    }
    let print = |title: &str, cell: &dyn Fn(&Path, &str) -> Result<String>| -> Result<()> {
        let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
        println!(
            "| {title} | {} |\n|{}",
            names.join(" | "),
            " --- |".repeat(1 + names.len())
        );
        for solver in &solvers {
            let of_column = |(_, path): &(String, PathBuf)| {
                let measured = fs::exists(file(path, solver, "times"))?;
                if measured {
                    cell(path, solver)
                } else {
                    Ok(String::new())
                }
            };
            let cells: Result<Vec<String>> = columns.iter().map(of_column).collect();
            println!("| {solver} | {} |", cells?.join(" | "));
        }
        println!();
        Ok(())
    };
    print("median, ms", &|path, solver| {
        Ok(digits(1e3 * median(turns(path, solver)?.concat())))
    })?;
    print("times trueaxis", &|path, solver| {
        let ours = turns(path, OURS)?;
        let pairs = turns(path, solver)?.into_iter().zip(ours);
        let ratios = pairs.map(|(other, ours)| median(other) / median(ours));
        Ok(digits(median(ratios.collect())))
    })?;
    print("iterations", &|path, solver| {
        let turns = read_rows(&file(path, solver, "times"), ' ')?;
        Ok(turns
            .first()
            .map_or(String::new(), |turn| turn[0].to_string()))
    })?;
    print("largest difference, mm", &|path, solver| {
        let solution = Solution::read(&file(path, solver, "solution"))?;
        let difference_mm = Solution::read(&file(path, OURS, "solution"))?.difference_mm(&solution);
        Ok(format!("{difference_mm:.0e}"))
    })
}

fn file(path: &Path, solver: &str, ending: &str) -> PathBuf {
    PathBuf::from(format!("{}.{solver}.{ending}", path.display()))
}

/// The seconds of every solve, turn by turn.
fn turns(path: &Path, solver: &str) -> Result<Vec<Vec<f64>>> {
    let turns = read_rows(&file(path, solver, "times"), ' ')?;
    Ok(turns.into_iter().map(|turn| turn[1..].to_vec()).collect())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        length if length % 2 == 0 => 0.5 * (values[middle - 1] + values[middle]),
        _ => values[middle],
    }
}

/// Three digits.
fn digits(value: f64) -> String {
    match value {
        100.0.. => format!("{value:.0}"),
        10.0.. => format!("{value:.1}"),
        1.0.. => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

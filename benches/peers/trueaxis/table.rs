//! The table of all times and differences.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::Result;

use crate::problem::{MONTE_CARLO, PROBLEMS};
use crate::solution::Solution;

const OURS: &str = "trueaxis";

/// Prints a row for each solver that left times: median, ratio to trueaxis, largest difference
/// of the solutions.
pub(crate) fn print(folder: &Path) -> Result<()> {
    println!("| problem | solver | median | times trueaxis | runs | largest difference, mm |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for problem in PROBLEMS
        .map(|(name, ..)| name)
        .into_iter()
        .chain([MONTE_CARLO])
    {
        let folder = folder.join(problem);
        let times = times(&folder)?;
        let Some(ours) = times.get(OURS).map(|times| median(times)) else {
            continue;
        };
        let solution = Solution::read(&folder, OURS)?;
        for (solver, seconds) in &times {
            let difference_mm = solution.difference_mm(&Solution::read(&folder, solver)?);
            let median = median(seconds);
            println!(
                "| {problem} | {solver} | {} | {:.1} | {} | {difference_mm:.1e} |",
                shown(median),
                median / ours,
                seconds.len()
            );
        }
    }
    Ok(())
}

/// `SOLVER.times` of a problem: a time a line.
fn times(folder: &Path) -> Result<BTreeMap<String, Vec<f64>>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path
            .extension()
            .is_some_and(|extension| extension == "times")
        {
            let text = fs::read_to_string(&path)?;
            let seconds: Result<Vec<f64>, _> = text.lines().map(str::parse).collect();
            let solver = path.file_stem().unwrap_or_default();
            all.insert(solver.to_string_lossy().into_owned(), seconds?);
        }
    }
    Ok(all)
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => f64::NAN,
        length if length % 2 == 0 => 0.5 * (sorted[middle - 1] + sorted[middle]),
        _ => sorted[middle],
    }
}

fn shown(seconds: f64) -> String {
    if seconds < 1e-3 {
        format!("{:.1} µs", seconds * 1e6)
    } else {
        format!("{:.2} ms", seconds * 1e3)
    }
}

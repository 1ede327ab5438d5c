//! trueaxis on one problem.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_multilateration::{Refined, Settings, Trials, refine};

use crate::problem::Problem;
use crate::solution::Solution;

/// Trials of one timing: a clock is too coarse for one of them.
const TRIALS: u32 = 5_000;

/// The one place that says which solver of trueaxis is compared: from the start that the peers get, and
/// without uncertainties, as they do.
pub(crate) fn solve(problem: &Problem) -> Result<Refined<'_>> {
    Ok(refine(
        &problem.network,
        &problem.stations,
        &problem.points,
        &Settings::default(),
    )?)
}

/// Solves a problem some times, prints the seconds that each took, and leaves its solution.
pub(crate) fn run(folder: &Path, name: &str, times: usize) -> Result<()> {
    let problem = Problem::read(folder)?;
    if !problem.trials.is_empty() {
        return run_trials(&problem, folder, name, times);
    }
    let mut solution = None;
    for _ in 0..times {
        let start = Instant::now();
        let solved = solve(black_box(&problem))?;
        println!("{}", start.elapsed().as_secs_f64());
        solution = Some(Solution::of(solved.points_mm(), &solved.stations()));
    }
    solution.map_or(Ok(()), |solution| solution.write(folder, name))
}

/// Seconds per trial, drawing included; the solution is that of the last trial in the files.
fn run_trials(problem: &Problem, folder: &Path, name: &str, times: usize) -> Result<()> {
    let solved = solve(problem)?.solution()?;
    let trials = Trials::new(&problem.network, &solved);
    let mut workspace = trials.workspace();
    let mut errors_mm = vec![0.0; trials.readings()];
    for _ in 0..times {
        let start = Instant::now();
        for trial in 0..TRIALS {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            rng.set_stream(trial.into());
            trials.draw(&mut rng, &mut errors_mm);
            black_box(trials.solve(black_box(&errors_mm), &mut workspace));
        }
        println!("{}", start.elapsed().as_secs_f64() / f64::from(TRIALS));
    }
    let Some(errors_mm) = problem.trials.last() else {
        return Ok(());
    };
    let corrections = trials.solve(errors_mm, &mut workspace);
    let points = solved.points_mm.iter().enumerate();
    let points: Vec<_> = points.map(|(i, p)| p + corrections.point_mm(i)).collect();
    let mut stations = solved.stations;
    for (i, station) in stations.iter_mut().enumerate() {
        station.position_mm += corrections.station_mm(i);
        station.dead_path_mm += corrections.dead_path_mm(i);
    }
    Solution::of(&points, &stations).write(folder, name)
}

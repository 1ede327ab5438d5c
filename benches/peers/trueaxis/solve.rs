//! trueaxis on one problem.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_benches::{Model, Problem, problem};

use crate::solution::Solution;

/// Trials of one timing: a clock is too coarse for one of them.
const TRIALS: u32 = 5_000;

/// Solves a problem some times and prints how many iterations and seconds each took, in one line; leaves
/// the solution.
pub(crate) fn run(folder: &Path, model: &str, solver: &str, times: usize) -> Result<()> {
    let name = folder.file_name().context("a folder")?.to_string_lossy();
    let problem = problem(&name);
    let model = Model::ALL
        .into_iter()
        .find(|m| m.name() == model)
        .context("free or joint")?;
    let run: &dyn Fn() -> f64 = match solver {
        "trueaxis" | "trueaxis-2-threads" => &|| timed(|| problem.adjust(model)),
        "trueaxis-covariance" => &|| timed(|| problem.adjust(model).covariance()),
        "trueaxis-from-nothing" => &|| timed(|| problem.solve(model)),
        "trueaxis-trial" => &|| trials(&problem),
        _ => bail!("no solver {solver}"),
    };
    let seconds: Vec<String> = (0..times).map(|_| run().to_string()).collect();
    let (points, stations, iterations) = problem.adjust(model).found();
    println!("{iterations} {}", seconds.join(" "));
    let file = format!("{}.{solver}.solution", model.name());
    Solution::of(&points, &stations).write(&folder.join(file))
}

fn timed<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64()
}

/// Seconds per trial, drawing included.
fn trials(problem: &Problem) -> f64 {
    let trials = problem.trials();
    let mut workspace = trials.workspace();
    let mut errors_mm = vec![0.0; trials.errors()];
    let all = || {
        for trial in 0..TRIALS {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            rng.set_stream(trial.into());
            trials.draw(&mut rng, &mut errors_mm);
            black_box(trials.solve(black_box(&errors_mm), &mut workspace));
        }
    };
    timed(all) / f64::from(TRIALS)
}

//! Whether anything is left at all: F tests of low harmonics, each through the model's projection.
//!
//! | varies with | columns |
//! | --- | --- |
//! | `time` | progress, and sines and cosines of 1 to 6 waves over the table |
//! | `position` | cosines of ½ to 3 waves over the travel, for each line (ball bar: 2 to 7 waves per turn) |
//! | `direction` | the direction, alone and times the columns of position |
//! | `direction in time` | the direction times cosines of ½ to 3 waves over the table |
//! | `cycle` | each cycle, alone and times the position |
//!
//! What the model absorbs of these columns counts neither as drop nor as rank.

use std::f64::consts::{PI, TAU};

use trueaxis_campaign::VerificationKind;
use trueaxis_files::told_period;

use crate::engine::{Family, MOST_OF_FREEDOM, Omnibus};
use crate::selection::Projection;
use crate::verification::base::{count, cycles, indicators, lines};
use crate::verification::comparison::Comparison;
use crate::verification::problem::Problem;

/// The sides of approach differ by what changes with time.
pub(crate) const IN_TIME: &str = "direction in time";

/// Waves of each family.
const WAVES: usize = 6;

/// All families, whitened.
pub(crate) fn families(
    comparison: &Comparison<'_>,
    whiten: impl Fn(&[f64]) -> Vec<f64>,
) -> Vec<Family> {
    let arrivals = &comparison.arrivals;
    let over =
        |f: &dyn Fn(f64) -> f64| arrivals.iter().map(|a| f(a.progress)).collect::<Vec<f64>>();
    let mut time = vec![over(&|t| t)];
    for k in 1..=WAVES {
        time.push(over(&|t| (TAU * k as f64 * t).sin()));
        time.push(over(&|t| (TAU * k as f64 * t).cos()));
    }
    let position = position_columns(comparison);
    let lines = indicators(&lines(comparison));
    let by_line = lines
        .iter()
        .flat_map(|line| position.iter().map(|c| times(c, line)));
    let by_line: Vec<Vec<f64>> = match comparison.kind {
        VerificationKind::Positioning { .. } => by_line.collect(),
        VerificationKind::Ballbar { .. } => position.clone(),
    };
    let direction: Vec<f64> = arrivals.iter().map(|a| a.direction).collect();
    let of_direction = position.iter().map(|column| times(column, &direction));
    let of_direction = std::iter::once(direction.clone())
        .chain(of_direction)
        .collect();
    // From one side only it would be time under another name.
    let is_of_both = direction.windows(2).any(|two| two[0] * two[1] < 0.0);
    let waves = if is_of_both { WAVES } else { 0 };
    let of_direction_in_time = (1..=waves).map(|k| {
        let wave = over(&|t| (PI * k as f64 * t).cos());
        times(&wave, &direction)
    });
    let of_direction_in_time = of_direction_in_time.collect();
    let cycles = indicators(&cycles(comparison));
    let tilted = cycles.iter().map(|cycle| times(cycle, &position[0]));
    let of_cycle = cycles.iter().cloned().chain(tilted).collect();
    let family = |varies_with, columns: Vec<Vec<f64>>| Family {
        varies_with,
        columns: columns.iter().map(|c| whiten(c)).collect(),
    };
    vec![
        family("time", time),
        family("position", by_line),
        family("direction", of_direction),
        family(IN_TIME, of_direction_in_time),
        family("cycle", of_cycle),
    ]
}

/// Columns that vary with the position along the line or around the circle.
fn position_columns(comparison: &Comparison<'_>) -> Vec<Vec<f64>> {
    match comparison.kind {
        VerificationKind::Positioning { .. } => comparison.waves_of_position(WAVES),
        VerificationKind::Ballbar { .. } => {
            let angles = &comparison.around;
            let wave = |k: usize, f: fn(f64) -> f64| {
                angles.iter().map(|angle| f(k as f64 * angle)).collect()
            };
            (2..=WAVES + 1)
                .flat_map(|k| [wave(k, f64::sin), wave(k, f64::cos)])
                .collect()
        }
    }
}

/// The tests of a model; p-values family-wise over all of them.
pub(crate) fn omnibus(problem: &Problem<'_>, model: &Projection) -> Vec<Omnibus> {
    let mut tests = Omnibus::of_all(model, &problem.families, MOST_OF_FREEDOM);
    let count = tests.len() as f64;
    for Omnibus { test, .. } in &mut tests {
        // 1 - (1 - p)^m without losing small p.
        test.p_value = -(count * (-test.p_value).ln_1p()).exp_m1();
        if test.p_value < STANDS_OUT && test.varies_with == "time" {
            test.detail = period(problem, model);
        }
    }
    tests
}

/// Below this a period is worth a word.
const STANDS_OUT: f64 = 0.01;

/// The period in time that explains most, as text; none if the table is not longer than it.
fn period(problem: &Problem<'_>, model: &Projection) -> Option<String> {
    let arrivals = &problem.comparison.arrivals;
    let duration = arrivals.iter().map(|a| a.elapsed_s).fold(0.0, f64::max);
    let best = best_waves(problem, model).filter(|&waves| waves > 1)?;
    let unit = problem.comparison.unit_of("s");
    Some(told_period(duration / best as f64, unit))
}

/// Waves over the table that explain most.
fn best_waves(problem: &Problem<'_>, model: &Projection) -> Option<usize> {
    let arrivals = &problem.comparison.arrivals;
    let drop = |k: usize| {
        let wave = |f: fn(f64) -> f64| {
            let column = arrivals.iter().map(|a| f(TAU * k as f64 * a.progress));
            problem.whiten(&column.collect::<Vec<_>>())
        };
        let with = model.extended(&[wave(f64::sin), wave(f64::cos)]);
        model.squares() - with.squares()
    };
    let drops = (1..=WAVES).map(|k| (k, drop(k)));
    let best = drops.max_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(waves, _)| waves)
}

/// Whether readings differ between cycles before anything is explained.
pub(crate) fn differs_by_cycle(problem: &Problem<'_>) -> bool {
    let mut tests = omnibus(problem, &problem.listed.base).into_iter();
    tests.any(|t| t.test.varies_with == "cycle" && t.test.p_value < STANDS_OUT)
}

/// Passes from which on something repeats.
const LEAST_PASSES: usize = 3;

/// Whether the period that explains most is a pass, or a cycle there and back: a function of position and side of approach has it.
pub(crate) fn repeats_with_cycle(problem: &Problem<'_>, model: &Projection) -> bool {
    let passes = count(&problem.comparison.passes);
    let is_of_passes = |waves: usize| waves == passes || 2 * waves == passes;
    passes >= LEAST_PASSES && best_waves(problem, model).is_some_and(is_of_passes)
}

fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

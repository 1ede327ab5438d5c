//! Whether anything is left at all: F tests of low harmonics, each through the model's projection.
//!
//! | varies with | columns |
//! | --- | --- |
//! | `time` | progress, and sines and cosines of 1 to 6 waves over the table |
//! | `position` | cosines of ½ to 3 waves over the travel, for each line (ball bar: 2 to 7 waves per turn) |
//! | `reversal` | ball bar: what fades away within a degree or four after an axis turns round, for each end of each axis |
//! | `position in time` | cosines of ½ to 3 waves over the travel (ball bar: as above) times progress |
//! | `direction` | the direction, alone and times the columns of position |
//! | `direction in time` | the direction times cosines of ½ to 3 waves over the table |
//! | `cycle` | each cycle, alone and times the position |
//!
//! What the model absorbs of these columns counts neither as drop nor as rank.

use std::f64::consts::{PI, TAU};

use trueaxis_campaign::VerificationKind;
use trueaxis_files::told_period;
use trueaxis_selection::Projection;

use crate::engine::{Family, MOST_OF_FREEDOM, Omnibus};
use crate::verification::base::{count, cycles, indicators, lines, times};
use crate::verification::comparison::Comparison;
use crate::verification::problem::Problem;
use crate::verification::whitening::Whitening;

/// Waves of each family.
const WAVES: usize = 6;

/// All families, whitened.
pub(crate) fn families(comparison: &Comparison<'_>, whitening: Whitening<'_>) -> Vec<Family> {
    let arrivals = &comparison.arrivals;
    let progress: Vec<f64> = arrivals.iter().map(|a| a.progress).collect();
    let mut time = vec![progress.clone()];
    time.extend((1..=WAVES).flat_map(|k| wave(&progress, TAU * k as f64)));
    let position = position_columns(comparison);
    let by_line = match comparison.kind {
        VerificationKind::Positioning { .. } => {
            comparison.waves_of_position(WAVES, lines(comparison))
        }
        VerificationKind::Ballbar { .. } => position.clone(),
    };
    // Not all positions warm up alike.
    let centred: Vec<f64> = progress.iter().map(|x| x - 0.5).collect();
    let in_time = position.iter().map(|column| times(column, &centred));
    let in_time = in_time.collect();
    let direction: Vec<f64> = arrivals.iter().map(|a| a.direction).collect();
    let of_direction = position.iter().map(|column| times(column, &direction));
    let of_direction = std::iter::once(direction.clone())
        .chain(of_direction)
        .collect();
    // From one side only it would be time under another name.
    let is_of_both = direction.windows(2).any(|two| two[0] * two[1] < 0.0);
    let waves = if is_of_both { WAVES } else { 0 };
    let of_direction_in_time = (1..=waves).map(|k| {
        let [_, cosine] = wave(&progress, PI * k as f64);
        times(&cosine, &direction)
    });
    let of_direction_in_time = of_direction_in_time.collect();
    let cycles = indicators(&cycles(comparison));
    let tilted = cycles.iter().map(|cycle| times(cycle, &position[0]));
    let of_cycle = cycles.iter().cloned().chain(tilted).collect();
    let family = |varies_with, columns: Vec<Vec<f64>>| Family {
        varies_with,
        columns: columns.iter().map(|c| whitening.whiten(c)).collect(),
    };
    vec![
        family("time", time),
        family("position", by_line),
        family("reversal", after_reversals(comparison)),
        family("position in time", in_time),
        family("direction", of_direction),
        family("direction in time", of_direction_in_time),
        family("cycle", of_cycle),
    ]
}

/// Columns that vary with the position along the line or around the circle.
fn position_columns(comparison: &Comparison<'_>) -> Vec<Vec<f64>> {
    match comparison.kind {
        VerificationKind::Positioning { .. } => {
            comparison.waves_of_position(WAVES, vec![0; comparison.arrivals.len()])
        }
        VerificationKind::Ballbar { .. } => (2..=WAVES + 1)
            .flat_map(|k| wave(&comparison.around, k as f64))
            .collect(),
    }
}

/// Angles within which what an axis does as it turns round fades away, rad: servos recover within some millimetres.
const FADES_RAD: [f64; 2] = [1.0 * PI / 180.0, 4.0 * PI / 180.0];

/// For each end of each axis of a ball bar columns that fade away with the angle of the bar since the axis turned
/// round there; not where a pass begins.
fn after_reversals(comparison: &Comparison<'_>) -> Vec<Vec<f64>> {
    if comparison.line().is_some() {
        return Vec::new();
    }
    let arrivals = &comparison.arrivals;
    let mut columns = Vec::new();
    for &axis in &comparison.moving {
        for end in [1.0, -1.0] {
            let mut since: Option<f64> = None;
            let turned_rad = (0..arrivals.len()).map(|i| {
                let side = arrivals[i].sides[axis];
                let before = i
                    .checked_sub(1)
                    .filter(|&k| arrivals[k].is_of_pass(&arrivals[i]));
                // From an end at which it went on in the other direction.
                match before.map(|k| (k, arrivals[k].sides[axis])) {
                    Some((k, came)) if came * side < 0.0 => {
                        let half = 0.5 * apart(comparison.around[k], comparison.around[i]);
                        since = (side * end < 0.0).then_some(half);
                    }
                    Some((k, _)) => {
                        let step = apart(comparison.around[k], comparison.around[i]);
                        since = since.map(|angle| angle + step);
                    }
                    None => since = None,
                }
                since
            });
            let turned_rad: Vec<Option<f64>> = turned_rad.collect();
            let fading = |fades_rad: f64| -> Vec<f64> {
                let of = |angle: &Option<f64>| angle.map_or(0.0, |x| (-x / fades_rad).exp());
                turned_rad.iter().map(of).collect()
            };
            columns.extend(FADES_RAD.map(fading));
        }
    }
    columns.retain(|column| column.iter().any(|x| *x > 0.0));
    columns
}

/// The angle between two, without regard to whole turns, rad.
fn apart(a: f64, b: f64) -> f64 {
    let apart = (b - a).rem_euclid(TAU);
    apart.min(TAU - apart)
}

/// Sine and cosine of multiples of values.
fn wave(of: &[f64], multiple: f64) -> [Vec<f64>; 2] {
    [f64::sin, f64::cos].map(|f| of.iter().map(|x| f(multiple * x)).collect())
}

/// The tests of a model.
pub(crate) fn omnibus(problem: &Problem<'_>, model: &Projection) -> Vec<Omnibus> {
    let mut tests = Omnibus::of_all(model, &problem.families, MOST_OF_FREEDOM);
    for Omnibus { test, .. } in &mut tests {
        if test.p_value < STANDS_OUT && test.varies_with == "time" {
            test.detail = period(problem, model);
        }
    }
    tests
}

/// p-value below which a period is stated.
const STANDS_OUT: f64 = 0.01;

/// The period in time that explains most, as text; `None` if the table is not longer than it.
fn period(problem: &Problem<'_>, model: &Projection) -> Option<String> {
    let arrivals = &problem.comparison.arrivals;
    let duration = arrivals.iter().map(|a| a.elapsed_s).fold(0.0, f64::max);
    let best = best_waves(problem, model).filter(|&waves| waves > 1)?;
    let unit = problem.comparison.unit_of("s");
    Some(told_period(duration / best as f64, unit))
}

/// Waves over the table that explain most.
fn best_waves(problem: &Problem<'_>, model: &Projection) -> Option<usize> {
    let arrivals = problem.comparison.arrivals.iter();
    let progress: Vec<f64> = arrivals.map(|a| a.progress).collect();
    let drop = |k: usize| {
        let wave = wave(&progress, TAU * k as f64).map(|column| problem.whiten(&column));
        model.squares() - model.extended(&wave).squares()
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

/// Whether the period that explains most is a pass or a whole cycle: a function of position and side has it.
pub(crate) fn repeats_with_cycle(problem: &Problem<'_>, model: &Projection) -> bool {
    let passes = count(&problem.comparison.passes);
    let is_of_passes = |waves: usize| [waves, 2 * waves].contains(&passes);
    passes >= LEAST_PASSES && best_waves(problem, model).is_some_and(is_of_passes)
}

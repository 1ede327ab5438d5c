//! Positions of an axis that nearly coincide: rounded differently, or read from encoders.
//!
//! A step is a commanded position, which all stations and repeats share. What differs by rounding only is one position
//! ([`join`]). What differs by more, but by next to nothing beside the distance of the steps, was not commanded: each
//! length would be a step of its own, and the steps would not be determined ([`check`]). The exception are positions at
//! which sweeps stop one after the other and read the same target: a sweep passes each commanded position only once. Half
//! of the sweeps that pass must do so, since encoders may show a single sweep two positions of one stop.

use std::cell::LazyCell;
use std::collections::{HashMap, HashSet};
use std::path::Path;

use trueaxis_kinematics::{AxisKind, Machine};

use crate::reading::{Reading, readings_of};
use crate::steps::Steps;
use crate::stops::append;
use crate::{Campaign, Error, Place, Problem, Stop, position_unit};

/// Positions this close are one, in mm and in degrees: no control is commanded to a nanometre.
const ROUNDING: [f64; 2] = [1e-6, 1e-7];

/// Share of the usual distance of neighbouring steps below which positions are not meant to differ.
const NEAR: f64 = 0.01;

/// The same, but never more than this, mm and degrees: encoders are not farther off, and a wide step beside a narrow one
/// may be meant.
const NEAR_AT_MOST: [f64; 2] = [0.05, 0.05];

/// Positions that are closer are one stop, mm and degrees: encoders of an axis that stands still differ by less.
const STANDSTILL: [f64; 2] = [0.001, 0.001];

/// The same for an axis that is parked, mm and degrees.
const NEAR_PARKED: [f64; 2] = [0.01, 0.001];

/// A limit for linear and rotary axes, mm or rad.
fn limit([mm, degrees]: [f64; 2], kind: AxisKind) -> f64 {
    match kind {
        AxisKind::Linear => mm,
        AxisKind::Rotary => degrees.to_radians(),
    }
}

/// Makes one of positions that rounding alone keeps apart: the one that is the shortest in writing.
pub(crate) fn join(
    machine: &Machine,
    (stops, mut steps): (Vec<Stop>, Steps),
) -> (Vec<Stop>, Steps) {
    let mut is_any_joined = false;
    for (number, axis) in machine.axes().iter().enumerate() {
        let kind = axis.kind();
        let mut positions: Vec<f64> = steps.steps.iter().map(|s| s.positions[number]).collect();
        positions.sort_by(f64::total_cmp);
        positions.dedup_by(|a, b| a.total_cmp(b).is_eq());
        let groups = positions.chunk_by(|a, b| b - a <= limit(ROUNDING, kind));
        for group in groups.filter(|group| group.len() > 1) {
            let length = |q: &&f64| position_unit::in_file(kind, **q).to_string().len();
            let Some(&shortest) = group.iter().min_by_key(length) else {
                continue;
            };
            let same = group[0]..=group[group.len() - 1];
            let cells = steps.steps.iter_mut().map(|s| &mut s.positions[number]);
            cells
                .filter(|q| same.contains(*q))
                .for_each(|q| *q = shortest);
            is_any_joined = true;
        }
    }
    if !is_any_joined {
        return (stops, steps);
    }
    let mut joined = Default::default();
    append(&mut joined, (stops, steps), 0);
    joined
}

/// A position of a run, the step and the line where it first is.
#[derive(Clone, Copy)]
struct Seen {
    position: f64,
    step: usize,
    line: usize,
}

/// Refuses a run with positions of an axis that differ in the last digits only.
pub(crate) fn check<R: Reading>(
    file: &Path,
    campaign: &Campaign,
    (stops, readings): (&[Stop], &[R]),
    steps: &Steps,
) -> Result<(), Error> {
    // Most campaigns have no positions that are near each other.
    let one_after_the_other = LazyCell::new(|| one_after_the_other(stops, readings));
    let mut of_runs = vec![Vec::new(); campaign.runs.len()];
    for (number, (step, &line)) in steps.steps.iter().zip(&steps.lines).enumerate() {
        if let Some(run) = step.run {
            of_runs[run].push((&step.positions, number, line));
        }
    }
    for (run, own) in campaign.runs.iter().zip(of_runs) {
        for (number, axis) in campaign.machine.axes().iter().enumerate() {
            let seen = own.iter().map(|&(positions, step, line)| Seen {
                position: positions[number],
                step,
                line,
            });
            let seen = in_order(seen.collect());
            let kind = axis.kind();
            let near = near(&seen, kind, number == run.axis);
            let pairs = seen.windows(2).filter(|pair| {
                let distance = pair[1].position - pair[0].position;
                let are_two_stops = || {
                    number == run.axis
                        && distance >= limit(STANDSTILL, kind)
                        && one_after_the_other.contains(&[pair[0].step, pair[1].step])
                };
                distance < near && !are_two_stops()
            });
            let Some(pair) = pairs.min_by_key(|pair| pair[0].line.max(pair[1].line)) else {
                continue;
            };
            let mut both = [pair[0], pair[1]];
            both.sort_by_key(|seen| seen.line);
            let [first, second] = both;
            return Err(Problem::NearPositions {
                run: run.name.clone(),
                position: position_unit::in_file(kind, second.position),
                other: position_unit::in_file(kind, first.position),
                other_line: first.line,
                unit: kind.position_unit(),
                near: (kind.position_in_file(near) * 1e6).round() / 1e6,
            }
            .at(Place::column(file, second.line, axis.name())));
        }
    }
    Ok(())
}

/// Steps, in both orders, at which half of the sweeps that come by, and two if there are two, stop one after the other with
/// the same target.
fn one_after_the_other<R: Reading>(stops: &[Stop], readings: &[R]) -> HashSet<[usize; 2]> {
    let sweep = |stop: &Stop| (stop.station, stop.repeat, stop.direction);
    let mut sweeps_at: HashMap<usize, HashSet<_>> = HashMap::new();
    for stop in stops {
        sweeps_at.entry(stop.step).or_default().insert(sweep(stop));
    }
    let mut in_turn: HashMap<[usize; 2], HashSet<_>> = HashMap::new();
    for pair in stops.windows(2) {
        let [first, second] = [0, 1].map(|k| readings_of(&pair[k], readings));
        let is_in_both = |r: &R| second.iter().any(|other| other.target() == r.target());
        if sweep(&pair[0]) == sweep(&pair[1]) && first.iter().any(is_in_both) {
            let mut steps = [pair[0].step, pair[1].step];
            steps.sort_unstable();
            in_turn.entry(steps).or_default().insert(sweep(&pair[0]));
        }
    }
    in_turn.retain(|[a, b], sweeps| {
        let coming_by = sweeps_at[a].union(&sweeps_at[b]).count();
        sweeps.len() >= coming_by.div_ceil(2).max(coming_by.min(2))
    });
    let commanded = in_turn.into_keys();
    commanded.flat_map(|[a, b]| [[a, b], [b, a]]).collect()
}

/// Each position once, rising, with its first line.
fn in_order(mut seen: Vec<Seen>) -> Vec<Seen> {
    let order = |a: &Seen, b: &Seen| a.position.total_cmp(&b.position);
    seen.sort_by(|a, b| order(a, b).then(a.line.cmp(&b.line)));
    seen.dedup_by(|a, b| order(a, b).is_eq());
    seen
}

/// Below which distance positions of an axis in a run, rising, are not meant to differ, mm or rad.
fn near(seen: &[Seen], kind: AxisKind, is_under_test: bool) -> f64 {
    let gaps = seen
        .windows(2)
        .map(|pair| pair[1].position - pair[0].position);
    let mut gaps: Vec<f64> = gaps.collect();
    let [at_most, parked] = [NEAR_AT_MOST, NEAR_PARKED].map(|limits| limit(limits, kind));
    let near_beside = |gap: f64| at_most.min(NEAR * gap);
    let largest = gaps.iter().copied().fold(0.0, f64::max);
    // The usual distance is that between groups of positions which are near beside the largest.
    gaps.retain(|&gap| gap >= near_beside(largest));
    gaps.sort_by(f64::total_cmp);
    let near = gaps
        .get(gaps.len() / 2)
        .map_or(0.0, |&usual| near_beside(usual));
    let moves = gaps.iter().sum::<f64>() > parked;
    match is_under_test && moves {
        true => near,
        false => near.max(parked),
    }
}

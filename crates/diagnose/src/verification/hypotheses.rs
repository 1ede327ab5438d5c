//! The effects of the catalogue that a verification may show, with their columns.

use std::f64::consts::PI;

use trueaxis_campaign::VerificationKind;
use trueaxis_effects::{
    BACKLASH, CROSS_COUPLING, Level, POSITION_DEPENDENT_BACKLASH, Scene, Shape, Subject, catalogue,
};
use trueaxis_leastsquares::median;
use trueaxis_selection::{Hypothesis, ShapeColumns, middle};

use crate::engine::linear::{Candidate, Finer};
use crate::engine::{TimeConstants, plausible, without_pauses};
use crate::numbers::distinct;
use crate::verification::arrivals::Arrival;
use crate::verification::comparison::{Comparison, along_itself};
use crate::verification::lost_motion;
use crate::verification::one_side;
use crate::verification::order::goes_against_its_sides;
use crate::verification::whitening::Whitening;

/// To a time constant that looks linear.
const TIME_CONSTANTS: TimeConstants = TimeConstants {
    parts: [0.02, 3.0],
    count: 16,
};

/// Fewest arrivals on either side of an instant (a quarter of all, if that is less).
const LEAST_ARRIVALS: usize = 3;

/// For a bar at least one in this many of all arrivals must be on either side.
const PARTS_OF_A_CIRCLE: usize = 20;

/// Most instants that are tried.
const INSTANTS: usize = 100;

/// Stops on either side of an instant to which it may still move: farther off it fits much worse, unless hardly seen.
const GAPS_NEARBY: usize = 60;

/// Steps of the wave number in waves over the range: a sixteenth of a wave more or less leaves 98.7 % of the squares
/// of a sine explained, `(sin x/x)²` for `x = π/16`.
const WAVE_STEP: f64 = 0.125;

/// Steps of the wave number of the longest period, half the range: what does not repeat is a step, a slope or a bow.
const FEWEST_STEPS: u32 = 16;

/// Most steps of the wave number that are tried, so that the grid takes no time worth mentioning.
const MOST_STEPS: u32 = 400;

/// Most whole waves per turn that are tried.
const MOST_PER_TURN: u32 = 12;

/// Every effect of this level on every subject that moves.
pub(crate) fn candidates<'a>(
    comparison: &'a Comparison<'a>,
    scene: &Scene,
    whitening: Whitening<'a>,
) -> Vec<Candidate<'a>> {
    let mut all = Vec::new();
    let readings: usize = comparison.arrivals.iter().map(|a| a.readings).sum();
    // Then nothing shows when the axis went which way.
    let are_sides_in_doubt =
        goes_against_its_sides(comparison) || one_side::doubt(comparison).is_some();
    for &effect in catalogue() {
        let is_in_doubt = effect.is_delay() && are_sides_in_doubt;
        if !effect.levels.contains(&Level::Verification) || is_in_doubt {
            continue;
        }
        let mut scene = Scene {
            moving: comparison.moving.clone(),
            ..scene.clone()
        };
        if effect == CROSS_COUPLING {
            // An axis that stands, but elsewhere than in the calibration, is coupled like one that moves.
            scene.moving.extend(&comparison.parked_elsewhere);
        } else if effect == BACKLASH {
            // An axis that came to its one position from both sides does not stand, either.
            let turns = |axis: &usize| comes_from_both_sides(comparison, *axis);
            scene.moving.extend(comparison.line().filter(turns));
        }
        scene.moving = distinct(scene.moving);
        let mut subjects = effect.subjects(&scene);
        subjects.retain(|subject| is_seen(comparison, subject));
        if effect.waves(0.0).is_some() {
            subjects.retain(|subject| is_half_turned(comparison, subject));
        }
        for hypothesis in Hypothesis::of_each(effect, subjects) {
            let subject = hypothesis.subject;
            let plausible = plausible(&hypothesis, &scene);
            let shapes = shapes(comparison, effect.shape, &subject);
            let is_seen = is_of_both_sides(comparison, &hypothesis);
            let column = move |k, shape| match is_seen {
                true => comparison.column(&hypothesis, k, shape),
                false => vec![0.0; comparison.arrivals.len()],
            };
            let count = plausible.len();
            let columns = move |shape: f64| -> Vec<Vec<f64>> {
                let whitened = (0..count).map(|k| whitening.whiten(&column(k, shape)));
                whitened.collect()
            };
            let gaps_s = (effect.shape == Shape::Instant).then(|| gaps_s(comparison));
            let is_along =
                effect == POSITION_DEPENDENT_BACKLASH && subject.axis == comparison.line();
            let straight = is_along.then(|| [0, 1].map(|k| column(k, 0.0)));
            let sizes = straight.as_ref();
            let sizes = sizes.map(|straight| lost_motion::sizes(comparison, straight));
            let has_more = gaps_s.is_some() || is_continuous(effect.shape);
            all.push(Candidate {
                hypothesis,
                columns: ShapeColumns::of_each(&shapes, columns).into(),
                plausible: plausible.clone(),
                is_free: false,
                sizes: sizes.unwrap_or_default(),
                finer: has_more.then(|| Finer {
                    columns: Box::new(columns),
                    gaps_s,
                    nearby: GAPS_NEARBY * readings.div_ceil(comparison.arrivals.len().max(1)),
                    shortest: match effect.shape {
                        Shape::Period => shortest_distinguished(comparison, &subject),
                        _ => f64::NEG_INFINITY,
                    },
                }),
            });
            let Some(straight) = straight else {
                continue;
            };
            let numbers = lost_motion::numbers_of_waves(comparison);
            let most = numbers.last().copied().unwrap_or(0);
            let more = lost_motion::waves(comparison, &straight, most);
            let columns: Vec<Vec<f64>> = straight.into_iter().chain(more).collect();
            let sizes = lost_motion::sizes(comparison, &columns);
            let columns: Vec<Vec<f64>> = columns.iter().map(|c| whitening.whiten(c)).collect();
            let first = |k: &usize| (*k as f64, columns[..count + k].to_vec());
            all.extend((most > 0).then(|| Candidate {
                hypothesis,
                columns: ShapeColumns::new(numbers.iter().map(first)).into(),
                plausible,
                is_free: true,
                sizes,
                finer: None,
            }));
        }
    }
    all
}

/// Whether a component error is sought. A single point does not distinguish an angle from a displacement: a line
/// shows the motion of the axis along itself, a ball bar displacements.
fn is_seen(comparison: &Comparison<'_>, subject: &Subject) -> bool {
    let (Some(axis), Some(component)) = (subject.axis, subject.component) else {
        return true;
    };
    // Nor sag with its angle from sag alone.
    if subject.other_axis.is_some() {
        return false;
    }
    let own = along_itself(&comparison.machine.axes()[axis]);
    match comparison.kind {
        VerificationKind::Positioning { .. } => component == own,
        VerificationKind::Ballbar { .. } => component == own || !component.is_angular(),
    }
}

/// Whether an axis turned so far that one wave per turn is not merely a slope or a bow.
fn is_half_turned(comparison: &Comparison<'_>, subject: &Subject) -> bool {
    let range = subject.axis.and_then(|axis| sampling(comparison, axis));
    range.is_some_and(|[range, _]| range > PI * (1.0 - ROUNDING))
}

/// Whether an effect is anything but lost motion of an axis that came from one side only: this cannot be separated
/// from a function of the position.
pub(crate) fn is_of_both_sides(comparison: &Comparison<'_>, own: &Hypothesis) -> bool {
    let axis = own.subject.axis.filter(|_| own.effect.is_lost_motion());
    axis.is_none_or(|axis| comes_from_both_sides(comparison, axis))
}

/// Whether an axis came from both sides.
pub(crate) fn comes_from_both_sides(comparison: &Comparison<'_>, axis: usize) -> bool {
    let sides = || comparison.arrivals.iter().map(|a| a.sides[axis]);
    sides().any(|side| side > 0.0) && sides().any(|side| side < 0.0)
}

/// The shapes that are tried.
fn shapes(comparison: &Comparison<'_>, shape: Shape, subject: &Subject) -> Vec<f64> {
    match shape {
        // Readings have no logged temperatures to lag behind.
        Shape::Fixed | Shape::Lag => vec![0.0],
        Shape::TimeConstant | Shape::SettlingTime => {
            let mut elapsed: Vec<f64> = comparison.arrivals.iter().map(|a| a.elapsed_s).collect();
            elapsed.sort_by(f64::total_cmp);
            let duration_s = elapsed.last().copied().unwrap_or(0.0);
            let busy_s = without_pauses(elapsed, duration_s);
            TIME_CONSTANTS.of(comparison.arrivals.len(), busy_s, duration_s)
        }
        Shape::Instant => {
            let gaps_s = gaps_s(comparison);
            let stride = gaps_s.len().div_ceil(INSTANTS).max(1);
            gaps_s.iter().step_by(stride).map(middle).collect()
        }
        Shape::Period => periods(comparison, subject),
        Shape::Waves(fewest) => (fewest..=MOST_PER_TURN).map(f64::from).collect(),
    }
}

/// Intervals between two readings, in the middle of which an instant is tried: not where fewer than three arrivals
/// are on one side, which show nothing that stays.
fn gaps_s(comparison: &Comparison<'_>) -> Vec<[f64; 2]> {
    let mut arrivals: Vec<&Arrival> = comparison.arrivals.iter().collect();
    arrivals.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    // Part of the circle determines what a bar moves by.
    let least = match comparison.line() {
        Some(_) => LEAST_ARRIVALS,
        None => LEAST_ARRIVALS.max(arrivals.len() / PARTS_OF_A_CIRCLE),
    };
    let margin = least.min(arrivals.len() / 4).max(1);
    let within = arrivals
        .get(margin - 1)
        .zip(arrivals.iter().nth_back(margin - 1));
    let within =
        within.and_then(|(a, b)| a.times_s.last().copied().zip(b.times_s.first().copied()));
    let mut times: Vec<f64> = arrivals.iter().flat_map(|a| &a.times_s).copied().collect();
    times.sort_by(f64::total_cmp);
    let between = times.windows(2).map(|pair| [pair[0], pair[1]]);
    let is_inside = |gap: &[f64; 2]| {
        gap[0] < gap[1] && within.is_some_and(|(from, to)| gap[0] >= from && gap[1] <= to)
    };
    between.filter(is_inside).collect()
}

/// Whether a shape may have any value between two of its list; not whole waves per turn, nor instants.
pub(crate) fn is_continuous(shape: Shape) -> bool {
    matches!(
        shape,
        Shape::TimeConstant | Shape::SettlingTime | Shape::Period
    )
}

/// Periods from two steps, the shortest that equal steps distinguish from a longer one, to half the range.
fn periods(comparison: &Comparison<'_>, subject: &Subject) -> Vec<f64> {
    let Some((range, most)) = most_waves(comparison, subject) else {
        return Vec::new();
    };
    let waves = (FEWEST_STEPS..=MOST_STEPS).map(|k| f64::from(k) * WAVE_STEP);
    let waves = waves.take_while(|waves| *waves <= most - WAVE_STEP * (1.0 - ROUNDING));
    let last = f64::from(MOST_STEPS) * WAVE_STEP;
    let waves = waves.chain([most].into_iter().filter(|most| *most <= last));
    waves.map(|waves| range / waves).collect()
}

/// The shortest period whose sine and cosine the positions distinguish: a step of the wave number longer than two
/// steps, where the worse one of the two still reaches seven tenths of its size.
fn shortest_distinguished(comparison: &Comparison<'_>, subject: &Subject) -> f64 {
    most_waves(comparison, subject).map_or(f64::NEG_INFINITY, |(range, most)| {
        range / (most - WAVE_STEP) * (1.0 - ROUNDING)
    })
}

/// Range of an axis, and how many waves of two steps it has.
fn most_waves(comparison: &Comparison<'_>, subject: &Subject) -> Option<(f64, f64)> {
    let [range, step] = sampling(comparison, subject.axis?)?;
    Some((range, 0.5 * range / step))
}

/// Rounding error of a quotient of positions.
const ROUNDING: f64 = 1e-9;

/// Range of the commanded positions of an axis and the typical step between neighbours.
pub(crate) fn sampling(comparison: &Comparison<'_>, axis: usize) -> Option<[f64; 2]> {
    let positions = comparison.positions(axis);
    let (first, last) = (positions.first()?, positions.last()?);
    let mut steps: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    Some([last - first, median(&mut steps)?])
}

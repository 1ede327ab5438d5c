//! Effects to be looked for in each set of curves: those that one curve alone shows ([`Effect::is_of_curve`]).
//!
//! `guideway_bow` joins two sets ([`crate::components::bow`]). Periods run from twice the step, the shortest that
//! equal steps distinguish from a longer one, to half the travel: what does not repeat at least twice is not called
//! periodic ([`repeats`]). Waves per turn are whole numbers; if a small part of a turn does not distinguish neighbouring numbers,
//! those tried are as far apart as periods are. All are tried over any part of a turn, but named only if two waves
//! show; one is enough of one or two per turn, which every rotary axis may have ([`shows_its_waves`]). Part of a wave
//! looks like any smooth curve, with an arbitrary amplitude.

use std::f64::consts::TAU;

use trueaxis_effects::{Effect, Scene, Shape, Subject, catalogue};
use trueaxis_selection::Hypothesis;

use crate::components::curve_set::CurveSet;

/// An effect on a set of curves, with all its possible shapes.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) hypothesis: Hypothesis,
    /// Number of linear parameters.
    pub(crate) parameters: usize,
    /// Periods (mm, rad), waves per turn, or a zero for an effect without shape.
    pub(crate) shapes: Vec<f64>,
}

/// Grid points for each frequency unit of one over the travel: half way between two of them a sine is 13 % of a
/// radian off at the ends, and less than 1 % of its squares is lost.
const FREQUENCIES_PER_TRAVEL: f64 = 4.0;

/// Number of times that a period must fit into the travel.
const FEWEST_PERIODS: f64 = 2.0;

/// Waves per turn that every rotary axis may have: one by eccentricity, two by ovality.
const KNOWN_WAVES: f64 = 2.0;

/// Steps per period that distinguish it from a longer one.
const STEPS_PER_PERIOD: f64 = 2.0;

pub(crate) fn candidates(set: &CurveSet, scene: &Scene) -> Vec<Candidate> {
    let first = set.components[0];
    let of_set = |effect: &&&Effect| effect.is_of_curve(&set.content, first);
    let candidate = |effect: &&'static Effect| {
        let (subject, shapes) = match effect.shape {
            Shape::Period => (Subject::component(set.axis, first), periods(set)),
            Shape::Waves(fewest) => (Subject::axis(set.axis), waves(set, fewest)),
            _ => (Subject::axis(set.axis), vec![0.0]),
        };
        (!shapes.is_empty()).then(|| Candidate::new(effect, subject, shapes, scene))
    };
    let all = catalogue().iter().filter(of_set);
    all.filter_map(candidate).collect()
}

impl Candidate {
    pub(crate) fn new(
        effect: &'static Effect,
        subject: Subject,
        shapes: Vec<f64>,
        scene: &Scene,
    ) -> Self {
        Self {
            hypothesis: Hypothesis {
                effect,
                subject,
                subjects: effect.subjects(scene).len(),
            },
            parameters: effect.parameters(scene, &subject).len(),
            shapes,
        }
    }
}

/// Periods at equal steps of the frequency.
fn periods(set: &CurveSet) -> Vec<f64> {
    let travel = set.travel();
    // At these steps waves two steps long show one phase only; without other positions no more can be known.
    let untold = if set.thinned.is_some() { 1.0 } else { 0.0 };
    let highest = travel / (STEPS_PER_PERIOD * set.step()) - untold / FREQUENCIES_PER_TRAVEL;
    let count = FREQUENCIES_PER_TRAVEL * (highest - FEWEST_PERIODS);
    let numbers = std::iter::successors(Some(0.0), |k| Some(k + 1.0));
    numbers
        .take_while(|&k| k <= count * (1.0 + f64::EPSILON.sqrt()))
        .map(|k| travel / (FEWEST_PERIODS + k / FREQUENCIES_PER_TRAVEL))
        .collect()
}

/// Whether a period is two steps or less: the true one may as well be shorter.
pub(crate) fn is_shortest(set: &CurveSet, period: f64) -> bool {
    period <= STEPS_PER_PERIOD * set.measured_step() * (1.0 + ROUNDING)
}

/// Relative rounding of a quotient of positions.
const ROUNDING: f64 = 1e-9;

/// The shortest period whose sine and cosine the steps distinguish: half a grid distance in frequency from two steps,
/// where the weaker of the two still has seven tenths of its size.
pub(crate) fn shortest_distinguished(set: &CurveSet) -> f64 {
    (measured_most(set) - 0.5 / (FREQUENCIES_PER_TRAVEL * set.travel())).recip()
}

/// The highest frequency that the measured positions distinguish from a lower one, in one over mm or rad.
pub(crate) fn measured_most(set: &CurveSet) -> f64 {
    (STEPS_PER_PERIOD * set.measured_step()).recip()
}

/// Distance of neighbouring periods of the search, mm or rad.
pub(crate) fn spacing(set: &CurveSet, period: f64) -> f64 {
    period * period / (FREQUENCIES_PER_TRAVEL * set.travel())
}

/// Whole numbers of waves from `fewest` to one wave in two steps, as close together as the travel distinguishes.
fn waves(set: &CurveSet, fewest: u32) -> Vec<f64> {
    let most = most_waves(set);
    let apart = waves_apart(set).unwrap_or(1.0);
    let whole = std::iter::successors(Some(f64::from(fewest)), |waves| Some(waves + apart));
    whole.take_while(|&waves| waves <= most).collect()
}

/// Number of waves per turn with two steps each.
pub(crate) fn most_waves(set: &CurveSet) -> f64 {
    TAU / (STEPS_PER_PERIOD * set.step()) * (1.0 + f64::EPSILON.sqrt())
}

/// Distance of neighbouring numbers of waves in the search, if the part of a turn does not distinguish all.
pub(crate) fn waves_apart(set: &CurveSet) -> Option<f64> {
    let apart = (TAU / (FREQUENCIES_PER_TRAVEL * set.travel())).floor();
    (apart >= 2.0).then_some(apart)
}

/// Whether the positions show enough of the waves of a turn to name them. If not, the waves stay in the model all the
/// same, or other effects would take their part.
pub(crate) fn shows_its_waves(set: &CurveSet, effect: &Effect, shape: f64) -> bool {
    effect.waves(shape).is_none_or(|waves| {
        let enough = if waves <= KNOWN_WAVES {
            1.0
        } else {
            FEWEST_PERIODS
        };
        waves * range(set) >= enough - ROUNDING
    })
}

/// Whether a period with its standard uncertainty fits often enough into the travel, and a number of times that is known:
/// the longest waves take what is left of any bend. Waves that do not repeat stay in the model all the same, as in
/// [`shows_its_waves`].
pub(crate) fn repeats(set: &CurveSet, effect: &Effect, [period, u]: [f64; 2]) -> bool {
    let periods = set.travel() / period;
    effect.shape != Shape::Period
        || periods >= FEWEST_PERIODS * (1.0 - NEARLY) && periods * u / period <= KNOWN_PERIODS
}

/// Part of a number of periods that may be lacking: estimates scatter.
const NEARLY: f64 = 0.02;

/// Largest standard uncertainty of the number of periods over the travel: a quarter of one turns a sine into a cosine.
const KNOWN_PERIODS: f64 = 0.25;

/// The part of a turn covered by the positions: at equal steps that close the turn the last position is the first.
fn range(set: &CurveSet) -> f64 {
    (set.travel() + set.step()) / TAU
}

//! What is looked for in which curves: the effects of which one curve alone tells ([`Effect::is_of_curve`]).
//!
//! `guideway_bow` joins two sets ([`crate::components::bow`]). Periods run from twice the step, the
//! shortest that equal steps tell from a longer one, to half the travel: what does not repeat at least
//! twice is not called periodic. Waves per turn are whole numbers; where a small part of a turn does not tell neighbouring ones
//! apart, they are tried as far apart as periods are. They are tried over any part of a turn, but named only where two waves show,
//! of one or two per turn, which every rotary axis may have, one ([`shows_its_waves`]): a part of a wave looks like any smooth
//! curve, with an arbitrary amplitude.

use std::f64::consts::TAU;

use trueaxis_effects::{Effect, Scene, Shape, Subject, catalogue};
use trueaxis_selection::Hypothesis;

use crate::components::curve_set::CurveSet;

/// An effect on a set of curves, with all shapes that it may have.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) hypothesis: Hypothesis,
    /// Number of linear parameters.
    pub(crate) parameters: usize,
    /// Periods (mm, rad), waves per turn, or a zero for an effect without shape.
    pub(crate) shapes: Vec<f64>,
}

/// Frequencies in one over the travel: at half of this distance from a grid point a sine is 13 % of a
/// radian off at the ends, and less than 1 % of its squares are lost.
const FREQUENCIES_PER_TRAVEL: f64 = 4.0;

/// Times that a period must fit into the travel.
const FEWEST_PERIODS: f64 = 2.0;

/// Waves per turn that every rotary axis may have: what is eccentric, and what is oval.
const KNOWN_WAVES: f64 = 2.0;

/// Steps per period that tell it from a longer one.
const STEPS_PER_PERIOD: f64 = 2.0;

/// All candidates of a set.
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
    catalogue()
        .iter()
        .filter(of_set)
        .filter_map(candidate)
        .collect()
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

/// Equal steps of the frequency.
fn periods(set: &CurveSet) -> Vec<f64> {
    let travel = set.travel();
    // Of waves two steps long the steps show one phase only; where no other positions were measured, no more can be known.
    let untold = if set.thinned.is_some() { 1.0 } else { 0.0 };
    let highest = travel / (STEPS_PER_PERIOD * set.step()) - untold / FREQUENCIES_PER_TRAVEL;
    let count = FREQUENCIES_PER_TRAVEL * (highest - FEWEST_PERIODS);
    let numbers = std::iter::successors(Some(0.0), |k| Some(k + 1.0));
    numbers
        .take_while(|&k| k <= count * (1.0 + f64::EPSILON.sqrt()))
        .map(|k| travel / (FEWEST_PERIODS + k / FREQUENCIES_PER_TRAVEL))
        .collect()
}

/// Whether a period is no longer than two steps: it may as well be shorter.
pub(crate) fn is_shortest(set: &CurveSet, period: f64) -> bool {
    period <= STEPS_PER_PERIOD * set.measured_step() * (1.0 + ROUNDING)
}

/// Of a quotient of positions.
const ROUNDING: f64 = 1e-9;

/// The shortest period whose sine and cosine the steps tell from each other: half a distance in frequency from two steps,
/// where the worse one of the two still reaches seven tenths of its size.
pub(crate) fn shortest_told(set: &CurveSet) -> f64 {
    (measured_most(set) - 0.5 / (FREQUENCIES_PER_TRAVEL * set.travel())).recip()
}

/// The highest frequency that the measured positions tell from a lower one, in one over mm or rad.
pub(crate) fn measured_most(set: &CurveSet) -> f64 {
    (STEPS_PER_PERIOD * set.measured_step()).recip()
}

/// Distance of neighbouring periods of the search, mm or rad.
pub(crate) fn spacing(set: &CurveSet, period: f64) -> f64 {
    period * period / (FREQUENCIES_PER_TRAVEL * set.travel())
}

/// Whole numbers from `fewest` while a wave has two steps, as far apart as the travel tells them.
fn waves(set: &CurveSet, fewest: u32) -> Vec<f64> {
    let most = most_waves(set);
    let apart = waves_apart(set).unwrap_or(1.0);
    let whole = std::iter::successors(Some(f64::from(fewest)), |waves| Some(waves + apart));
    whole.take_while(|&waves| waves <= most).collect()
}

/// Waves a turn of two steps each.
pub(crate) fn most_waves(set: &CurveSet) -> f64 {
    TAU / (STEPS_PER_PERIOD * set.step()) * (1.0 + f64::EPSILON.sqrt())
}

/// Distance of neighbouring waves a turn of the search, if the travel is a part of a turn that does not tell all whole numbers.
pub(crate) fn waves_apart(set: &CurveSet) -> Option<f64> {
    let apart = (TAU / (FREQUENCIES_PER_TRAVEL * set.travel())).floor();
    (apart >= 2.0).then_some(apart)
}

/// Whether the positions show enough of the waves of a turn for these to be named. Where they do not, the waves stay in the model all
/// the same: else other effects would share what is theirs.
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

/// The part of a turn that the positions go through: the last of equal steps that close the turn is the first.
fn range(set: &CurveSet) -> f64 {
    (set.travel() + set.step()) / TAU
}

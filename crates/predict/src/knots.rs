//! Steps as the points of a polynomial: those that are near each other are one *knot*.
//!
//! No gap between neighbouring knots is smaller than a quarter of another in the same polynomial ([`NEAR`]), so that it amplifies little
//! noise. Steps of equal distance are knots of their own.

use std::f64::consts::TAU;

use crate::curve::MOST_STEPS;

/// Steps whose distance is less than this part of another in the same polynomial are one knot: then the uncertainty half way
/// is at most 1.4 times that of a step, and five times in the first gap, if the others are as short as they may be.
const NEAR: f64 = 0.25;

/// A divided difference as a function of the nodes, which it is over.
pub(crate) type DividedDifference = Vec<(usize, f64)>;

/// Steps whose distance is less than this part of another in the same polynomial are one: their difference is noise, no slope.
const COINCIDENT: f64 = 0.02;

/// Where nodes are, mm or rad.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Step {
    pub(crate) position: f64,
    pub(crate) nodes: Vec<usize>,
}

/// A step, or steps that are near each other, in order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Knot {
    /// The mean of its nodes.
    pub(crate) position: f64,
    pub(crate) steps: Vec<Step>,
}

impl Knot {
    /// From the nearest of its steps.
    pub(crate) fn distance(&self, position: f64) -> f64 {
        let distances = self
            .steps
            .iter()
            .map(|step| (step.position - position).abs());
        distances.fold(f64::INFINITY, f64::min)
    }

    fn nodes(&self) -> impl Iterator<Item = usize> + Clone {
        self.steps.iter().flat_map(|step| &step.nodes).copied()
    }
}

/// Distances of neighbouring knots.
pub(crate) fn gaps(knots: &[Knot]) -> Vec<f64> {
    let pairs = knots.windows(2);
    pairs
        .map(|pair| pair[1].position - pair[0].position)
        .collect()
}

/// Knots of steps in order: those that coincide are one step, those that are near each other one knot.
pub(crate) fn well_apart(steps: Vec<Step>) -> Vec<Knot> {
    let coincident = gathered(steps, COINCIDENT).into_iter();
    let steps = coincident.map(|knot| Step {
        nodes: knot.nodes().collect(),
        position: knot.position,
    });
    gathered(steps.collect(), NEAR)
}

/// Joins neighbours that are nearer than a part of the other gaps, the relatively nearest first, until none are.
fn gathered(steps: Vec<Step>, near: f64) -> Vec<Knot> {
    let of_one = |step: Step| Knot {
        position: step.position,
        steps: vec![step],
    };
    let mut knots: Vec<Knot> = steps.into_iter().map(of_one).collect();
    loop {
        let gaps = gaps(&knots);
        // The gaps that may be in a polynomial with it.
        let within = MOST_STEPS - 2;
        let share = |k: usize| {
            let around = &gaps[k.saturating_sub(within)..gaps.len().min(k + within + 1)];
            gaps[k] / around.iter().copied().fold(f64::MIN_POSITIVE, f64::max)
        };
        let shares = (0..gaps.len()).map(|k| (k, share(k)));
        let nearest = shares.min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((k, _)) = nearest.filter(|&(_, share)| share < near) else {
            return knots;
        };
        let next = knots.remove(k + 1);
        let knot = &mut knots[k];
        let share =
            next.nodes().count() as f64 / (knot.nodes().count() + next.nodes().count()) as f64;
        knot.position += share * (next.position - knot.position);
        knot.steps.extend(next.steps);
    }
}

/// Shares the weight of a step or a knot among its nodes.
pub(crate) fn shared(
    nodes: impl Iterator<Item = usize> + Clone,
    weight: f64,
) -> impl Iterator<Item = (usize, f64)> {
    let share = weight / nodes.clone().count() as f64;
    nodes.map(move |node| (node, share))
}

fn of_nodes(knots: &[Knot], weight: impl Fn(&Knot) -> f64) -> Vec<(usize, f64)> {
    let of_knot = |knot| shared(Knot::nodes(knot), weight(knot));
    knots.iter().flat_map(of_knot).collect()
}

/// As many knots of the turns before and after as a polynomial at the ends takes; those of both ends that are nearly at
/// the same angle are there once.
pub(crate) fn with_other_turns(knots: &[Knot], largest_gap: f64) -> Vec<Knot> {
    let near = NEAR * largest_gap;
    let [first, last] = [&knots[0], &knots[knots.len() - 1]].map(|knot| knot.position);
    let turned = |by: f64| {
        let step = move |step: &Step| Step {
            position: step.position + by,
            nodes: step.nodes.clone(),
        };
        knots.iter().map(move |knot| Knot {
            position: knot.position + by,
            steps: knot.steps.iter().map(step).collect(),
        })
    };
    let before = turned(-TAU).filter(|knot| knot.position < first - near);
    let mut before: Vec<Knot> = before.collect();
    before.drain(..before.len().saturating_sub(MOST_STEPS));
    let after = turned(TAU).filter(|knot| knot.position > last + near);
    let after = after.take(MOST_STEPS);
    before
        .into_iter()
        .chain(knots.iter().cloned())
        .chain(after)
        .collect()
}

/// Weights of Lagrange's polynomial.
pub(crate) fn lagrange(stencil: &[Knot], position: f64) -> Vec<(usize, f64)> {
    let weight = |j: &Knot| {
        let others = stencil
            .iter()
            .filter(|i| i.position.total_cmp(&j.position).is_ne());
        let factors = others.map(|i| (position - i.position) / (j.position - i.position));
        factors.product()
    };
    of_nodes(stencil, weight)
}

/// `f[q_0, …] = Σ_j f_j / Π_{i≠j} (q_j - q_i)`.
pub(crate) fn divided_difference(knots: &[Knot]) -> DividedDifference {
    let weight = |j: &Knot| {
        let others = knots
            .iter()
            .filter(|i| i.position.total_cmp(&j.position).is_ne());
        let factors = others.map(|i| j.position - i.position);
        factors.product::<f64>().recip()
    };
    of_nodes(knots, weight)
}

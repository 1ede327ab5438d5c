//! The component errors of an axis between its steps.
//!
//! Local interpolation by the polynomial through the nearest steps, four of them (Lagrange; unequal spacings are
//! no matter), so that the result is linear in the data and a wrong step stays where it is:
//!
//! ```text
//! p(q) = Σ_j f_j Π_{i≠j} (q - q_i) / (q_j - q_i)     f(q) - p(q) = f[q_0, …, q_3, q] ω(q)     ω(q) = Π_j (q - q_j)
//! ```
//!
//! with Newton's remainder, a divided difference of fourth order (J. Stoer, R. Bulirsch, *Introduction to Numerical
//! Analysis*, 2.1.3 and 2.1.4). Of three steps it takes two at a time, of four three, so that a step can be left out
//! to see how well that goes ([`crate::remainder`]). A rotary axis whose steps go round a full turn has no
//! ends. Outside its steps an axis has the errors of the last.
//!
//! The polynomial amplifies noise by the ratio of distances: a hundredfold with two steps 0.5 mm apart and one at 50 mm.
//! It therefore goes through *knots* ([`crate::knots`]): steps that are much nearer to each other than to the others, as
//! those of two runs of an axis may be, are one at their mean position with the mean of their errors. What the polynomial
//! leaves of each error, `r_j = f_j - p(q_j)`, is added, linearly from the step before to the step after it. The curve goes
//! through every step (those nearer than a fiftieth are one), is continuous and linear in the data, and amplifies no noise.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use trueaxis_campaign::Direction;
use trueaxis_kinematics::AxisKind;

use crate::interpolation::{Node, sides_of};
use crate::knots::{
    DividedDifference, Knot, Step, divided_difference, gaps, lagrange, shared, well_apart,
    with_other_turns,
};

/// Steps that take part in the polynomial.
pub(crate) const MOST_STEPS: usize = 4;

/// A gap that is larger than the largest between steps by no more than this factor closes a turn.
const CLOSING_GAP: f64 = 1.5;

/// Positions this close are one, mm or rad: files round degrees to 1e-9.
const SAME: f64 = 1e-9;

/// The steps of an axis, on each side of approach.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    sides: Vec<Side>,
}

/// The component errors at a position as a linear function of those at the nodes.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Sample {
    /// Nodes and weights, which add up to one.
    pub(crate) weights: Vec<(usize, f64)>,
    /// `|ω|`: what the interpolation may be off by, for a divided difference of one.
    pub(crate) remainder: f64,
    /// Distance from the nearest step for a position outside all steps, mm or rad.
    pub(crate) beyond: f64,
    /// Whether that is the first step.
    pub(crate) is_below: bool,
}

/// The side of approach, if only one counts, and how many steps of it, or of each side, are below a position.
pub(crate) type Gap = (Option<usize>, Vec<usize>);

#[derive(Debug, Clone, PartialEq)]
struct Side {
    /// Side of approach, where kept apart.
    direction: Option<Direction>,
    /// In order of position; behind the ends of a closed turn those of the turns before and after it.
    knots: Vec<Knot>,
    is_closed: bool,
    /// Number of knots in a polynomial.
    order: usize,
    /// All steps, in order.
    steps: Vec<f64>,
    /// The steps of the knots, in order, and whether the knot has others.
    of_knots: Vec<(Step, bool)>,
}

impl Curve {
    /// Of nodes in order of position.
    pub(crate) fn new(kind: AxisKind, nodes: &[Node]) -> Self {
        let of_side = |side| {
            let numbered = nodes.iter().enumerate();
            let own = numbered.filter(|(_, node)| node.direction == side);
            let steps = own.map(|(node, at)| Step {
                position: at.position,
                nodes: vec![node],
            });
            Side::new(kind, side, steps.collect())
        };
        Self {
            sides: sides_of(nodes).into_iter().map(of_side).collect(),
        }
    }

    /// The steps in rising order, each once, mm or rad.
    pub(crate) fn steps(&self) -> Vec<f64> {
        let own = self.sides.iter().flat_map(|side| &side.steps);
        let mut steps: Vec<f64> = own.copied().collect();
        steps.sort_by(f64::total_cmp);
        steps.dedup_by(|a, b| (*a - *b).abs() <= SAME);
        steps
    }

    /// The steps whose errors a calibration takes for those at home, which is 0: home, the two around it, or the nearest.
    pub(crate) fn steps_of_home(&self) -> Vec<f64> {
        let steps = self.steps();
        let distance = |q: &&f64| q.abs();
        let nearest = |side: fn(&&f64) -> bool| {
            let own = steps.iter().filter(side);
            own.min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        let at_home = steps.iter().find(|q| q.abs() <= SAME);
        let around = [nearest(|q| **q < 0.0), nearest(|q| **q > 0.0)];
        match at_home {
            Some(home) => vec![*home],
            None => around.into_iter().flatten().copied().collect(),
        }
    }

    /// Whether both sides of approach have a curve of their own.
    pub(crate) fn keeps_sides_apart(&self) -> bool {
        self.sides.len() > 1
    }

    /// The curve at a position approached from one side; the mean where the sides are not apart.
    pub(crate) fn at_from(&self, position: f64, direction: Direction) -> Sample {
        let own = self.sides.iter().find(|s| s.direction == Some(direction));
        own.map_or_else(|| self.at(position), |side| side.at(position))
    }

    /// The curve at a position: the mean of the sides of approach that reach it, the nearest step if none does.
    pub(crate) fn at(&self, position: f64) -> Sample {
        let mut samples: Vec<Sample> = self.sides.iter().map(|side| side.at(position)).collect();
        let beyond = samples.iter().map(|sample| sample.beyond);
        let least = beyond.fold(f64::INFINITY, f64::min);
        samples.retain(|sample| sample.beyond <= least);
        let share = 1.0 / samples.len().max(1) as f64;
        let mut mean = Sample::default();
        for sample in samples {
            let weights = sample.weights.into_iter();
            mean.weights
                .extend(weights.map(|(node, weight)| (node, weight * share)));
            mean.remainder += sample.remainder * share;
            mean.beyond += sample.beyond * share;
            mean.is_below = sample.is_below;
        }
        mean
    }

    /// Between which steps a position is, of the side from which it is approached if that is given and has a curve of its own:
    /// positions with the same are in the same gap.
    pub(crate) fn gap(&self, position: f64, from: Option<Direction>) -> Gap {
        let gap = |side: &Side| {
            let position = side.in_turn(position);
            side.of_knots
                .partition_point(|(step, _)| step.position < position)
        };
        let mut sides = self.sides.iter();
        match sides.position(|s| from.is_some() && s.direction == from) {
            Some(own) => (Some(own), vec![gap(&self.sides[own])]),
            None => (None, self.sides.iter().map(gap).collect()),
        }
    }

    /// Divided differences over neighbouring steps: of this order, or else of that of the interpolation's remainder.
    pub(crate) fn divided_differences(&self, order: Option<usize>) -> Vec<DividedDifference> {
        let of_side = |side: &Side| -> Vec<DividedDifference> {
            let windows = side.knots.windows(order.unwrap_or(side.order) + 1);
            windows.map(divided_difference).collect()
        };
        self.sides.iter().flat_map(of_side).collect()
    }

    /// Each two neighbouring divided differences of the order of the interpolation's remainder, where this is of third degree.
    pub(crate) fn neighbouring_differences(&self) -> Vec<[DividedDifference; 2]> {
        let cubic = self.sides.iter().filter(|side| side.order == MOST_STEPS);
        let windows = cubic.flat_map(|side| side.knots.windows(MOST_STEPS + 2));
        let pair = |knots: &[Knot]| {
            let last = knots.len() - 1;
            [&knots[..last], &knots[1..]].map(divided_difference)
        };
        windows.map(pair).collect()
    }

    /// The mean slope from each step to the one that is `steps` further on.
    pub(crate) fn slopes(&self, steps: usize) -> Vec<DividedDifference> {
        let of_side = |side: &Side| -> Vec<DividedDifference> {
            let windows = side.knots.windows(steps + 1);
            let ends = windows.map(|knots| [knots[0].clone(), knots[steps].clone()]);
            ends.map(|ends| divided_difference(&ends)).collect()
        };
        self.sides.iter().flat_map(of_side).collect()
    }

    /// For each side of approach the slope between its first two steps, or its last two, and their distance.
    pub(crate) fn slopes_at_end(&self, is_below: bool) -> Vec<(DividedDifference, f64)> {
        let of_side = |side: &Side| {
            let mut pairs = side.knots.windows(2);
            let pair = if is_below { pairs.next() } else { pairs.last() }?;
            Some((
                divided_difference(pair),
                pair[1].position - pair[0].position,
            ))
        };
        self.sides.iter().filter_map(of_side).collect()
    }
}

impl Side {
    /// Of its steps, in order.
    fn new(kind: AxisKind, direction: Option<Direction>, steps: Vec<Step>) -> Self {
        let positions: Vec<f64> = steps.iter().map(|step| step.position).collect();
        let [first, last] = ends(&positions);
        let mut knots = well_apart(steps);
        let count = knots.len();
        let largest_gap = gaps(&knots).into_iter().fold(0.0, f64::max);
        let closing_gap = TAU - (last - first);
        let is_closed = kind == AxisKind::Rotary
            && count > MOST_STEPS
            && closing_gap <= CLOSING_GAP * largest_gap;
        if is_closed {
            knots = with_other_turns(&knots, largest_gap);
        }
        let of_knots = knots.iter().flat_map(|knot| {
            let has_others = knot.steps.len() > 1;
            knot.steps
                .iter()
                .map(move |step| (step.clone(), has_others))
        });
        Self {
            direction,
            of_knots: of_knots.collect(),
            knots,
            is_closed,
            // One step fewer than there are, so that one can be left out; two always make a line.
            order: count.saturating_sub(1).clamp(2, MOST_STEPS).min(count),
            steps: positions,
        }
    }

    fn at(&self, mut position: f64) -> Sample {
        let [first, last] = ends(&self.steps);
        if self.is_closed && !self.whole_stencils().contains(&position) {
            position = self.in_turn(position);
        }
        let beyond = match self.is_closed {
            true => 0.0,
            false => (first - position).max(position - last),
        };
        let is_below = position < first;
        if beyond > 0.0 {
            position = position.clamp(first, last);
        }
        if self.knots.is_empty() {
            return Sample {
                beyond: f64::INFINITY,
                ..Sample::default()
            };
        }
        let distances = self.stencil(position).iter().map(|k| k.distance(position));
        let remainder: f64 = distances.product();
        Sample {
            weights: self.weights(position),
            remainder: if self.knots.len() > 1 { remainder } else { 0.0 },
            beyond: if beyond > SAME { beyond } else { 0.0 },
            is_below,
        }
    }

    /// Of the nodes: the polynomial, and what it leaves of the steps around that share their knot with others.
    fn weights(&self, position: f64) -> Vec<(usize, f64)> {
        let above = self
            .of_knots
            .partition_point(|(step, _)| step.position < position);
        let around = &self.of_knots[above.saturating_sub(1)..self.of_knots.len().min(above + 1)];
        let is_here = |step: &Step| (step.position - position).abs() <= SAME;
        if let Some((step, _)) = around.iter().find(|(step, _)| is_here(step)) {
            return shared(step.nodes.iter().copied(), 1.0).collect();
        }
        let mut weights = lagrange(self.stencil(position), position);
        let [below, above] = around else {
            return weights;
        };
        let share = (position - below.0.position) / (above.0.position - below.0.position);
        for ((step, has_others), share) in [(below, 1.0 - share), (above, share)] {
            if *has_others {
                let smooth = lagrange(self.stencil(step.position), step.position).into_iter();
                weights.extend(shared(step.nodes.iter().copied(), share));
                weights.extend(smooth.map(|(node, weight)| (node, -share * weight)));
            }
        }
        collected(weights)
    }

    /// The knots of the polynomial at a position.
    fn stencil(&self, position: f64) -> &[Knot] {
        let above = self.knots.partition_point(|knot| knot.position < position);
        let start = above.saturating_sub(1).saturating_sub((self.order - 1) / 2);
        let start = start.min(self.knots.len() - self.order);
        &self.knots[start..start + self.order]
    }

    /// A position, on a closed curve that of the turn which begins with its first step.
    fn in_turn(&self, position: f64) -> f64 {
        match (self.is_closed, self.steps.first()) {
            (true, Some(first)) => first + (position - first).rem_euclid(TAU),
            _ => position,
        }
    }

    /// The positions about which a closed curve has steps on both sides. Near its ends it goes on, and does not jump to the other
    /// end: the steps there, at the same angle, differ by their noise, and a position that is corrected must not jump.
    fn whole_stencils(&self) -> RangeInclusive<f64> {
        let inner = MOST_STEPS / 2;
        let last = self.knots.len() - 1 - inner;
        self.knots[inner].position..=self.knots[last].position
    }
}

/// First and last of the steps.
fn ends(steps: &[f64]) -> [f64; 2] {
    [steps.first(), steps.last()].map(|q| q.copied().unwrap_or_default())
}

/// Each node once.
fn collected(mut weights: Vec<(usize, f64)>) -> Vec<(usize, f64)> {
    weights.sort_by_key(|(node, _)| *node);
    let of_each = weights.chunk_by(|a, b| a.0 == b.0);
    of_each
        .map(|own| (own[0].0, own.iter().map(|(_, weight)| weight).sum()))
        .collect()
}

#[cfg(test)]
mod tests;

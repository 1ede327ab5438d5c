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
//! The polynomial amplifies noise by the ratio of distances: of two steps 0.5 mm apart beside one at 50 mm it makes a
//! hundredfold. It therefore goes through *knots* ([`crate::knots`]): steps that are much nearer to each other than to the others, as
//! those of two runs of an axis may be, are one at their mean position with the mean of their errors. What the polynomial leaves of the
//! error of each of these steps, `r_j = f_j - p(q_j)`, is added in proportion to the distance, from the step before it to the step after
//! it, so that the curve goes through every step, is continuous and linear in the data, and amplifies no noise.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use trueaxis_campaign::Direction;
use trueaxis_kinematics::AxisKind;

use crate::interpolation::{Node, sides_of};
use crate::knots::{
    DividedDifference, Knot, Step, divided_difference, gaps, lagrange, well_apart, with_other_turns,
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
                node,
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
    /// positions with the same number are in the same gap.
    pub(crate) fn gap(&self, position: f64, from: Option<Direction>) -> usize {
        let gap = |side: &Side| {
            let position = side.in_turn(position);
            side.knots.partition_point(|knot| knot.position < position)
        };
        let own = self
            .sides
            .iter()
            .position(|s| from.is_some() && s.direction == from);
        let counts = || self.sides.iter().map(|side| side.knots.len() + 1);
        match own {
            // Behind the numbers of all gaps of the mean curve.
            Some(own) => {
                let before: usize = counts().product::<usize>() + counts().take(own).sum::<usize>();
                before + gap(&self.sides[own])
            }
            None => self
                .sides
                .iter()
                .zip(counts())
                .fold(0, |all, (side, count)| all * count + gap(side)),
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

    /// Pairs of neighbours of those of the interpolation's remainder, where it is of third degree.
    pub(crate) fn neighbouring_differences(&self) -> Vec<[DividedDifference; 2]> {
        let cubic = self.sides.iter().filter(|side| side.order == MOST_STEPS);
        let windows = cubic.flat_map(|side| side.knots.windows(MOST_STEPS + 2));
        let pair = |knots: &[Knot]| {
            let last = knots.len() - 1;
            [&knots[..last], &knots[1..]].map(divided_difference)
        };
        windows.map(pair).collect()
    }

    /// Slopes from each step to that so many steps on.
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
            knot.steps.iter().map(move |step| (*step, has_others))
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
            return vec![(step.node, 1.0)];
        }
        let mut weights = lagrange(self.stencil(position), position);
        let &[below, above] = around else {
            return weights;
        };
        let share = (position - below.0.position) / (above.0.position - below.0.position);
        for ((step, has_others), share) in [(below, 1.0 - share), (above, share)] {
            if has_others {
                let smooth = lagrange(self.stencil(step.position), step.position).into_iter();
                weights.push((step.node, share));
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
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use trueaxis_campaign::Direction::{Backward, Forward};
    use trueaxis_montecarlo::ChaCha8Rng;

    use super::*;
    use crate::interpolation::tests::at;

    fn places(positions: impl IntoIterator<Item = f64>) -> Vec<Node> {
        positions.into_iter().map(|q| at(q, None)).collect()
    }

    /// Steps at 0 and at 360° have noise of their own: the curve goes on at both without a jump.
    #[test]
    fn a_full_turn_does_not_jump_at_its_ends() {
        let nodes = places((0..=18).map(|k| (20.0 * f64::from(k)).to_radians()));
        let curve = Curve::new(AxisKind::Rotary, &nodes);
        let at = |q: f64| {
            let weights = curve.at(q).weights.into_iter();
            // 1 at the last step, 0 at all others.
            weights
                .filter(|(node, _)| *node == 18)
                .map(|(_, weight)| weight)
                .sum::<f64>()
        };
        for (end, expected) in [(TAU, 1.0), (0.0, 0.0)] {
            for q in [end - 1e-6, end, end + 1e-6] {
                assert!((at(q) - expected).abs() < 1e-5, "{q}: {}", at(q));
            }
        }
        // Elsewhere a turn more is no matter.
        assert!((at(TAU + 2.0) - at(2.0)).abs() < 1e-12);
    }

    fn value(curve: &Curve, nodes: &[Node], f: impl Fn(f64) -> f64, q: f64) -> f64 {
        let weights = curve.at(q).weights;
        weights
            .iter()
            .map(|&(n, weight)| weight * f(nodes[n].position))
            .sum()
    }

    #[test]
    fn cubics_come_back_and_quartics_differ_by_the_remainder() {
        let nodes = places([0.0, 10.0, 30.0, 38.0, 50.0, 80.0]);
        let curve = Curve::new(AxisKind::Linear, &nodes);
        let cubic = |q: f64| 3.0 - 0.2 * q + 0.01 * q * q - 2e-4 * q.powi(3);
        let quartic = |q: f64| cubic(q) + 7e-6 * q.powi(4);
        for difference in curve.divided_differences(None) {
            let found: f64 = difference
                .iter()
                .map(|&(n, w)| w * quartic(nodes[n].position))
                .sum();
            assert!((found - 7e-6).abs() < 1e-15, "{found}");
        }
        for i in 0..=160 {
            let q = 0.5 * f64::from(i);
            assert!((value(&curve, &nodes, cubic, q) - cubic(q)).abs() < 1e-12);
            let off = value(&curve, &nodes, quartic, q) - quartic(q);
            let expected = 7e-6 * curve.at(q).remainder;
            assert!(
                (off.abs() - expected).abs() < 1e-12,
                "{q}: {off} {expected}"
            );
        }
    }

    #[test]
    fn a_turn_has_no_ends() {
        let f = |q: f64| (2.0 * q).sin() + 0.3 * q.cos();
        for last in [17, 18] {
            let nodes = places((0..=last).map(|i| f64::from(20 * i).to_radians()));
            let curve = Curve::new(AxisKind::Rotary, &nodes);
            for degrees in [-5.0_f64, 3.0, 345.0, 352.0, 359.0, 367.0] {
                let q = degrees.to_radians();
                let off = value(&curve, &nodes, f, q) - f(q);
                assert!(off.abs() < 0.01, "{degrees}: {off}");
                assert!(curve.at(q).beyond < f64::MIN_POSITIVE);
            }
        }
        // Half a turn has.
        let nodes = places((0..=9).map(|i| f64::from(20 * i).to_radians()));
        let outside = Curve::new(AxisKind::Rotary, &nodes).at(190_f64.to_radians());
        assert_eq!(outside.weights, [(9, 1.0)]);
        assert!((outside.beyond - 10_f64.to_radians()).abs() < 1e-12);
    }

    #[test]
    fn few_steps_make_lines_and_parabolas() {
        for (steps, powers) in [(1, 1), (2, 2), (3, 2), (4, 3), (5, 4)] {
            let nodes = places((0..steps).map(|i| f64::from(i * 10)));
            let curve = Curve::new(AxisKind::Linear, &nodes);
            let f = |q: f64| (0..powers).map(|p| (0.1 * q - 0.3).powi(p)).sum::<f64>();
            let q = 4.0_f64.min(f64::from(steps - 1) * 10.0);
            assert!(
                (value(&curve, &nodes, f, q) - f(q)).abs() < 1e-12,
                "{steps}"
            );
        }
    }

    /// Standard uncertainty where each step has that of 1, all independent.
    fn u(sample: &Sample) -> f64 {
        let squares = sample.weights.iter().map(|(_, weight)| weight * weight);
        squares.sum::<f64>().sqrt()
    }

    #[test]
    fn steps_that_nearly_coincide_do_not_amplify_noise() {
        let wave_um = |q: f64| 5.0 * (TAU * q / 200.0).sin();
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for gap in [0.0001, 0.5, 3.0] {
            let nodes = places((0..20).flat_map(|k| [0.0, gap].map(|by| 20.0 * f64::from(k) + by)));
            let curve = Curve::new(AxisKind::Linear, &nodes);
            // Between steps, at them, within pairs and beyond the ends.
            let between = (-4..=1544).map(|k| 0.25 * f64::from(k));
            let places: Vec<f64> = between.chain(nodes.iter().map(|n| n.position)).collect();
            let samples: Vec<Sample> = places.iter().map(|&q| curve.at(q)).collect();
            for _ in 0..20 {
                let noise = || random.sample::<f64, _>(StandardNormal);
                let noise: Vec<f64> = std::iter::repeat_with(noise).take(nodes.len()).collect();
                for (q, sample) in places.iter().zip(&samples) {
                    let weights = sample.weights.iter();
                    let found = weights.map(|&(n, w)| w * (wave_um(nodes[n].position) + noise[n]));
                    let off = found.sum::<f64>() - wave_um(q.clamp(0.0, 380.0 + gap));
                    assert!(off.abs() < 4.5 * u(sample) + 0.1, "{gap} {q}: {off}");
                }
            }
            let largest = samples.iter().map(u).fold(0.0, f64::max);
            assert!(largest < 1.1, "{gap}: {largest}");
            // The mean of the pair half way, each of them where it is, and no jump anywhere.
            for (node, weight) in curve.at(40.0 + 0.5 * gap).weights {
                let expected = if [4, 5].contains(&node) { 0.5 } else { 0.0 };
                assert!((weight - expected).abs() < 0.03, "{gap} {node}: {weight}");
            }
            assert_eq!(curve.at(40.0 + gap).weights, [(5, 1.0)]);
            assert_eq!(curve.steps().len(), nodes.len());
            for q in nodes.iter().map(|node| node.position) {
                let [below, above] =
                    [q - 1e-9, q + 1e-9].map(|q| value(&curve, &nodes, wave_um, q));
                assert!((below - above).abs() < 1e-6, "{gap} {q}: {below} {above}");
            }
        }
    }

    /// 10 mm beside gaps of 100 and more: as mean values of both the step at 200 was off by half of what they differ.
    #[test]
    fn every_step_has_its_own_error() {
        let nodes = places([0.0, 100.0, 200.0, 210.0, 380.0, 500.0]);
        let curve = Curve::new(AxisKind::Linear, &nodes);
        for (k, node) in nodes.iter().enumerate() {
            let sample = curve.at(node.position);
            assert_eq!(sample.weights, [(k, 1.0)]);
            assert!(sample.remainder.abs() < f64::MIN_POSITIVE);
        }
    }

    #[test]
    fn no_grid_amplifies_noise_more_than_fivefold() {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        for _ in 0..200 {
            let gap = || 10_f64.powf(random.random_range(-3.0..2.0));
            let gaps = std::iter::repeat_with(gap).take(30);
            let positions = gaps.scan(0.0, |q, gap| {
                *q += gap;
                Some(*q)
            });
            let nodes = places(positions);
            let curve = Curve::new(AxisKind::Linear, &nodes);
            let [first, last] = [nodes[0].position, nodes[29].position];
            for k in 0..=1000 {
                let q = first + (last - first) * f64::from(k) / 1000.0;
                assert!(u(&curve.at(q)) < 5.0, "{q} of {nodes:?}");
            }
        }
    }

    /// The ends of a turn, too: 359.99° is 0°.
    #[test]
    fn ends_of_a_turn_that_nearly_coincide_do_not_amplify_noise() {
        let degrees = (0..18).map(|k| 20.0 * f64::from(k)).chain([359.99]);
        let nodes = places(degrees.map(f64::to_radians));
        let curve = Curve::new(AxisKind::Rotary, &nodes);
        for k in -300..=4000 {
            let q = (0.1 * f64::from(k)).to_radians();
            assert!(u(&curve.at(q)) < 1.1, "{k}: {}", u(&curve.at(q)));
        }
    }

    #[test]
    fn steps_of_like_distances_are_knots_of_their_own() {
        for positions in [
            vec![0.0, 10.0, 20.0, 30.0, 40.0],
            vec![0.0, 5.0, 25.0, 40.0, 45.0, 65.0],
        ] {
            let curve = Curve::new(AxisKind::Linear, &places(positions.iter().copied()));
            let knots = curve.sides[0].knots.iter();
            let own = knots.map(|knot| (knot.position, knot.steps.len()));
            let expected = positions.iter().map(|&q| (q, 1));
            assert!(own.eq(expected));
        }
        let equal = Curve::new(AxisKind::Linear, &places([0.0, 10.0, 20.0, 30.0, 40.0]));
        let expected = [(1, -0.0625), (2, 0.5625), (3, 0.5625), (4, -0.0625)];
        assert_eq!(equal.at(25.0).weights, expected);
    }

    #[test]
    fn sides_that_reach_a_position_share_it() {
        let nodes = [
            at(0.0, Some(Forward)),
            at(10.0, Some(Backward)),
            at(10.0, Some(Forward)),
            at(20.0, Some(Backward)),
            at(20.0, Some(Forward)),
        ];
        let curve = Curve::new(AxisKind::Linear, &nodes);
        assert_eq!(curve.at(5.0).weights, [(0, 0.5), (2, 0.5)]);
        assert_eq!(curve.at(10.0).weights, [(1, 0.5), (2, 0.5)]);
        let sum: f64 = curve
            .at(15.0)
            .weights
            .iter()
            .map(|(_, weight)| weight)
            .sum();
        assert!((sum - 1.0).abs() < 1e-15);
        assert!((curve.at(-3.0).beyond - 3.0).abs() < 1e-15);
    }
}

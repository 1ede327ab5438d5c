//! The curves of a calibration in sets on which effects act, and what the gauge takes out of them.
//!
//! | axis | set | base B |
//! | --- | --- | --- |
//! | linear | each straightness | `1, q` |
//! | linear | positioning, each angle | `1` |
//! | rotary | both curves of δ across the axis | a constant vector and one that turns with the axis |
//! | rotary | both curves of ε across the axis | the same |
//! | rotary | δ along the axis; ε about it | `1` |
//!
//! Where the two sides of approach have curves of their own, half their difference joins the base as a constant.

use nalgebra::{DMatrix, Rotation3, Vector3};
use trueaxis_calibrate::{AxisResult, Calibration};
use trueaxis_campaign::Direction;
use trueaxis_effects::AxisPosition;
use trueaxis_kinematics::{Axis, AxisKind, Component, Machine, MotionError};
use trueaxis_leastsquares::median;
use trueaxis_predict::Unit;
use trueaxis_selection::Projection;

use crate::components::candidates::Candidate;
use crate::numbers::extremes;

/// Curves that are judged together.
#[derive(Debug, Clone)]
pub(crate) struct CurveSet {
    /// Index of the axis in the machine.
    pub(crate) axis: usize,
    pub(crate) content: Axis,
    /// The curves, one after the other.
    pub(crate) components: Vec<Component>,
    /// Position of each step, mm or rad, and its side of approach, +1 or -1.
    pub(crate) nodes: Vec<(f64, f64)>,
    /// Values, µm or arcsec, curve after curve.
    pub(crate) values: Vec<f64>,
    pub(crate) covariance: DMatrix<f64>,
    /// Base: what the gauge takes out.
    pub(crate) base: Vec<Vec<f64>>,
    /// All steps, if some were left out.
    pub(crate) thinned: Option<Thinned>,
}

/// A set before it was thinned.
#[derive(Debug, Clone)]
pub(crate) struct Thinned {
    /// All steps, as [`CurveSet::nodes`].
    pub(crate) nodes: Vec<(f64, f64)>,
    /// Values there, curve after curve.
    pub(crate) values: Vec<f64>,
    /// One step in this many was kept.
    pub(crate) stride: usize,
}

/// Fewest steps at which a curve says anything about its rest: the base and an effect with a period take up to five.
pub(crate) const FEWEST_STEPS: usize = 8;

/// Most steps of an axis; more are thinned, because the cost of its six curves grows with their third power. Of waves
/// that look alike at the kept steps all steps show the true one ([`crate::components::aliases`]).
const MOST_STEPS: usize = 96;

/// Most steps of a line, which is one curve.
const MOST_STEPS_OF_LINE: usize = 400;

/// All sets of all axes; axes with too few steps are named in `notices`.
pub(crate) fn curve_sets(
    calibration: &Calibration,
    machine: &Machine,
    notices: &mut Vec<String>,
) -> Vec<CurveSet> {
    let mut sets = Vec::new();
    for result in &calibration.axes {
        let steps = result.nodes.len();
        if steps < FEWEST_STEPS {
            notices.push(format!(
                "axis {}: {steps} positions are too few to look for effects in its error curves, {FEWEST_STEPS} are needed",
                result.name
            ));
            continue;
        }
        let stride = steps.div_ceil(MOST_STEPS);
        let content = &machine.axes()[result.axis];
        let sides: Vec<_> = result.nodes.iter().map(|node| node.direction).collect();
        let kept = thinned(&sides, stride);
        for components in groups(content) {
            sets.push(CurveSet::new(
                calibration,
                result,
                &kept,
                content,
                components,
            ));
        }
        let notice = sets
            .last()
            .and_then(|set| set.notice(&format!("axis {}", result.name)));
        notices.extend(notice);
    }
    sets
}

/// Every `stride`-th node of each side of approach, in order, so that alternating sides lose equally many.
fn thinned(sides: &[Option<Direction>], stride: usize) -> Vec<usize> {
    let kept = [None, Some(Direction::Backward), Some(Direction::Forward)].map(|side| {
        let own = (0..sides.len()).filter(move |&node| sides[node] == side);
        own.step_by(stride)
    });
    let mut kept: Vec<usize> = kept.into_iter().flatten().collect();
    kept.sort_unstable();
    kept
}

fn groups(axis: &Axis) -> Vec<Vec<Component>> {
    let along = axis.principal();
    let across: Vec<usize> = (0..3).filter(|&i| i != along).collect();
    match axis.kind() {
        AxisKind::Linear => Component::ALL.map(|component| vec![component]).into(),
        AxisKind::Rotary => vec![
            across.iter().map(|&i| Component::ALL[i]).collect(),
            vec![Component::ALL[along]],
            across.iter().map(|&i| Component::ALL[3 + i]).collect(),
            vec![Component::ALL[3 + along]],
        ],
    }
}

impl CurveSet {
    /// The curves of an axis at the kept nodes.
    fn new(
        calibration: &Calibration,
        result: &AxisResult,
        kept: &[usize],
        content: &Axis,
        components: Vec<Component>,
    ) -> Self {
        let nodes = result.nodes.iter();
        let values = components.iter().flat_map(|component| {
            let nodes = nodes.clone();
            nodes.map(|node| in_unit(&node.error, *component))
        });
        let values = values.collect();
        let side = |side: Option<Direction>| f64::from(side.map_or(1, Direction::sign));
        let all = Thinned {
            stride: nodes.len().div_ceil(kept.len()),
            nodes: nodes
                .map(|node| (node.position, side(node.direction)))
                .collect(),
            values,
        };
        let covariance = covariance(calibration, result, kept, &components);
        Self::of_kept((result.axis, content), components, all, kept, covariance)
    }

    /// One curve from a positioning line, µm or arcsec at positions in mm or rad, with independent values.
    pub(crate) fn of_line(
        axis: usize,
        content: &Axis,
        component: Component,
        positions: Vec<f64>,
        values: Vec<f64>,
        variances: Vec<f64>,
    ) -> Self {
        let stride = positions.len().div_ceil(MOST_STEPS_OF_LINE);
        let kept: Vec<usize> = (0..positions.len()).step_by(stride).collect();
        let variances: Vec<f64> = kept.iter().map(|&node| variances[node]).collect();
        let covariance = DMatrix::from_diagonal(&variances.into());
        let all = Thinned {
            nodes: positions.into_iter().map(|q| (q, 1.0)).collect(),
            values,
            stride,
        };
        Self::of_kept((axis, content), vec![component], all, &kept, covariance)
    }

    /// Curves at the kept nodes, with the covariance of their values there.
    fn of_kept(
        (axis, content): (usize, &Axis),
        components: Vec<Component>,
        all: Thinned,
        kept: &[usize],
        covariance: DMatrix<f64>,
    ) -> Self {
        let curves = all.values.chunks_exact(all.nodes.len());
        let values = curves.flat_map(|curve| kept.iter().map(move |&node| curve[node]));
        let mut set = Self {
            axis,
            content: content.clone(),
            components,
            nodes: kept.iter().map(|&node| all.nodes[node]).collect(),
            values: values.collect(),
            covariance,
            base: Vec::new(),
            thinned: (kept.len() < all.nodes.len()).then_some(all),
        };
        set.base = set.gauge();
        set
    }

    /// The notice that not all of its positions were used, if so.
    pub(crate) fn notice(&self, whose: &str) -> Option<String> {
        let thinned = self.thinned.as_ref()?;
        Some(format!(
            "{whose}: of its {} positions one in {} was used to look for effects in its error curves; all positions tell apart the waves that \
             look alike at these; only a wave with the same value at each of these cannot be found",
            thinned.nodes.len(),
            thinned.stride
        ))
    }

    /// A function of curve and step as a column, curve after curve.
    fn column(&self, value: impl Fn(usize, f64, f64) -> f64) -> Vec<f64> {
        self.column_at(&self.nodes, value)
    }

    fn column_at(&self, nodes: &[(f64, f64)], value: impl Fn(usize, f64, f64) -> f64) -> Vec<f64> {
        let curves = 0..self.components.len();
        let steps = curves.flat_map(|c| nodes.iter().map(move |&(q, side)| (c, q, side)));
        steps.map(|(c, q, side)| value(c, q, side)).collect()
    }

    fn gauge(&self) -> Vec<Vec<f64>> {
        let only = |curve: usize| move |c: usize| f64::from(u8::from(c == curve));
        let curves = 0..self.components.len();
        let mut base: Vec<Vec<f64>> = curves
            .clone()
            .map(|curve| self.column(|c, _, _| only(curve)(c)))
            .collect();
        match self.content.kind() {
            AxisKind::Linear if self.is_straightness() => {
                let travel = self.travel();
                base.push(self.column(|_, q, _| q / travel));
            }
            AxisKind::Linear => {}
            AxisKind::Rotary if self.components.len() == 2 => {
                let directions: Vec<usize> =
                    self.components.iter().map(|c| c.index() % 3).collect();
                let d = self.content.direction();
                for &start in &directions {
                    base.push(self.column(|c, q, _| {
                        let turned = Rotation3::from_axis_angle(&d, q) * Vector3::ith(start, 1.0);
                        turned[directions[c]]
                    }));
                }
            }
            AxisKind::Rotary => {}
        }
        let two_sided = self.nodes.iter().any(|node| node.1 < 0.0)
            && self.nodes.iter().any(|node| node.1 > 0.0);
        if two_sided {
            base.extend(curves.map(|curve| self.column(|c, _, side| only(curve)(c) * side)));
        }
        base
    }

    /// Whether it is the straightness of a linear axis.
    pub(crate) fn is_straightness(&self) -> bool {
        let component = self.components[0];
        self.content.kind() == AxisKind::Linear
            && !component.is_angular()
            && component.index() != self.content.principal()
    }

    /// The distance from the first to the last position, mm or rad.
    pub(crate) fn travel(&self) -> f64 {
        let [low, high] = extremes(self.nodes.iter().map(|node| node.0));
        high - low
    }

    /// Between the first and the last position, mm or rad.
    pub(crate) fn middle(&self) -> f64 {
        let [low, high] = extremes(self.nodes.iter().map(|node| node.0));
        0.5 * (low + high)
    }

    /// The median distance of neighbouring positions, mm or rad.
    pub(crate) fn step(&self) -> f64 {
        step_of(&self.nodes)
    }

    /// The median distance of all measured neighbouring positions.
    pub(crate) fn measured_step(&self) -> f64 {
        let all = self.thinned.as_ref();
        step_of(all.map_or(&self.nodes, |all| &all.nodes))
    }

    pub(crate) fn after_gauge(&self, curves: Vec<f64>) -> Projection {
        Projection::dense(curves, &self.base)
    }

    /// Changes of the curves, µm or arcsec, by a unit of each parameter of a candidate with this shape.
    pub(crate) fn columns(&self, candidate: &Candidate, shape: f64) -> Vec<Vec<f64>> {
        self.columns_at(&self.nodes, candidate, shape)
    }

    /// The same at other nodes.
    pub(crate) fn columns_at(
        &self,
        nodes: &[(f64, f64)],
        candidate: &Candidate,
        shape: f64,
    ) -> Vec<Vec<f64>> {
        let (effect, subject) = (candidate.hypothesis.effect, &candidate.hypothesis.subject);
        let of_parameter = |k: usize| {
            self.column_at(nodes, |c, position, direction| {
                let at = AxisPosition {
                    axis: &self.content,
                    position,
                    direction,
                };
                in_unit(&effect.motion(subject, k, shape, &at), self.components[c])
            })
        };
        (0..candidate.parameters).map(of_parameter).collect()
    }
}

/// The median distance of neighbouring positions.
fn step_of(nodes: &[(f64, f64)]) -> f64 {
    let mut positions: Vec<f64> = nodes.iter().map(|node| node.0).collect();
    positions.sort_by(f64::total_cmp);
    let mut gaps: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps.retain(|gap| *gap > 0.0);
    median(&mut gaps).unwrap_or(0.0)
}

/// One component of an error, µm or arcsec.
fn in_unit(error: &MotionError, component: Component) -> f64 {
    error.to_vector()[component.index()] / Unit::of_component(component).size()
}

/// The covariance at the kept nodes of the curves of an axis, µm and arcsec.
fn covariance(
    calibration: &Calibration,
    result: &AxisResult,
    kept: &[usize],
    components: &[Component],
) -> DMatrix<f64> {
    let before = calibration.axes.iter();
    let before = before.take_while(|axis| axis.axis != result.axis);
    let first: usize = before.map(|axis| axis.nodes.len()).sum();
    let places = components.iter().flat_map(|component| {
        let nodes = kept.iter().map(|node| first + node);
        nodes.map(|node| 6 * node + component.index())
    });
    let places: Vec<usize> = places.collect();
    // All components of a set are of one kind.
    let unit = Unit::of_component(components[0]).size();
    calibration.factors.of_results(&places) / (unit * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes are sorted by position, backward before forward: every second node would be one side only.
    #[test]
    fn both_sides_of_approach_are_thinned_alike() {
        let both = [Some(Direction::Backward), Some(Direction::Forward)];
        let sides = both.repeat(3);
        assert_eq!(thinned(&sides, 2), [0, 1, 4, 5]);
        assert_eq!(thinned(&[None; 5], 2), [0, 2, 4]);
        assert_eq!(thinned(&sides, 1), [0, 1, 2, 3, 4, 5]);
    }
}

//! The reference frame of a campaign: the rule of `trueaxis-kinematics`, applied to its measurements.

use nalgebra::{DMatrix, Vector3};
use trueaxis_campaign::frame_rule;
use trueaxis_kinematics::{AxisKind, LocationComponent, Machine, SmallMotion};
use trueaxis_leastsquares::dense::Svd;

use crate::identify::context::Context;

/// The rule that fixes the frame of a campaign.
pub(crate) struct FrameRule {
    /// Up to two linear axes (indices of the axis data).
    pub(crate) lines: Vec<usize>,
    /// The targets that decide the rest, once for each run that measured them.
    pub(crate) anchors: Vec<Anchor>,
    /// Weight of each run in the mean of a target among the anchors: all targets count alike.
    weights: Vec<f64>,
    /// See [`FrameRule::axial_places`].
    axial: DMatrix<f64>,
    rule: trueaxis_kinematics::FrameRule,
}

/// A target in a run, whose position at home enters the frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Anchor {
    /// Index of the axis data.
    pub(crate) data: usize,
    pub(crate) run: usize,
    /// Place of the target among the run's targets.
    pub(crate) place: usize,
    /// Number of the target among those of the rule.
    number: usize,
}

impl FrameRule {
    pub(crate) fn new(context: &Context<'_>) -> Self {
        let data = context.data;
        let measured = data.iter().flat_map(|axis| {
            let targets = axis.runs.iter().flat_map(|run| &run.targets);
            targets.map(|&target| (axis.axis, target))
        });
        let rule = frame_rule(context.machine, &context.campaign.targets, measured);
        let lines: Vec<usize> = rule
            .lines()
            .filter_map(|axis| context.place_of(axis))
            .collect();
        let numbers: Vec<usize> = rule.anchors().collect();
        let mut anchors: Vec<Anchor> = Vec::new();
        for (k, axis) in data.iter().enumerate() {
            if !lines.is_empty() && context.axis(k).kind() != AxisKind::Linear {
                continue;
            }
            for (run, content) in axis.runs.iter().enumerate() {
                for (place, target) in content.targets.iter().enumerate() {
                    if let Ok(number) = numbers.binary_search(target) {
                        anchors.push(Anchor {
                            data: k,
                            run,
                            place,
                            number,
                        });
                    }
                }
            }
        }
        let mut weights = vec![0.0; numbers.len()];
        anchors.iter().for_each(|a| weights[a.number] += 1.0);
        let weights = weights.into_iter().map(f64::recip).collect();
        Self {
            lines,
            anchors,
            weights,
            axial: axial(context, &rule),
            rule,
        }
    }

    /// Whether axis `k` has a position along itself.
    pub(crate) fn is_placed(&self, k: usize) -> bool {
        self.axial.column(k).amax() > 0.0
    }

    /// The position of each axis along itself (a row), from the mean shift of its targets along it; zero for axes
    /// without such a position.
    pub(crate) fn axial_places(&self, mean_shifts: &DMatrix<f64>) -> DMatrix<f64> {
        &self.axial * mean_shifts
    }

    /// The location errors of an axis that are reported: for a line, those that the frame does not define.
    pub(crate) fn reported(&self, machine: &Machine, axis: usize) -> Vec<LocationComponent> {
        let geometry = &machine.axes()[axis];
        let mut all = geometry.location_components();
        all.retain(|&c| {
            geometry.kind() == AxisKind::Rotary || !self.rule.defines(machine, axis, c)
        });
        all
    }

    /// The motion to be taken out, from the tilts of the lines (rotation vectors in the reference frame) and the
    /// shifts of the anchors. It is linear in both.
    pub(crate) fn motion(&self, tilts: &[Vector3<f64>], shifts: &[Vector3<f64>]) -> SmallMotion {
        let mut means = vec![Vector3::zeros(); self.weights.len()];
        for (anchor, shift) in self.anchors.iter().zip(shifts) {
            means[anchor.number] += shift * self.weights[anchor.number];
        }
        self.rule.motion(tilts, &means)
    }
}

/// Singular value below which rotary axes that carry each other share shifts: they are parallel to 0.8 degrees.
const SHARED_TOL: f64 = 1e-4;

/// Inverts the shifts of targets by shifts of axes: if rotary axes that carry each other are oblique, both count.
fn axial(context: &Context<'_>, rule: &trueaxis_kinematics::FrameRule) -> DMatrix<f64> {
    let (machine, data) = (context.machine, context.data);
    let is_placed = |k: usize| {
        context.axis(k).kind() == AxisKind::Rotary && rule.places_along_itself(data[k].axis)
    };
    let moved = |k: usize, j: usize| {
        let targets = data[k].runs.iter().flat_map(|run| &run.targets);
        let carriers = targets.map(|&target| context.campaign.targets[target].carrier);
        let chains: Vec<&[usize]> = carriers.map(|carrier| machine.chain(carrier)).collect();
        let moved = chains.iter().filter(|chain| chain.contains(&data[j].axis));
        moved.count() as f64 / chains.len() as f64
    };
    let direction = |k: usize| context.axis(k).direction().into_inner();
    let parts = DMatrix::from_fn(data.len(), data.len(), |k, j| {
        if is_placed(k) && is_placed(j) {
            moved(k, j) * direction(k).dot(&direction(j))
        } else {
            0.0
        }
    });
    // Parts of unit vectors are finite.
    Svd::new(&parts).map_or(parts, |svd| svd.pseudo_inverse(SHARED_TOL))
}

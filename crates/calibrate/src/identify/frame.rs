//! The reference frame of a campaign: the rule of `trueaxis-kinematics` on what was measured.

use nalgebra::Vector3;
use trueaxis_kinematics::{AxisKind, LocationComponent, Machine, NominalTarget};

use crate::identify::context::Context;

pub(crate) use trueaxis_kinematics::SmallMotion;

/// The rule that fixes the frame of a campaign.
pub(crate) struct FrameRule {
    /// Up to two linear axes (indices of the axis data).
    pub(crate) lines: Vec<usize>,
    /// The targets that decide the rest, once for each run that measured them.
    pub(crate) anchors: Vec<Anchor>,
    /// Of each target among the anchors: the mean over the runs counts, whatever their number.
    weights: Vec<f64>,
    rule: trueaxis_kinematics::FrameRule,
}

/// A target in a run, whose position at home enters the frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Anchor {
    /// Index of the axis data.
    pub(crate) data: usize,
    /// Its run.
    pub(crate) run: usize,
    /// Place of the target among the run's targets.
    pub(crate) place: usize,
    /// Number of the target among those of the rule.
    number: usize,
}

impl FrameRule {
    pub(crate) fn new(context: &Context<'_>) -> Self {
        let Context {
            campaign,
            machine,
            data,
            ..
        } = *context;
        let targets = campaign.targets.iter().map(|target| NominalTarget {
            carrier: target.carrier,
            home_mm: target.home_mm,
        });
        let targets: Vec<NominalTarget> = targets.collect();
        let measured = data.iter().flat_map(|axis| {
            let targets = axis.runs.iter().flat_map(|run| &run.targets);
            targets.map(|&target| (axis.axis, target))
        });
        let rule = trueaxis_kinematics::FrameRule::new(machine, &targets, measured);
        let lines: Vec<usize> = rule
            .lines()
            .filter_map(|axis| context.place_of(axis))
            .collect();
        let numbers: Vec<usize> = rule.anchors().collect();
        let mut anchors = Vec::new();
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
        anchors
            .iter()
            .for_each(|a: &Anchor| weights[a.number] += 1.0);
        let weights = weights.into_iter().map(f64::recip).collect();
        Self {
            lines,
            anchors,
            weights,
            rule,
        }
    }

    /// Whether a rotary axis has a place along itself.
    pub(crate) fn places_along_itself(&self, axis: usize) -> bool {
        self.rule.places_along_itself(axis)
    }

    /// The location errors of an axis that are reported: of lines those that the frame does not define away.
    pub(crate) fn reported(&self, machine: &Machine, axis: usize) -> Vec<LocationComponent> {
        let geometry = &machine.axes()[axis];
        let mut all = geometry.location_components();
        all.retain(|&c| {
            geometry.kind() == AxisKind::Rotary || !self.rule.defines(machine, axis, c)
        });
        all
    }

    /// The motion that is to be taken out: from the tilts of the lines (rotation vectors in the
    /// reference frame) and the shifts of the anchors. It is linear in both.
    pub(crate) fn motion(&self, tilts: &[Vector3<f64>], shifts: &[Vector3<f64>]) -> SmallMotion {
        let mut means = vec![Vector3::zeros(); self.weights.len()];
        for (anchor, shift) in self.anchors.iter().zip(shifts) {
            means[anchor.number] += shift * self.weights[anchor.number];
        }
        self.rule.motion(tilts, &means)
    }
}

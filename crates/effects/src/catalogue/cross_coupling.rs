//! An error of one axis depends on the position of another, as sag under a moving mass does:
//! `c q_A q_B`, both from home.
//!
//! The form is the same for A on B and B on A; each pair stands once, the axis that comes first in the
//! machine as the subject. On a line along one axis only the part of `c` along the line shows. Without
//! a calibration a guideway whose yaw grows in proportion to position does the same to a line that is
//! measured with another lever arm.

use nalgebra::Vector3;
use trueaxis_kinematics::{AxisKind, MICROMETRE};

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

/// Square metres in a square millimetre.
const M2_PER_MM2: f64 = 1e-6;

#[derive(Debug)]
pub(super) struct CrossCoupling;

impl Effect for CrossCoupling {
    fn id(&self) -> &'static str {
        "cross_coupling"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths, Level::Verification]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        let mut linear: Vec<usize> = scene.moving_axes(AxisKind::Linear).collect();
        linear.sort_unstable();
        let pairs = linear
            .iter()
            .enumerate()
            .flat_map(|(i, &a)| linear[i + 1..].iter().map(move |&b| (a, b)));
        pairs
            .map(|(axis, other)| Subject {
                other_axis: Some(other),
                ..Subject::axis(axis)
            })
            .collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        ["x", "y", "z"]
            .map(|axis| Parameter::new(format!("coupling_{axis}"), "um/m2"))
            .into()
    }

    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        _: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        let (Some(a), Some(b)) = (subject.axis, subject.other_axis) else {
            return Displaced::default();
        };
        if !(at.is_carried_by(a) || at.is_carried_by(b)) {
            return Displaced::default();
        }
        let position = |axis: usize| at.positions.get(axis).copied().unwrap_or(0.0);
        let product_m2 = position(a) * position(b) * M2_PER_MM2;
        Displaced::point(Vector3::ith(parameter, MICROMETRE * product_m2))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the structure bends under the mass that another axis moves: sag, or a guideway twisted by the load",
            consequence: "the errors of the axis hold only where the other axis stood when they were measured; a model of single axes cannot hold both",
            action: "measure the axis with the other one at several positions and compensate over both (a grid), or re-level the machine",
            separate_by: "measure the axis with the other one parked at both ends of its travel, at the same lever arm: an angular error of the guideway goes away with the lever arm, sag does not",
        }
    }
}

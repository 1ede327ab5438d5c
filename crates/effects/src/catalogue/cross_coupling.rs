//! An error of one axis depends on the position of another, as sag under a moving mass does:
//! `D_p = c q_A q_B`, both from home, where A or B moves the target; c is `coupling_x`, `coupling_y`,
//! `coupling_z` in µm/m², in the reference frame.
//!
//! The form is the same for A on B and B on A; each pair stands once, the axis that comes first in the
//! machine as the subject. On a line along one axis only the part of `c` along the line shows. Without
//! a calibration a guideway whose yaw grows in proportion to position does the same to a line that is
//! measured with another lever arm.

use trueaxis_kinematics::MICROMETRE;

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

/// Square metres in a square millimetre.
const M2_PER_MM2: f64 = 1e-6;

pub(super) const EFFECT: Effect = Effect {
    id: "cross_coupling",
    layer: Layer::Machine,
    levels: &[Level::Lengths, Level::Verification],
    subjects: |scene| {
        let pairs = scene.linear_pairs().into_iter();
        pairs.map(|(a, b)| Subject::pair(a, b)).collect()
    },
    parameters: |_, _| Parameter::vector("coupling", "um/m2"),
    shape: Shape::Fixed,
    form: Form::Target(|of| {
        let axes = [of.subject.axis, of.subject.other_axis];
        if !axes
            .into_iter()
            .flatten()
            .any(|axis| of.at.is_carried_by(axis))
        {
            return 0.0;
        }
        let position = |axis: Option<usize>| axis.map_or(0.0, |axis| of.at.position(axis));
        let product_m2 = position(axes[0]) * position(axes[1]) * M2_PER_MM2;
        MICROMETRE * product_m2
    }),
    explanation: Explanation {
        cause: "the structure bends under the mass that another axis moves: sag, or a guideway twisted by the load",
        consequence: "the errors of the axis hold only where the other axis stood when they were measured; a model of single axes cannot hold both",
        action: "measure the axis with the other one at several positions and compensate over both (a grid), or re-level the machine",
        separate_by: "measure the axis with the other one parked at both ends of its travel, at the same lever arm: an angular error of the guideway goes away with the lever arm, sag does not",
    },
};

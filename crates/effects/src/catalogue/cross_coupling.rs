//! An error of one axis depends on the position of another, as sag under a moving mass does, in proportion to
//! both positions from home.
//!
//! Without a component: `D_p = c q_A q_B`, where A or B moves the target; c is `coupling_x`, `coupling_y`,
//! `coupling_z` in µm/m², in the reference frame. The form is the same for A on B and B on A; each pair stands
//! once, the axis that comes first in the machine as the subject. On a line along one axis only the part of `c`
//! along the line shows. Without a calibration a guideway whose yaw grows in proportion to position does the
//! same to a line that is measured with another lever arm.
//!
//! With a component, a straightness of A in the direction s: the guideway of A sags, as a cross rail does under
//! the mass that B moves, and the stage of A stands tangent to it (see `guideway_bow` for the angle),
//!
//! ```text
//! δ = y s        ε = y' d × s        y = c q_A q_B        y' = c q_B
//! ```
//!
//! c is `sag` in µm/m².

use nalgebra::Vector3;
use trueaxis_kinematics::{AxisKind, Component, MICROMETRE, MotionError};

use crate::form::AtReading;
use crate::waves::across;
use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Scene, Shape, Subject};

/// Ten millimetres over a metre of both axes: no machine that is to be calibrated sags by more.
const MOST_UM_PER_M2: [f64; 2] = [-1e4, 1e4];

/// Square metres in a square millimetre.
const M2_PER_MM2: f64 = 1e-6;

pub(super) const EFFECT: Effect = Effect {
    id: "cross_coupling",
    layer: Layer::Machine,
    levels: &[Level::Lengths, Level::Verification],
    subjects: pairs_and_sags,
    parameters: |_, subject| match subject.component {
        Some(_) => vec![Parameter::new("sag", "um/m2").plausible(MOST_UM_PER_M2)],
        None => {
            let coupling = Parameter::vector("coupling", "um/m2").into_iter();
            coupling.map(|c| c.plausible(MOST_UM_PER_M2)).collect()
        }
    },
    shape: Shape::Fixed,
    form: Form::Displacement(coupled),
    explanation: Explanation {
        cause: "the structure bends under the mass that another axis moves: sag, or a guideway twisted by the load",
        consequence: "the errors of the axis hold only where the other axis stood when they were measured; a model of single axes cannot hold both",
        action: "measure the axis with the other one at several positions and compensate over both (a grid), or re-level the machine",
        separate_by: "measure the axis with the other one parked at both ends of its travel, at the same lever arm: an angular error of the guideway goes away with the lever arm, sag does not",
    },
};

fn pairs_and_sags(scene: &Scene) -> Vec<Subject> {
    let pairs = scene.linear_pairs().into_iter();
    let mut all: Vec<Subject> = pairs.map(|(a, b)| Subject::pair(a, b)).collect();
    let axes: Vec<usize> = scene.moving_axes(AxisKind::Linear).collect();
    for &axis in &axes {
        for &other in axes.iter().filter(|&&other| other != axis) {
            let across = across(&scene.machine.axes()[axis]).map(|i| Component::ALL[i]);
            all.extend(across.map(|component| Subject {
                component: Some(component),
                ..Subject::pair(axis, other)
            }));
        }
    }
    all
}

/// Displacement for a unit of the parameter, mm.
fn coupled(of: &AtReading<'_>) -> Vector3<f64> {
    let (Some(axis), Some(other)) = (of.subject.axis, of.subject.other_axis) else {
        return Vector3::zeros();
    };
    let (q, q_other) = (of.at.position(axis), of.at.position(other));
    let y_mm = MICROMETRE * M2_PER_MM2 * q * q_other;
    let Some(component) = of.subject.component else {
        let moves = [axis, other]
            .into_iter()
            .any(|axis| of.at.is_carried_by(axis));
        return Vector3::ith(of.parameter, if moves { y_mm } else { 0.0 });
    };
    let slope_rad = MICROMETRE * M2_PER_MM2 * q_other;
    let d = of.at.machine.axes()[axis].direction().into_inner();
    let s = Vector3::ith(component.index() % 3, 1.0);
    let s = (s - d * d.dot(&s)).normalize();
    of.at
        .moved(axis, &MotionError::new(s * y_mm, d.cross(&s) * slope_rad))
}

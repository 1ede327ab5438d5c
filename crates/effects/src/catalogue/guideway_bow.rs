//! A curved guideway: the stage follows the curve and turns with its slope.
//!
//! The reference point follows `y(q) = b q²` in the direction s across the axis d; the stage stands
//! tangent to the guideway, so the direction d of its way turns into `d + y' s`. The small rotation ε
//! across d that does this has `ε × d = y' s`, hence
//!
//! ```text
//! δ = y s        ε = d × (y' s) = y' d × s        y' = 2 b q
//! ```
//!
//! since `(d × s) × d = s` for unit vectors at right angles. For y(x) of an X axis the stage turns by
//! atan(dy/dx), about +z. By the right-hand rule:
//!
//! | straightness | matching angle | | straightness | matching angle |
//! | --- | --- | --- | --- | --- |
//! | `EYX` | `ECX = +dEYX/dx` | | `EZX` | `EBX = -dEZX/dx` |
//! | `EXY` | `ECY = -dEXY/dy` | | `EZY` | `EAY = +dEZY/dy` |
//! | `EXZ` | `EBZ = +dEXZ/dz` | | `EYZ` | `EAZ = -dEYZ/dz` |
//!
//! If another point of the stage follows the guideway, an offset along d or s adds a linear term to the
//! straightness (squareness takes it) or to the positioning (`scale_error`); the bow b stays the same. b is `bow` in µm/m².

use nalgebra::Vector3;
use trueaxis_kinematics::{AxisKind, Component, MotionError};

use crate::form::OnCurve;
use crate::waves::across;
use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "guideway_bow",
    layer: Layer::Machine,
    levels: &[Level::Components],
    subjects: |scene| {
        let axes = scene.moving_axes(AxisKind::Linear);
        axes.flat_map(|axis| {
            let across = across(&scene.machine.axes()[axis]);
            across.map(|i| Subject::component(axis, Component::ALL[i]))
        })
        .collect()
    },
    parameters: |_, _| vec![Parameter::new("bow", "um/m2")],
    shape: Shape::Fixed,
    form: Form::Curves(bow),
    explanation: Explanation {
        cause: "the guideway is bent: by its weight, its clamping, a temperature gradient between top and bottom, or how it was ground; the stage follows it and tilts with its slope",
        consequence: "points far from the guideway see the straightness and, through the lever arm, a positioning error that is linear in position and grows with the height above the guideway",
        action: "look at the temperatures at the top and bottom of the bed, its levelling and the bolts of the guideway; compensate straightness and angle together",
        separate_by: "measure the angle along the axis with an electronic level or an autocollimator, in the morning and after hours of running: a thermal bow changes",
    },
};

/// δ and ε for b = 1 µm/m².
fn bow(of: &OnCurve<'_>) -> MotionError {
    let d = of.at.axis.direction().into_inner();
    let component = of.subject.component.filter(|c| !c.is_angular());
    let direction = component.map(|c| Vector3::ith(c.index(), 1.0));
    // At right angles to an axis that is not quite parallel to its reference direction.
    let across = direction.and_then(|s| (s - d * d.dot(&s)).try_normalize(MIN_ACROSS));
    let Some(s) = across else {
        return MotionError::default();
    };
    let y_mm = UM_PER_M2 * of.at.position * of.at.position;
    let slope_rad = 2.0 * UM_PER_M2 * of.at.position;
    MotionError::new(s * y_mm, d.cross(&s) * slope_rad)
}

/// 1 µm/m² in 1/mm.
const UM_PER_M2: f64 = 1e-9;

/// A straightness direction nearer than this to the axis (sine of the angle) has no part across it.
const MIN_ACROSS: f64 = 1e-6;

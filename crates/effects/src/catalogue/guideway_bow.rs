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
//! straightness (squareness takes it) or to the positioning (`scale_error`); the bow b stays the same.

use nalgebra::Vector3;
use trueaxis_kinematics::{AxisKind, Component, MotionError};

use crate::curve::curve_form;
use crate::{
    AxisPosition, Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene,
    Subject,
};

#[derive(Debug)]
pub(super) struct GuidewayBow;

impl Effect for GuidewayBow {
    fn id(&self) -> &'static str {
        "guideway_bow"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Components]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        let mut subjects = Vec::new();
        for axis in scene.moving_axes(AxisKind::Linear) {
            let principal = scene.machine.axes()[axis].principal();
            let across = (0..3).filter(|&i| i != principal);
            subjects.extend(across.map(|i| Subject::component(axis, Component::ALL[i])));
        }
        subjects
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("bow", "um/m2")]
    }

    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        shape: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        curve_form(self, subject, parameter, shape, at)
    }

    fn motion(&self, subject: &Subject, _: usize, _: f64, at: &AxisPosition<'_>) -> MotionError {
        let d = at.axis.direction().into_inner();
        let component = subject.component.filter(|c| !c.is_angular());
        let direction = component.map(|c| Vector3::ith(c.index(), 1.0));
        // At right angles to an axis that is not quite parallel to its reference direction.
        let across = direction.and_then(|s| (s - d * d.dot(&s)).try_normalize(MIN_ACROSS));
        let Some(s) = across else {
            return MotionError::default();
        };
        let y_mm = UM_PER_M2 * at.position * at.position;
        let slope_rad = 2.0 * UM_PER_M2 * at.position;
        MotionError::new(s * y_mm, d.cross(&s) * slope_rad)
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the guideway is bent: by its weight, its clamping, a temperature gradient between top and bottom, or how it was ground; the stage follows it and tilts with its slope",
            consequence: "points far from the guideway see the straightness and, through the lever arm, a positioning error that is linear in position and grows with the height above the guideway",
            action: "look at the temperatures at the top and bottom of the bed, its levelling and the bolts of the guideway; compensate straightness and angle together",
            separate_by: "measure the angle along the axis with an electronic level or an autocollimator, in the morning and after hours of running: a thermal bow changes",
        }
    }
}

/// 1 µm/m² in 1/mm.
const UM_PER_M2: f64 = 1e-9;

/// A straightness direction nearer than this to the axis (sine of the angle) has no part across it.
const MIN_ACROSS: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use trueaxis_kinematics::Axis;

    /// The table of signs, each angle as the difference quotient of its straightness.
    #[test]
    fn the_angle_is_the_slope_of_the_straightness_by_the_right_hand_rule() {
        // Axis, straightness, angle, sign.
        let table = [
            (0, 1, 2, 1.0),
            (0, 2, 1, -1.0),
            (1, 0, 2, -1.0),
            (1, 2, 0, 1.0),
        ];
        for (axis, straightness, angle, sign) in
            table.into_iter().chain([(2, 0, 1, 1.0), (2, 1, 0, -1.0)])
        {
            let content = Axis::linear("L", Vector3::ith(axis, 1.0), [-200.0, 400.0]).unwrap();
            let subject = Subject::component(0, Component::ALL[straightness]);
            let motion = |position| {
                let at = AxisPosition {
                    axis: &content,
                    position,
                    direction: 1.0,
                };
                GuidewayBow.motion(&subject, 0, 0.0, &at)
            };
            let (before, after) = (motion(149.0).translation_mm, motion(151.0).translation_mm);
            let slope = (after - before)[straightness] / 2.0;
            assert!(slope > 0.0);
            let expected = Vector3::ith(angle, sign * slope);
            assert!((motion(150.0).rotation_rad - expected).norm() < 1e-6 * slope);
        }
    }
}

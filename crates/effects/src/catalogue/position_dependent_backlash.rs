//! Lost motion that changes along the axis, as a worn screw has it: `±b(q)/2` by direction,
//! `b(q) = mean + slope (q - q_mid)` with `q_mid` in the middle of travel.

use crate::axis_at::unit_motion;
use trueaxis_kinematics::{ARCSEC, AxisKind, MICROMETRE};

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

const MM_PER_M: f64 = 1e3;

#[derive(Debug)]
pub(super) struct PositionDependentBacklash;

impl Effect for PositionDependentBacklash {
    fn id(&self) -> &'static str {
        "position_dependent_backlash"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Components, Level::Verification]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        scene
            .moving
            .iter()
            .map(|&axis| Subject::axis(axis))
            .collect()
    }

    fn parameters(&self, scene: &Scene, subject: &Subject) -> Vec<Parameter> {
        // Of a rotary axis an angle, and its change per angle.
        let rotary = subject
            .axis
            .is_some_and(|axis| scene.machine.axes()[axis].kind() == AxisKind::Rotary);
        let [mean, slope] = if rotary {
            ["arcsec", "arcsec/rad"]
        } else {
            ["um", "um/m"]
        };
        vec![
            Parameter::new("lost_motion_mean", mean),
            Parameter::new("lost_motion_slope", slope),
        ]
    }

    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        _: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        let Some(axis) = subject.axis.filter(|&axis| axis == at.axis) else {
            return Displaced::default();
        };
        let content = &at.machine.axes()[axis];
        let [low, high] = content.travel();
        let from_middle = at.positions.get(axis).copied().unwrap_or(0.0) - 0.5 * (low + high);
        let (unit, per_unit) = match content.kind() {
            AxisKind::Linear => (MICROMETRE, from_middle / MM_PER_M),
            AxisKind::Rotary => (ARCSEC, from_middle),
        };
        let part = if parameter == 0 { 1.0 } else { per_unit };
        Displaced::point(unit_motion(axis, at) * (-0.5 * at.direction * unit * part))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the drive is worn where it is used most: play that is not the same along the axis",
            consequence: "the two sides of approach are two machines that differ by another amount at each position; one value in the backlash compensation is right at one place only",
            action: "replace or re-preload the screw, or give the control a table of backlash over position",
            separate_by: "measure the axis from both sides with a finer step where it is used most: play that follows wear is largest there",
        }
    }
}

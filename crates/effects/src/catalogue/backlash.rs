//! Lost motion on reversal: after arrival in positive direction the axis stands `b/2` short, in negative direction `b/2` far.

use crate::axis_at::unit_motion;
use trueaxis_kinematics::{ARCSEC, AxisKind, MICROMETRE};

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct Backlash;

impl Effect for Backlash {
    fn id(&self) -> &'static str {
        "backlash"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths, Level::Verification]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        scene
            .moving
            .iter()
            .map(|&axis| Subject::axis(axis))
            .collect()
    }

    fn parameters(&self, scene: &Scene, subject: &Subject) -> Vec<Parameter> {
        // Of a rotary axis an angle.
        let rotary = subject
            .axis
            .is_some_and(|axis| scene.machine.axes()[axis].kind() == AxisKind::Rotary);
        vec![Parameter::new(
            "lost_motion",
            if rotary { "arcsec" } else { "um" },
        )]
    }

    fn form(&self, subject: &Subject, _: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        match subject.axis {
            Some(axis) if axis == at.axis => {
                let unit = match at.machine.axes()[axis].kind() {
                    AxisKind::Linear => MICROMETRE,
                    AxisKind::Rotary => ARCSEC,
                };
                Displaced::point(unit_motion(axis, at) * (-0.5 * at.direction * unit))
            }
            _ => Displaced::default(),
        }
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "lost motion of the axis: play or wind-up between motor and stage",
            consequence: "the two sides of approach are two machines; their mean is neither",
            action: "adjust the drive or the backlash compensation of the control; calibrate --by-direction keeps the sides apart",
            separate_by: "measure the axis from both sides at two feeds: lost motion stays, a time offset of the readings grows with the feed",
        }
    }
}

//! The time stamps of the readings are late while the machine moves on: `v Δt` along the axis.

use crate::axis_at::unit_motion;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

const SECONDS_PER_MS: f64 = 1e-3;

#[derive(Debug)]
pub(super) struct TimestampOffset;

impl Effect for TimestampOffset {
    fn id(&self) -> &'static str {
        "timestamp_offset"
    }

    fn layer(&self) -> Layer {
        Layer::Instrument
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

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("offset", "ms")]
    }

    fn form(&self, subject: &Subject, _: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        match subject.axis {
            Some(axis) if axis == at.axis => {
                Displaced::point(unit_motion(axis, at) * (at.speed_per_s * SECONDS_PER_MS))
            }
            _ => Displaced::default(),
        }
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "readings are taken on the fly and their time stamps do not belong to the positions",
            consequence: "looks like lost motion in proportion to the feed",
            action: "synchronise the trigger, or measure at standstill",
            separate_by: "measure the same line at another feed: a time offset grows with the feed, lost motion does not",
        }
    }
}

//! Where the targets should be.

use nalgebra::Point3;
use trueaxis_kinematics::Ideal;

use super::hypothesis::Hypothesis;
use super::pairs::{End, Pair};
use crate::Campaign;

/// The nominal positions of all targets at all steps, mm.
pub(crate) struct NominalPoints {
    points: Vec<Point3<f64>>,
    targets: usize,
}

impl NominalPoints {
    /// Moves the ideal machine to every step, with its positions and targets read as `hypothesis` says.
    pub(crate) fn new(campaign: &Campaign, hypothesis: &Hypothesis) -> Self {
        let targets = &campaign.targets;
        let mut points = Vec::with_capacity(campaign.steps.len() * targets.len());
        let mut positions = Vec::new();
        for step in &campaign.steps {
            positions.clear();
            let factors = step.positions.iter().zip(&hypothesis.axis_factors);
            positions.extend(factors.map(|(position, factor)| position * factor));
            // Targets are mostly on one stage, whose motion is needed once.
            let mut stage = None;
            for target in targets {
                let motion = match stage {
                    Some((carrier, motion)) if carrier == target.carrier => motion,
                    _ => {
                        let machine = &campaign.machine;
                        machine.motion(&Ideal, target.carrier, &positions)
                    }
                };
                stage = Some((target.carrier, motion));
                points.push(motion * (target.home_mm * hypothesis.target_factor));
            }
        }
        Self {
            points,
            targets: targets.len(),
        }
    }

    pub(crate) fn at(&self, step: usize, target: usize) -> Point3<f64> {
        self.points[step * self.targets + target]
    }

    /// Nominal distance between the ends of a pair, mm.
    pub(crate) fn distance_mm(&self, pair: &Pair) -> f64 {
        self.between_mm(&pair.ends[0], &pair.ends[1])
    }

    /// Nominal distance between the targets of two readings, mm.
    pub(crate) fn between_mm(&self, a: &End, b: &End) -> f64 {
        nalgebra::distance(&self.at(a.step, a.target), &self.at(b.step, b.target))
    }
}

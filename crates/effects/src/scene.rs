//! What there is that effects can happen to.

use trueaxis_kinematics::{Axis, AxisKind, Machine};

use crate::{Medium, SceneTemperature, Subject};

/// The stations, targets and axes of a measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The machine.
    pub machine: Machine,
    /// Names of the stations.
    pub stations: Vec<String>,
    /// The targets.
    pub targets: Vec<SceneTarget>,
    /// The axes that move in the data.
    pub moving: Vec<usize>,
    /// The logged temperatures that effects may go with, in the order of [`crate::Circumstances::temperatures`].
    pub temperatures: Vec<SceneTemperature>,
}

/// A target of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneTarget {
    /// Its name.
    pub name: String,
    /// The outermost axis that moves it; none on the bed.
    pub carrier: Option<usize>,
}

impl Scene {
    /// Whether there are targets on the bed, which no axis moves.
    pub fn has_bed_targets(&self) -> bool {
        self.targets.iter().any(|target| target.carrier.is_none())
    }

    /// The moving axes of a kind.
    pub fn moving_axes(&self, kind: AxisKind) -> impl Iterator<Item = usize> + '_ {
        let axes = self.moving.iter().copied();
        axes.filter(move |&axis| self.machine.axes()[axis].kind() == kind)
    }

    /// The name of an axis.
    pub fn axis_name(&self, axis: usize) -> &str {
        self.machine.axes()[axis].name()
    }

    /// The numbers of the temperatures of a medium.
    pub(crate) fn columns_of(&self, medium: Medium) -> impl Iterator<Item = usize> + '_ {
        let numbered = self.temperatures.iter().enumerate();
        numbered.filter_map(move |(number, own)| (own.medium == medium).then_some(number))
    }

    /// All pairs of moving linear axes; the first comes first in the machine.
    pub(crate) fn linear_pairs(&self) -> Vec<(usize, usize)> {
        let mut linear: Vec<usize> = self.moving_axes(AxisKind::Linear).collect();
        linear.sort_unstable();
        let numbered = linear.iter().enumerate();
        let pairs = numbered.flat_map(|(i, &a)| linear[i + 1..].iter().map(move |&b| (a, b)));
        pairs.collect()
    }

    /// The unit of a parameter that depends on the kind of the subject's axis.
    pub(crate) fn unit(
        &self,
        subject: &Subject,
        linear: &'static str,
        rotary: &'static str,
    ) -> &'static str {
        let axis = subject.axis.and_then(|axis| self.machine.axes().get(axis));
        match axis.map(Axis::kind) {
            Some(AxisKind::Rotary) => rotary,
            Some(AxisKind::Linear) | None => linear,
        }
    }
}

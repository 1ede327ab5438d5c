//! What there is that effects can happen to.

use trueaxis_kinematics::{AxisKind, Machine};

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
}

/// A target of the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneTarget {
    /// Its name.
    pub name: String,
    /// The outermost axis that moves it.
    pub carrier: usize,
}

impl Scene {
    /// The moving axes of a kind.
    pub fn moving_axes(&self, kind: AxisKind) -> impl Iterator<Item = usize> + '_ {
        let axes = self.moving.iter().copied();
        axes.filter(move |&axis| self.machine.axes()[axis].kind() == kind)
    }

    /// The name of an axis.
    pub fn axis_name(&self, axis: usize) -> &str {
        self.machine.axes()[axis].name()
    }
}

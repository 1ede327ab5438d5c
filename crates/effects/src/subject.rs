//! What an effect happens to.

use trueaxis_kinematics::{AxisKind, Component};

use crate::Scene;

/// Station, target and axes that an effect concerns, by index; none where it concerns all alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Subject {
    /// The station.
    pub station: Option<usize>,
    /// The target.
    pub target: Option<usize>,
    /// The axis.
    pub axis: Option<usize>,
    /// The axis on whose position the error of the first one depends.
    pub other_axis: Option<usize>,
    /// The component error of the axis.
    pub component: Option<Component>,
    /// The axis that carries the targets concerned.
    pub carrier: Option<usize>,
    /// The logged temperature that it goes with.
    pub column: Option<usize>,
}

impl Subject {
    /// Only a station.
    pub fn station(station: usize) -> Self {
        Self {
            station: Some(station),
            ..Self::default()
        }
    }

    /// Only a target.
    pub fn target(target: usize) -> Self {
        Self {
            target: Some(target),
            ..Self::default()
        }
    }

    /// Only an axis.
    pub fn axis(axis: usize) -> Self {
        Self {
            axis: Some(axis),
            ..Self::default()
        }
    }

    /// A component error of an axis.
    pub fn component(axis: usize, component: Component) -> Self {
        Self {
            axis: Some(axis),
            component: Some(component),
            ..Self::default()
        }
    }

    /// Only the targets that an axis carries.
    pub fn carrier(axis: usize) -> Self {
        Self {
            carrier: Some(axis),
            ..Self::default()
        }
    }

    /// The same with a logged temperature.
    #[must_use]
    pub fn with_column(self, column: usize) -> Self {
        Self {
            column: Some(column),
            ..self
        }
    }

    /// Whether the effect concerns this station.
    pub fn has_station(&self, station: usize) -> bool {
        self.station.is_none_or(|own| own == station)
    }

    /// Whether the effect concerns this target.
    pub fn has_target(&self, target: usize) -> bool {
        self.target.is_none_or(|own| own == target)
    }

    /// An axis, and the one on whose position its error depends.
    pub(crate) fn pair(axis: usize, other: usize) -> Self {
        Self {
            other_axis: Some(other),
            ..Self::axis(axis)
        }
    }
}

/// What effects can happen to in a scene.
impl Subject {
    pub(crate) fn all_alike(_: &Scene) -> Vec<Self> {
        vec![Self::default()]
    }

    pub(crate) fn each_station(scene: &Scene) -> Vec<Self> {
        (0..scene.stations.len()).map(Self::station).collect()
    }

    /// Without stations the frame in which coordinates are measured.
    pub(crate) fn each_station_or_frame(scene: &Scene) -> Vec<Self> {
        match scene.stations.is_empty() {
            true => Self::all_alike(scene),
            false => Self::each_station(scene),
        }
    }

    pub(crate) fn each_station_and_all(scene: &Scene) -> Vec<Self> {
        [Self::each_station(scene), Self::all_alike(scene)].concat()
    }

    pub(crate) fn each_target(scene: &Scene) -> Vec<Self> {
        (0..scene.targets.len()).map(Self::target).collect()
    }

    pub(crate) fn each_axis(scene: &Scene) -> Vec<Self> {
        scene.moving.iter().copied().map(Self::axis).collect()
    }

    pub(crate) fn each_linear_axis(scene: &Scene) -> Vec<Self> {
        let axes = scene.moving_axes(AxisKind::Linear);
        axes.map(Self::axis).collect()
    }

    pub(crate) fn each_rotary_axis(scene: &Scene) -> Vec<Self> {
        let axes = scene.moving_axes(AxisKind::Rotary);
        axes.map(Self::axis).collect()
    }
}

//! What an effect happens to.

use trueaxis_kinematics::Component;

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

    /// Whether the effect concerns this station.
    pub fn has_station(&self, station: usize) -> bool {
        self.station.is_none_or(|own| own == station)
    }

    /// Whether the effect concerns this target.
    pub fn has_target(&self, target: usize) -> bool {
        self.target.is_none_or(|own| own == target)
    }
}

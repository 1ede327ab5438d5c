//! What causes make responsible, and whether two are the same trouble under two names.

use trueaxis_effects::Effect;

use crate::engine::{Found, Measured};

/// What a cause makes responsible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Culprit {
    /// What happens at a station, or to the machine during its occupation, at an instant or not.
    Station(usize, bool),
    Target(usize, bool),
    /// An axis in one way.
    Axis(usize, &'static Effect),
    /// Something that goes on through every occupation, or moves all points or the frame that they are measured in.
    EveryOccupation,
    /// The whole campaign in one way.
    Everything(&'static Effect),
}

/// What a cause and its rivals make responsible.
pub(crate) struct Culprits(Vec<Culprit>);

impl Culprits {
    pub(crate) fn of<D: Measured>(data: &D, found: &Found) -> Self {
        let rivals = found.rivals.iter().map(|(suspect, _)| suspect);
        let all = rivals.chain([&found.suspect]);
        Self(all.map(|suspect| data.culprit(suspect)).collect())
    }

    pub(crate) fn any(&self, is_wanted: impl Fn(&Culprit) -> bool) -> bool {
        self.0.iter().any(is_wanted)
    }

    /// Whether two causes have an explanation in common: then the second is no cause of its own but a sign
    /// that neither has the right shape. A tripod that sways is no pile of jumps; a tripod that creeps and was
    /// bumped has two troubles.
    pub(crate) fn overlap(&self, other: &Self) -> bool {
        self.any(|culprit| other.0.contains(culprit))
    }
}

//! What causes blame, and whether two causes are the same problem under two names.

use trueaxis_effects::Effect;

use crate::engine::{Found, Measured};

/// What a cause blames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Culprit {
    /// A station, or the machine during its occupation, at an instant or not.
    Station(usize, bool),
    Target(usize, bool),
    /// An axis, by the effect on it.
    Axis(usize, &'static Effect),
    /// A process in every occupation, or a motion of all points or of the frame in which they are measured.
    EveryOccupation,
    /// The whole campaign, by the effect on it.
    Everything(&'static Effect),
}

impl Culprit {
    /// What a cause and its rivals blame. If two causes share any of it, the second is not a separate cause but a sign
    /// that neither has the right shape. A tripod that sways is no pile of jumps; a tripod that creeps and was bumped
    /// has two problems.
    pub(crate) fn all_of<D: Measured>(data: &D, found: &Found) -> Vec<Self> {
        let rivals = found.rivals.iter().map(|(suspect, _)| suspect);
        let all = rivals.chain([&found.suspect]);
        all.map(|suspect| data.culprit(suspect)).collect()
    }
}

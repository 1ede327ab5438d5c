//! What can be wrong with the description of a machine.

/// A machine that cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// The direction of an axis is zero or not finite.
    #[error(
        "axis {axis}: direction [{x}, {y}, {z}] has length {length}, expected a unit vector",
        x = direction[0], y = direction[1], z = direction[2]
    )]
    Direction {
        axis: String,
        direction: [f64; 3],
        length: f64,
    },
    /// The travel of an axis is not an interval.
    #[error("axis {axis}: travel [{low}, {high}] is not an interval of finite numbers, low first")]
    Travel {
        axis: String,
        /// Lower end, mm or rad.
        low: f64,
        /// Upper end, mm or rad.
        high: f64,
    },
    /// A coordinate is not finite.
    #[error("axis {axis}: its position is not finite")]
    Position { axis: String },
    /// Two axes share a name.
    #[error("two axes are named {name}")]
    DuplicateAxis { name: String },
    /// A branch refers to an axis that does not exist.
    #[error("a branch names axis number {index}, but the machine has {count} axes")]
    UnknownAxis { index: usize, count: usize },
    /// An axis stands in a branch twice or in both branches.
    #[error("axis {name} appears twice in the kinematic branches")]
    AxisUsedTwice { name: String },
    /// An axis stands in no branch.
    #[error("axis {name} appears in no kinematic branch")]
    AxisUnused { name: String },
}

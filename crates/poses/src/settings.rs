//! How to find poses.

use trueaxis_identify::SixRows;
use trueaxis_screening::MOST_REMOVED;

/// Settings of [`crate::measure()`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How poses follow from the measurement.
    pub method: Method,
    /// Whether the two sides of approach get poses of their own.
    pub by_direction: bool,
    /// Whether gross errors are removed and interrupted occupations split; otherwise all lengths are
    /// adjusted as they are.
    pub robust: bool,
    /// Share of the lengths that may be removed as gross errors.
    pub most_removed: f64,
    /// Whether a diagnosis asks why lengths contradict each other, where a calibration would refuse them: many
    /// lengths of one target may be removed, and stations may be poorly known.
    pub asks_why: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            by_direction: false,
            robust: true,
            most_removed: MOST_REMOVED,
            asks_why: false,
        }
    }
}

/// How the pose of a stage follows from the lengths or points of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The lengths of all steps in one adjustment with rigid stages, whose unknowns include the pose of each step.
    /// Measured points are identified as with [`Method::Nine`].
    #[default]
    Joint,
    /// Points first, each free of the others; then all nine equations (three for each target), weighted with
    /// the covariance of the points. The paper's path.
    Nine,
    /// Points first, then six of nine equations without weights; [`SixRows::PAPER`] is the paper's choice.
    Six(SixRows),
}

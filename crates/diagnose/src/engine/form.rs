//! The form of a course that wanders: how fast, how it goes on without readings, and what of a stage it moves most.

/// The form of a course: the prior of its coefficients, without its width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Form {
    /// ℓ, as a share of the range of the argument.
    pub(crate) length: f64,
    /// T of a swing, as an air conditioning makes: after a quarter of it, ℓ, nothing is alike.
    pub(crate) period: Option<f64>,
    /// Where it goes on in pauses of unknown duration.
    pub(crate) pauses: Pauses,
    /// Ratio of the prior widths of displacements and rotations of a stage; 1 for everything else.
    pub(crate) displaced: f64,
    /// The same of rotations that a stage makes at home, too; 1 for everything else.
    pub(crate) turned_at_home: f64,
    /// The same of what a rotary axis does twice a turn.
    pub(crate) twice_a_turn: f64,
}

impl Form {
    /// A smooth course of this correlation length.
    pub(crate) fn smooth(length: f64) -> Self {
        Self {
            length,
            period: None,
            pauses: Pauses::Nowhere,
            displaced: 1.0,
            turned_at_home: 1.0,
            twice_a_turn: 1.0,
        }
    }

    /// `a sin 2πx/T + b cos 2πx/T`. As a smooth process it would pay for every other course as quick as it, and what
    /// repeats in nearly the time of a cycle would look simpler as an error of the axis.
    pub(crate) fn swing(period: f64) -> Self {
        Self {
            period: Some(period),
            ..Self::smooth(0.25 * period)
        }
    }
}

/// Where a course goes on without readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pauses {
    Nowhere,
    /// Between two cycles, or where an instrument was set to zero for the next one; the axis turned without a pause.
    BetweenCycles,
    BetweenPasses,
}

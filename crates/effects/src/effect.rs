//! The shape that all effects share.

use trueaxis_kinematics::MotionError;

use crate::{AxisPosition, Circumstances, Displaced, Scene, Subject};

/// A physical effect: a hypothesis about what disturbs the readings.
pub trait Effect: std::fmt::Debug + Sync {
    /// Its fixed name, as `machine_shift`.
    fn id(&self) -> &'static str;

    /// Where it comes from; instrument and set-up are ruled out before the machine is blamed.
    fn layer(&self) -> Layer;

    /// Where it can be seen; nowhere if no data of this kind can show it.
    fn levels(&self) -> &'static [Level];

    /// What it can happen to.
    fn subjects(&self, scene: &Scene) -> Vec<Subject>;

    /// Its linear parameters for a subject.
    fn parameters(&self, scene: &Scene, subject: &Subject) -> Vec<Parameter>;

    /// What else has to be found.
    fn shape(&self) -> Shape {
        Shape::Fixed
    }

    /// What one unit of parameter `parameter` does to a reading. An effect with an instant says what
    /// it does after it.
    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        shape: f64,
        at: &Circumstances<'_>,
    ) -> Displaced;

    /// What one unit of parameter `parameter` adds to the component errors of its axis, mm and rad,
    /// before the least-squares gauge; nothing for an effect that is no part of an error curve.
    fn motion(
        &self,
        _subject: &Subject,
        _parameter: usize,
        _shape: f64,
        _at: &AxisPosition<'_>,
    ) -> MotionError {
        MotionError::default()
    }

    /// What to tell a calibration engineer.
    fn explanation(&self) -> Explanation;
}

/// The layer that an effect belongs to, in the order of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Layer {
    /// The measuring instrument and the air.
    Instrument,
    /// Tripod, targets, fixture.
    Setup,
    /// The machine.
    Machine,
}

impl Layer {
    /// As the result files name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Instrument => "instrument",
            Self::Setup => "setup",
            Self::Machine => "machine",
        }
    }
}

/// The data in which an effect is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// The tracker's lengths.
    Lengths,
    /// The identified error curves.
    Components,
    /// Positioning lines and ballbar sweeps.
    Verification,
}

impl Level {
    /// As the result files name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lengths => "lengths",
            Self::Components => "components",
            Self::Verification => "verification",
        }
    }
}

/// A linear parameter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// Name, as `shift_x`.
    pub name: String,
    /// Unit, as `um`.
    pub unit: &'static str,
}

impl Parameter {
    /// A parameter of this name and unit.
    pub fn new(name: impl Into<String>, unit: &'static str) -> Self {
        Self {
            name: name.into(),
            unit,
        }
    }

    /// The three components of a vector in µm, as `shift_x shift_y shift_z`.
    pub fn vector_um(name: &str) -> Vec<Self> {
        let along = |axis| Self::new(format!("{name}_{axis}"), "um");
        ["x", "y", "z"].map(along).into()
    }
}

/// The parameter of an effect that is not linear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// None.
    Fixed,
    /// An instant, s: the effect is there after it.
    Instant,
    /// A time constant, s.
    TimeConstant,
    /// A period along the axis, mm or rad.
    Period,
    /// A whole number of waves per turn.
    Waves,
}

/// An effect in the words of a calibration engineer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Explanation {
    /// What physically happened.
    pub cause: &'static str,
    /// What it does to the calibration if it is left in.
    pub consequence: &'static str,
    /// What to do.
    pub action: &'static str,
    /// The extra measurement that tells it from its rivals.
    pub separate_by: &'static str,
}

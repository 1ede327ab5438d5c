//! What an effect is: a name, where it is looked for, its parameters, and one formula.

use trueaxis_kinematics::{Axis, AxisKind, Component};

use crate::{Form, Scene, Shape, Subject};

/// A physical effect: a hypothesis about what disturbs the readings.
pub struct Effect {
    /// Its fixed name, such as `machine_shift`.
    pub id: &'static str,
    /// Where it comes from; instrument and set-up are ruled out before the machine is blamed.
    pub layer: Layer,
    /// Where it can be seen; nowhere if no data of this kind can show it.
    pub levels: &'static [Level],
    pub(crate) subjects: fn(&Scene) -> Vec<Subject>,
    pub(crate) parameters: fn(&Scene, &Subject) -> Vec<Parameter>,
    /// What has to be found beside its linear parameters.
    pub shape: Shape,
    pub(crate) form: Form,
    /// What to tell a calibration engineer.
    pub explanation: Explanation,
}

impl Effect {
    /// What it can happen to.
    pub fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        (self.subjects)(scene)
    }

    /// Its linear parameters for a subject.
    pub fn parameters(&self, scene: &Scene, subject: &Subject) -> Vec<Parameter> {
        (self.parameters)(scene, subject)
    }

    /// Whether it moves all that the machine carries alike.
    pub fn moves_machine(&self) -> bool {
        self.layer == Layer::Machine && matches!(self.form, Form::Target(_))
    }

    /// Whether it moves a station, or the frame in which coordinates are measured.
    pub fn moves_station(&self) -> bool {
        matches!(self.form, Form::Station(_))
    }

    /// Whether it makes lengths longer in proportion to the distance.
    pub fn scales_lengths(&self) -> bool {
        matches!(self.form, Form::Scale(_))
    }

    /// Whether it makes readings late, so that it goes with the speed of an axis.
    pub fn is_delay(&self) -> bool {
        matches!(self.form, Form::Delay(_))
    }

    /// Whether it parts the two sides from which an axis approaches.
    pub fn is_lost_motion(&self) -> bool {
        matches!(self.form, Form::LostMotion(_))
    }

    /// Whether the scale of an axis changes while it is measured.
    pub fn grows_axis(&self) -> bool {
        matches!(self.form, Form::Growth(_))
    }

    /// Whether it is a slope of the positioning of an axis.
    pub fn is_scale_of_axis(&self) -> bool {
        matches!(self.form, Form::Positioning(_))
    }

    /// How many waves it has in a turn of a rotary axis, at a shape.
    pub fn waves(&self, shape: f64) -> Option<f64> {
        match self.form {
            Form::WavesAbout(waves) => Some(waves.unwrap_or(shape)),
            Form::WavesAcross(_) => Some(shape),
            _ => None,
        }
    }

    /// Whether the curve of a component error of an axis shows it, across a rotary axis with that of the other direction:
    ///
    /// | curves | effects |
    /// | --- | --- |
    /// | positioning of a linear axis | a scale, periods |
    /// | any other of a linear axis, δ along a rotary one | periods |
    /// | ε about a rotary axis | waves about it |
    /// | δ across, ε across a rotary axis | waves across it |
    pub fn is_of_curve(&self, axis: &Axis, component: Component) -> bool {
        let is_along = component.index() % 3 == axis.principal();
        let is_angular = component.is_angular();
        match (&self.form, axis.kind()) {
            (Form::Positioning(_), AxisKind::Linear) => is_along && !is_angular,
            (Form::Component(_), AxisKind::Linear) => true,
            (Form::Component(_), AxisKind::Rotary) => is_along && !is_angular,
            (Form::WavesAbout(_), AxisKind::Rotary) => is_along && is_angular,
            (Form::WavesAcross(two), AxisKind::Rotary) => {
                !is_along && two[0].is_angular() == is_angular
            }
            _ => false,
        }
    }
}

/// Effects are the same if their names are.
impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Eq for Effect {}

/// By name: the rest stands in the catalogue.
impl std::fmt::Debug for Effect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Effect").field(&self.id).finish()
    }
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
    /// Coordinates of targets, measured by any instrument.
    Points,
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
            Self::Points => "points",
            Self::Components => "components",
            Self::Verification => "verification",
        }
    }
}

/// A linear parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name, such as `shift_x`.
    pub name: String,
    /// Unit, such as `um`.
    pub unit: &'static str,
    /// The range in which a value is plausible, where it is known.
    pub plausible: Option<[f64; 2]>,
}

impl Parameter {
    /// A parameter of this name and unit.
    pub fn new(name: impl Into<String>, unit: &'static str) -> Self {
        Self {
            name: name.into(),
            unit,
            plausible: None,
        }
    }

    /// The same with the range in which a value is plausible.
    pub(crate) fn plausible(self, range: [f64; 2]) -> Self {
        Self {
            plausible: Some(range),
            ..self
        }
    }

    /// The three components of a vector, such as `shift_x shift_y shift_z`.
    pub(crate) fn vector(name: &str, unit: &'static str) -> Vec<Self> {
        let along = |axis| Self::new(format!("{name}_{axis}"), unit);
        ["x", "y", "z"].map(along).into()
    }

    /// How a station moves: the three components of a vector. Where there are no stations but the frame in which
    /// an instrument measures coordinates, it also turns: `<name>_a`, `_b`, `_c` in arcsec about the reference axes
    /// through the origin of the reference frame, where the vector is its displacement.
    pub(crate) fn of_station(name: &str, scene: &Scene, most: MostOfFrame) -> Vec<Self> {
        let along = Self::vector(name, "um");
        if !scene.stations.is_empty() {
            return along;
        }
        let about = |axis| Self::new(format!("{name}_{axis}"), "arcsec").plausible(most.arcsec);
        let along = along.into_iter().map(|p| p.plausible(most.um));
        along.chain(["a", "b", "c"].map(about)).collect()
    }

    /// The two amplitudes of a wave.
    pub(crate) fn sine_and_cosine(unit: &'static str) -> Vec<Self> {
        ["sine", "cosine"].map(|name| Self::new(name, unit)).into()
    }
}

/// Plausible motions of the frame of an instrument.
#[derive(Clone, Copy)]
pub(crate) struct MostOfFrame {
    um: [f64; 2],
    arcsec: [f64; 2],
}

/// Five millimetres, or five in a metre: whoever bumps an instrument by more sets it up again.
pub(crate) const BUMPED: MostOfFrame = MostOfFrame {
    um: [-5e3, 5e3],
    arcsec: [-1e3, 1e3],
};

/// One, or one in a metre: what gives way by itself.
pub(crate) const CREPT: MostOfFrame = MostOfFrame {
    um: [-1e3, 1e3],
    arcsec: [-200.0, 200.0],
};

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

//! A disturbance, as reported.

use trueaxis_effects::{Layer, Level, Scene, Subject};

/// A smooth process of unknown form.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbance {
    /// The level at which it was found.
    pub level: Level,
    /// The data in which it was found, as [`crate::LevelReport::data`].
    pub data: String,
    /// What wanders, and with what.
    pub whose: Wandering,
    /// Probability that noise alone looks as much like any disturbance (family-wise).
    pub p_value: f64,
    /// Rms of its effect on the readings of the level, µm; for a verification the rms of what it takes out of the misfit,
    /// weighted like the misfit.
    pub rms_um: f64,
    /// Its share of the misfit of its level, 0 to 1 ([`crate::Shares`]).
    pub share: f64,
    /// How fast it changes.
    pub correlation_length: CorrelationLength,
    /// The period of one that swings, four times the correlation length, in the unit of that.
    pub period: Option<f64>,
    /// Relative drop of the held-out rms; `None` where nothing could be held out, or causes contribute to the gain.
    pub heldout_gain: Option<f64>,
    /// Its course.
    pub curve: Vec<CurvePoint>,
    /// Other disturbances that explain the data nearly as well.
    pub rivals: Vec<Wandering>,
}

/// What wanders, by layer and subject. Without a subject it is the machine (layer machine), all tripods or, for
/// points, the frame of the instrument (set-up), or the air (instrument).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wandering {
    /// The level at which it was found.
    pub level: Level,
    /// Instrument, set-up or machine.
    pub layer: Layer,
    /// Station, target or axis; empty for what concerns everything.
    pub subject: Subject,
    /// `time`; `position`; `position` and `direction`; for an axis `time` and `position`, `time` and `direction`.
    pub varies_with: &'static [&'static str],
}

/// The distance within which a course is nearly constant (Matérn's, ν = 3/2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrelationLength {
    /// Value.
    pub value: f64,
    /// `s`, `mm` or `deg`.
    pub unit: &'static str,
}

/// A point of a course, or of a free function of position.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePoint {
    /// Time or position, in the unit of the correlation length; for a free function mm.
    pub at: f64,
    /// Position of the axis whose geometry it is, mm or deg; `None` for anything else.
    pub position: Option<f64>,
    /// Deviation of each coordinate from its mean over a turn or range (what goes with the side of approach: positive less
    /// negative side), µm: x, y, z; for a station its dead path, for
    /// the frame of the instrument its rotations as rms displacement of the points, too. For the geometry of an axis
    /// x, y, z of what carries it and the rotations of its stage as rms displacement of its targets.
    pub value_um: Vec<f64>,
    /// Their standard uncertainties, µm.
    pub u_um: Vec<f64>,
}

impl Wandering {
    /// Description, such as `station S2, with time`.
    pub fn in_words(&self, scene: &Scene) -> String {
        let name = |names: Option<&String>| names.cloned().unwrap_or_default();
        let (station, target, axis) =
            (self.subject.station, self.subject.target, self.subject.axis);
        let axis_name = axis.and_then(|k| scene.machine.axes().get(k));
        let axis_name = axis_name.map(|axis| axis.name()).unwrap_or_default();
        let who = match (station, target, self.layer) {
            (Some(k), _, _) => format!("station {}", name(scene.stations.get(k))),
            (_, Some(k), _) => {
                format!("target {}", name(scene.targets.get(k).map(|t| &t.name)))
            }
            (_, _, Layer::Machine) if axis.is_some() => match self.varies_with {
                ["time"] => format!("the scale of axis {axis_name}"),
                ["time", "position"] => format!("the geometry of axis {axis_name}"),
                ["position"] => format!("axis {axis_name}"),
                ["direction"] => format!("straightness and angles of axis {axis_name}"),
                _ => format!("lost motion of axis {axis_name}"),
            },
            (_, _, Layer::Machine) => "the machine".to_owned(),
            (_, _, Layer::Setup) if self.level == Level::Points => {
                "the frame of the instrument".to_owned()
            }
            (_, _, Layer::Setup) => "all tripods".to_owned(),
            (_, _, Layer::Instrument) if self.level == Level::Verification => {
                "the zero of the reading instrument".to_owned()
            }
            (_, _, Layer::Instrument) => "the air (scale of the lengths)".to_owned(),
        };
        match (self.varies_with, axis) {
            (["position"], Some(_)) if self.layer != Layer::Machine => {
                format!("{who}, with the position of {axis_name}")
            }
            (["time", _], Some(_)) => format!("{who}, with time"),
            (with, _) => format!("{who}, with {}", with.join(" and ")),
        }
    }
}

//! What wanders in a course that nobody knows, as the outcome says it.

use trueaxis_effects::{Layer, Level, Scene, Subject};

/// A smooth process of unknown form.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbance {
    /// Where it was found.
    pub level: Level,
    /// The data in which it was found, as [`crate::LevelReport::data`].
    pub data: String,
    /// What wanders, and with what.
    pub whose: Wandering,
    /// Probability that noise alone looks as much like any disturbance (family-wise).
    pub p_value: f64,
    /// Rms of what it does to the readings of the level, µm.
    pub rms_um: f64,
    /// Its share of the misfit of its level, 0 to 1 ([`crate::Shares`]).
    pub share: f64,
    /// How fast it changes.
    pub correlation_length: CorrelationLength,
    /// Of one that swings with a period, that, in the unit of the correlation length, which is a quarter of it.
    pub period: Option<f64>,
    /// By what part the held-out rms falls; none where nothing could be held out, or causes gain, too.
    pub heldout_gain: Option<f64>,
    /// Its course.
    pub curve: Vec<CurvePoint>,
    /// What explains the data nearly as well.
    pub rivals: Vec<Wandering>,
}

/// What wanders: layer and subject say whose it is. Without a subject it is the machine (layer machine), all tripods or, of
/// points, the frame of the instrument (set-up), or the air (instrument).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wandering {
    /// Where it was found.
    pub level: Level,
    /// Instrument, set-up or machine.
    pub layer: Layer,
    /// Station, target or axis; none for what concerns all.
    pub subject: Subject,
    /// `time`; `position`; `position` and `direction`; of an axis `time` and `position` (its geometry), `time` and `direction`.
    pub varies_with: &'static [&'static str],
}

/// The distance within which a course stays nearly the same (Matérn's, ν = 3/2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrelationLength {
    /// Value.
    pub value: f64,
    /// `s`, `mm` or `deg`.
    pub unit: &'static str,
}

/// A point of a course, or of a free form.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePoint {
    /// Time or position, in the unit of the correlation length; mm of a free form.
    pub at: f64,
    /// Where the axis stands of whose geometry it is, mm or deg; none of anything else.
    pub position: Option<f64>,
    /// Each coordinate (x, y, z; of a station its dead path, of the frame of the instrument its rotations by what they move the
    /// points, rms, too; of the geometry of an axis x, y, z of what carries it and the
    /// rotations of its stage about these by what they move its targets, rms), µm: from its mean over a turn, or over the range.
    pub value_um: Vec<f64>,
    /// Their standard uncertainties, µm.
    pub u_um: Vec<f64>,
}

impl Wandering {
    /// In words, as `station S2, with time`.
    pub fn in_words(&self, scene: &Scene) -> String {
        let name = |names: Option<&String>| names.cloned().unwrap_or_default();
        let Subject {
            station,
            target,
            axis,
            ..
        } = self.subject;
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

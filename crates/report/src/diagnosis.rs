//! What figures and tables need of `diagnosis.json`.

use serde::Deserialize;
use serde_json::{Map, Value};

use crate::calibration::Curve;
use crate::words;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Diagnosis {
    pub(crate) campaign: String,
    pub(crate) verdict: String,
    pub(crate) causes: Vec<Cause>,
    pub(crate) disturbances: Vec<Disturbance>,
    pub(crate) levels: Vec<Level>,
}

impl Diagnosis {
    /// Whether verification readings alone were judged.
    pub(crate) fn is_of_readings(&self) -> bool {
        let is_verification = |level: &Level| level.level == "verification";
        !self.levels.is_empty() && self.levels.iter().all(is_verification)
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct Cause {
    pub(crate) effect: String,
    #[serde(default)]
    pub(crate) level: String,
    /// Which data of the level show it.
    #[serde(default)]
    pub(crate) data: Vec<String>,
    #[serde(default)]
    pub(crate) subject: Map<String, Value>,
    #[serde(default)]
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) curve: Option<Vec<CurvePoint>>,
    pub(crate) mean_lost_motion: Option<Parameter>,
    #[serde(default)]
    pub(crate) cannot_tell_apart_from: Vec<Rival>,
    pub(crate) explained_rms_um: Option<f64>,
    #[serde(default)]
    pub(crate) component_change: Map<String, Value>,
    pub(crate) fitted: Option<Fitted>,
}

impl Cause {
    /// Whether it is the form of an error curve, which contradicts nothing.
    pub(crate) fn is_of_curve(&self) -> bool {
        self.level == "components"
    }

    /// Whether it has a share of the misfit of a level; each verification is one.
    pub(crate) fn is_in(&self, level: &Level) -> bool {
        self.level == level.level && (self.data.is_empty() || self.data.contains(&level.data))
    }
}

/// The misfit without a cause and what it explains of it, reading by reading.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Fitted {
    pub(crate) of: String,
    pub(crate) against: String,
    pub(crate) unit: String,
    pub(crate) at: Vec<f64>,
    pub(crate) direction: Vec<i8>,
    pub(crate) misfit_um: Option<Vec<f64>>,
    pub(crate) fitted_um: Option<Vec<f64>>,
    pub(crate) u_um: Option<Vec<f64>>,
    pub(crate) misfit_arcsec: Option<Vec<f64>>,
    pub(crate) fitted_arcsec: Option<Vec<f64>>,
    pub(crate) u_arcsec: Option<Vec<f64>>,
    /// The other coordinates of the same readings in which the cause shows.
    pub(crate) beside: Vec<Self>,
}

impl Fitted {
    /// Whether the course is over time, else over the position of an axis.
    pub(crate) fn is_over_time(&self) -> bool {
        ["time", "order"].contains(&self.against.as_str())
    }

    pub(crate) fn given_others(&self) -> bool {
        self.of.ends_with(" given the others")
    }

    /// Whether it is over a position that was approached from both sides.
    pub(crate) fn has_sides(&self) -> bool {
        let mut sides = self.direction.iter();
        !self.is_over_time() && sides.any(|side| Some(side) != self.direction.first())
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct Rival {
    pub(crate) effect: String,
    #[serde(default)]
    pub(crate) subject: Map<String, Value>,
    /// Of a disturbance.
    #[serde(default)]
    layer: String,
    #[serde(default)]
    varies_with: Vec<String>,
}

impl Rival {
    /// `station jump of station S2`, or that of a disturbance in the data of a cause.
    pub(crate) fn name(&self, of: &Cause) -> String {
        if self.effect != "disturbance" {
            return words::effect(&self.effect, &self.subject);
        }
        let disturbance = Disturbance {
            layer: self.layer.clone(),
            level: of.level.clone(),
            data: of.data.clone(),
            subject: self.subject.clone(),
            varies_with: self.varies_with.clone(),
            ..Disturbance::default()
        };
        disturbance.name()
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    pub(crate) value: f64,
    pub(crate) u: Option<f64>,
    #[serde(default)]
    pub(crate) unit: String,
}

/// A smooth process of unknown form.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Disturbance {
    pub(crate) layer: String,
    pub(crate) level: String,
    pub(crate) data: Vec<String>,
    pub(crate) subject: Map<String, Value>,
    pub(crate) varies_with: Vec<String>,
    pub(crate) correlation_length: CorrelationLength,
    pub(crate) curve: Option<Vec<CurvePoint>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct CorrelationLength {
    pub(crate) unit: String,
}

impl Disturbance {
    /// Whether the frame in which points are measured wanders.
    pub(crate) fn is_of_frame(&self) -> bool {
        let is_of_target = self.subject.get("target").is_some_and(Value::is_string);
        self.level == "points" && self.layer == "setup" && !is_of_target
    }

    pub(crate) fn axis(&self) -> Option<&str> {
        self.subject.get("axis").and_then(Value::as_str)
    }

    /// `disturbance of station S2, with time`; of readings also where, as there may be several files.
    pub(crate) fn name(&self) -> String {
        let with = self.varies_with.join(" and ");
        let is_of_readings = self.level == "verification";
        let name = match (self.layer.as_str(), self.axis()) {
            ("instrument", None) if is_of_readings => {
                "disturbance of the reading instrument".to_owned()
            }
            (_, Some(axis)) if with == "time" => format!("disturbance of the scale of axis {axis}"),
            (_, Some(axis)) if with == "time and position" => {
                format!("disturbance of the geometry of axis {axis}")
            }
            (_, Some(axis)) if with == "time and direction" => {
                format!("disturbance of the lost motion of axis {axis}")
            }
            (_, Some(axis)) if with == "direction" => {
                format!("disturbance of straightness and angles of axis {axis}")
            }
            _ if self.is_of_frame() => "disturbance of the frame of the instrument".to_owned(),
            _ if self.subject.values().any(Value::is_string) => {
                words::effect("disturbance", &self.subject)
            }
            ("machine", _) => "disturbance of the machine".to_owned(),
            _ => "disturbance of all tripods".to_owned(),
        };
        let at = match is_of_readings {
            true => format!(" in {}", self.data.join(", ")),
            false => String::new(),
        };
        match with.is_empty() {
            true => format!("{name}{at}"),
            false => format!("{name}{at}, with {with}"),
        }
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct CurvePoint {
    pub(crate) at: Vec<f64>,
    /// The coordinates there.
    #[serde(flatten)]
    pub(crate) of: Curve,
}

/// What one kind of data says.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Level {
    pub(crate) level: String,
    pub(crate) data: String,
    pub(crate) noise_floor_um: Option<f64>,
    pub(crate) before: Option<Misfit>,
    pub(crate) after: Option<Misfit>,
    pub(crate) shares: Shares,
    pub(crate) places: Vec<MisfitAt>,
}

impl Level {
    /// Whether something is in the model that takes misfit away.
    pub(crate) fn is_explained(&self) -> bool {
        let differs = |place: &MisfitAt| place.before_um.total_cmp(&place.after_um).is_ne();
        self.places.iter().any(differs) || self.before != self.after
    }
}

/// What a model leaves.
#[derive(Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(crate) struct Misfit {
    pub(crate) rms_um: Option<f64>,
}

/// Parts of the sum of squares; they add up to 1.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Shares {
    pub(crate) causes: Vec<f64>,
    pub(crate) disturbances: Vec<f64>,
    pub(crate) unexplained: f64,
    pub(crate) noise: f64,
}

#[derive(Debug, Deserialize)]
pub(crate) struct MisfitAt {
    pub(crate) by: String,
    pub(crate) name: String,
    pub(crate) before_um: f64,
    pub(crate) after_um: f64,
}

//! What figures and tables need of `calibration.json`.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Map, Value};

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Calibration {
    pub(crate) campaign: String,
    pub(crate) machine: Machine,
    pub(crate) adjustment: Adjustment,
    pub(crate) stations: Vec<Place>,
    pub(crate) targets: Vec<Place>,
    pub(crate) axes: Vec<Axis>,
    pub(crate) location_errors: Map<String, Value>,
    pub(crate) relative_locations: Vec<Relative>,
    pub(crate) misfits: Vec<Contradiction>,
    pub(crate) effects_taken_out: Vec<TakenOut>,
}

/// An effect that was taken out of the lengths first.
#[derive(Debug, Deserialize)]
pub(crate) struct TakenOut {
    pub(crate) effect: String,
    #[serde(default)]
    pub(crate) subject: Map<String, Value>,
}

/// What contradicts the rest.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Contradiction {
    /// In words: a step, runs of an axis, or something known.
    pub(crate) step: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Machine {
    pub(crate) name: String,
    pub(crate) axes: Vec<NominalAxis>,
}

impl Machine {
    pub(crate) fn is_rotary(&self, axis: &str) -> bool {
        let mut axes = self.axes.iter();
        axes.any(|nominal| nominal.name == axis && nominal.kind == Kind::Rotary)
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct NominalAxis {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) direction: [f64; 3],
    /// mm or degrees.
    pub(crate) travel: Option<[f64; 2]>,
    pub(crate) position_mm: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    Linear,
    Rotary,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Adjustment {
    pub(crate) observations: usize,
    pub(crate) degrees_of_freedom: usize,
    pub(crate) rms_residual_um: Option<f64>,
    pub(crate) p_value: Option<f64>,
    pub(crate) sigma0: Option<f64>,
}

/// A named point.
#[derive(Debug, Deserialize)]
pub(crate) struct Place {
    pub(crate) name: String,
    pub(crate) position_mm: [f64; 3],
}

/// Where a rotary axis lies relative to another one, along and about a direction.
#[derive(Debug, Deserialize)]
pub(crate) struct Relative {
    pub(crate) axis: String,
    pub(crate) to: String,
    pub(crate) direction: [f64; 3],
    pub(crate) offset: Value,
    pub(crate) angle: Value,
}

/// A measured axis.
#[derive(Debug, Deserialize)]
pub(crate) struct Axis {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    /// mm or degrees.
    pub(crate) positions: Vec<f64>,
    /// Side of approach of each position, where these are kept apart.
    #[serde(default)]
    pub(crate) direction: Vec<i8>,
    #[serde(default)]
    pub(crate) components: BTreeMap<String, Curve>,
    #[serde(default)]
    pub(crate) u_ratio: BTreeMap<String, Ratio>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Curve {
    value_um: Option<Vec<f64>>,
    u_um: Option<Vec<f64>>,
    value_arcsec: Option<Vec<f64>>,
    u_arcsec: Option<Vec<f64>>,
    /// Degrees of freedom of u; infinite where absent.
    pub(crate) dof: Option<f64>,
}

impl Curve {
    /// Whether it is an angle, arcsec; otherwise a displacement, µm.
    pub(crate) fn is_angular(&self) -> bool {
        self.value_arcsec.is_some()
    }

    pub(crate) fn values(&self) -> &[f64] {
        let values = self.value_um.as_ref().or(self.value_arcsec.as_ref());
        values.map_or(&[], Vec::as_slice)
    }

    /// Standard uncertainties.
    pub(crate) fn u(&self) -> &[f64] {
        let u = self.u_um.as_ref().or(self.u_arcsec.as_ref());
        u.map_or(&[], Vec::as_slice)
    }
}

/// u by equations relative to that of the joint adjustment.
#[derive(Debug, Deserialize)]
pub(crate) struct Ratio {
    pub(crate) nine: Option<f64>,
    pub(crate) six: Option<f64>,
}

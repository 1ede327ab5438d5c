//! The misfit without a cause and what the cause explains of it, in `diagnosis.json`.

use schemars::JsonSchema;
use serde::Serialize;

use crate::json::um;
use crate::{Against, Fitted, FittedPoint};

/// Lists of the same length, a place for each reading or mean of neighbours.
#[derive(Serialize, JsonSchema)]
pub(super) struct FittedFile<'a> {
    /// Which readings.
    of: &'a str,
    /// `time`, `order` (the number of the reading), or the axis over whose position they are.
    against: &'a str,
    /// That of `at`: `s`, `1`, `mm` or `deg`.
    unit: &'static str,
    at: Vec<f64>,
    direction: Vec<i8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    misfit_um: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fitted_um: Option<Vec<f64>>,
    /// Standard deviation that noise alone gives the misfit.
    #[serde(skip_serializing_if = "Option::is_none")]
    u_um: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    misfit_arcsec: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fitted_arcsec: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    u_arcsec: Option<Vec<f64>>,
    /// The other coordinates of the same readings in which the cause shows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    beside: Vec<Self>,
}

impl<'a> FittedFile<'a> {
    pub(super) fn new(fitted: &'a Fitted) -> Self {
        let (against, unit) = match &fitted.against {
            Against::Time => ("time", "s"),
            Against::Order => ("order", "1"),
            Against::Position(axis, unit) => (axis.as_str(), *unit),
        };
        let points = || fitted.points.iter();
        let all = |f: fn(&FittedPoint) -> f64| points().map(|point| um(f(point))).collect();
        let of = |is_angular: bool, f| (fitted.is_angular == is_angular).then(|| all(f));
        Self {
            of: &fitted.of,
            against,
            unit,
            at: all(|point| point.at),
            direction: points().map(|point| point.direction).collect(),
            misfit_um: of(false, |point| point.misfit),
            fitted_um: of(false, |point| point.fitted),
            u_um: of(false, |point| point.u),
            misfit_arcsec: of(true, |point| point.misfit),
            fitted_arcsec: of(true, |point| point.fitted),
            u_arcsec: of(true, |point| point.u),
            beside: fitted.beside.iter().map(Self::new).collect(),
        }
    }
}

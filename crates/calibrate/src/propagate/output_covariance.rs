//! The covariance of all results together.
//!
//! Results of one axis are correlated through the points that they share, those of different axes
//! through the axes that stand still while others are measured, everything through the stations:
//! with `F` the coefficients of the shared sources in all results,
//!
//! ```text
//! cov = own + F Σ Fᵀ
//! ```

use nalgebra::DMatrix;
use trueaxis_kinematics::Machine;

use crate::Error;
use crate::identify::axis_data::AxisData;
use crate::propagate::axis_noise::AxisForm;
use crate::propagate::propagation::{Propagation, place_of};
use crate::result::calibration::{
    AxisResult, StationResult, widening_of_components, widening_of_locations,
};
use crate::result::numbered::{NumberedResult, results};
use crate::result::output::{Output, OutputCovariance};

/// Largest covariance that is made, GiB.
const LIMIT_GIB: u32 = 1;

/// Refuses a covariance that would not fit.
pub(crate) fn check_size(
    machine: &Machine,
    data: &[AxisData],
    stations: usize,
) -> Result<(), Error> {
    let of_axis = |axis: &AxisData| {
        6 * axis.nodes.len() + machine.axes()[axis.axis].location_components().len()
    };
    require_size(data.iter().map(of_axis).sum::<usize>() + 4 * stations)
}

fn require_size(outputs: usize) -> Result<(), Error> {
    let gib = (outputs as f64).powi(2) * size_of::<f64>() as f64 / 1024_f64.powi(3);
    if gib > f64::from(LIMIT_GIB) {
        return Err(Error::CovarianceTooLarge {
            outputs,
            gib,
            limit_gib: LIMIT_GIB,
        });
    }
    Ok(())
}

impl OutputCovariance {
    /// Of the results that `propagation` gave their uncertainties.
    pub(crate) fn new(
        propagation: &Propagation<'_>,
        axes: &[AxisResult],
        stations: &[StationResult],
    ) -> Self {
        let mut matrix = in_mm_and_rad(propagation, axes);
        let results = results(axes, stations);
        let birge_ratio = |output: &Output| match output {
            Output::ComponentError { axis, .. } => axes
                .iter()
                .find(|result| result.name == *axis)
                .map_or(1.0, widening_of_components),
            Output::LocationError { .. } => widening_of_locations(axes),
            Output::StationPosition { .. } | Output::DeadPath { .. } => 1.0,
        };
        // Gauge and frame leave rounding where they define a result.
        let scale = |result: &NumberedResult| match result.u > 0.0 {
            true => birge_ratio(&result.output) / result.output.unit().size(),
            false => 0.0,
        };
        let scales: Vec<f64> = results.iter().map(scale).collect();
        // Symmetric to the last bit.
        for j in 0..scales.len() {
            for i in 0..=j {
                let value = matrix[(i, j)] * (scales[i] * scales[j]);
                matrix[(i, j)] = value;
                matrix[(j, i)] = value;
            }
        }
        let outputs = results.into_iter().map(|result| result.output).collect();
        Self { outputs, matrix }
    }
}

/// The upper triangle in mm and rad.
fn in_mm_and_rad(propagation: &Propagation<'_>, axes: &[AxisResult]) -> DMatrix<f64> {
    let noise = &propagation.whole;
    let dependence = propagation.dependence;
    let components: Vec<AxisForm> = dependence
        .identified
        .gauges
        .iter()
        .map(|gauge| AxisForm::component_errors(gauge, 0..gauge.node_effects.len()))
        .collect();
    // All results as functions of the sources; component errors have a part of their own beside.
    let over_sources = over_sources(propagation, axes, &components);
    let mut shared = &over_sources * &noise.sources.shared;
    let mut covariance = &over_sources * &noise.sources.own * over_sources.transpose();
    let mut first = 0;
    for (k, form) in components.iter().enumerate() {
        let (axis, sources) = (&noise.axes[k], &dependence.sources.axes[k]);
        let count = 6 * axes[k].nodes.len();
        let mut rows = shared.rows_mut(first, count);
        rows += axis.shared(form);
        let mut block = covariance.view_mut((first, first), (count, count));
        block += axis.own(form, form);
        let of_own_sources = over_sources.select_columns(&sources.places);
        let cross = axis.own(form, &sources.form) * of_own_sources.transpose();
        let mut rows = covariance.rows_mut(first, count);
        rows += &cross;
        let mut columns = covariance.columns_mut(first, count);
        columns += cross.transpose();
        first += count;
    }
    covariance.gemm(1.0, &(&shared * noise.shared()), &shared.transpose(), 1.0);
    covariance
}

/// What results owe to the sources: location errors and stations all that they are, component
/// errors what goes through the base of their axis.
fn over_sources(
    propagation: &Propagation<'_>,
    axes: &[AxisResult],
    components: &[AxisForm],
) -> DMatrix<f64> {
    let dependence = propagation.dependence;
    let locations = dependence
        .locations
        .iter()
        .zip(axes)
        .flat_map(|(rows, axis)| {
            let reported = axis.location_errors.iter();
            reported.map(|location| rows.row(place_of(location.component)))
        });
    let stations = dependence.stations.iter().flat_map(|rows| rows.row_iter());
    let of_frame: Vec<_> = locations.chain(stations).collect();
    let first_of_frame: usize = axes.iter().map(|axis| 6 * axis.nodes.len()).sum();
    let mut all = DMatrix::zeros(first_of_frame + of_frame.len(), dependence.sources.count);
    let mut first = 0;
    for (k, form) in components.iter().enumerate() {
        if let Some(rows) = dependence.through_base(k, form) {
            all.rows_mut(first, rows.nrows()).copy_from(&rows);
        }
        first += 6 * axes[k].nodes.len();
    }
    for (i, row) in of_frame.iter().enumerate() {
        all.row_mut(first_of_frame + i).copy_from(row);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_with_its_size() {
        assert_eq!(require_size(11_585), Ok(()));
        let refused = require_size(40_000).map_err(|error| error.to_string());
        let text = refused.unwrap_err();
        assert!(text.contains("40000 results takes 11.9 GiB"), "{text}");
    }
}

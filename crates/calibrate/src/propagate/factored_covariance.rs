//! The covariance of all results in factors.
//!
//! With the sources `t` of all axes ([`crate::propagate::sources`]) and the shared sources `s` every result is
//!
//! ```text
//! r = m + L t - F s      component errors m of a node: own noise B, cov(m, t) = Z; none for other results
//! ```
//!
//! `L` holds the gauge, as the parameters of an axis are among its sources, the bases that move, and for location
//! errors and stations the frame. With the own part `S` of `cov(t)` the covariance of two results is
//!
//! ```text
//! [same node] B + L S Lᵀ + L Zᵀ + Z Lᵀ + F Σ Fᵀ        U = [L Z F]     M = [S I 0; I 0 0; 0 0 Σ]
//! ```

use nalgebra::DMatrix;

use crate::propagate::axis_noise::AxisForm;
use crate::propagate::propagation::{Propagation, place_of};
use crate::result::calibration::{AxisResult, StationResult, widening_of_components};
use crate::result::factored_covariance::FactoredCovariance;
use crate::result::numbered::results;

impl FactoredCovariance {
    /// Of the results that `propagation` gave their uncertainties; stations are not widened where runs contradict
    /// each other.
    pub(crate) fn new(
        propagation: &Propagation<'_>,
        axes: &[AxisResult],
        stations: &[StationResult],
    ) -> Self {
        let noise = &propagation.whole;
        let dependence = propagation.dependence;
        // Stations stand behind all others, and follow from the shared sources alone.
        let sources = dependence.sources.stations;
        let count = results(axes, stations).len();
        let mut of_sources = DMatrix::zeros(count, dependence.sources.count);
        let mut own_with_sources = DMatrix::zeros(count, sources);
        let mut through_poses = DMatrix::zeros(count, noise.shared().nrows());
        let mut own = Vec::new();
        let mut first = 0;
        for (k, gauge) in dependence.identified.gauges.iter().enumerate() {
            let (axis, places) = (&noise.axes[k], &dependence.sources.axes[k].places);
            let form = AxisForm::component_errors(gauge, 0..gauge.node_effects.len());
            let rows = form.parameters.nrows();
            let mut coefficients = of_sources.rows_mut(first, rows);
            if let Some(through_base) = dependence.through_base(k, &form) {
                coefficients.copy_from(&through_base);
            }
            for (column, &place) in form.parameters.column_iter().zip(places) {
                let mut sum = coefficients.column_mut(place);
                sum += column;
            }
            let of_nodes = AxisForm {
                parameters: DMatrix::zeros(rows, gauge.parameters()),
                poses: form.poses,
            };
            let with_sources = axis.own(&of_nodes, &dependence.sources.axes[k].form);
            for (column, &place) in with_sources.column_iter().zip(places) {
                own_with_sources
                    .view_mut((first, place), (rows, 1))
                    .copy_from(&column);
            }
            through_poses
                .rows_mut(first, rows)
                .copy_from(&axis.shared(&of_nodes));
            own.extend((0..axes[k].nodes.len()).map(|node| axis.own_of_node(node)));
            first += rows;
        }
        let locations = dependence.locations.iter().zip(axes);
        let locations = locations.flat_map(|(rows, axis)| {
            let reported = axis.location_errors.iter();
            reported.map(|location| rows.row(place_of(location.component)))
        });
        let of_stations = dependence.stations.iter().flat_map(|rows| rows.row_iter());
        for row in locations.chain(of_stations) {
            of_sources.row_mut(first).copy_from(&row);
            first += 1;
        }
        through_poses += &of_sources * &noise.sources.shared;

        let mut sensitivities =
            of_sources.remove_columns(sources, dependence.sources.count - sources);
        sensitivities = joined(sensitivities, &own_with_sources);
        sensitivities = joined(sensitivities, &through_poses);
        let (behind, width) = (2 * sources, noise.shared().nrows());
        let size = behind + width;
        let mut shared = DMatrix::zeros(size, size);
        let own_of_sources = noise.sources.own.view((0, 0), (sources, sources));
        shared
            .view_mut((0, 0), (sources, sources))
            .copy_from(&own_of_sources);
        shared
            .view_mut((0, sources), (sources, sources))
            .fill_with_identity();
        shared
            .view_mut((sources, 0), (sources, sources))
            .fill_with_identity();
        shared
            .view_mut((behind, behind), (width, width))
            .copy_from(noise.shared());
        let covariance = Self {
            own,
            sensitivities,
            shared,
        };
        covariance.scaled(&scales(axes, stations))
    }
}

/// By what each result is widened; zero for what gauge or frame define, where they leave rounding.
fn scales(axes: &[AxisResult], stations: &[StationResult]) -> Vec<f64> {
    let components = axes
        .iter()
        .flat_map(|axis| vec![widening_of_components(axis); 6 * axis.nodes.len()]);
    let widened = components.chain(std::iter::repeat(1.0));
    let results = results(axes, stations);
    let pairs = results.iter().zip(widened);
    pairs
        .map(|(result, factor)| if result.u > 0.0 { factor } else { 0.0 })
        .collect()
}

/// Two matrices side by side.
fn joined(left: DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let columns = left.ncols();
    let mut both = left.resize_horizontally(columns + right.ncols(), 0.0);
    both.columns_mut(columns, right.ncols()).copy_from(right);
    both
}

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

use std::ops::Range;

use nalgebra::{DMatrix, Matrix6};

use crate::in_order;
use crate::propagate::axis_noise::AxisForm;
use crate::propagate::propagation::{Noise, place_of};
use crate::result::calibration::{AxisResult, StationResult, widening_of_components};
use crate::result::factored_covariance::{FactoredCovariance, scaled};
use crate::result::numbered::results;
use crate::result::sensitivities::{Rows, Sensitivities};

/// Nodes that one thread takes at a time.
const NODES: usize = 128;

impl FactoredCovariance {
    /// Of the results that have their uncertainties from this noise; stations are not widened where runs contradict
    /// each other.
    pub(crate) fn new(noise: &Noise<'_>, axes: &[AxisResult], stations: &[StationResult]) -> Self {
        let dependence = noise.dependence;
        let scales = scales(axes, stations);
        let (mut own, mut rows) = (Vec::new(), Vec::new());
        for (k, axis) in axes.iter().enumerate() {
            let (nodes, first) = (axis.nodes.len(), 6 * own.len());
            let pieces = in_order::map(nodes.div_ceil(NODES), |piece| {
                let start = NODES * piece;
                let piece = start..nodes.min(start + NODES);
                of_nodes(noise, k, piece, (first + 6 * start, &scales))
            });
            for (of_piece, piece) in pieces {
                own.extend(of_piece);
                rows.push(piece);
            }
        }
        let locations = dependence.locations.iter().zip(axes);
        let locations = locations.flat_map(|(rows, axis)| {
            let reported = axis.location_errors.iter();
            reported.map(|location| rows.row(place_of(location.component)))
        });
        let of_stations = dependence.stations.iter().flat_map(|rows| rows.row_iter());
        let others: Vec<_> = locations.chain(of_stations).collect();
        let first = 6 * own.len();
        if !others.is_empty() {
            let of_sources = DMatrix::from_rows(&others);
            let with_sources = DMatrix::zeros(others.len(), dependence.sources.stations);
            let through_poses = &of_sources * &noise.sources.shared;
            let all = joined(&of_sources, &with_sources, &through_poses, &scales[first..]);
            rows.push(Rows::new(first, &all));
        }

        // Stations stand behind all other sources, and follow from the shared ones alone.
        let (sources, width) = (dependence.sources.stations, noise.shared().nrows());
        let (behind, size) = (2 * sources, 2 * sources + width);
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
        let mut sensitivities = Sensitivities::new(size, rows);
        let used = sensitivities.drop_unused_columns();
        Self {
            own,
            sensitivities,
            shared: shared.select_rows(&used).select_columns(&used),
        }
    }
}

/// What some nodes of axis `k` have alone, and their rows; `first` is the first of their results.
fn of_nodes(
    noise: &Noise<'_>,
    k: usize,
    nodes: Range<usize>,
    (first, scales): (usize, &[f64]),
) -> (Vec<Matrix6<f64>>, Rows) {
    let dependence = noise.dependence;
    let (axis, own_sources) = (&noise.axes[k], &dependence.sources.axes[k]);
    let gauge = &dependence.identified.gauges[k];
    let scales = &scales[first..];
    let form = AxisForm::component_errors(gauge, nodes.clone());
    let rows = form.parameters.nrows();
    let through_base = dependence.through_base(k, &form);
    let mut of_sources =
        through_base.unwrap_or_else(|| DMatrix::zeros(rows, dependence.sources.count));
    for (column, &place) in form.parameters.column_iter().zip(&own_sources.places) {
        let mut sum = of_sources.column_mut(place);
        sum += column;
    }
    let of_poses = AxisForm {
        parameters: DMatrix::zeros(rows, gauge.parameters()),
        poses: form.poses,
    };
    let mut with_sources = DMatrix::zeros(rows, dependence.sources.stations);
    let of_own_sources = axis.own(&of_poses, &own_sources.form);
    for (column, &place) in of_own_sources.column_iter().zip(&own_sources.places) {
        with_sources.column_mut(place).copy_from(&column);
    }
    let through_poses = axis.shared(&of_poses) + &of_sources * &noise.sources.shared;
    let all = joined(&of_sources, &with_sources, &through_poses, scales);
    let own = nodes.zip(scales.chunks_exact(6));
    let own = own.map(|(node, factors)| scaled(&axis.own_of_node(node), factors));
    (own.collect(), Rows::new(first, &all))
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

/// `[L Z F]` without the stations among the sources, each row times a factor.
fn joined(
    of_sources: &DMatrix<f64>,
    with_sources: &DMatrix<f64>,
    through_poses: &DMatrix<f64>,
    scales: &[f64],
) -> DMatrix<f64> {
    let sources = with_sources.ncols();
    let columns = of_sources.column_iter().take(sources);
    let columns = columns.chain(with_sources.column_iter());
    let columns: Vec<_> = columns.chain(through_poses.column_iter()).collect();
    let mut all = DMatrix::from_columns(&columns);
    for (mut row, factor) in all.row_iter_mut().zip(scales) {
        row *= *factor;
    }
    all
}

//! The covariance of all results in factors.
//!
//! With the sources `t` of all axes ([`crate::propagate::sources`]) and the shared sources `s` every result is
//!
//! ```text
//! r = m + L t - F s      component errors m of a node: own noise B, cov(m, t) = Z; none for other results
//! ```
//!
//! For component errors `m`, `L` and `F` are those of [`crate::propagate::node_functions`]; for location errors and
//! stations `L` contains the frame. With the own part `S` of `cov(t)` the covariance of two results is
//!
//! ```text
//! [same node] B + L S Lᵀ + L Zᵀ + Z Lᵀ + F Σ Fᵀ        U = [L Z F]     M = [S I 0; I 0 0; 0 0 Σ]
//! ```
//!
//! and what contradictory runs add to the location parameters are further columns.

use nalgebra::{DMatrix, DVectorView, Vector6};
use trueaxis_predict::{FactoredCovariance, Rows};

use crate::propagate::propagation::{Noise, place_of};
use crate::result::calibration::{AxisResult, StationResult, widening_of_components};
use crate::result::numbered::results;

/// The covariance of the results, whose uncertainties follow from this noise. Contradictory runs do not widen
/// stations.
pub(crate) fn factored_covariance(
    noise: &Noise<'_>,
    axes: &[AxisResult],
    stations: &[StationResult],
) -> FactoredCovariance {
    let dependence = noise.dependence;
    let scales = scales(axes, stations);
    // Stations come after all other sources, and depend on the shared ones alone.
    let (sources, width) = (dependence.sources.stations, noise.poses.shared.nrows());
    let behind = 2 * sources..2 * sources + width;
    let (mut own, mut rows) = (Vec::new(), Vec::new());
    for k in 0..axes.len() {
        let first_of_axis = 6 * own.len();
        let chunks = noise.of_nodes(k, |node, f| {
            let first = first_of_axis + 6 * node;
            let scales = &scales[first..first + 6 * f.own.len()];
            let with_sources = f.sources.iter().map(|source| sources + source);
            let columns = f.sources.iter().copied().chain(with_sources);
            let columns = columns.chain(behind.clone());
            let blocks = [&f.of_sources, &f.with_sources, &f.of_shared];
            let own = f.own.iter().zip(scales.chunks_exact(6));
            let own = own.map(|(own, factors)| {
                let factors = Vector6::from_column_slice(factors);
                own.component_mul(&(factors * factors.transpose()))
            });
            (
                own.collect::<Vec<_>>(),
                Rows::of_columns(first, scales, columns.zip(side_by_side(blocks))),
            )
        });
        for (of_chunk, chunk) in chunks {
            own.extend(of_chunk);
            rows.push(chunk);
        }
    }
    let locations = dependence.locations.iter().zip(axes);
    let locations = locations.flat_map(|(rows, axis)| {
        let reported = axis.location_errors.iter();
        reported.map(|location| rows.row(place_of(location.component)))
    });
    let of_stations = dependence.stations.iter().flat_map(|rows| rows.row_iter());
    let others: Vec<_> = locations.chain(of_stations).collect();
    let others = match others.is_empty() {
        true => DMatrix::zeros(0, dependence.sources.count),
        false => DMatrix::from_rows(&others),
    };
    let first = 6 * own.len();
    let of_shared = &others * &noise.sources.shared;
    let of_sources = others.columns(0, sources).into_owned();
    let columns = (0..sources).chain(behind.clone());
    let columns = columns.zip(side_by_side([&of_sources, &of_shared]));
    rows.push(Rows::of_columns(
        first,
        &scales[first..first + others.nrows()],
        columns,
    ));

    let mut shared = DMatrix::zeros(behind.end, behind.end);
    let square = (sources, sources);
    let own_of_sources = noise.sources.own.view((0, 0), square);
    shared.view_mut((0, 0), square).copy_from(&own_of_sources);
    shared.view_mut((0, sources), square).fill_with_identity();
    shared.view_mut((sources, 0), square).fill_with_identity();
    let mut of_shared = shared.view_range_mut(behind.clone(), behind.clone());
    of_shared.copy_from(&noise.poses.shared);
    let mut factors = FactoredCovariance::new(own, rows, &shared);
    for error in &noise.sources.scatter {
        let of_nodes = (0..axes.len()).flat_map(|k| noise.through_base(k, error));
        let of_others = (&others * error).as_slice().to_vec();
        let all = of_nodes.chain(of_others).zip(&scales);
        factors.add_common(
            &all.map(|(change, scale)| change * scale)
                .collect::<Vec<_>>(),
        );
    }
    factors
}

/// Factor by which each result is widened; zero where gauge or frame define it, to remove rounding.
fn scales(axes: &[AxisResult], stations: &[StationResult]) -> Vec<f64> {
    let components = axes
        .iter()
        .flat_map(|axis| vec![widening_of_components(axis); 6 * axis.nodes.len()]);
    let widened = components.chain(std::iter::repeat(1.0));
    let pairs = results(axes, stations).zip(widened);
    pairs
        .map(|(result, factor)| if result.u > 0.0 { factor } else { 0.0 })
        .collect()
}

/// The columns of blocks side by side.
fn side_by_side<const N: usize>(
    blocks: [&DMatrix<f64>; N],
) -> impl Iterator<Item = DVectorView<'_, f64>> {
    blocks.into_iter().flat_map(|block| block.column_iter())
}

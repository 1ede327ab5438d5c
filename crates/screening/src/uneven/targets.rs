//! Targets whose lengths scatter more than those to the other targets of their stage.

use trueaxis_multilateration::Network;

use crate::uneven::{Scatter, Uneven, Whose, changes, ratio_to_others, uneven, visits_of};

/// The targets that plainly scatter more, with the visits that read them; by w of each reading.
pub(super) fn uneven_targets(network: &Network, w: impl Fn(usize) -> f64) -> Vec<Uneven> {
    let bodies = network.bodies.iter().flat_map(|bodies| &bodies.bodies);
    let of_body = |(body, places): (usize, usize)| {
        let scatters = scatters(network, body, places, &w);
        uneven(&scatters).into_iter().map(move |own| Uneven {
            whose: Whose::Target((body, own.number)),
            ratio: own.ratio,
            plain: own.plain,
            visits: (0..network.visits.len()).collect(),
        })
    };
    bodies
        .map(|body| body.home_mm.len())
        .enumerate()
        .flat_map(of_body)
        .collect()
}

/// Ratio of the variance of w of a target to the median of the others of its body.
pub(super) fn ratio_of_target(
    network: &Network,
    (body, place): (usize, usize),
    w: impl Fn(usize) -> f64,
) -> Option<f64> {
    let places = network.bodies.as_ref()?.bodies[body].home_mm.len();
    ratio_to_others(&scatters(network, body, places, &w), place).map(|(ratio, _)| ratio)
}

/// The target that a reading of a visit was taken to.
pub(crate) fn place_of(network: &Network, visit: usize, reading: usize) -> Option<(usize, usize)> {
    let bodies = network.bodies.as_deref()?;
    let placed = &bodies.of_groups[network.visits[visit].group];
    Some((placed.body?, placed.places[network.readings[reading].point]))
}

/// How the lengths to each target of a body change from one visit of a station to the next.
fn scatters(
    network: &Network,
    body: usize,
    places: usize,
    w: &impl Fn(usize) -> f64,
) -> Vec<Option<Scatter>> {
    let stations = 0..network.stations.len();
    let of_stations: Vec<Vec<usize>> = stations.map(|j| visits_of(network, j)).collect();
    let of_place = |place: usize| {
        let own_w = |visit: usize| -> Vec<f64> {
            let readings = network.visits[visit].readings.clone();
            let own = readings.filter(|&i| place_of(network, visit, i) == Some((body, place)));
            own.map(w).collect()
        };
        let squares = of_stations
            .iter()
            .flat_map(|visits| changes(network, visits, own_w));
        let squares: Vec<f64> = squares.collect();
        let count = squares.len();
        Scatter::of(squares, count)
    };
    (0..places).map(of_place).collect()
}

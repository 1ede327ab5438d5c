//! A network solved from where everything is known to be nearly.

use nalgebra::Point3;

use crate::solve::{Attempt, adjust_from, batches_of, solution};
use crate::state::State;
use crate::{Error, Network, Settings, Solution, Station};

/// Adjusted points, stations and dead paths, yet without uncertainties.
pub struct Refined<'a> {
    network: &'a Network,
    attempt: Attempt<'a>,
}

/// Finds all points, stations and dead paths of a network from where they are known to be nearly:
/// without the search for a start, and without doubt about mirror images.
///
/// `points_mm` are in the order of the network. Lengths are linear in dead paths, so those of the
/// `stations` may be far off; dead paths after interruptions start like their station's.
///
/// # Errors
/// Those of [`crate::solve`]; [`Error::Malformed`] if the numbers of stations or points are not the
/// network's or one of their coordinates is not finite.
pub fn refine<'a>(
    network: &'a Network,
    stations: &[Station],
    points_mm: &[Point3<f64>],
    settings: &Settings,
) -> Result<Refined<'a>, Error> {
    network.check()?;
    let batches = batches_of(network)?;
    let stations_mm: Vec<_> = stations.iter().map(|s| s.position_mm).collect();
    let dead_paths_mm: Vec<_> = stations.iter().map(|s| s.dead_path_mm).collect();
    let (found, need) = (
        (stations.len(), points_mm.len()),
        (network.stations.len(), network.nominal_mm.len()),
    );
    let mut places = stations_mm.iter().chain(points_mm);
    let finite = places.all(|p| p.iter().all(|x| x.is_finite()))
        && dead_paths_mm.iter().all(|x| x.is_finite());
    if found != need || !finite {
        let what = format!(
            "a start of {} stations and {} points, all finite, is needed; found {} and {}",
            need.0, need.1, found.0, found.1
        );
        return Err(Error::Malformed { what });
    }
    let state = State::new(network, stations_mm, dead_paths_mm, points_mm.to_vec());
    let attempt = adjust_from(network, &batches, state, settings)?;
    Ok(Refined { network, attempt })
}

impl Refined<'_> {
    /// The whole solution with the covariance of everything.
    ///
    /// # Errors
    /// Those of [`crate::solve`].
    pub fn solution(self) -> Result<Solution, Error> {
        solution(self.network, self.attempt, false)
    }
}

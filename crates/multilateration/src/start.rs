//! The start of the iteration: stations from the nominal points alone.

mod station;

use trueaxis_leastsquares::median;

use self::station::{Cloud, Sighting, StationFit, find_station, residual_mm};
use crate::solve::{batches_of, solve_from_start};
use crate::state::State;
use crate::{Error, Network, Solution, Station};

/// Largest number of readings for the start of one station: enough for it, and the time stays linear.
const MAX_READINGS: usize = 2000;

/// A fit of one station worse than this, relative to the size of its points, is tried again from other starts, then
/// without far readings: nominal positions are never that wrong.
const POOR_FIT: f64 = 1e-2;

/// No position with a fit worse than this, relative to the size of its points, is credible.
const NO_FIT: f64 = 0.1;

/// Start of the adjustment of a network, with what it leaves open.
pub struct Start {
    /// Points at their nominal positions and the stations that fit them best.
    pub(crate) state: State,
    /// For each station its mirror image, if that fits the nominal points as well and no position of the station is
    /// given.
    pub(crate) images: Vec<Option<Station>>,
}

impl Start {
    /// The start of a network.
    ///
    /// # Errors
    /// Those of [`crate::solve`] that need no adjustment: too few lengths, or a station that no position explains.
    pub fn new(network: &Network) -> Result<Self, Error> {
        network.check()?;
        // First, so that too few lengths are reported as such.
        batches_of(network)?;
        start(network)
    }

    /// Observed minus computed length of every reading, mm; `network` must be the one of this start.
    pub fn residuals_mm(&self, network: &Network) -> Vec<f64> {
        self.state.residuals_mm(network)
    }

    /// Solves the network of this start; its weights may have changed.
    pub fn solve(self, network: &Network) -> Result<Solution, Error> {
        solve_from_start(network, &batches_of(network)?, self)
    }
}

pub(crate) fn start(network: &Network) -> Result<Start, Error> {
    let seen = sightings(network);
    let (mut stations, mut images) = (Vec::new(), Vec::new());
    for (j, (readings, some)) in seen.into_iter().enumerate() {
        let mut cloud = Cloud::new(&some);
        let mut fits = find_station(&some, &cloud, network.stations[j]);
        if let Some(rest) = without_far(&some, &cloud, &fits) {
            cloud = Cloud::new(&rest);
            fits = find_station(&rest, &cloud, network.stations[j]);
        }
        let is_good = |fit: &&StationFit| fit.rms_mm <= NO_FIT * cloud.radius_mm;
        let Some(&fit) = fits.first().filter(is_good) else {
            let rms_mm = fits.first().map_or(f64::INFINITY, |fit| fit.rms_mm);
            return Err(Error::NoStart {
                station: j,
                readings,
                rms_mm,
            });
        };
        let place = fit.station.position_mm;
        let is_open = network.stations[j].is_none();
        let mut others = fits.iter().map(|fit| fit.station).filter(|_| is_open);
        images.push(others.find(|other| cloud.on_other_side(place, other.position_mm)));
        stations.push((place, fit.station.dead_path_mm));
    }
    let (stations, dead_paths_mm) = stations.into_iter().unzip();
    let points = network.nominal_mm.clone();
    Ok(Start {
        state: State::new(network, stations, dead_paths_mm, points),
        images,
    })
}

/// For each station the number of its readings, and an evenly spread selection of them.
fn sightings(network: &Network) -> Vec<(usize, Vec<Sighting>)> {
    let mut seen = vec![Vec::new(); network.stations.len()];
    for visit in &network.visits {
        let sightings = network.readings_of(visit).iter().map(|reading| Sighting {
            point: network.nominal_mm[network.point(visit.group, reading.point)],
            length_mm: reading.length_mm,
        });
        seen[visit.station].extend(sightings);
    }
    let spread = |all: Vec<Sighting>| {
        let every = all.len().div_ceil(MAX_READINGS).max(1);
        (all.len(), all.into_iter().step_by(every).collect())
    };
    seen.into_iter().map(spread).collect()
}

/// A reading with more than this many times the median residual spoils a poor fit.
const FAR: f64 = 10.0;

/// Share of the readings that may spoil a fit.
const MOST_FAR: f64 = 0.05;

/// The sightings of a poor fit without those that spoil it; `None` if the fit is not poor, or none or many spoil it.
fn without_far(
    sightings: &[Sighting],
    cloud: &Cloud,
    fits: &[StationFit],
) -> Option<Vec<Sighting>> {
    let fit = fits
        .iter()
        .min_by(|a, b| a.rms_mm.total_cmp(&b.rms_mm))
        .filter(|fit| fit.rms_mm > POOR_FIT * cloud.radius_mm)?;
    let size_mm = |s: &Sighting| residual_mm(s, fit.station).abs();
    let median_mm = median(&mut sightings.iter().map(size_mm).collect::<Vec<_>>())?;
    let near = sightings.iter().filter(|s| size_mm(s) <= FAR * median_mm);
    let rest: Vec<Sighting> = near.copied().collect();
    let far = sightings.len() - rest.len();
    let few = far > 0 && far as f64 <= MOST_FAR * sightings.len() as f64;
    few.then_some(rest)
}

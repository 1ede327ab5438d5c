//! How many readings may be removed before the measurement itself is to blame.

use trueaxis_multilateration::{MIN_STATIONS_PER_POINT, Network, ReadingTest, Visit};

use crate::robust_weights::REMOVED;
use crate::screened::Removed;
use crate::{Error, Part};

/// Share of all readings that may be removed.
pub const MOST_REMOVED: f64 = 0.05;

/// Share of the readings of one station, of one group, or of any other part that may be removed.
pub const MOST_OF_A_PART: f64 = 1.0 / 3.0;

/// So many removals of one target from one station, if more than half of all, are no accident: there are at least
/// twelve such pairs.
const FEW: usize = 10;

/// Whether `part` removals, all of one target from one station, are too many of `all` to be accidents.
pub fn is_concentrated(part: usize, all: usize) -> bool {
    part >= FEW && 2 * part > all
}

/// If the residuals keep less of a reading than this share, the others do not check it.
const CHECKED: f64 = 0.02;

/// Refuses removals of more than `limit` of all readings, or of too many of one station or group.
pub(crate) fn check(network: &Network, removed: &[Removed], limit: f64) -> Result<(), Error> {
    let readings = network.readings.len();
    if removed.len() as f64 > limit * readings as f64 {
        return Err(Error::TooManyGrossErrors {
            removed: removed.iter().map(|r| r.reading).collect(),
            readings,
            limit,
        });
    }
    // Removed and all readings of each station, then of each group.
    let stations = network.stations.len();
    let mut counts = vec![(0, 0); stations + network.groups.len()];
    let mut is_removed = vec![false; readings];
    for removed in removed {
        is_removed[removed.reading] = true;
    }
    for visit in &network.visits {
        for reading in visit.readings.clone() {
            for part in [visit.station, stations + visit.group] {
                counts[part].0 += usize::from(is_removed[reading]);
                counts[part].1 += 1;
            }
        }
    }
    for (number, (removed, readings)) in counts.into_iter().enumerate() {
        if removed as f64 > MOST_OF_A_PART * readings as f64 {
            let group = number.checked_sub(stations);
            return Err(Error::PartLost {
                part: group.map_or(Part::Station(number), Part::Group),
                removed,
                readings,
                limit: MOST_OF_A_PART,
            });
        }
    }
    Ok(())
}

/// Readings that nothing checks since others of their point were removed: they may as well be the wrong ones, and
/// are removed, too. The points of a body check each other.
///
/// # Errors
/// [`Error::Undecidable`] if the point or body is then seen from too few stations.
pub(crate) fn unchecked(network: &Network, tests: &[ReadingTest]) -> Result<Vec<usize>, Error> {
    let is_removed = |reading: usize| network.variance_factor(reading) >= REMOVED;
    let mut first_removed: Vec<Option<usize>> = vec![None; network.nominal_mm.len()];
    for (reading, point) in network.visits.iter().flat_map(|v| points(network, v)) {
        if is_removed(reading) {
            first_removed[point].get_or_insert(reading);
        }
    }
    let mut unchecked = Vec::new();
    let mut checked_from: Vec<Vec<usize>> = vec![Vec::new(); network.nominal_mm.len()];
    for visit in &network.visits {
        for (reading, point) in points(network, visit) {
            if first_removed[point].is_none() || is_removed(reading) {
                continue;
            }
            if tests[reading].kept < CHECKED {
                unchecked.push((reading, point));
            } else if !checked_from[point].contains(&visit.station) {
                checked_from[point].push(visit.station);
            }
        }
    }
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    let mut said = vec![false; network.nominal_mm.len()];
    for &(other, point) in &unchecked {
        if let Some(reading) = first_removed[point]
            && checked_from[point].len() < MIN_STATIONS_PER_POINT
            && !said[point]
        {
            said[point] = true;
            pairs.push((reading, other));
        }
    }
    if !pairs.is_empty() {
        return Err(Error::Undecidable { pairs });
    }
    Ok(unchecked.into_iter().map(|(reading, _)| reading).collect())
}

/// The readings of a visit with their points; all points of a body count as its first one.
fn points<'a>(network: &'a Network, visit: &'a Visit) -> impl Iterator<Item = (usize, usize)> + 'a {
    let readings = visit.readings.clone();
    let is_tied = network.body_of(visit.group).is_some();
    let point = move |i: usize| {
        if is_tied {
            0
        } else {
            network.readings[i].point
        }
    };
    readings.map(move |i| (i, network.point(visit.group, point(i))))
}

//! How much may be removed before the measurement, and not the readings, is to blame.

use crate::baarda::ReadingTest;
use crate::screen::Removed;
use crate::{Error, Network, Part};

/// Share of all readings that may be removed.
const MOST_REMOVED: f64 = 0.05;

/// Share of the readings of one station, or of one group, that may be removed.
const MOST_OF_A_PART: f64 = 1.0 / 3.0;

/// A reading of which the residuals keep less than this part is not checked by the others.
const CHECKED: f64 = 0.02;

/// Refuses removals that the measurement does not carry. `tests` are those of all readings of the
/// working network, in which removed readings have no weight.
pub(crate) fn check(
    network: &Network,
    removed: &[Removed],
    tests: &[ReadingTest],
) -> Result<(), Error> {
    let readings = network.readings.len();
    if removed.len() as f64 > MOST_REMOVED * readings as f64 {
        return Err(Error::TooManyGrossErrors {
            removed: removed.len(),
            readings,
            limit: MOST_REMOVED,
        });
    }
    let mut stations = vec![(0, 0); network.stations.len()];
    let mut groups = vec![(0, 0); network.groups.len()];
    let mut is_removed = vec![false; readings];
    for removed in removed {
        is_removed[removed.reading] = true;
    }
    for visit in &network.visits {
        for reading in visit.readings.clone() {
            for count in [&mut stations[visit.station], &mut groups[visit.group]] {
                count.0 += usize::from(is_removed[reading]);
                count.1 += 1;
            }
        }
    }
    let parts = stations
        .iter()
        .enumerate()
        .map(|(j, c)| (Part::Station(j), c));
    let parts = parts.chain(groups.iter().enumerate().map(|(g, c)| (Part::Group(g), c)));
    for (part, &(lost, all)) in parts {
        if lost as f64 > MOST_OF_A_PART * all as f64 {
            return Err(Error::PartLost {
                part,
                removed: lost,
                readings: all,
                limit: MOST_OF_A_PART,
            });
        }
    }
    decidable(network, removed, &is_removed, tests)
}

/// If nothing checks the other readings of a point any more, each of them may be the wrong one as
/// well as the one that was removed.
fn decidable(
    network: &Network,
    removed: &[Removed],
    is_removed: &[bool],
    tests: &[ReadingTest],
) -> Result<(), Error> {
    if removed.is_empty() {
        return Ok(());
    }
    let mut first_removed: Vec<Option<usize>> = vec![None; network.nominal_mm.len()];
    let points = |visit: &crate::Visit| {
        let group = visit.group;
        visit
            .readings
            .clone()
            .map(move |i| (i, network.point(group, network.readings[i].point)))
    };
    for (reading, point) in network.visits.iter().flat_map(points) {
        if is_removed[reading] {
            first_removed[point].get_or_insert(reading);
        }
    }
    for (other, point) in network.visits.iter().flat_map(points) {
        if let Some(reading) = first_removed[point]
            && !is_removed[other]
            && tests[other].kept < CHECKED
        {
            return Err(Error::Undecidable { reading, other });
        }
    }
    Ok(())
}

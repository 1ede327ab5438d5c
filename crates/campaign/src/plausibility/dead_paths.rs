//! Known dead paths against the lengths.
//!
//! With the dead path L the distance to the target is `|p - S| = l + L`, so it is positive for every length l. A dead path of the
//! wrong sign, or in metres, makes most of them negative; a single one is an error of the length.

use std::path::Path;

use crate::reading::readings_of;
use crate::{Campaign, Error, LengthReading, Lengths, Place, Problem};

/// Refuses a known dead path that makes most distances of its station negative; returns notices about others.
pub(crate) fn check(
    file: &Path,
    name: &str,
    campaign: &Campaign,
    lengths: &Lengths,
) -> Result<Vec<String>, Error> {
    let mut notices = Vec::new();
    for (j, station) in campaign.stations.iter().enumerate() {
        let Some(known) = station.dead_path else {
            continue;
        };
        let stops = lengths.stops.iter().filter(|stop| stop.station == j);
        let readings = || {
            stops
                .clone()
                .flat_map(|stop| readings_of(stop, &lengths.readings))
        };
        let is_negative = |reading: &&LengthReading| reading.length_mm + known.length_mm <= 0.0;
        let negative = readings().filter(is_negative).count();
        let Some(first) = readings().find(is_negative) else {
            continue;
        };
        let found = format!(
            "a length of {} mm, which with the dead path of station `{}` ({} mm) is a distance of {} mm",
            first.length_mm,
            station.name,
            known.length_mm,
            first.length_mm + known.length_mm,
        );
        let all = readings().count();
        if 2 * negative > all {
            let expected = "a positive distance: length_mm + dead_path_mm of campaign.json; correct its \
                            sign or unit";
            let place = Place::column(file, first.line, "length_mm");
            return Err(Problem::value(found, expected).at(place));
        }
        notices.push(format!(
            "{name} line {}, target `{}`: {found} ({negative} of {all} lengths of the station)",
            first.line, campaign.targets[first.target].name,
        ));
    }
    Ok(notices)
}

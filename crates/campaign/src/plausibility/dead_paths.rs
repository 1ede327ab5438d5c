//! Known dead paths against the lengths.
//!
//! With the dead path L the distance to the target is `|p - S| = l + L`, so it is positive for every
//! length l. A dead path of the wrong sign, or in metres, makes it negative.

use std::path::Path;

use super::station_name;
use crate::reading::readings_of;
use crate::{Campaign, Error, Lengths, Place, Problem};

/// Refuses a length that is shorter than its station's known dead path allows.
pub(crate) fn check(file: &Path, campaign: &Campaign, lengths: &Lengths) -> Result<(), Error> {
    if campaign.stations.iter().all(|s| s.dead_path.is_none()) {
        return Ok(());
    }
    for stop in &lengths.stops {
        let station = campaign.stations.get(stop.station);
        let Some(known) = station.and_then(|station| station.dead_path) else {
            continue;
        };
        for reading in readings_of(stop, &lengths.readings) {
            let distance_mm = reading.length_mm + known.length_mm;
            if distance_mm <= 0.0 {
                let found = format!(
                    "a length of {} mm, which with the dead path of station `{}` ({} mm) is a distance of \
                     {distance_mm} mm",
                    reading.length_mm,
                    station_name(campaign, stop.station),
                    known.length_mm,
                );
                let expected = "a positive distance: length_mm + dead_path_mm of campaign.json; mend its \
                                sign or unit";
                let place = Place::column(file, reading.line, "length_mm");
                return Err(Problem::value(found, expected).at(place));
            }
        }
    }
    Ok(())
}

//! Repeats that were not measured but copied.
//!
//! The readings of a repeat of a run from a station are a copy if all of them, for the same steps, directions and targets, equal
//! those of another to the last digit. A display of 1 µm does that by chance to one length in three if machine and instrument
//! repeat to 1 µm, to more if they repeat better: not to [`LEAST_READINGS`].
//!
//! Two repeats of one station: a notice, because lengths that a program made without noise look the
//! same. Two stations: an error, because no two places see the same lengths of a motion.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use crate::reading::{Reading, readings_of};
use crate::{Campaign, Error, Place, Problem, Stop};

/// Fewer readings may be equal by chance, or because nothing moved.
const LEAST_READINGS: usize = 30;

/// Station, run, repeat.
type Series = (usize, usize, u32);

/// The readings of a series, whatever their order.
#[derive(Default)]
struct Content {
    first_line: usize,
    count: usize,
    /// Sum of a hash of each reading.
    hash: u64,
}

/// Refuses a station's readings under the name of another; returns a notice on repeats.
pub(crate) fn check<R: Reading>(
    file: &Path,
    name: &str,
    campaign: &Campaign,
    stops: &[Stop],
    readings: &[R],
) -> Result<Option<String>, Error> {
    let mut contents: BTreeMap<Series, Content> = BTreeMap::new();
    for stop in stops {
        // What stands still may read the same again.
        let Some(run) = campaign.steps[stop.step].run else {
            continue;
        };
        let series = (stop.station, run, stop.repeat);
        let content = contents.entry(series).or_default();
        for reading in readings_of(stop, readings) {
            if content.count == 0 {
                content.first_line = reading.line();
            }
            content.count += 1;
            content.hash = content.hash.wrapping_add(hash(stop, reading));
        }
    }
    let mut first: BTreeMap<(usize, usize, u64), (Series, usize)> = BTreeMap::new();
    let mut copies = Vec::new();
    for (&series, content) in &contents {
        if content.count < LEAST_READINGS {
            continue;
        }
        let key = (series.1, content.count, content.hash);
        match first.get(&key) {
            Some(&(original, _)) if original.0 != series.0 => {
                return Err(Problem::StationCopied {
                    count: content.count,
                    run: campaign.runs[series.1].name.clone(),
                    station: campaign.stations[series.0].name.clone(),
                    original: campaign.stations[original.0].name.clone(),
                    original_line: contents[&original].first_line,
                }
                .at(Place::line(file, content.first_line)));
            }
            Some(&(original, line)) => copies.push((series, content, original, line)),
            None => drop(first.insert(key, (series, content.first_line))),
        }
    }
    let Some(&((station, run, repeat), content, (.., original), line)) = copies.first() else {
        return Ok(None);
    };
    let from = if R::HAS_STATION {
        format!(" from station `{}`", campaign.stations[station].name)
    } else {
        String::new()
    };
    let more = match copies.len() - 1 {
        0 => String::new(),
        more => format!(" (and {more} more like it)"),
    };
    Ok(Some(format!(
        "{name} line {}: repeat {repeat} of run `{}`{from} equals repeat {original} (line {line}) in all \
         {} readings to the last digit{more}; a copy is no second measurement and makes every uncertainty too \
         small: remove it, unless a program made the data without noise",
        content.first_line, campaign.runs[run].name, content.count,
    )))
}

/// Of what was read where; the time is none of it.
fn hash<R: Reading>(stop: &Stop, reading: &R) -> u64 {
    let mut hasher = DefaultHasher::new();
    (stop.step, stop.direction, reading.target()).hash(&mut hasher);
    reading.values().map(f64::to_bits).hash(&mut hasher);
    hasher.finish()
}

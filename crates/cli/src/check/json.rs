//! What `check --json` prints.

use serde::Serialize;
use trueaxis_campaign::{Campaign, Hole};

#[derive(Serialize)]
struct File<'a> {
    format: &'static str,
    version: u32,
    campaign: &'a str,
    readings: usize,
    stops: usize,
    coverage: Vec<Entry<'a>>,
    notices: &'a [String],
}

#[derive(Serialize)]
struct Entry<'a> {
    /// Null for targets on the bed.
    run: Option<&'a str>,
    target: &'a str,
    /// Null in a points campaign.
    station: Option<&'a str>,
    readings: usize,
    steps: usize,
    steps_of_run: usize,
    hole: Option<&'static str>,
}

/// The text of the document.
pub(super) fn text(campaign: &Campaign) -> String {
    let (readings, stops) = match (&campaign.lengths, &campaign.points) {
        (Some(lengths), _) => (lengths.readings.len(), lengths.stops.len()),
        (None, Some(points)) => (points.readings.len(), points.stops.len()),
        (None, None) => (0, 0),
    };
    let file = File {
        format: "trueaxis-check",
        version: 1,
        campaign: &campaign.name,
        readings,
        stops,
        coverage: entries(campaign),
        notices: &campaign.notices,
    };
    // Serialising plain structs of numbers and strings has no way to fail.
    trueaxis_files::to_json(&file).expect("numbers and strings serialise")
}

fn entries(campaign: &Campaign) -> Vec<Entry<'_>> {
    let mut entries = Vec::new();
    for covered in campaign.coverage() {
        for (station, seen) in covered.seen.iter().enumerate() {
            let lengths = campaign.lengths.as_ref();
            entries.push(Entry {
                run: covered.run.map(|run| campaign.runs[run].name.as_str()),
                target: &campaign.targets[covered.target].name,
                station: lengths.map(|_| campaign.stations[station].name.as_str()),
                readings: seen.readings,
                steps: seen.steps,
                steps_of_run: covered.steps_of_run,
                hole: covered.hole(station).map(|hole| match hole {
                    Hole::NotSeen => "not seen",
                    Hole::Steps => "steps",
                    Hole::Readings => "readings",
                }),
            });
        }
    }
    entries
}

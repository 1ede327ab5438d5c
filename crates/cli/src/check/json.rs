//! What `check --json` prints.

use serde_json::{Value, json};
use trueaxis_campaign::{Campaign, Hole};
use trueaxis_files::value_to_json;

/// The text of the document.
pub(super) fn text(campaign: &Campaign, notices: &[String]) -> String {
    let stops = campaign.stops();
    let document = json!({
        "format": "trueaxis-check",
        "version": 1,
        "campaign": campaign.name,
        "readings": stops.last().map_or(0, |stop| stop.readings.end),
        "stops": stops.len(),
        "coverage": entries(campaign),
        "notices": notices,
    });
    value_to_json(&document)
}

/// Targets on the bed have no run, those of a points campaign no station.
fn entries(campaign: &Campaign) -> Vec<Value> {
    let mut entries = Vec::new();
    for covered in campaign.coverage() {
        for (station, seen) in covered.seen.iter().enumerate() {
            let lengths = campaign.lengths.as_ref();
            entries.push(json!({
                "run": covered.run.map(|run| &campaign.runs[run].name),
                "target": campaign.targets[covered.target].name,
                "station": lengths.map(|_| &campaign.stations[station].name),
                "readings": seen.readings,
                "steps": seen.steps,
                "steps_of_run": covered.steps_of_run,
                "hole": covered.hole(station).map(|hole| match hole {
                    Hole::NotSeen => "not seen",
                    Hole::Steps => "steps",
                    Hole::Readings => "readings",
                }),
            }));
        }
    }
    entries
}

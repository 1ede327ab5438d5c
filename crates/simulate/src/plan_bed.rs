//! Targets on the bed: which, and when they are read.

use trueaxis_campaign::Target;

use crate::check;
use crate::plan_runs::PlannedRun;
use crate::{Error, Scenario};

/// The targets on the bed, and before which sweeps of an occupation they are read.
#[derive(Debug, Default)]
pub(crate) struct PlannedBed {
    pub(crate) targets: Vec<usize>,
    /// Ascending; the number of all sweeps is their end.
    before_sweeps: Vec<usize>,
}

impl PlannedBed {
    /// Whether they are read before a sweep of an occupation, by its number.
    pub(crate) fn is_read_before(&self, sweep: usize) -> bool {
        self.before_sweeps.binary_search(&sweep).is_ok()
    }
}

/// Fewest readings: at the start and at the end.
const FEWEST: u32 = 2;

pub(crate) fn plan_bed(
    scenario: &Scenario,
    targets: &[Target],
    runs: &[PlannedRun],
) -> Result<PlannedBed, Error> {
    let on_bed = (0..targets.len()).filter(|&t| targets[t].carrier.is_none());
    let on_bed: Vec<usize> = on_bed.collect();
    let spec = match (&scenario.bed, on_bed.first()) {
        (None, None) => return Ok(PlannedBed::default()),
        (None, Some(_)) => {
            return Err(check::expected("bed", "when targets on the bed are read"));
        }
        (Some(_), None) => {
            let expected = "a target on the bed (`carried_by` null), or no field `bed`";
            return Err(check::expected("bed", expected));
        }
        (Some(spec), Some(_)) => spec,
    };
    let of_repeat: usize = runs.iter().map(|run| run.directions.len()).sum();
    let sweeps = of_repeat * scenario.repeats as usize;
    let readings = spec.readings as usize;
    if spec.readings < FEWEST || readings > sweeps + 1 {
        let most = sweeps + 1;
        let expected = format!("{FEWEST} to {most}: before, between and after {sweeps} sweeps");
        return Err(check::expected("bed.readings", expected));
    }
    let between = readings - 1;
    Ok(PlannedBed {
        targets: on_bed,
        // Rounded to the nearest.
        before_sweeps: (0..readings)
            .map(|i| (2 * i * sweeps + between) / (2 * between))
            .collect(),
    })
}

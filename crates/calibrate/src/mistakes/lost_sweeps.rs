//! Sweeps of which most lengths were removed: more than accidents.

use std::collections::{BTreeMap, BTreeSet};

use crate::mistakes::Mistakes;
use crate::mistakes::scope::Scope;
use crate::result::calibration::Calibration;

/// Share of the lengths of a sweep to one target, from which on it was lost as a whole.
const LOST: f64 = 0.5;

/// Fewer removed lengths may be accidents.
const LEAST: usize = 5;

/// A sweep: station, run, repeat.
type Sweep = (usize, usize, u32);

impl Mistakes<'_> {
    /// For each sweep that was lost to targets what was lost, and which mistake would explain it.
    pub(crate) fn lost_sweeps(&self, calibration: &Calibration) -> Vec<String> {
        let campaign = self.campaign;
        let Some(lengths) = &campaign.lengths else {
            return Vec::new();
        };
        let rejected = calibration.adjustment.rejected.iter();
        let rejected: BTreeSet<usize> = rejected.map(|rejected| rejected.line).collect();
        if rejected.len() < LEAST {
            return Vec::new();
        }
        // Lengths and removed ones by sweep and target.
        let mut counts: BTreeMap<(Sweep, usize), [usize; 2]> = BTreeMap::new();
        for stop in &lengths.stops {
            // Targets on the bed are in no sweep.
            let Some(run) = campaign.steps[stop.step].run else {
                continue;
            };
            let sweep = (stop.station, run, stop.repeat);
            for reading in &lengths.readings[stop.readings.clone()] {
                let [all, removed] = counts.entry((sweep, reading.target)).or_default();
                *all += 1;
                *removed += usize::from(rejected.contains(&reading.line));
            }
        }
        let mut lost: BTreeMap<Sweep, Vec<usize>> = BTreeMap::new();
        for (&(sweep, target), &[all, removed]) in &counts {
            if removed >= LEAST && removed as f64 >= LOST * all as f64 {
                lost.entry(sweep).or_default().push(target);
            }
        }
        let notice = |(sweep, targets): (Sweep, Vec<usize>)| {
            let (station, run, repeat) = sweep;
            let removed = targets.iter().map(|&target| counts[&(sweep, target)][1]);
            let names = targets.iter().map(|&t| campaign.targets[t].name.as_str());
            let scope = Scope {
                station: Some(station),
                run: Some(run),
                repeat: Some(repeat),
            };
            let explanation = self.explanation_within(&scope);
            format!(
                "a whole sweep was thrown away: {} lengths to {} {} contradict all others; {}",
                removed.sum::<usize>(),
                names.collect::<Vec<_>>().join(", "),
                scope.in_words(campaign),
                explanation.map_or_else(
                    || "find out what happened before you use the results".to_owned(),
                    |found| format!("this would explain it: {found}"),
                )
            )
        };
        lost.into_iter().map(notice).collect()
    }
}

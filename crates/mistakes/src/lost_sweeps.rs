//! Sweeps of which most lengths were removed: more than accidents.

use std::collections::{BTreeMap, BTreeSet};

use crate::scope::Scope;
use crate::search::Mistakes;

/// Share of the lengths of a sweep to one target, from which on it was lost as a whole.
const LOST: f64 = 0.5;

/// Fewer removed lengths may be accidents.
const LEAST: usize = 5;

impl Mistakes<'_> {
    /// For each sweep that was lost to targets what was lost, and which mistake would explain it: `rejected` are the lines
    /// of the lengths that were removed.
    pub fn lost_sweeps(&self, rejected: &BTreeSet<usize>) -> Vec<String> {
        let campaign = self.campaign;
        let Some(lengths) = &campaign.lengths else {
            return Vec::new();
        };
        if rejected.len() < LEAST {
            return Vec::new();
        }
        // Lengths and removed ones by sweep and target.
        let mut counts: BTreeMap<(Scope, usize), [usize; 2]> = BTreeMap::new();
        for stop in &lengths.stops {
            let sweep = Scope {
                station: Some(stop.station),
                run: campaign.steps[stop.step].run,
                repeat: Some(stop.repeat),
            };
            // Targets on the bed are in no sweep.
            for reading in &lengths.readings[stop.readings.clone()] {
                if sweep.run.is_some() {
                    let [all, removed] = counts.entry((sweep, reading.target)).or_default();
                    *all += 1;
                    *removed += usize::from(rejected.contains(&reading.line));
                }
            }
        }
        let mut lost: BTreeMap<Scope, (Vec<&str>, usize)> = BTreeMap::new();
        for ((sweep, target), [all, removed]) in counts {
            if removed >= LEAST && removed as f64 >= LOST * all as f64 {
                let (targets, lengths) = lost.entry(sweep).or_default();
                targets.push(&campaign.targets[target].name);
                *lengths += removed;
            }
        }
        let notice = |(sweep, (targets, lengths)): (Scope, (Vec<&str>, usize))| {
            let explanation = self.explanation_within(&sweep);
            format!(
                "a whole sweep was thrown away: {lengths} lengths to {} {} contradict all others; {}",
                targets.join(", "),
                sweep.in_words(campaign),
                explanation.map_or_else(
                    || "find out what happened before you use the results".to_owned(),
                    |found| format!("this would explain it: {found}"),
                )
            )
        };
        lost.into_iter().map(notice).collect()
    }
}

//! Where a mistake may have been made.

use std::collections::BTreeSet;

use rayon::prelude::*;
use trueaxis_campaign::Campaign;

use crate::mistakes::scope::Scope;

/// What becomes of the lengths if a part of them is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LeftOut {
    /// They fit: the mistake is in the part.
    Fits,
    /// They contradict each other: it is not, or not only.
    Contradicts,
    /// They are too few to tell.
    Open,
}

/// Parts of the measurement.
pub(crate) struct Places {
    /// Whether they are of the whole measurement.
    pub(crate) anywhere: bool,
    pub(crate) scopes: Vec<Scope>,
}

impl Places {
    /// The parts within another one, from what becomes of the rest without them.
    pub(crate) fn new(
        campaign: &Campaign,
        within: &Scope,
        left_out: impl Fn(Scope) -> LeftOut + Sync,
    ) -> Self {
        let stops = campaign.lengths.iter().flat_map(|lengths| &lengths.stops);
        let repeats: BTreeSet<u32> = stops.map(|stop| stop.repeat).collect();
        let repeats: Vec<u32> = repeats.into_iter().collect();
        let runs: Vec<usize> = (0..campaign.runs.len()).collect();
        let runs = one_of(within.run, &runs, |run| {
            let run = Some(run);
            left_out(Scope { run, ..*within })
        });
        let repeats = one_of(within.repeat, &repeats, |repeat| {
            let repeat = Some(repeat);
            left_out(Scope { repeat, ..*within })
        });
        let stations: Vec<Option<usize>> = match within.station {
            Some(station) => vec![Some(station)],
            None => std::iter::once(None)
                .chain((0..campaign.stations.len()).map(Some))
                .collect(),
        };
        let mut scopes = Vec::new();
        for &repeat in &repeats {
            for &run in &runs {
                scopes.extend(stations.iter().map(|&station| Scope {
                    station,
                    run,
                    repeat,
                }));
            }
        }
        Self {
            anywhere: *within == Scope::default(),
            scopes,
        }
    }
}

/// The one that is given; else those of several without which the rest fits; else all together, and those of which
/// nothing is known.
fn one_of<T: Copy + Sync + Send>(
    given: Option<T>,
    several: &[T],
    left_out: impl Fn(T) -> LeftOut + Sync,
) -> Vec<Option<T>> {
    if given.is_some() || several.len() < 2 {
        return vec![given];
    }
    let outcomes: Vec<(T, LeftOut)> = several
        .par_iter()
        .map(|&one| (one, left_out(one)))
        .collect();
    let which = |outcome: LeftOut| {
        let some = outcomes.iter().filter(move |(_, found)| *found == outcome);
        some.map(|&(one, _)| Some(one))
    };
    let in_one: Vec<Option<T>> = which(LeftOut::Fits).collect();
    match in_one.is_empty() {
        true => std::iter::once(None).chain(which(LeftOut::Open)).collect(),
        false => in_one,
    }
}

//! All mistakes that are tried, the simplest first.

use std::collections::BTreeSet;

use rayon::prelude::*;
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::AxisKind;

use crate::mistake::{Mistake, What};
use crate::scope::Scope;
use crate::setups::setups;

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

/// The suspects within a part of the measurement, by the size of the place where each was made: those made everywhere
/// first, and constants of any size last. `left_out` says what becomes of the lengths without a part.
pub(crate) fn suspects(
    campaign: &Campaign,
    within: &Scope,
    left_out: impl Fn(Scope) -> LeftOut + Sync,
) -> Vec<Vec<Mistake>> {
    let scopes = scopes(campaign, within, left_out);
    let mut all: Vec<Mistake> = Vec::new();
    let mut add = |what: What, scope: Scope| all.push(Mistake { what, scope });
    let everywhere = Scope::default();
    if *within == everywhere {
        let axes: BTreeSet<usize> = campaign.runs.iter().map(|run| run.axis).collect();
        for &axis in &axes {
            let of_kind = factors(campaign.machine.axes()[axis].kind());
            for &factor in of_kind {
                add(What::AxisScaled(axis, factor), everywhere);
            }
            let of_axis = |run: &usize| campaign.runs[*run].axis == axis;
            let runs: Vec<usize> = (0..campaign.runs.len()).filter(of_axis).collect();
            for &run in runs.iter().filter(|_| runs.len() > 1) {
                let run = Some(run);
                add(What::AxisScaled(axis, -1.0), Scope { run, ..everywhere });
            }
        }
        for setup in setups(campaign) {
            add(What::Setup(Box::new(setup)), everywhere);
        }
    }
    for &scope in &scopes {
        if scope.run.is_none() && scope.repeat.is_none() && campaign.lengths.is_some() {
            add(What::LengthsReversed, scope);
        }
    }
    let targets = pairs_of_targets(campaign);
    for &scope in &scopes {
        for &pair in &targets {
            add(What::TargetsExchanged(pair), scope);
        }
    }
    let parts = scopes.iter().filter(|scope| **scope != everywhere);
    for &scope in parts.clone().filter(|scope| scope.station.is_none()) {
        for a in 0..campaign.stations.len() {
            for b in a + 1..campaign.stations.len() {
                add(What::StationsExchanged([a, b]), scope);
            }
        }
    }
    // Not everywhere: there it is the constant of the reflector.
    let mut offsets = Vec::new();
    for &scope in parts {
        for target in (0..campaign.targets.len()).filter(|&t| is_read(campaign, t, &scope)) {
            let (offset_mm, u_mm) = (0.0, 0.0);
            let what = What::Offset {
                target,
                offset_mm,
                u_mm,
            };
            offsets.push(Mistake { what, scope });
        }
    }
    [by_size(all), by_size(offsets)].concat()
}

/// Mistakes in order of the number of parts that make the place, those with the same number together; what is wrong in several
/// entries of the campaign comes after what is wrong in one.
fn by_size(mut all: Vec<Mistake>) -> Vec<Vec<Mistake>> {
    let size = |mistake: &Mistake| {
        let is_rebuilt = matches!(&mistake.what, What::Setup(setup) if setup.is_rebuilt);
        (mistake.scope.parts(), is_rebuilt)
    };
    all.sort_by_key(size);
    let alike = all.chunk_by(|a, b| size(a) == size(b));
    alike.map(<[_]>::to_vec).collect()
}

/// The parts in which a mistake may have been made. If the lengths fit without those of a run, it was made there and
/// nowhere else; if they do so without none of the runs, it was made in several. The same of repeats. A station
/// cannot be left out so easily. All together are a place in any case: without the run that tells a machine from its
/// mirror image, a mistake that mirrors it leaves no contradiction.
fn scopes(
    campaign: &Campaign,
    within: &Scope,
    left_out: impl Fn(Scope) -> LeftOut + Sync,
) -> Vec<Scope> {
    let stops = campaign.stops().iter();
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
    if !scopes.contains(within) {
        scopes.insert(0, *within);
    }
    scopes
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
    let outcomes: Vec<LeftOut> = several.par_iter().map(|&one| left_out(one)).collect();
    let which = |outcome: LeftOut| {
        let some = several.iter().zip(&outcomes);
        some.filter_map(move |(&one, found)| (*found == outcome).then_some(Some(one)))
    };
    let in_one: Vec<Option<T>> = which(LeftOut::Fits).collect();
    match in_one.is_empty() {
        true => std::iter::once(None).chain(which(LeftOut::Open)).collect(),
        false => in_one,
    }
}

/// Whether there are lengths to a target in a part.
fn is_read(campaign: &Campaign, target: usize, scope: &Scope) -> bool {
    let mut readings = scope
        .stops(campaign)
        .flat_map(|stop| campaign.sightings(stop));
    campaign.lengths.is_some() && readings.any(|seen| seen.target == target)
}

/// Targets that could be taken for each other: those that are read at the same stops.
fn pairs_of_targets(campaign: &Campaign) -> BTreeSet<[usize; 2]> {
    let mut pairs = BTreeSet::new();
    for stop in campaign.stops() {
        let read: Vec<usize> = campaign.sightings(stop).map(|seen| seen.target).collect();
        for (i, &a) in read.iter().enumerate() {
            let others = read[i + 1..].iter().filter(|b| **b != a);
            pairs.extend(others.map(|&b| [a.min(b), a.max(b)]));
        }
    }
    pairs
}

/// How many times as far as commanded an axis may move: reversed; diameters, inches; degrees and radians.
fn factors(kind: AxisKind) -> &'static [f64] {
    const RADIAN: f64 = 180.0 / std::f64::consts::PI;
    match kind {
        AxisKind::Linear => &[-1.0, 0.5, 2.0, 25.4, 1.0 / 25.4],
        AxisKind::Rotary => &[-1.0, RADIAN, 1.0 / RADIAN],
    }
}

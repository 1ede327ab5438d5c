//! All mistakes that are tried, the simplest first.

use std::collections::BTreeSet;

use trueaxis_campaign::Campaign;

use crate::mistakes::mistake::Mistake;
use crate::mistakes::places::Places;
use crate::mistakes::scope::Scope;

/// The suspects in some places, by the size of the place: those made everywhere first.
pub(crate) fn suspects(campaign: &Campaign, places: &Places) -> Vec<Vec<Mistake>> {
    let pairs = pairs_of_targets(campaign);
    let inside = places.scopes.iter();
    let mut all: Vec<Mistake> = Vec::new();
    if places.anywhere {
        let axes: BTreeSet<usize> = campaign.runs.iter().map(|run| run.axis).collect();
        for &axis in &axes {
            all.push(Mistake::AxisReversed { axis, run: None });
            let runs = (0..campaign.runs.len()).filter(|&run| campaign.runs[run].axis == axis);
            let runs: Vec<usize> = runs.collect();
            let single = runs.iter().filter(|_| runs.len() > 1);
            all.extend(single.map(|&run| Mistake::AxisReversed {
                axis,
                run: Some(run),
            }));
        }
        all.extend(nominals_away(campaign));
    }
    let of_station = |scope: &&Scope| scope.run.is_none() && scope.repeat.is_none();
    let whole_stations = inside.clone().filter(of_station);
    all.extend(whole_stations.map(|&scope| Mistake::LengthsReversed { scope }));
    for &scope in inside.clone() {
        let exchanged = |&targets: &[usize; 2]| Mistake::TargetsExchanged { targets, scope };
        all.extend(pairs.iter().map(exchanged));
    }
    for &scope in inside.filter(|scope| scope.station.is_none() && **scope != Scope::default()) {
        for a in 0..campaign.stations.len() {
            for b in a + 1..campaign.stations.len() {
                let stations = [a, b];
                all.push(Mistake::StationsExchanged { stations, scope });
            }
        }
    }
    by_size(all, Mistake::parts)
}

/// Places in order of the number of parts that make them, those with the same number together.
fn by_size<T: Clone>(mut all: Vec<T>, parts: impl Fn(&T) -> usize) -> Vec<Vec<T>> {
    all.sort_by_key(&parts);
    let alike = all.chunk_by(|a, b| parts(a) == parts(b));
    alike.map(<[T]>::to_vec).collect()
}

/// Targets, and where their lengths may all be off alike, by the size of the place: not everywhere, for there that
/// is the constant of the reflector.
pub(crate) fn offset_scopes(campaign: &Campaign, places: &Places) -> Vec<Vec<(usize, Scope)>> {
    let scopes = places.scopes.iter().copied();
    let inside = scopes.filter(|scope| *scope != Scope::default());
    let read = |target: usize, scope: &Scope| {
        campaign.lengths.as_ref().is_some_and(|lengths| {
            let stops = lengths.stops.iter();
            let mut inside = stops.filter(|stop| scope.holds(campaign, stop));
            inside.any(|stop| {
                let readings = &lengths.readings[stop.readings.clone()];
                readings.iter().any(|reading| reading.target == target)
            })
        })
    };
    let targets = 0..campaign.targets.len();
    let places = inside.flat_map(|scope| targets.clone().map(move |target| (target, scope)));
    let places = places.filter(|(target, scope)| read(*target, scope));
    by_size(places.collect(), |(_, scope)| scope.parts())
}

/// Targets that could be taken for each other: those that are read at the same stops.
fn pairs_of_targets(campaign: &Campaign) -> Vec<[usize; 2]> {
    let mut pairs = BTreeSet::new();
    if let Some(lengths) = &campaign.lengths {
        for stop in &lengths.stops {
            let read = &lengths.readings[stop.readings.clone()];
            for (i, a) in read.iter().enumerate() {
                for b in &read[i + 1..] {
                    pairs.insert([a.target.min(b.target), a.target.max(b.target)]);
                }
            }
        }
    }
    pairs.into_iter().filter(|[a, b]| a != b).collect()
}

/// Where the axes stood at the beginning of runs, if not all at home.
fn nominals_away(campaign: &Campaign) -> Vec<Mistake> {
    let mut places: Vec<Vec<f64>> = Vec::new();
    for run in 0..campaign.runs.len() {
        let first = campaign.steps.iter().find(|step| step.run == Some(run));
        let Some(first) = first else { continue };
        let mut parked = first.positions.clone();
        parked[campaign.runs[run].axis] = 0.0;
        for place in [first.positions.clone(), parked] {
            let away = place.iter().any(|position| position.abs() > 0.0);
            if away && !places.contains(&place) {
                places.push(place);
            }
        }
    }
    let mistakes = places.into_iter();
    mistakes
        .map(|positions| Mistake::NominalsAway { positions })
        .collect()
}

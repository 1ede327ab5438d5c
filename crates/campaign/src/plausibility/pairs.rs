//! Pairs of readings whose nominal distance limits what may be measured between them.

use std::collections::BTreeMap;

use nalgebra::Point3;

use super::hypothesis::Hypothesis;
use super::nominal::NominalPoints;
use crate::reading::{Reading, readings_of};
use crate::{Campaign, Lengths, Points, Stop};

/// How much more than nominal a target may move: axis directions and pivots are rough.
const MOTION_FACTOR: f64 = 1.2;

/// The same for targets that hardly move, mm: they are mounted by hand.
const MOUNTING_SLACK_MM: f64 = 10.0;

/// Part of the motion that must be seen in lengths, somewhere, if their unit is right.
const VISIBLE_PART: f64 = 0.02;

/// The telling pairs of a campaign.
pub(crate) struct Pairs {
    pairs: Vec<Pair>,
    /// Points are as far apart as nominal; lengths may change less than the target moves.
    both_ways: bool,
}

/// Targets on the bed, in place of a run: they stand still.
const BED: usize = usize::MAX;

/// Which pairs contradict the nominal motion.
pub(crate) struct Judgement<'p> {
    /// The pair that contradicts most, among pervasive ones if there are any.
    pub(crate) worst: Option<&'p Pair>,
    /// Runs in which some pair does.
    pub(crate) touched_runs: Vec<usize>,
    /// Runs in which most pairs do.
    pub(crate) runs: Vec<usize>,
    /// Stations from which most pairs do.
    pub(crate) stations: Vec<usize>,
}

impl Judgement<'_> {
    /// Whether it is more than single rows.
    pub(crate) fn is_pervasive(&self) -> bool {
        !(self.runs.is_empty() && self.stations.is_empty())
    }
}

impl Pairs {
    /// For each station, run, repeat and target the two readings whose lengths differ most. An
    /// interferometer that is set to zero again between repeats or runs contradicts nothing.
    pub(crate) fn of_lengths(lengths: &Lengths, campaign: &Campaign) -> Self {
        let mut extremes: BTreeMap<_, [(f64, End); 2]> = BTreeMap::new();
        for stop in &lengths.stops {
            let run = run_of(stop, campaign);
            for reading in readings_of(stop, &lengths.readings) {
                let end = End::of(stop, reading);
                let length = (reading.length_mm, end);
                let series = (stop.station, run, stop.repeat, reading.target);
                let [shortest, longest] = extremes.entry(series).or_insert([length; 2]);
                if length.0 < shortest.0 {
                    *shortest = length;
                }
                if length.0 > longest.0 {
                    *longest = length;
                }
            }
        }
        let pairs = extremes.into_iter().map(|((station, run, ..), [a, b])| {
            let observed_mm = b.0 - a.0;
            Pair::new(station, run, a.1, b.1, observed_mm)
        });
        Self {
            pairs: pairs.collect(),
            both_ways: false,
        }
    }

    /// For each run and target the first reading with the one measured farthest from it, and with
    /// the one nominally farthest from it; and the first readings of different targets.
    pub(crate) fn of_points(points: &Points, campaign: &Campaign, nominal: &NominalPoints) -> Self {
        let mut series: BTreeMap<(usize, usize), Vec<Measured>> = BTreeMap::new();
        for stop in &points.stops {
            let run = run_of(stop, campaign);
            for reading in readings_of(stop, &points.readings) {
                let end = End::of(stop, reading);
                let measured = series.entry((run, reading.target)).or_default();
                measured.push((end, reading.position_mm));
            }
        }
        let mut pairs = Vec::new();
        let mut neighbour: Option<(usize, Measured)> = None;
        for (&(run, _), measured) in &series {
            let Some(&first) = measured.first() else {
                continue;
            };
            let measured_mm = |m: &Measured| nalgebra::distance(&first.1, &m.1);
            let nominal_mm = |m: &Measured| nominal.between_mm(&first.0, &m.0);
            let mut add = |other: &Measured| {
                pairs.push(Pair::new(0, run, first.0, other.0, measured_mm(other)));
            };
            let farthest = |distance_mm: &dyn Fn(&Measured) -> f64| {
                let farther =
                    |a: &&Measured, b: &&Measured| f64::total_cmp(&distance_mm(a), &distance_mm(b));
                measured.iter().max_by(farther)
            };
            farthest(&measured_mm).into_iter().for_each(&mut add);
            farthest(&nominal_mm).into_iter().for_each(&mut add);
            if let Some((_, other)) = neighbour.filter(|&(other_run, _)| other_run == run) {
                add(&other);
            }
            neighbour = Some((run, first));
        }
        Self {
            pairs,
            both_ways: true,
        }
    }

    /// Counts the pairs that contradict the nominal motion if the data are read by `hypothesis`.
    pub(crate) fn judge(&self, nominal: &NominalPoints, hypothesis: &Hypothesis) -> Judgement<'_> {
        let mut runs: BTreeMap<usize, Tally> = BTreeMap::new();
        let mut stations: BTreeMap<usize, Tally> = BTreeMap::new();
        let mut contradictions = Vec::new();
        for pair in &self.pairs {
            let excess_mm = self.excess_mm(pair, nominal, hypothesis);
            runs.entry(pair.run).or_default().count(excess_mm > 0.0);
            let station = stations.entry(pair.station).or_default();
            station.count(excess_mm > 0.0);
            if excess_mm > 0.0 {
                contradictions.push((excess_mm, pair));
            }
        }
        let touched = runs.iter().filter(|(_, tally)| tally.contradictions > 0);
        let touched_runs = touched.map(|(&run, _)| run).collect();
        let runs = mostly_contradicting(runs);
        let stations = mostly_contradicting(stations);
        let is_pervasive = |p: &Pair| runs.contains(&p.run) || stations.contains(&p.station);
        let worst = contradictions.into_iter().max_by(|(a_mm, a), (b_mm, b)| {
            let order = is_pervasive(a).cmp(&is_pervasive(b));
            order.then(a_mm.total_cmp(b_mm))
        });
        Judgement {
            worst: worst.map(|(_, pair)| pair),
            touched_runs,
            runs,
            stations,
        }
    }

    /// By how much a pair is beyond what the motion allows, mm.
    fn excess_mm(&self, pair: &Pair, nominal: &NominalPoints, hypothesis: &Hypothesis) -> f64 {
        let observed_mm = pair.observed_mm * hypothesis.measured_factor(pair.station);
        let nominal_mm = nominal.distance_mm(pair);
        let beyond = |a_mm: f64, b_mm: f64| a_mm - MOTION_FACTOR * b_mm - MOUNTING_SLACK_MM;
        let excess_mm = beyond(observed_mm, nominal_mm);
        if self.both_ways {
            excess_mm.max(beyond(nominal_mm, observed_mm))
        } else {
            excess_mm
        }
    }

    /// Whether some pair that the hypothesis is about sees a fair part of the motion: without
    /// this, any unit small enough would explain lengths that change too much. Points see all of it.
    pub(crate) fn show_motion(&self, nominal: &NominalPoints, hypothesis: &Hypothesis) -> bool {
        let part = if self.both_ways {
            1.0 / MOTION_FACTOR
        } else {
            VISIBLE_PART
        };
        let concerned = self.pairs.iter().filter(|p| hypothesis.is_about(p.station));
        concerned.into_iter().any(|pair| {
            let observed_mm = pair.observed_mm * hypothesis.measured_factor(pair.station);
            let nominal_mm = nominal.distance_mm(pair);
            nominal_mm > MOUNTING_SLACK_MM && observed_mm > part * nominal_mm
        })
    }
}

type Measured = (End, Point3<f64>);

/// Two readings, and what was measured between them.
#[derive(Debug, Clone)]
pub(crate) struct Pair {
    /// Station of both.
    pub(crate) station: usize,
    /// Run of both.
    pub(crate) run: usize,
    /// The readings, the earlier row first.
    pub(crate) ends: [End; 2],
    /// Change of the length, or distance of the points, mm.
    pub(crate) observed_mm: f64,
}

/// One of the two readings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct End {
    pub(crate) step: usize,
    pub(crate) target: usize,
    pub(crate) line: usize,
}

impl End {
    fn of(stop: &Stop, reading: &impl Reading) -> Self {
        Self {
            step: stop.step,
            target: reading.target(),
            line: reading.line(),
        }
    }
}

impl Pair {
    fn new(station: usize, run: usize, a: End, b: End, observed_mm: f64) -> Self {
        let ends = if a.line <= b.line { [a, b] } else { [b, a] };
        Self {
            station,
            run,
            ends,
            observed_mm,
        }
    }
}

fn run_of(stop: &Stop, campaign: &Campaign) -> usize {
    campaign.steps[stop.step].run.unwrap_or(BED)
}

/// Pairs of a group, and how many of them contradict.
#[derive(Default)]
struct Tally {
    pairs: usize,
    contradictions: usize,
}

impl Tally {
    fn count(&mut self, contradicts: bool) {
        self.pairs += 1;
        self.contradictions += usize::from(contradicts);
    }
}

fn mostly_contradicting(groups: BTreeMap<usize, Tally>) -> Vec<usize> {
    let groups = groups.into_iter();
    let groups = groups.filter(|(_, tally)| 2 * tally.contradictions > tally.pairs);
    groups.map(|(group, _)| group).collect()
}

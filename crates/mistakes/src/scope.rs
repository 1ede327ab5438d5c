//! A part of the measurement in which a mistake may have been made, and the campaign without it.

use trueaxis_campaign::{Campaign, Sighting, Stop};

/// All stops of a station, a run, a repeat; those of all of them where `None`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(crate) struct Scope {
    pub(crate) station: Option<usize>,
    pub(crate) run: Option<usize>,
    pub(crate) repeat: Option<u32>,
}

impl Scope {
    pub(crate) fn holds(&self, campaign: &Campaign, stop: &Stop) -> bool {
        let run = campaign.steps[stop.step].run;
        self.station.is_none_or(|station| station == stop.station)
            && (self.run.is_none() || self.run == run)
            && self.repeat.is_none_or(|repeat| repeat == stop.repeat)
    }

    pub(crate) fn stops<'a>(&'a self, campaign: &'a Campaign) -> impl Iterator<Item = &'a Stop> {
        let stops = campaign.stops().iter();
        stops.filter(|stop| self.holds(campaign, stop))
    }

    /// How many of station, run and repeat it is restricted to; 0 is everywhere.
    pub(crate) fn parts(&self) -> usize {
        usize::from(self.station.is_some())
            + usize::from(self.run.is_some())
            + usize::from(self.repeat.is_some())
    }

    /// `in repeat 2 of run x from station S1 (lines 12 to 80 of the lengths)`; `everywhere` for all of the measurement.
    pub(crate) fn in_words(&self, campaign: &Campaign) -> String {
        if *self == Self::default() {
            return "everywhere".to_owned();
        }
        let repeat = self.repeat.map(|repeat| format!("in repeat {repeat}"));
        let run = self.run.map(|run| {
            let of = if repeat.is_some() { "of" } else { "in" };
            format!("{of} run {}", campaign.runs[run].name)
        });
        let station = self
            .station
            .map(|station| format!("from station {}", campaign.stations[station].name));
        let parts: Vec<String> = [repeat, run, station].into_iter().flatten().collect();
        let sightings = self
            .stops(campaign)
            .flat_map(|stop| campaign.sightings(stop));
        let lines = sightings.fold([usize::MAX, 0], |[a, b], Sighting { line, .. }| {
            [a.min(line), b.max(line)]
        });
        let parts = parts.join(" ");
        let what = match campaign.lengths {
            Some(_) => "lengths",
            None => "points",
        };
        format!("{parts} (lines {} to {} of the {what})", lines[0], lines[1])
    }
}

/// Steps that are left of each run: enough to tell a line or a circle from what is none.
const STEPS: usize = 9;

/// The campaign with steps evenly taken from each run, ends included, and with the targets on the bed: so that many
/// mistakes can be tried.
pub(crate) fn thinned(campaign: &Campaign) -> Campaign {
    let steps = campaign.steps.iter();
    let mut kept: Vec<bool> = steps.map(|step| step.run.is_none()).collect();
    for run in 0..campaign.runs.len() {
        let is_of_run = |step: &usize| campaign.steps[*step].run == Some(run);
        let of_run: Vec<usize> = (0..kept.len()).filter(is_of_run).collect();
        let (last, count) = (of_run.len().saturating_sub(1), STEPS.min(of_run.len()));
        for i in 0..count {
            kept[of_run[i * last / (count - 1).max(1)]] = true;
        }
    }
    with_readings(campaign, |stop, _| kept[stop.step])
}

/// The campaign with some of its lengths or points only, told by their stop and target.
pub(crate) fn with_readings(campaign: &Campaign, keep: impl Fn(&Stop, usize) -> bool) -> Campaign {
    let mut changed = campaign.clone();
    let mut kept = Vec::new();
    let mut count = 0;
    let mut retain = |stop: &mut Stop| {
        let first = count;
        for Sighting { target, .. } in campaign.sightings(stop) {
            kept.push(keep(stop, target));
            count += usize::from(kept.last() == Some(&true));
        }
        stop.readings = first..count;
        !stop.readings.is_empty()
    };
    if let Some(lengths) = &mut changed.lengths {
        lengths.stops.retain_mut(&mut retain);
        of_kept(&mut lengths.readings, &kept);
        for column in &mut lengths.logged {
            of_kept(&mut column.values, &kept);
        }
    } else if let Some(points) = &mut changed.points {
        points.stops.retain_mut(&mut retain);
        of_kept(&mut points.readings, &kept);
    }
    changed
}

fn of_kept<T>(all: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    all.retain(|_| kept.next() == Some(&true));
}

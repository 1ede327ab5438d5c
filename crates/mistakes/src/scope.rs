//! A part of the measurement in which a mistake may have been made, and the campaign without it.

use trueaxis_campaign::{Campaign, LengthReading, Lengths, Stop};

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

    /// Its stops.
    pub(crate) fn stops<'a>(
        &'a self,
        campaign: &'a Campaign,
        lengths: &'a Lengths,
    ) -> impl Iterator<Item = &'a Stop> {
        let stops = lengths.stops.iter();
        stops.filter(|stop| self.holds(campaign, stop))
    }

    /// How many of station, run and repeat it is restricted to; 0 is everywhere.
    pub(crate) fn parts(&self) -> usize {
        usize::from(self.station.is_some())
            + usize::from(self.run.is_some())
            + usize::from(self.repeat.is_some())
    }

    /// `in repeat 2 of run x from station S1 (lines 12 to 80 of the lengths)`; nothing for all of the measurement.
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
        let (mut first, mut last) = (usize::MAX, 0);
        if let Some(lengths) = &campaign.lengths {
            for stop in self.stops(campaign, lengths) {
                for reading in &lengths.readings[stop.readings.clone()] {
                    (first, last) = (first.min(reading.line), last.max(reading.line));
                }
            }
        }
        let parts = parts.join(" ");
        format!("{parts} (lines {first} to {last} of the lengths)")
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
    with_lengths(campaign, |stop, _| kept[stop.step])
}

/// The campaign with some of its lengths only.
pub(crate) fn with_lengths(
    campaign: &Campaign,
    keep: impl Fn(&Stop, &LengthReading) -> bool,
) -> Campaign {
    let mut changed = campaign.clone();
    let Some(lengths) = &mut changed.lengths else {
        return changed;
    };
    let all = std::mem::take(&mut lengths.readings);
    let mut kept = Vec::with_capacity(all.len());
    lengths.stops.retain_mut(|stop| {
        let (first, before) = (lengths.readings.len(), stop.clone());
        for reading in &all[before.readings.clone()] {
            kept.push(keep(&before, reading));
            if kept.last() == Some(&true) {
                lengths.readings.push(reading.clone());
            }
        }
        stop.readings = first..lengths.readings.len();
        !stop.readings.is_empty()
    });
    for column in &mut lengths.logged {
        let mut kept = kept.iter();
        column.values.retain(|_| kept.next() == Some(&true));
    }
    changed
}

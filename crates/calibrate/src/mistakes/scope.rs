//! A part of the measurement in which a mistake may have been made.

use trueaxis_campaign::{Campaign, LengthReading, Lengths, Stop};

/// All stops of a station, a run, a repeat; those of all of them where `None`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

    /// How many of station, run and repeat it is restricted to.
    pub(crate) fn parts(&self) -> usize {
        let given = [
            self.station.is_some(),
            self.run.is_some(),
            self.repeat.is_some(),
        ];
        given.into_iter().filter(|given| *given).count()
    }

    /// The campaign with stops of this part, and their readings, changed.
    pub(crate) fn changed(
        &self,
        campaign: &Campaign,
        change: impl Fn(&mut Stop, &mut [LengthReading]),
    ) -> Campaign {
        let mut changed = campaign.clone();
        if let Some(lengths) = &mut changed.lengths {
            let stops = lengths.stops.iter_mut();
            for stop in stops.filter(|stop| self.holds(campaign, stop)) {
                let readings = stop.readings.clone();
                change(stop, &mut lengths.readings[readings]);
            }
        }
        changed
    }

    /// The campaign without this part.
    pub(crate) fn left_out(&self, campaign: &Campaign) -> Campaign {
        with_lengths(campaign, |stop, _| !self.holds(campaign, stop))
    }

    /// The campaign without the lengths of this part to a target.
    pub(crate) fn without(&self, campaign: &Campaign, target: usize) -> Campaign {
        with_lengths(campaign, |stop, reading| {
            reading.target != target || !self.holds(campaign, stop)
        })
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
        let lines = campaign.lengths.iter().flat_map(|lengths| {
            let stops = lengths
                .stops
                .iter()
                .filter(|stop| self.holds(campaign, stop));
            stops.flat_map(|stop| {
                lengths.readings[stop.readings.clone()]
                    .iter()
                    .map(|r| r.line)
            })
        });
        let (first, last) = lines.fold((usize::MAX, 0), |(first, last), line| {
            (first.min(line), last.max(line))
        });
        format!(
            "{} (lines {first} to {last} of the lengths)",
            parts.join(" ")
        )
    }
}

/// The campaign with some of its lengths only.
pub(crate) fn with_lengths(
    campaign: &Campaign,
    keep: impl Fn(&Stop, &LengthReading) -> bool,
) -> Campaign {
    let Some(all) = &campaign.lengths else {
        return campaign.clone();
    };
    let mut lengths = Lengths {
        logged: all.logged.clone(),
        ..Lengths::default()
    };
    let mut kept = Vec::with_capacity(all.readings.len());
    for stop in &all.stops {
        let first = lengths.readings.len();
        for i in stop.readings.clone() {
            let reading = &all.readings[i];
            kept.push(keep(stop, reading));
            if kept[i] {
                lengths.readings.push(reading.clone());
            }
        }
        if lengths.readings.len() > first {
            lengths.stops.push(Stop {
                readings: first..lengths.readings.len(),
                ..stop.clone()
            });
        }
    }
    for column in &mut lengths.logged {
        let mut kept = kept.iter();
        column
            .values
            .retain(|_| kept.next().copied().unwrap_or(false));
    }
    Campaign {
        lengths: Some(lengths),
        ..campaign.clone()
    }
}

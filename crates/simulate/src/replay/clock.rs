//! The clock of a replay: it runs evenly, with the usual times of the campaign.

use trueaxis_campaign::Campaign;
use trueaxis_effects::GivenEffect;

use crate::Timing;

/// Times of the campaign's readings and of the same ones in a replay.
pub(super) struct Clock {
    campaign_s: Vec<f64>,
    replay_s: Vec<f64>,
    /// For each reading how it follows the one before in the replay; none where the replay has others
    /// between.
    before: Vec<Option<Transition>>,
}

/// From one reading to the next.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Transition {
    SameStop,
    NextStop,
    NextStation,
}

/// Clocks that differ by more than this get a notice, s.
const WORTH_A_WORD_S: f64 = 1.0;

/// Time of a reading in a file, s.
const RESOLUTION_S: f64 = 1e-3;

impl Clock {
    /// `places`: for each reading of the campaign its place in the replay.
    pub(super) fn of(campaign: &Campaign, replay: &Campaign, places: &[usize]) -> Self {
        let times = |campaign: &Campaign| -> Vec<f64> {
            let readings = campaign.lengths.iter().flat_map(|l| &l.readings);
            readings.map(|reading| reading.time_s).collect()
        };
        let mut stops = Vec::new();
        for (number, stop) in replay.lengths.iter().flat_map(|l| &l.stops).enumerate() {
            stops.extend(stop.readings.clone().map(|_| (stop.station, number)));
        }
        let replay_s = times(replay);
        let mut before = vec![None; places.len()];
        for (transition, pair) in before.iter_mut().skip(1).zip(places.windows(2)) {
            let (from, to) = (stops[pair[0]], stops[pair[1]]);
            *transition =
                (pair[0] + 1 == pair[1]).then_some(match (from.0 == to.0, from.1 == to.1) {
                    (true, true) => Transition::SameStop,
                    (true, false) => Transition::NextStop,
                    (false, _) => Transition::NextStation,
                });
        }
        Self {
            campaign_s: times(campaign),
            replay_s: places.iter().map(|&place| replay_s[place]).collect(),
            before,
        }
    }

    /// The usual times of the campaign.
    pub(super) fn timing(&self) -> Timing {
        let median = |wanted: Transition| {
            let pairs = self.campaign_s.windows(2).zip(self.before.iter().skip(1));
            let mut times_s: Vec<f64> = pairs
                .filter(|(_, transition)| **transition == Some(wanted))
                .map(|(pair, _)| pair[1] - pair[0])
                .collect();
            times_s.sort_by(f64::total_cmp);
            times_s.get(times_s.len() / 2).copied()
        };
        let to_ms = |s: f64| (s.max(0.0) / RESOLUTION_S).round() * RESOLUTION_S;
        let between_stops = median(Transition::NextStop).unwrap_or(0.0);
        let per_reading = median(Transition::SameStop)
            .unwrap_or(0.0)
            .min(between_stops);
        let per_move = between_stops - per_reading;
        let per_change = median(Transition::NextStation).unwrap_or(between_stops) - between_stops;
        let first_s = self.campaign_s.first().copied().unwrap_or(0.0);
        Timing {
            start_s: to_ms(first_s - per_move),
            per_reading_s: to_ms(per_reading),
            per_move_s: to_ms(per_move),
            per_station_change_s: to_ms(per_change),
        }
    }

    /// Puts instants between the same readings as in the campaign.
    pub(super) fn set_instants(&self, effects: &mut [GivenEffect]) {
        if self.largest_difference_s() <= RESOLUTION_S {
            return;
        }
        let parameters = effects.iter_mut().flat_map(|effect| &mut effect.parameters);
        for instant in parameters.filter(|parameter| parameter.name == "time") {
            let after = self.campaign_s.partition_point(|&t| t < instant.value);
            let (Some(&to), Some(from)) = (self.campaign_s.get(after), after.checked_sub(1)) else {
                continue;
            };
            let from_s = self.campaign_s[from];
            let part = (instant.value - from_s) / (to - from_s);
            instant.value =
                self.replay_s[from] + part * (self.replay_s[after] - self.replay_s[from]);
        }
    }

    pub(super) fn notice(&self) -> Option<String> {
        let difference_s = self.largest_difference_s();
        (difference_s > WORTH_A_WORD_S).then(|| {
            format!(
                "the clock of replay.json runs evenly and differs by up to {difference_s:.0} s from that of the \
                 campaign; instants stay between the same lengths"
            )
        })
    }

    fn largest_difference_s(&self) -> f64 {
        let pairs = self.campaign_s.iter().zip(&self.replay_s);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }
}

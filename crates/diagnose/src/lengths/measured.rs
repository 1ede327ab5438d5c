//! The lengths as the search for causes needs them.

use trueaxis_effects::{Layer, Scene, Shape};
use trueaxis_multilateration::Noise;
use trueaxis_selection::{DECISIVE, Hypothesis, Projection, Score, VisitTimes, is_rival};

use crate::Error;
use crate::engine::{Culprit, Measured, Suspect, TimeConstants, busy_s, duration_s, plausible};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::swapped::swapped;

/// From a hundredth of the campaign, or of the longest occupation of a station, to twice its length.
const TIME_CONSTANTS: TimeConstants = TimeConstants {
    parts: [0.01, 2.0],
    count: 24,
};

/// Lags behind a temperature to try besides none.
const LAGS: TimeConstants = TimeConstants {
    parts: [0.01, 1.0],
    count: 11,
};

impl Measured for Base<'_> {
    type Model = Adjusted;
    type Noise = Noise;

    /// False alarms in one of two hundred clean campaigns.
    const CAUSE_LEVEL: f64 = 0.005;
    const MOST_CAUSES: usize = 6;

    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn bare(model: &Adjusted) -> &Projection {
        &model.before_causes
    }

    fn projection(model: &Adjusted) -> &Projection {
        &model.projection
    }

    fn suspects(model: &Adjusted) -> &[Suspect] {
        &model.suspects
    }

    fn columns_mm<'m>(
        &'m self,
        model: &'m Adjusted,
    ) -> impl Fn(&Hypothesis, f64) -> Vec<Vec<f64>> + Sync + 'm {
        let observations = self.observations(&model.solution);
        move |hypothesis, shape| self.columns_at(&observations, hypothesis, shape)
    }

    fn whiten(&self, model: &Adjusted, column: &mut [f64]) {
        model.whitened.whiten(column);
    }

    fn visits(&self) -> Vec<VisitTimes> {
        let visits = self.network.visits.iter();
        let visits = visits.filter(|visit| !visit.readings.is_empty());
        let of_visit = |rows: &std::ops::Range<usize>| {
            let times = self.readings[rows.clone()].iter().map(|r| r.time_s);
            VisitTimes::new(rows.clone(), times)
        };
        visits.map(|visit| of_visit(&visit.readings)).collect()
    }

    fn shapes(&self, shape: Shape) -> Vec<f64> {
        let visits = self.visits();
        let parts: Vec<Vec<VisitTimes>> = match shape {
            Shape::SettlingTime => {
                let station = |visit: &VisitTimes| self.readings[visit.rows.start].station;
                let of_one = |one| visits.iter().filter(move |v| station(v) == one).cloned();
                let stations = 0..self.scene.stations.len();
                stations.map(|one| of_one(one).collect()).collect()
            }
            _ => vec![visits],
        };
        let longest = |time_s: fn(&[VisitTimes]) -> f64| {
            parts.iter().map(|part| time_s(part)).fold(0.0, f64::max)
        };
        let (busy_s, duration_s) = (longest(busy_s), longest(duration_s));
        let visits = parts.iter().map(Vec::len).max().unwrap_or(0);
        let list = |times: &TimeConstants| times.of(visits, busy_s, duration_s);
        match shape {
            Shape::Lag => [vec![0.0], list(&LAGS)].concat(),
            _ => list(&TIME_CONSTANTS),
        }
    }

    fn adjust(&self, suspects: Vec<Suspect>, noise: Option<Noise>) -> Result<Adjusted, Error> {
        self.adjust_from(None, suspects, noise)
    }

    /// What the other model absorbs is used again: causes of some µm over a metre change it by a millionth.
    fn adjust_near(&self, near: &Adjusted, suspects: Vec<Suspect>) -> Result<Adjusted, Error> {
        let near_if_projected = Some(near).filter(|near| near.is_projected());
        self.adjust_from(near_if_projected, suspects, Some(near.network.noise))
    }

    fn noise(model: &Adjusted) -> Noise {
        model.network.noise
    }

    fn exchanged(&self, suspects: &[Suspect]) -> Option<Vec<Suspect>> {
        swapped(self, suspects)
    }

    fn culprit(&self, suspect: &Suspect) -> Culprit {
        let (effect, subject) = (suspect.hypothesis.effect, suspect.hypothesis.subject);
        let during = || {
            let after = self.readings.iter().find(|r| r.time_s > suspect.shape);
            after.map_or(0, |r| r.station)
        };
        let at_an_instant = effect.shape == Shape::Instant;
        let is_of_stations = || {
            let all = effect.subjects(&self.scene);
            all.iter().any(|subject| subject.station.is_some())
        };
        if subject.carrier.is_some() {
            return Culprit::EveryOccupation;
        }
        match (subject.axis, subject.target, subject.station) {
            (Some(axis), _, _) => Culprit::Axis(axis, effect),
            (_, Some(target), _) => Culprit::Target(target, at_an_instant),
            (_, _, Some(station)) => Culprit::Station(station, at_an_instant),
            _ if at_an_instant => Culprit::Station(during(), true),
            _ if effect.moves_machine() || is_of_stations() => Culprit::EveryOccupation,
            _ => Culprit::Everything(effect),
        }
    }

    /// A temperature of the machine may have any coefficient, but not the refractive index of air.
    fn plausible(&self, hypothesis: &Hypothesis) -> Vec<Option<[f64; 2]>> {
        let is_limited =
            hypothesis.subject.column.is_some() && hypothesis.effect.layer == Layer::Instrument;
        let ranges = plausible(hypothesis, &self.scene).into_iter();
        ranges.map(|range| range.filter(|_| is_limited)).collect()
    }

    /// A logged temperature is an observation: if it explains the data better than time, it does so even if their
    /// courses are alike.
    fn is_alike(
        (leader, of_leader): (&Hypothesis, &Score),
        (other, of_other): (&Hypothesis, &Score),
        cosine: f64,
    ) -> bool {
        match leader.subject.column.is_some() == other.subject.column.is_some() {
            true => is_rival(of_leader, of_other, cosine),
            false => of_leader.two_ln_b - of_other.two_ln_b < DECISIVE,
        }
    }
}

//! The points as the search for causes needs them.

use trueaxis_effects::{Parameter, Scene, Shape};
use trueaxis_selection::{ALIKE, Hypothesis, Projection, Score, VisitTimes, is_rival};

use crate::Error;
use crate::engine::{Culprit, Measured, Suspect, TimeConstants, busy_s};
use crate::points::base::Base;
use crate::points::model::Model;
use crate::points::noise::Noise;

/// From a hundredth of the campaign to three times its length.
const TIME_CONSTANTS: TimeConstants = TimeConstants {
    parts: [0.01, 3.0],
    count: 20,
};

/// Plausible sudden and gradual displacements: those of a frame.
const FARTHEST_UM: [f64; 2] = [-5e3, 5e3];
const CREPT_UM: [f64; 2] = [-1e3, 1e3];

impl Measured for Base<'_> {
    type Model = Model;
    type Noise = Noise;

    /// With the level of the omnibus tests, and since [`Null`](trueaxis_selection::Null) underestimates scans over
    /// instants by a factor of about two, one of 150 clean campaigns raises an alarm.
    const CAUSE_LEVEL: f64 = 0.002;
    const MOST_CAUSES: usize = 4;

    fn scene(&self) -> &Scene {
        self.scene
    }

    fn bare(model: &Model) -> &Projection {
        &model.bare
    }

    fn projection(model: &Model) -> &Projection {
        &model.projection
    }

    fn suspects(model: &Model) -> &[Suspect] {
        &model.suspects
    }

    fn columns_mm<'m>(
        &'m self,
        _: &'m Model,
    ) -> impl Fn(&Hypothesis, f64) -> Vec<Vec<f64>> + Sync + 'm {
        |hypothesis, shape| self.columns_at(hypothesis, shape)
    }

    fn whiten(&self, model: &Model, column: &mut [f64]) {
        model.whiten(self, column);
    }

    fn visits(&self) -> Vec<VisitTimes> {
        let of_stop = |stop: &std::ops::Range<usize>| {
            let readings = self.readings.all[stop.clone()].iter();
            let times = readings.flat_map(|r| [r.time_s; 3]);
            VisitTimes::new(3 * stop.start..3 * stop.end, times)
        };
        self.readings.stops.iter().map(of_stop).collect()
    }

    fn shapes(&self, _: Shape) -> Vec<f64> {
        let elapsed = self.readings.all.iter().map(|r| r.elapsed_s);
        let duration_s = elapsed.fold(0.0, f64::max);
        TIME_CONSTANTS.of(
            self.readings.stops.len(),
            busy_s(&self.visits()),
            duration_s,
        )
    }

    fn adjust(&self, suspects: Vec<Suspect>, noise: Option<Noise>) -> Result<Model, Error> {
        let columns = self.columns_of(&suspects);
        let model = match noise {
            None => Model::estimated(self, &columns),
            Some(noise) => Model::with(self, &columns, noise, None),
        };
        Ok(model.fitted(self, suspects))
    }

    fn noise(model: &Model) -> Noise {
        model.noise
    }

    /// A displacement without a range of its own is at most that of a frame that somebody bumped: farther off it is
    /// another point, and everything here is linear.
    fn plausible(&self, hypothesis: &Hypothesis) -> Vec<Option<[f64; 2]>> {
        let of = hypothesis.parameters(self.scene);
        let farthest_um = match hypothesis.effect.shape {
            Shape::Instant => FARTHEST_UM,
            _ => CREPT_UM,
        };
        let range = |p: &Parameter| p.plausible.or((p.unit == "um").then_some(farthest_um));
        of.iter().map(range).collect()
    }

    /// The machine as a whole and the frame of the instrument have the same courses in time.
    fn culprit(&self, suspect: &Suspect) -> Culprit {
        let (effect, subject) = (suspect.hypothesis.effect, suspect.hypothesis.subject);
        match (subject.axis, subject.target) {
            (Some(axis), _) => Culprit::Axis(axis, effect),
            (None, Some(target)) => Culprit::Target(target, false),
            _ if effect.moves_machine() || effect.moves_station() => Culprit::EveryOccupation,
            _ => Culprit::Everything(effect),
        }
    }

    /// A frame that is only displaced is a machine displaced the other way, whatever else a frame can do.
    fn is_alike(
        (leader, of_leader): (&Hypothesis, &Score),
        (other, of_other): (&Hypothesis, &Score),
        cosine: f64,
    ) -> bool {
        let are_confounded = leader.effect.moves_machine() && other.effect.moves_station();
        are_confounded && cosine > ALIKE || is_rival(of_leader, of_other, cosine)
    }
}

impl Base<'_> {
    /// The columns of suspects one after the other, mm.
    pub(crate) fn columns_of(&self, suspects: &[Suspect]) -> Vec<Vec<f64>> {
        let of = |suspect: &Suspect| self.columns_at(&suspect.hypothesis, suspect.shape);
        suspects.iter().flat_map(of).collect()
    }
}

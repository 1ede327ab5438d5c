//! The report of lengths or points, from the model that explains them.

use trueaxis_effects::Level;
use trueaxis_selection::Projection;

use crate::engine::{
    Competed, HeldOut, Misfits, Omnibus, Suspect, Wanders, cause, wandered, whitened_columns,
};
use crate::fitted::Fitted;
use crate::said::Entry;
use crate::{Error, Gain, LevelReport, Misfit, Place, Shares, Unexplained};

/// What was found in lengths or points.
pub(crate) struct Findings<'f, D: Wanders> {
    pub(crate) level: Level,
    /// What was measured, as `2340 lengths`.
    pub(crate) data: String,
    pub(crate) competed: &'f Competed<D>,
    /// The model with neither causes nor disturbances, in the final noise.
    pub(crate) sharp: &'f D::Model,
    /// Standard deviation of a row, and what is left at best, µm.
    pub(crate) noise_um: f64,
    pub(crate) floor_um: f64,
    /// Prediction of sweeps, and of stations, from the others.
    pub(crate) heldout: Option<HeldOut>,
    pub(crate) stations_out: Option<HeldOut>,
    /// The tests before and after.
    pub(crate) tests: [Vec<Omnibus>; 2],
    pub(crate) unexplained: Option<Unexplained>,
    /// What all causes and disturbances leave, and the places to look at.
    pub(crate) left: &'f Projection,
    pub(crate) places: &'f dyn Fn(&Misfits<'_>) -> Vec<Place>,
}

/// Rms of what a model leaves, for one degree of freedom, in units of the noise.
pub(crate) fn rms(projection: &Projection) -> f64 {
    (projection.squares() / projection.degrees_of_freedom.max(1.0)).sqrt()
}

impl<D: Wanders> Findings<'_, D> {
    /// The report; `shown` is the rms of a cause and its figure.
    pub(crate) fn entry(
        self,
        shown: impl Fn(&Suspect) -> Result<(f64, Option<Fitted>), Error>,
    ) -> Result<Entry, Error> {
        let (base, wandering) = (&self.competed.base, &self.competed.wandering);
        let search = &self.competed.search;
        let (found, model) = (&search.found, &search.adjusted);
        let [before_um, after_um] =
            [self.sharp, model].map(|m| self.noise_um * rms(D::projection(m)));
        let gain = self.heldout.map(|h| Gain {
            leave_one_station_out: self.stations_out.map(|h| h.ratio),
            ..h.gain([before_um, after_um, self.floor_um].map(|um| um * um))
        });
        let columns = base.columns(self.sharp);
        let of_causes = D::suspects(model).iter();
        let of_causes = of_causes.map(|s| columns(&s.hypothesis, s.shape));
        let smooth = base.disturbances().iter();
        let smooth = smooth.map(|own| whitened_columns(base, self.sharp, own));
        let is_left = self.unexplained.is_some();
        let misfit = |rms_um: f64, k: usize| Misfit {
            rms_um,
            heldout_rms_um: self.heldout.map(|h| h.rms()[k] * self.noise_um),
        };
        let before = D::projection(self.sharp);
        let misfits = Misfits {
            residuals: [before, self.left].map(|p| &*p.residuals),
            degrees_of_freedom: [before, D::projection(model)].map(|p| p.degrees_of_freedom),
            readings: before.rows() / D::ROWS,
            rows: D::ROWS,
            noise_um: self.noise_um,
        };
        let [tests, tests_after] = self.tests.map(Omnibus::tests);
        let report = LevelReport {
            level: self.level,
            data: self.data,
            noise_floor_um: self.floor_um,
            prediction_u_um: None,
            before: misfit(before_um, 0),
            after: misfit(after_um, 1),
            gain,
            shares: Shares::of_parts(before, of_causes, smooth, is_left),
            unexplained: self.unexplained,
            tests,
            tests_after,
            places: (self.places)(&misfits),
        };
        let gain = gain.filter(|_| found.len() + wandering.len() == 1);
        let causes = found.iter().map(|found| {
            let shown = shown(&found.suspect)?;
            Ok(cause(base, self.level, model, found, gain, shown))
        });
        Ok(Entry {
            report,
            causes: causes.collect::<Result<_, Error>>()?,
            disturbances: wandered(base, self.level, model, wandering, gain),
        })
    }
}

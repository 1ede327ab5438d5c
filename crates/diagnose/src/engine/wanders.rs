//! Disturbances in data that are adjusted anew with each: lengths and points.

use trueaxis_effects::{Circumstances, Displaced};
use trueaxis_leastsquares::dot;
use trueaxis_selection::Projection;

use crate::Error;
use crate::engine::coordinate::{Coordinate, moved};
use crate::engine::disturbance::{Disturbance, Here, Wanderer, With};
use crate::engine::smooth::{SMOOTH_LEVEL, Smooth, beside_all};
use crate::engine::wandering::{JudgedDisturbance, Wandering};
use crate::engine::{Measured, Suspect, whitened};

/// Data that may have disturbances.
pub(crate) trait Wanders: Measured + Clone + Send {
    /// Rows of a reading.
    const ROWS: usize;

    /// All that may wander in these data, and with what.
    fn wanderers(&self) -> Vec<Wanderer>;

    /// Another wanderer with the same columns, if there is one.
    fn confounded(&self, wanderer: Wanderer) -> Option<Wanderer>;

    /// Time and place of each reading.
    fn here(&self) -> Vec<Here>;

    /// Number of stops of a course.
    fn stops(&self, with: With) -> usize;

    /// Positions of an axis at 0 and 1 of its range, mm or rad.
    fn ends(&self, axis: usize) -> [f64; 2];

    /// Changes of the rows by a unit of each coefficient, mm.
    fn courses_mm(&self, model: &Self::Model, wanderer: Wanderer) -> Vec<Vec<f64>>;

    fn circumstances<'c>(&'c self, model: &Self::Model, reading: usize) -> Circumstances<'c>;

    /// The same data with disturbances in their covariance.
    fn beside(&self, disturbances: Vec<Disturbance>) -> Self;

    fn disturbances(&self) -> &[Disturbance];

    fn variance(noise: &Self::Noise) -> f64;
}

/// Data beside causes, in which disturbances are sought.
pub(crate) struct Beside<'b, D> {
    base: &'b D,
    suspects: &'b [Suspect],
    all: Vec<Wanderer>,
}

/// Nothing wanders farther, µm (standard deviation): names were exchanged, or coordinates mistyped.
const FARTHEST_UM: f64 = 5e3;

/// A lost motion that is a cause may change with time or position: only these are tested, since it is known to be there.
const WAYS_TO_CHANGE: f64 = 2.0;

impl<'b, D: Wanders> Beside<'b, D> {
    pub(crate) fn new(base: &'b D, suspects: &'b [Suspect]) -> Self {
        Self {
            base,
            suspects,
            all: base.wanderers(),
        }
    }
}

impl<D: Wanders> Wandering for Beside<'_, D> {
    type Model = D::Model;

    const MOST: usize = 3;

    fn wanderers(&self) -> &[Wanderer] {
        &self.all
    }

    fn fit(&self, own: &[JudgedDisturbance], near: Option<&D::Model>) -> Result<D::Model, Error> {
        let beside = self.base.beside(disturbances(own));
        beside.adjust(self.suspects.to_vec(), near.map(D::noise))
    }

    /// None that would be larger than anything that wanders.
    fn judge(&self, model: &D::Model, wanderer: Wanderer) -> Option<JudgedDisturbance> {
        let (base, scene) = (self.base, self.base.scene());
        let columns = whitened(base, model, base.courses_mm(model, wanderer));
        let all = base.here();
        let forms = wanderer.forms(scene, base.stops(wanderer.with));
        let roots = forms.iter();
        let roots = roots.map(|&form| wanderer.roots_of_spectrum(scene, &all, form));
        let roots: Vec<Vec<f64>> = roots.collect();
        let smooth = Smooth::new(D::projection(model), &columns, &roots)?;
        let is_too_large = |unit_um: &f64| smooth.width * unit_um > FARTHEST_UM;
        if smooth.p_value < SMOOTH_LEVEL && units_um(base, model, wanderer).iter().any(is_too_large)
        {
            return None;
        }
        let mut causes = D::suspects(model).iter();
        let tests = match causes.any(|cause| wanderer.changes(&cause.hypothesis)) {
            true => WAYS_TO_CHANGE,
            false => self.all.len() as f64,
        };
        Some(JudgedDisturbance {
            disturbance: Disturbance {
                wanderer,
                form: forms[smooth.spectrum],
                width: smooth.width,
            },
            two_ln_b: smooth.two_ln_b - 2.0 * (wanderer.of_kind(scene) as f64).ln(),
            p_value: (tests * smooth.p_value).min(1.0),
            rivals: Vec::new(),
        })
    }

    fn confounded(&self, wanderer: Wanderer) -> Option<Wanderer> {
        self.base.confounded(wanderer)
    }
}

/// Displacement by a unit of each coordinate, rms over the readings concerned, µm; the motions of a stage count as
/// the same at all positions of the axis. Lost motion is twice its displacement.
pub(crate) fn units_um<D: Wanders>(data: &D, model: &D::Model, wanderer: Wanderer) -> Vec<f64> {
    let coordinates = wanderer.coordinates(data.scene()).into_iter();
    let coordinates: Vec<Coordinate> = coordinates.map(Coordinate::without_law).collect();
    let (subject, readings) = (wanderer.subject(), D::projection(model).rows() / D::ROWS);
    let moved = (0..readings).map(|i| moved(&coordinates, &subject, &data.circumstances(model, i)));
    let moved: Vec<Vec<Displaced>> = moved.collect();
    let times = match wanderer.with {
        With::Sides | With::SidesInTime | With::StageBySides => 2.0,
        _ => 1.0,
    };
    let unit_um = |c: usize| {
        let squares = moved.iter().map(|moved| {
            let own = &moved[c];
            (own.point_mm - own.station_mm).norm_squared() + own.length_mm.powi(2)
        });
        let seen = squares.filter(|square| *square > 0.0);
        let (sum, count) = seen.fold((0.0, 0_usize), |(sum, n), square| (sum + square, n + 1));
        times * 1e3 * (sum / count.max(1) as f64).sqrt()
    };
    (0..coordinates.len()).map(unit_um).collect()
}

/// Whitened columns of a disturbance, scaled to coefficients of unit prior variance.
pub(crate) fn whitened_columns<D: Wanders>(
    data: &D,
    model: &D::Model,
    own: &Disturbance,
) -> Vec<Vec<f64>> {
    let columns = data.courses_mm(model, own.wanderer);
    let columns = own.scaled(data.scene(), &data.here(), columns);
    whitened(data, model, columns)
}

/// The effect of disturbances on each row, or on those of `elsewhere`, as far as the data show it, mm.
pub(crate) fn wandered_mm<D: Wanders>(
    data: &D,
    model: &D::Model,
    elsewhere: Option<&D>,
) -> Vec<f64> {
    let at = elsewhere.unwrap_or(data);
    let all = at.here();
    let mut sum_mm = vec![0.0; D::ROWS * all.len()];
    for own in data.disturbances() {
        let there = own.scaled(at.scene(), &all, at.courses_mm(model, own.wanderer));
        let whitened = match elsewhere {
            None => whitened(data, model, there.clone()),
            Some(_) => whitened_columns(data, model, own),
        };
        for (own, there) in whitened.iter().zip(&there) {
            let coefficient = dot(own, &D::projection(model).residuals);
            for (sum, x) in sum_mm.iter_mut().zip(there) {
                *sum += coefficient * x;
            }
        }
    }
    sum_mm
}

/// Twice the logarithm of the marginal likelihood ratio of disturbances against a model without them, and the projection with them.
pub(crate) fn of_wandering<D: Wanders>(
    base: &D,
    plain: &D::Model,
    wandering: &[JudgedDisturbance],
) -> (f64, Projection) {
    let processes = wandering.iter().map(|judged| {
        let (scene, wanderer) = (base.scene(), judged.wanderer());
        let columns = whitened_columns(base, plain, &judged.disturbance);
        let forms = wanderer.forms(scene, base.stops(wanderer.with)).len();
        (columns, forms * wanderer.of_kind(scene))
    });
    beside_all(D::projection(plain), processes)
}

/// The noise with the least variance.
pub(crate) fn least<D: Wanders>(noises: impl Iterator<Item = D::Noise>) -> Option<D::Noise> {
    noises.min_by(|a, b| D::variance(a).total_cmp(&D::variance(b)))
}

pub(crate) fn disturbances(wandering: &[JudgedDisturbance]) -> Vec<Disturbance> {
    wandering.iter().map(|judged| judged.disturbance).collect()
}

//! Poses: what any adjustment says about the stages. Their errors are as on the page of the crate, along the axes of
//! the datum.
//!
//! `D_i` is the pose's own covariance, `s` what all poses share: first the stations (x y z and dead path of each),
//! then other dead paths, shapes of targets, and the datum. The joint adjustment and the nine or six equations all
//! give these poses; later stages do not know which it was.

use nalgebra::{
    DMatrix, Isometry3, Matrix2, Matrix3, Matrix6, MatrixView6xX, Point3, Translation3,
    UnitQuaternion, Vector3, Vector6,
};
use trueaxis_campaign::Direction;

/// All measured poses of the stages under test.
#[derive(Debug, Clone)]
pub struct Poses {
    /// The bodies to which the poses belong.
    pub bodies: Vec<TargetBody>,
    /// One for each step (and side of approach, if the sides are kept apart) of each run.
    pub observations: Vec<PoseObservation>,
    /// Covariance of their errors.
    pub noise: PoseNoise,
    /// The part of the noise that the instrument alone causes.
    pub instrument: PoseNoise,
    /// How well the two variance factors of the noise (the instrument's, the repeatability) are known: their
    /// covariance relative to their values. Zero if the declared noise counts as known.
    pub relative_covariance: Matrix2<f64>,
}

/// Targets that move together.
#[derive(Debug, Clone)]
pub struct TargetBody {
    /// The campaign's targets, ascending.
    pub targets: Vec<usize>,
    /// Their adjusted positions at home, mm.
    pub home_mm: Vec<Point3<f64>>,
}

/// A measured pose.
#[derive(Debug, Clone)]
pub struct PoseObservation {
    /// The campaign's step.
    pub step: usize,
    /// Side of approach, if the sides are kept apart.
    pub direction: Option<Direction>,
    /// The body, an index into [`Poses::bodies`].
    pub body: usize,
    /// Brings the body from home to its measured pose, in the datum.
    pub datum_from_home: Isometry3<f64>,
    /// The point that the error of the pose refers to, in the datum, mm.
    pub pivot_mm: Point3<f64>,
}

/// Covariance of the errors of all poses, mm and rad.
#[derive(Debug, Clone, Default)]
pub struct PoseNoise {
    /// `D` of each pose.
    pub own: Vec<Matrix6<f64>>,
    /// `Z` of each pose, one after the other ([`PoseNoise::coupling`]).
    pub(crate) couplings: Vec<f64>,
    /// `Σ`. It may be indefinite and has a meaning only between couplings, except for the stations.
    pub shared: DMatrix<f64>,
    /// Number of the first shared sources, which come from stations, dead paths and datum. The others, independent of
    /// them, are shapes as functions of the points: noise even if the stations are known.
    pub of_stations: usize,
    /// The part of `Σ` that comes from declared uncertainties and not from the noise of lengths.
    pub declared: DMatrix<f64>,
    /// x y z and dead path of each station, mm, as functions of the shared sources, a row each; empty in a points
    /// campaign.
    pub stations: DMatrix<f64>,
}

/// A variance in parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThroughSources {
    /// Through stations, dead paths and datum, declared parts included.
    pub stations: f64,
    /// The declared part of `stations`.
    pub declared: f64,
    /// Through shapes.
    pub shapes: f64,
}

impl PoseNoise {
    /// Number of shared sources.
    pub fn width(&self) -> usize {
        self.shared.nrows()
    }

    /// `Z` of a pose.
    ///
    /// # Panics
    /// If there is no such pose.
    pub fn coupling(&self, pose: usize) -> MatrixView6xX<'_, f64> {
        let size = 6 * self.width();
        MatrixView6xX::from_slice(&self.couplings[pose * size..][..size], self.width())
    }

    /// Multiplies all variances except declared ones.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.own.iter_mut().for_each(|own| *own *= factor);
        self.shared -= &self.declared;
        self.shared *= factor;
        self.shared += &self.declared;
    }

    /// The variances of functions of the shared sources, with a row of coefficients for each.
    pub fn through_sources(&self, coefficients: &DMatrix<f64>) -> Vec<ThroughSources> {
        let products = (coefficients * &self.shared).component_mul(coefficients);
        let of_stations = products.columns(0, self.of_stations).column_sum();
        let of_shapes = products.columns_range(self.of_stations..).column_sum();
        let declared = match self.declared.iter().any(|x| *x != 0.0) {
            true => (coefficients * &self.declared).component_mul(coefficients),
            false => DMatrix::zeros(coefficients.nrows(), 0),
        };
        let declared = declared.column_sum();
        let of_function = |i: usize| ThroughSources {
            stations: of_stations[i],
            declared: declared[i],
            shapes: of_shapes[i],
        };
        (0..coefficients.nrows()).map(of_function).collect()
    }
}

impl Poses {
    /// The same errors about the pivots of `other`; `None` if its poses are not those of the same steps.
    pub(crate) fn noise_about_pivots_of(&self, other: &Self) -> Option<PoseNoise> {
        let mut noise = self.noise.clone();
        let size = 6 * noise.width();
        if self.observations.len() != other.observations.len() {
            return None;
        }
        let pairs = self.observations.iter().zip(&other.observations);
        for (i, (from, to)) in pairs.enumerate() {
            if (from.step, from.direction) != (to.step, to.direction) {
                return None;
            }
            let map = from.to_pivot(&to.pivot_mm);
            noise.own[i] = map * noise.own[i] * map.transpose();
            let coupling = map * noise.coupling(i);
            noise.couplings[i * size..][..size].copy_from_slice(coupling.as_slice());
        }
        Some(noise)
    }
}

impl PoseObservation {
    /// The pose moved by a small twist: translation (mm) of the pivot and rotation (rad).
    pub(crate) fn moved(&self, twist: &Vector6<f64>) -> Isometry3<f64> {
        turned_about(&self.pivot_mm, twist) * self.datum_from_home
    }

    /// From the twist about the pose's own pivot to that about another pivot (datum, mm).
    pub(crate) fn to_pivot(&self, pivot_mm: &Point3<f64>) -> Matrix6<f64> {
        let arm_mm = pivot_mm - self.pivot_mm;
        twist_map(&Matrix3::identity(), &-arm_mm.cross_matrix())
    }
}

/// The map of twists that turns both parts and moves the pivot: `by_rotation` times the rotation is added.
pub fn twist_map(turn: &Matrix3<f64>, by_rotation: &Matrix3<f64>) -> Matrix6<f64> {
    let mut map = Matrix6::zeros();
    map.fixed_view_mut::<3, 3>(0, 0).copy_from(turn);
    map.fixed_view_mut::<3, 3>(3, 3).copy_from(turn);
    map.fixed_view_mut::<3, 3>(0, 3).copy_from(by_rotation);
    map
}

/// The motion of a twist: its first three elements move the pivot, the others turn everything about it.
pub fn turned_about(pivot_mm: &Point3<f64>, twist: &Vector6<f64>) -> Isometry3<f64> {
    let part = |first: usize| -> Vector3<f64> { twist.fixed_rows::<3>(first).into_owned() };
    Translation3::from(pivot_mm.coords + part(0))
        * UnitQuaternion::from_scaled_axis(part(3))
        * Translation3::from(-pivot_mm.coords)
}

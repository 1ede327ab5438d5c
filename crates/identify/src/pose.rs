//! From the measured points of a step to the pose of its stage.
//!
//! The equations are linear in the errors of a pose near the true one. With the targets `s_j` on the stage at home
//! and a pose `T`, the volumetric errors are
//!
//! ```text
//! Δ_j = p_j - T s_j = δ + ε × r_j        r_j = T s_j - T c
//! ```
//!
//! about the pivot `c`. Turning `T` by ε, shifting it by δ and solving again leaves no second-order error (Newton's
//! method). The effect of displacements of the points on the pose is then the operator of the last equations, `dT = G
//! dp`.

use nalgebra::{DMatrix, Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use trueaxis_kinematics::MotionError;

use crate::design::require_finite;
use crate::{Error, Operator, RigidMisfit, SixRows, nine_weighted, rigid_misfit};

/// Which of the nine (or 3T) equations make the pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Equations {
    /// All, weighted by [`StepPoints::about_shape`] ([`nine_weighted`]).
    Weighted,
    /// Six coordinates of three targets ([`SixRows`]), counted along the axes of the points' frame.
    Six(SixRows),
}

/// The input of one step; the covariance has x y z of each target, targets in order.
#[derive(Debug, Clone, Copy)]
pub struct StepPoints<'a> {
    /// The targets on the stage at home, mm.
    pub shape_mm: &'a [Point3<f64>],
    /// The measured points, in any frame that stands still, mm.
    pub points_mm: &'a [Point3<f64>],
    /// Covariance of the points about the shape for all noise, including that shared by steps and that of the shape,
    /// 3T x 3T, mm²: for the weights and the rigid misfit.
    pub about_shape: &'a DMatrix<f64>,
}

/// The pose of a stage at one step. Twists are small motions: δ of the pivot (mm), then the
/// rotation vector ε (rad), both along the axes of the points' frame.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredPose {
    /// From the stage at home to the points' frame.
    pub points_from_home: Isometry3<f64>,
    /// `G`: the twist of the pose by displacements of the points. Its targets are relative to the
    /// pivot; its noise gains are those of the method.
    pub from_points: Operator,
    /// What the rigid motion leaves of the points.
    pub misfit: RigidMisfit,
}

/// Rounding of a coordinate, relative to the largest, with a margin for the sums it is part of.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A pose 0.1 rad off takes four steps. With more the shape does not fit the points at all.
const MAX_ITERATIONS: usize = 50;

/// Condition number of six rows from which the distortion of a triangle by noise may leave them without a pose: this
/// occurred from 59 on. With a smaller one the points are not the triangle.
const NEAR_SINGULAR: f64 = 30.0;

/// The pose of a stage that puts its targets where they were measured, by the paper's equations
/// ([`crate::equations`], Eq. 21) with the volumetric errors of Eqs. 5 to 7 and 12 to 14 as right-hand side.
///
/// `nominal` (points' frame from stage at home) is the start of Newton's method: more than one pose has the same six
/// coordinates, and the one near the start is found. `pivot_mm` is the point of the stage, at home, whose translation
/// is δ.
///
/// ```
/// use nalgebra::{DMatrix, Isometry3, Point3, Vector3};
/// use trueaxis_identify::{Equations, StepPoints, pose_from_points};
///
/// let shape = [[0.0, 150.0, 0.0], [200.0, 0.0, 50.0], [0.0, -120.0, 90.0]].map(Point3::from);
/// let truth = Isometry3::new(Vector3::new(100.0, 0.002, 0.0), Vector3::new(0.0, 0.0, 1e-5));
/// let points = shape.map(|p| truth * p);
/// let noise = DMatrix::identity(9, 9) * 1e-6;
/// let step = StepPoints {
///     shape_mm: &shape,
///     points_mm: &points,
///     about_shape: &noise,
/// };
/// let nominal = Isometry3::translation(100.0, 0.0, 0.0);
/// let found = pose_from_points(&step, Equations::Weighted, &nominal, Point3::origin())?;
/// let left = found.points_from_home.inverse() * truth;
/// assert!(left.translation.vector.norm() < 1e-12 && left.rotation.angle() < 1e-14);
/// assert_eq!(found.misfit.degrees_of_freedom, 3);
/// # Ok::<(), trueaxis_identify::Error>(())
/// ```
///
/// # Errors
/// Those of [`nine_weighted`] or [`SixRows::operator`]; [`Error::TargetCount`] if points and targets
/// are not equally many, or six rows are asked of other than three; [`Error::CovarianceShape`],
/// [`Error::CovarianceAsymmetric`], [`Error::Covariance`], [`Error::NotFinite`], [`Error::NoPose`],
/// [`Error::NearSingularRows`].
pub fn pose_from_points(
    step: &StepPoints<'_>,
    equations: Equations,
    nominal: &Isometry3<f64>,
    pivot_mm: Point3<f64>,
) -> Result<MeasuredPose, Error> {
    step.require_shapes()?;
    let (mut pose, mut iterations) = (*nominal, 0);
    loop {
        iterations += 1;
        let pivot = pose * pivot_mm;
        let levers_mm = step.levers_mm(&pose, &pivot_mm);
        let operator = step.operator(equations, &levers_mm)?;
        let change = operator.apply(&step.deltas_mm(&pose));
        pose = twisted(&pose, &change, &pivot);
        let left_mm = left_by(&change, &levers_mm, &step.deltas_mm(&pose));
        if left_mm <= ROUNDING * step.largest_mm() {
            return step.measured(pose, operator);
        }
        if iterations == MAX_ITERATIONS {
            if let Equations::Six(rows) = equations {
                let condition = rows.condition(&step.levers_mm(nominal, &pivot_mm))?;
                if condition > NEAR_SINGULAR {
                    return Err(Error::NearSingularRows { rows, condition });
                }
            }
            let moved = levers_mm.iter().map(|r| change.displacement_mm(*r).norm());
            let step_mm = moved.fold(0.0, f64::max);
            return Err(Error::NoPose {
                iterations,
                step_mm,
            });
        }
    }
}

/// Estimate of what is left after a step, mm: the square of the step on the longest lever, and the distortion of the
/// points times the rotation of the equations by the step.
fn left_by(change: &MotionError, levers_mm: &[Vector3<f64>], deltas_mm: &[Vector3<f64>]) -> f64 {
    let longest = |v: &[Vector3<f64>]| v.iter().map(|v| v.norm()).fold(0.0, f64::max);
    let angle = change.rotation_rad.norm();
    angle * (angle * longest(levers_mm) + change.translation_mm.norm() + longest(deltas_mm))
}

/// The pose after a motion of the stage about a point of the points' frame.
fn twisted(pose: &Isometry3<f64>, by: &MotionError, about: &Point3<f64>) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_scaled_axis(by.rotation_rad);
    Translation3::from(about.coords + by.translation_mm)
        * turn
        * Translation3::from(-about.coords)
        * pose
}

impl StepPoints<'_> {
    /// # Errors
    /// [`Error::TargetCount`], [`Error::NotFinite`].
    fn require_shapes(&self) -> Result<(), Error> {
        let (nominal, measured) = (self.shape_mm.len(), self.points_mm.len());
        if nominal != measured {
            return Err(Error::TargetCount { nominal, measured });
        }
        let points: Vec<Vector3<f64>> = self.points_mm.iter().map(|p| p.coords).collect();
        require_finite("measured position", &points)
    }

    /// The generalised coordinates of the targets in a pose.
    fn levers_mm(&self, pose: &Isometry3<f64>, pivot_mm: &Point3<f64>) -> Vec<Vector3<f64>> {
        let pivot = pose * pivot_mm;
        let lever = |target: &Point3<f64>| pose * target - pivot;
        self.shape_mm.iter().map(lever).collect()
    }

    fn operator(
        &self,
        equations: Equations,
        levers_mm: &[Vector3<f64>],
    ) -> Result<Operator, Error> {
        match (equations, levers_mm) {
            (Equations::Weighted, _) => nine_weighted(levers_mm, self.about_shape),
            (Equations::Six(rows), &[p, q, k]) => rows.operator(&[p, q, k]),
            (Equations::Six(_), _) => Err(Error::TargetCount {
                nominal: 3,
                measured: levers_mm.len(),
            }),
        }
    }

    /// Measured minus ideal positions of the targets in a pose (Eqs. 7 and 14).
    fn deltas_mm(&self, pose: &Isometry3<f64>) -> Vec<Vector3<f64>> {
        let targets = self.points_mm.iter().zip(self.shape_mm);
        targets.map(|(point, home)| point - pose * home).collect()
    }

    fn largest_mm(&self) -> f64 {
        let both = self.points_mm.iter().chain(self.shape_mm);
        both.map(|p| p.coords.amax()).fold(0.0, f64::max)
    }

    /// `operator` may be that of a pose that differs negligibly.
    fn measured(
        &self,
        points_from_home: Isometry3<f64>,
        operator: Operator,
    ) -> Result<MeasuredPose, Error> {
        let deltas_mm = self.deltas_mm(&points_from_home);
        Ok(MeasuredPose {
            points_from_home,
            misfit: rigid_misfit(&operator, &deltas_mm, self.about_shape)?,
            from_points: operator,
        })
    }
}

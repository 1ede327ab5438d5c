//! The poses of a body whose shape is not known beforehand, from its points at many steps.
//!
//! The shape is nominal plus the mean over all steps of what no rigid motion explains,
//! `w = mean Π Q_i dp_i` (`Q`: home from points' frame, `Π`: what is left after an unweighted rigid fit), so
//! that it is the same function of the points at every step. With the operator `G_i` of a step
//! ([`pose_from_points`])
//!
//! ```text
//! x_i = G_i (dp_i - Q_iᵀ w)
//! ```
//!
//! If the errors of the points are `dp_i = ξ_i - Z_i s`, with `cov(ξ_i) = D_i` independent between steps and
//! `cov(s) = Σ`, those of the poses have the same form, in which the shape adds two sets of shared sources:
//!
//! ```text
//! x_i:  own G D Gᵀ    coupling [G Z - S W_z | S | N]    S = G Qᵀ    N = G D Qᵀ Πᵀ / n    cov | W  -1 |
//!                                                                                            | -1  0 |
//! ```
//!
//! with `W = Σ Π Q D Qᵀ Πᵀ / n²` and `W_z = Σ Π Q Z / n`. The equations are weighted with the covariance of the
//! points about the shape,
//!
//! ```text
//! C_i = D_i - (D_i V_iᵀ + V_i D_i) / n + Q_iᵀ W Q_i + T_i Σ T_iᵀ     V = Qᵀ Π Q     T = Z - Qᵀ W_z
//! ```
//!
//! Weighting with the covariance of the points alone would treat the shape as exact, and mistake the effect of the
//! stations' errors on the shape for a rotation.

use std::ops::Range;

use nalgebra::{
    DMatrix, DVector, Isometry3, Matrix3, Matrix6, Matrix6xX, Point3, Vector3, Vector6,
};
use rayon::prelude::*;
use trueaxis_kinematics::centroid;

use crate::{
    Equations, Error, MeasuredPose, StepError, StepPoints, equations, nine, pose_from_points,
};

/// A body at one step.
#[derive(Debug, Clone)]
pub struct BodyStep {
    /// Points' frame from home, nominal: the start of the iteration.
    pub nominal: Isometry3<f64>,
    /// The measured points, targets in order, mm.
    pub points_mm: Vec<Point3<f64>>,
}

/// The errors of the points of a body: `D` (3T x 3T, mm²) and `Z` (3T rows) of a step, and `Σ`.
pub struct BodyNoise<'a> {
    /// `D` and `Z` of the step with this number.
    pub of_step: &'a (dyn Fn(usize) -> (DMatrix<f64>, DMatrix<f64>) + Sync),
    /// `Σ`: covariance of the shared parameters.
    pub shared: &'a DMatrix<f64>,
}

/// The errors of the poses of a body that follow from those of the points.
pub struct BodyPoseNoise {
    /// `G D Gᵀ` of each step, mm² and rad².
    pub own: Vec<Matrix6<f64>>,
    /// `[G Z - S W_z | S | N]` of each step.
    pub coupling: Vec<Matrix6xX<f64>>,
    /// Covariance of the sources that the shape adds: `[[W, -1], [-1, 0]]`. It is indefinite and has a meaning only
    /// between couplings.
    pub of_shape: DMatrix<f64>,
}

/// The adjusted shape and poses of a body.
pub struct BodyPoses {
    /// The targets at home, mm.
    pub shape_mm: Vec<Point3<f64>>,
    /// The point of the body, at home, whose translation is the first half of a twist, mm.
    pub pivot_mm: Point3<f64>,
    /// One for each step.
    pub steps: Vec<StepPose>,
    shape: Shape,
}

/// The pose of a body at one step.
pub struct StepPose {
    /// The pose with its linear map from the points.
    pub pose: MeasuredPose,
    /// `C`, mm².
    pub about_shape: DMatrix<f64>,
    /// Measured minus predicted points, mm.
    pub deltas_mm: Vec<Vector3<f64>>,
    /// What an unweighted rigid fit leaves of `deltas_mm`, turned home, mm.
    pub distortion_mm: Vec<Vector3<f64>>,
    /// `Q`.
    pub home_from_points: Matrix3<f64>,
}

/// Shapes have converged when no coordinate changes by more than this, mm.
const CONVERGED_MM: f64 = 1e-10;

/// A shape this near, mm, lets every step find its pose with the weights of its points. Targets stand millimetres off, and
/// the beam of a tracker weighs hundreds of times as much as the directions across: from the nominal shape the
/// iteration of a pose may then diverge. With equal weights it does not.
const NEAR_MM: f64 = 1e-3;

/// Each pass changes the shape by a ten-thousandth (the size of the errors in rad) of the change before.
const MAX_PASSES: usize = 60;

/// The shape and the poses of a body with targets at `nominal_mm` at home.
///
/// # Errors
/// Those of [`pose_from_points`], with the number of the step.
pub fn poses_of_body(
    nominal_mm: &[Point3<f64>],
    steps: &[BodyStep],
    noise: &BodyNoise<'_>,
    equations: Equations,
) -> Result<BodyPoses, StepError> {
    let shape = Shape::new(nominal_mm, steps, noise);
    let weights: Vec<DMatrix<f64>> = numbered(steps.len())
        .map(|i| shape.weight(&steps[i], &(noise.of_step)(i), noise.shared))
        .collect();
    let equal = DMatrix::identity(3 * nominal_mm.len(), 3 * nominal_mm.len());
    let mut fitting = Fitting {
        steps,
        equations,
        pivot_mm: centroid(nominal_mm),
        shape_mm: nominal_mm.to_vec(),
        found: Vec::new(),
    };
    fitting.settle(&|_| &equal, NEAR_MM)?;
    fitting.settle(&|i| &weights[i], CONVERGED_MM)?;
    let Fitting {
        pivot_mm,
        shape_mm,
        found,
        ..
    } = fitting;
    Ok(BodyPoses {
        shape_mm,
        pivot_mm,
        steps: found,
        shape,
    })
}

/// The shape and the poses as far as they are known.
struct Fitting<'a> {
    steps: &'a [BodyStep],
    equations: Equations,
    pivot_mm: Point3<f64>,
    shape_mm: Vec<Point3<f64>>,
    found: Vec<StepPose>,
}

impl Fitting<'_> {
    /// Fits poses and shape in turn until no coordinate of the shape changes by more than this.
    fn settle<'w>(
        &mut self,
        about_shape: &(dyn Fn(usize) -> &'w DMatrix<f64> + Sync),
        until_mm: f64,
    ) -> Result<(), StepError> {
        for _ in 0..MAX_PASSES {
            let solve = |i: usize| {
                let start = self.found.get(i).map(|step| step.pose.points_from_home);
                let start = start.unwrap_or(self.steps[i].nominal);
                let points = (&self.steps[i].points_mm[..], about_shape(i));
                step_pose(
                    &self.shape_mm,
                    points,
                    self.equations,
                    (&start, self.pivot_mm),
                )
                .map_err(|error| StepError { step: i, error })
            };
            let count = self.steps.len();
            self.found = numbered(count).map(solve).collect::<Result<_, _>>()?;
            let mut change_mm = 0.0_f64;
            for (target, home) in self.shape_mm.iter_mut().enumerate() {
                let left = self.found.iter().map(|step| step.distortion_mm[target]);
                let change = left.sum::<Vector3<f64>>() / count as f64;
                *home += change;
                change_mm = change_mm.max(change.norm());
            }
            if change_mm <= until_mm {
                break;
            }
        }
        Ok(())
    }
}

fn step_pose(
    shape_mm: &[Point3<f64>],
    (points_mm, about_shape): (&[Point3<f64>], &DMatrix<f64>),
    equations: Equations,
    (start, pivot_mm): (&Isometry3<f64>, Point3<f64>),
) -> Result<StepPose, Error> {
    let step = StepPoints {
        shape_mm,
        points_mm,
        about_shape,
    };
    let pose = pose_from_points(&step, equations, start, pivot_mm)?;
    let at = pose.points_from_home;
    let deltas = points_mm
        .iter()
        .zip(shape_mm)
        .map(|(p, home)| p - at * home);
    let deltas_mm: Vec<Vector3<f64>> = deltas.collect();
    let plain = nine(pose.from_points.targets_mm())?;
    let home_from_points = at.rotation.inverse();
    let left = plain.residual_mm(&deltas_mm).into_iter();
    Ok(StepPose {
        distortion_mm: left.map(|v| home_from_points * v).collect(),
        home_from_points: home_from_points.to_rotation_matrix().into_inner(),
        about_shape: about_shape.clone(),
        deltas_mm,
        pose,
    })
}

impl BodyPoses {
    /// `Π / n`: the shape from the points of one step, turned home.
    pub fn shape_from_points(&self) -> DMatrix<f64> {
        &self.shape.projection / self.shape.steps
    }

    /// The errors of the poses for this noise of the points.
    pub fn noise(&self, noise: &BodyNoise<'_>) -> BodyPoseNoise {
        let turns = |i: usize| self.steps[i].home_from_points;
        let shape = self.shape.with_noise(&turns, self.steps.len(), noise);
        let size = shape.own.nrows();
        let mut of_shape = DMatrix::zeros(2 * size, 2 * size);
        of_shape
            .view_mut((0, 0), (size, size))
            .copy_from(&shape.own);
        for i in 0..size {
            of_shape[(i, size + i)] = -1.0;
            of_shape[(size + i, i)] = -1.0;
        }
        let of_step = |i: usize| {
            let (d, z) = (noise.of_step)(i);
            let (g, turn) = (self.steps[i].pose.from_points.matrix(), turns(i));
            let by_shape = turned_columns(&dynamic(&g), &turn.transpose());
            let with_noise = &g * d;
            let to_shape = turned_columns(&shape.projection, &turn);
            let sources = z.ncols();
            let mut coupling = Matrix6xX::zeros(sources + 2 * size);
            coupling
                .columns_mut(0, sources)
                .copy_from(&(&g * z - &by_shape * &shape.coupling));
            coupling.columns_mut(sources, size).copy_from(&by_shape);
            coupling
                .columns_mut(sources + size, size)
                .copy_from(&(&with_noise * to_shape.transpose() / shape.steps));
            (with_noise * g.transpose(), coupling)
        };
        let (own, coupling) = numbered(self.steps.len()).map(of_step).unzip();
        BodyPoseNoise {
            own,
            coupling,
            of_shape,
        }
    }

    /// The twists of the poses for displacements of the points (`errors_mm`: x y z of each target, for each step),
    /// with unchanged operators.
    pub fn twists(&self, errors_mm: &[DVector<f64>]) -> Vec<Vector6<f64>> {
        let mut shape = DVector::zeros(self.shape.projection.nrows());
        for (step, errors) in self.steps.iter().zip(errors_mm) {
            shape += turned_columns(&self.shape.projection, &step.home_from_points) * errors;
        }
        shape /= self.shape.steps;
        let twist = |(step, errors): (&StepPose, &DVector<f64>)| {
            let turn = step.home_from_points.transpose();
            let mut relative = errors.clone();
            for k in (0..relative.len()).step_by(3) {
                let own = relative.fixed_rows::<3>(k) - turn * shape.fixed_rows::<3>(k);
                relative.fixed_rows_mut::<3>(k).copy_from(&own);
            }
            step.pose.from_points.matrix() * relative
        };
        self.steps.iter().zip(errors_mm).map(twist).collect()
    }
}

/// The shape as a function of the points, and its noise. Both are zero for a body with a single step, whose points
/// are the shape, and for targets on a line, which the identification refuses.
#[derive(Clone)]
struct Shape {
    /// `Π`.
    projection: DMatrix<f64>,
    /// Number of steps `n`.
    steps: f64,
    /// `W` and `W_z`.
    own: DMatrix<f64>,
    coupling: DMatrix<f64>,
}

impl Shape {
    fn new(nominal_mm: &[Point3<f64>], steps: &[BodyStep], noise: &BodyNoise<'_>) -> Self {
        let size = 3 * nominal_mm.len();
        let centre = centroid(nominal_mm);
        let levers: Vec<Vector3<f64>> = nominal_mm.iter().map(|p| p - centre).collect();
        let projection = match nine(&levers) {
            Ok(plain) if steps.len() > 1 => {
                DMatrix::identity(size, size) - equations(&levers) * plain.matrix()
            }
            _ => DMatrix::zeros(size, size),
        };
        Self {
            projection,
            steps: steps.len() as f64,
            own: DMatrix::zeros(0, 0),
            coupling: DMatrix::zeros(0, 0),
        }
        .with_noise(&|i| home_from_points(&steps[i]), steps.len(), noise)
    }

    /// The same shape for another noise of the points; `turn` is `Q` of each step.
    fn with_noise(
        &self,
        turn: &(dyn Fn(usize) -> Matrix3<f64> + Sync),
        steps: usize,
        noise: &BodyNoise<'_>,
    ) -> Self {
        let (size, sources) = (self.projection.nrows(), noise.shared.nrows());
        let of_chunk = |chunk: Range<usize>| {
            let mut own = DMatrix::zeros(size, size);
            let mut coupling = DMatrix::zeros(size, sources);
            for i in chunk {
                let (d, z) = (noise.of_step)(i);
                let to_shape = turned_columns(&self.projection, &turn(i));
                own.gemm(1.0, &(&to_shape * d), &to_shape.transpose(), 1.0);
                coupling.gemm(1.0, &to_shape, &z, 1.0);
            }
            (own, coupling)
        };
        // Chunks have a fixed size and are added in order: the bits do not depend on the number of threads.
        let chunks: Vec<Range<usize>> = (0..steps)
            .step_by(CHUNK)
            .map(|first| first..steps.min(first + CHUNK))
            .collect();
        let parts: Vec<_> = chunks.into_par_iter().map(of_chunk).collect();
        let mut sums = (DMatrix::zeros(size, size), DMatrix::zeros(size, sources));
        for (own, coupling) in parts {
            sums.0 += own;
            sums.1 += coupling;
        }
        Self {
            own: sums.0 / (self.steps * self.steps),
            coupling: sums.1 / self.steps,
            ..self.clone()
        }
    }

    /// `C`, symmetric to the last bit.
    fn weight(
        &self,
        step: &BodyStep,
        (d, z): &(DMatrix<f64>, DMatrix<f64>),
        shared: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let turn = home_from_points(step);
        let seen_from_points =
            |matrix: &DMatrix<f64>| turned_columns(&turned_rows(matrix, &turn.transpose()), &turn);
        let cross = d * seen_from_points(&self.projection) / self.steps;
        let through = z - turned_rows(&self.coupling, &turn.transpose());
        let c = d + seen_from_points(&self.own) - &cross - cross.transpose()
            + &through * shared * through.transpose();
        (&c + c.transpose()) * 0.5
    }
}

/// Steps that one thread takes at a time.
const CHUNK: usize = 32;

fn numbered(count: usize) -> rayon::iter::MinLen<rayon::range::Iter<usize>> {
    (0..count).into_par_iter().with_min_len(CHUNK)
}

/// `Q`, nominal.
fn home_from_points(step: &BodyStep) -> Matrix3<f64> {
    let turn = step.nominal.rotation.inverse();
    turn.to_rotation_matrix().into_inner()
}

fn dynamic(matrix: &Matrix6xX<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(matrix.nrows(), matrix.ncols(), matrix.as_slice())
}

/// `A Q` with the same rotation for every point.
fn turned_columns(matrix: &DMatrix<f64>, rotation: &Matrix3<f64>) -> DMatrix<f64> {
    let mut turned = matrix.clone();
    for j in (0..matrix.ncols()).step_by(3) {
        let block = matrix.fixed_columns::<3>(j) * rotation;
        turned.fixed_columns_mut::<3>(j).copy_from(&block);
    }
    turned
}

/// `Q A` with the same rotation for every point.
fn turned_rows(matrix: &DMatrix<f64>, rotation: &Matrix3<f64>) -> DMatrix<f64> {
    turned_columns(&matrix.transpose(), &rotation.transpose()).transpose()
}

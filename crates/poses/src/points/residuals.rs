//! What rigid motions leave of each measured coordinate.
//!
//! The mean points `m` of a step, with the operator `G` of its pose and the equations `A`, leave
//!
//! ```text
//! v = M (dm - Qᵀ w)    M = I - A G    w = mean Π Q dm        cov(v) = M C Mᵀ
//! ```
//!
//! ([`trueaxis_identify::poses_of_body`] names `Q`, `Π`, `w`, and `C`, the covariance of the bracket.) One reading `p`
//! of a target `t`, with the weight `h` in its mean `m_t`, leaves `p - m_t + v_t`:
//!
//! ```text
//! variance            var(p - m_t) + 2 [cov(p - m_t, m) (M B)ᵀ]_t + [M C Mᵀ]_t    B = I - Qᵀ Π Q / n
//! redundancy number   1 - h (1 - [M B]_tt)
//! ```
//!
//! The scale, which all coordinates share, is the same in `p` and `m_t` and leaves their difference unchanged.

use nalgebra::{DMatrix, Matrix3, Vector3};
use trueaxis_identify::{BodyPoses, StepPose, equations};

use crate::Residual;
use crate::points::equations::PointEquations;
use crate::points::{GroupReading, MeasuredPoints};

/// A variance below this share of that of the reading is rounding: nothing checks the coordinate.
const CHECKED: f64 = 1e-10;

impl PointEquations {
    /// The residuals of all coordinates that led to poses, in units of the noise of `points`, in measuring order.
    pub(crate) fn residuals(&self, points: &MeasuredPoints) -> Vec<Residual> {
        let mut residuals = Vec::new();
        for source in &self.sources {
            let step = LeftOfStep::new(&self.bodies[source.body], source.step);
            let (own, _) = points.noise.of(source);
            let readings = &points.readings[source.group];
            for (t, &place) in source.places.iter().enumerate() {
                for reading in readings.iter().filter(|reading| reading.place == place) {
                    let common =
                        |place: &usize| points.covariance_with_mean(reading, *place, readings);
                    let with_means: Vec<Matrix3<f64>> = source.places.iter().map(common).collect();
                    let repeatability_mm2 = points.repeatability_variance_mm2;
                    let variances_mm2 = reading.own_mm2.diagonal().add_scalar(repeatability_mm2);
                    residuals.extend(step.of_reading(
                        t,
                        (reading, variances_mm2),
                        &own,
                        &with_means,
                    ));
                }
            }
        }
        residuals.sort_by_key(|residual| (residual.reading, residual.coordinate));
        residuals
    }
}

/// What the pose of a step leaves of displacements of its mean points.
struct LeftOfStep<'a> {
    step: &'a StepPose,
    /// `M B`.
    of_means: DMatrix<f64>,
    /// `M C Mᵀ`.
    covariance: DMatrix<f64>,
}

impl<'a> LeftOfStep<'a> {
    fn new(body: &'a BodyPoses, number: usize) -> Self {
        let step = &body.steps[number];
        let operator = &step.pose.from_points;
        let size = 3 * step.deltas_mm.len();
        let rigid = equations(operator.targets_mm()) * operator.matrix();
        let without_motion = DMatrix::identity(size, size) - rigid;
        let turn = rotations(&step.home_from_points, step.deltas_mm.len());
        let through_shape = turn.transpose() * body.shape_from_points() * &turn;
        let without_shape = DMatrix::identity(size, size) - through_shape;
        Self {
            step,
            of_means: &without_motion * without_shape,
            covariance: &without_motion * &step.about_shape * without_motion.transpose(),
        }
    }

    /// The residuals of a reading of target `t` with the variances of its coordinates; `own` is the covariance of the
    /// means, `with_means` that of the reading with the mean of each target.
    fn of_reading(
        &self,
        t: usize,
        (reading, variances_mm2): (&GroupReading, Vector3<f64>),
        own: &DMatrix<f64>,
        with_means: &[Matrix3<f64>],
    ) -> [Residual; 3] {
        let of_mean = |b: usize| own.fixed_view::<3, 3>(3 * t, 3 * b);
        let left = self.step.pose.misfit.residual_mm[t];
        std::array::from_fn(|c| {
            let row = 3 * t + c;
            let off_mean = variances_mm2[c] - 2.0 * with_means[t][(c, c)] + of_mean(t)[(c, c)];
            let targets = with_means.iter().enumerate();
            let between = targets.map(|(b, with)| {
                let off_mean_with_mean = with.row(c) - of_mean(b).row(c);
                off_mean_with_mean.dot(&self.of_means.fixed_view::<1, 3>(row, 3 * b))
            });
            let variance = off_mean + 2.0 * between.sum::<f64>() + self.covariance[(row, row)];
            let residual_mm = reading.off_mean_mm[c] + left[c];
            let is_checked = variance > CHECKED * variances_mm2[c];
            Residual {
                reading: reading.reading,
                coordinate: Some(c),
                residual_mm,
                standardized: match is_checked {
                    true => residual_mm / variance.sqrt(),
                    false => 0.0,
                },
                redundancy: Some(1.0 - reading.share * (1.0 - self.of_means[(row, row)])),
            }
        })
    }
}

/// The same rotation for all points, as one matrix.
fn rotations(rotation: &Matrix3<f64>, points: usize) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(3 * points, 3 * points);
    for k in (0..3 * points).step_by(3) {
        all.fixed_view_mut::<3, 3>(k, k).copy_from(rotation);
    }
    all
}

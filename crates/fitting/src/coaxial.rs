//! Circles about one axis, by orthogonal distance.
//!
//! A circle of radius `R_k` at the height `z_k` on the axis through `q` along `n` is missed by the
//! point `p` of the group `k` by
//!
//! ```text
//! h = n·(p - q) - z_k         along the axis
//! g = |(p - q) - (n·(p - q)) n| - R_k   across it
//! ```
//!
//! and `Σ h² + g²` is least. Unknowns are two shifts of `q` and two tilts of `n` across the axis,
//! then height and radius of each circle. `q` is kept nearest to the centroid of all points, the
//! origin: there shifts and tilts correlate little.

use faer::Mat;
use nalgebra::{Matrix3, Vector2, Vector3};

use crate::cloud::{Cloud, mean};
use crate::gauss_newton::Model;
use crate::planar_circle::{algebraic_centre, mean_distance};

/// Unknowns of the axis; each circle adds two.
pub(crate) const AXIS_UNKNOWNS: usize = 4;

/// Circles about one axis through groups of points, all in units of the cloud.
#[derive(Debug, Clone)]
pub(crate) struct Coaxial<'a> {
    groups: &'a [Vec<Vector3<f64>>],
    /// Columns `a`, `b` across the axis and `n` along it, right-handed.
    pub(crate) frame: Matrix3<f64>,
    /// `q`, perpendicular to `n`.
    pub(crate) point: Vector3<f64>,
    /// Height and radius of each circle.
    pub(crate) circles: Vec<(f64, f64)>,
}

impl<'a> Coaxial<'a> {
    /// The circles about a given axis: `frame[2]` is its direction, turned to agree with the sense
    /// of travel, `centre` a point on it in the coordinates `frame[0]`, `frame[1]`.
    pub(crate) fn about(
        cloud: &'a Cloud,
        mut frame: Matrix3<f64>,
        mut centre: Vector2<f64>,
    ) -> Self {
        if travel(&cloud.groups, &frame, centre) < 0.0 {
            frame.swap_columns(0, 1);
            frame.column_mut(2).neg_mut();
            centre = centre.yx();
        }
        let height_and_radius = |group: &Vec<Vector3<f64>>| {
            let height = frame.column(2).dot(&mean(group));
            (height, mean_distance(&in_plane(group, &frame), centre))
        };
        Self {
            groups: &cloud.groups,
            frame,
            point: frame.fixed_columns::<2>(0) * centre,
            circles: cloud.groups.iter().map(height_and_radius).collect(),
        }
    }

    /// The circles about the axis along `frame[2]` through the centre that suits all groups best.
    pub(crate) fn along(cloud: &'a Cloud, frame: Matrix3<f64>) -> Self {
        let planar: Vec<_> = cloud.groups.iter().map(|g| in_plane(g, &frame)).collect();
        let slices: Vec<&[Vector2<f64>]> = planar.iter().map(Vec::as_slice).collect();
        Self::about(cloud, frame, algebraic_centre(&slices))
    }

    /// Centre of circle `k`.
    pub(crate) fn centre(&self, k: usize) -> Vector3<f64> {
        self.point + self.frame.column(2) * self.circles[k].0
    }
}

impl Model for Coaxial<'_> {
    fn linearise(&self) -> (Vec<f64>, Mat<f64>) {
        let points: usize = self.groups.iter().map(Vec::len).sum();
        let mut residuals = Vec::with_capacity(2 * points);
        let mut jacobian = Mat::zeros(2 * points, AXIS_UNKNOWNS + 2 * self.circles.len());
        for (k, (group, (height, radius))) in self.groups.iter().zip(&self.circles).enumerate() {
            let of_circle = AXIS_UNKNOWNS + 2 * k;
            for p in group {
                let arm = self.frame.tr_mul(&(p - self.point));
                let across = arm.xy();
                // A point on the axis has no direction from it; its row then says nothing.
                let outwards = across.try_normalize(0.0).unwrap_or_default();

                let row = residuals.len();
                residuals.push(arm.z - height);
                for i in 0..2 {
                    jacobian[(row, 2 + i)] = across[i];
                }
                jacobian[(row, of_circle)] = -1.0;

                let row = residuals.len();
                residuals.push(across.norm() - radius);
                for i in 0..2 {
                    jacobian[(row, i)] = -outwards[i];
                    jacobian[(row, 2 + i)] = -arm.z * outwards[i];
                }
                jacobian[(row, of_circle + 1)] = -1.0;
            }
        }
        (residuals, jacobian)
    }

    fn moved(&self, step: &[f64]) -> Self {
        let [a, b, n] = [0, 1, 2].map(|i| self.frame.column(i));
        let point = self.point + a * step[0] + b * step[1];
        let along = (n + a * step[2] + b * step[3]).normalize();
        let across = (a - along * along.dot(&a)).normalize();
        let slide = along.dot(&point);
        let circles = self.circles.iter().zip(step[AXIS_UNKNOWNS..].chunks(2));
        Self {
            groups: self.groups,
            frame: Matrix3::from_columns(&[across, along.cross(&across), along]),
            point: point - along * slide,
            circles: circles
                .map(|((height, radius), change)| (height + change[0] + slide, radius + change[1]))
                .collect(),
        }
    }

    fn rounding(&self) -> f64 {
        let reach = |(height, radius): &(f64, f64)| height.abs() + radius.abs();
        let size = self.point.norm() + self.circles.iter().map(reach).fold(0.0, f64::max);
        let points: usize = self.groups.iter().map(Vec::len).sum();
        f64::EPSILON * size * (2.0 * points as f64).sqrt()
    }
}

/// Twice the area that the arms from the centre sweep from point to point, positive if they go
/// round `frame[2]` by the right-hand rule. A target near the axis, whose travel is mostly noise,
/// sweeps little and does not decide.
fn travel(groups: &[Vec<Vector3<f64>>], frame: &Matrix3<f64>, centre: Vector2<f64>) -> f64 {
    let swept = |group: &Vec<Vector3<f64>>| -> f64 {
        in_plane(group, frame)
            .windows(2)
            .map(|pair| (pair[0] - centre).perp(&(pair[1] - centre)))
            .sum()
    };
    groups.iter().map(swept).sum()
}

/// The points in the coordinates of the first two columns of `frame`.
pub(crate) fn in_plane(points: &[Vector3<f64>], frame: &Matrix3<f64>) -> Vec<Vector2<f64>> {
    let across = frame.fixed_columns::<2>(0);
    points.iter().map(|p| across.tr_mul(p)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauss_newton::jacobian_error;
    use nalgebra::Point3;

    /// Off the minimum, at random-looking values: two circles of three points.
    #[test]
    fn jacobian_agrees_with_differences() {
        let near = [[1.0, 0.2, 0.1], [0.1, 1.1, 0.0], [-0.9, 0.3, 0.2]].map(Point3::from);
        let far = [[0.4, -0.7, 1.6], [0.9, 0.1, 1.4], [0.2, 0.6, 1.5]].map(Point3::from);
        let cloud = Cloud::new(&[&near, &far]).unwrap();
        let n = Vector3::new(0.1, -0.2, 1.0).normalize();
        let a = n.cross(&Vector3::y()).normalize();
        let frame = Matrix3::from_columns(&[a, n.cross(&a), n]);
        let circles = Coaxial::about(&cloud, frame, Vector2::new(0.15, 0.05));
        assert!(jacobian_error(&circles) < 1e-8);
    }
}

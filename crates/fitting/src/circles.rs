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
//! and `Σ h² + g²` is least. Unknowns are two shifts of `q` and two tilts of `n` across the axis of
//! the start, then height and radius of each circle. All are in units of the cloud, from its
//! centroid.

use nalgebra::{DMatrix, Matrix3, Matrix3x2, Unit, Vector2, Vector3};
use trueaxis_leastsquares::dense::{Model, adjust};

use crate::cloud::{Cloud, mean};
use crate::{Circle, CommonAxis, Error, Line};

/// Unknowns of the axis; each circle adds two.
const AXIS_UNKNOWNS: usize = 4;

/// Steps fall to the rounding within ten or so. A target within its own noise of the axis needs a
/// hundred, and an arc without a bend runs away towards a straight line until it is stopped.
const MAX_ITERATIONS: usize = 500;

/// The residuals of all points, with the axis of the start.
struct Axis<'a> {
    groups: &'a [Vec<Vector3<f64>>],
    /// `a`, `b` across the axis and `n` along it, right-handed.
    frame: Matrix3<f64>,
    point: Vector3<f64>,
}

/// The axis for some values of its unknowns.
struct Placed {
    point: Vector3<f64>,
    direction: Vector3<f64>,
    /// How the direction changes with the two tilts.
    tilts: Matrix3x2<f64>,
}

/// The circles about an axis near `frame[2]` with the least sum of squares, in mm.
///
/// # Errors
/// [`Error::Undetermined`] if the points leave a combination of the unknowns free.
pub(crate) fn fit(cloud: &Cloud, mut frame: Matrix3<f64>) -> Result<CommonAxis, Error> {
    let mut centre = algebraic_centre(&cloud.groups, &frame);
    if travel(&cloud.groups, &frame, centre) < 0.0 {
        frame.swap_columns(0, 1);
        frame.column_mut(2).neg_mut();
        centre = centre.yx();
    }
    let axis = Axis {
        groups: &cloud.groups,
        frame,
        point: frame.fixed_columns::<2>(0) * centre,
    };
    let mut start = vec![0.0; AXIS_UNKNOWNS];
    for group in &cloud.groups {
        let radii = in_plane(group, &frame).map(|p| (p - centre).norm());
        let radius = radii.sum::<f64>() / group.len().max(1) as f64;
        start.extend([frame.column(2).dot(&mean(group)), radius]);
    }
    let undetermined = |singular_value| Error::Undetermined { singular_value };
    let fitted = adjust(&axis, &start, MAX_ITERATIONS).map_err(|_| undetermined(f64::NAN))?;
    if fitted.covariance.is_none() {
        let values = &fitted.singular_values;
        let ends = values.last().zip(values.first());
        return Err(undetermined(
            ends.map_or(f64::NAN, |(least, most)| least / most),
        ));
    }
    let Placed {
        point, direction, ..
    } = axis.placed(&fitted.unknowns);
    let along = direction.dot(&point);
    let nearest = point - direction * along;
    let circle = |of_circle: &[f64]| Circle {
        center_mm: cloud.to_mm(nearest + direction * (of_circle[0] + along)),
        radius_mm: of_circle[1] * cloud.unit_mm,
    };
    let circles = fitted.unknowns[AXIS_UNKNOWNS..].chunks_exact(2);
    Ok(CommonAxis {
        axis: Line {
            point_mm: cloud.to_mm(nearest),
            direction: Unit::new_unchecked(direction),
        },
        circles: circles.map(circle).collect(),
        termination: fitted.termination,
    })
}

impl Axis<'_> {
    fn placed(&self, unknowns: &[f64]) -> Placed {
        let across = self.frame.fixed_columns::<2>(0);
        let tilted = self.frame.column(2) + across * Vector2::new(unknowns[2], unknowns[3]);
        let direction = tilted.normalize();
        let crosswise = Matrix3::identity() - direction * direction.transpose();
        Placed {
            point: self.point + across * Vector2::new(unknowns[0], unknowns[1]),
            direction,
            tilts: crosswise * across / tilted.norm(),
        }
    }

    fn points(&self) -> impl Iterator<Item = (usize, &Vector3<f64>)> {
        let groups = self.groups.iter().enumerate();
        groups.flat_map(|(k, group)| group.iter().map(move |p| (k, p)))
    }
}

impl Model for Axis<'_> {
    fn residuals(&self, unknowns: &[f64]) -> Vec<f64> {
        let axis = self.placed(unknowns);
        let of_point = |(k, p): (usize, &Vector3<f64>)| {
            let arm = p - axis.point;
            let height = axis.direction.dot(&arm);
            let [z, radius] = [0, 1].map(|i| unknowns[AXIS_UNKNOWNS + 2 * k + i]);
            [height - z, (arm - axis.direction * height).norm() - radius]
        };
        self.points().flat_map(of_point).collect()
    }

    fn jacobian(&self, unknowns: &[f64]) -> DMatrix<f64> {
        let axis = self.placed(unknowns);
        let across = self.frame.fixed_columns::<2>(0);
        let points: usize = self.groups.iter().map(Vec::len).sum();
        let mut jacobian = DMatrix::zeros(2 * points, unknowns.len());
        for (i, (k, p)) in self.points().enumerate() {
            let arm = p - axis.point;
            let height = axis.direction.dot(&arm);
            // A point on the axis has no direction from it; its row then says nothing.
            let outwards = (arm - axis.direction * height)
                .try_normalize(0.0)
                .unwrap_or_default();
            let by_tilt = [
                axis.tilts.tr_mul(&arm),
                axis.tilts.tr_mul(&outwards) * -height,
            ];
            let by_shift = [axis.direction, outwards].map(|d| -across.tr_mul(&d));
            for part in 0..2 {
                for j in 0..2 {
                    jacobian[(2 * i + part, j)] = by_shift[part][j];
                    jacobian[(2 * i + part, 2 + j)] = by_tilt[part][j];
                }
                jacobian[(2 * i + part, AXIS_UNKNOWNS + 2 * k + part)] = -1.0;
            }
        }
        jacobian
    }

    fn rounding(&self) -> f64 {
        let squares: f64 = self.points().map(|(_, p)| p.norm_squared()).sum();
        f64::EPSILON * squares.sqrt()
    }
}

/// A common centre of the groups, each with its own radius, in the coordinates of `frame[0]` and
/// `frame[1]`, from the linear equations `2 c·(p - p̄) = |p|² - mean |p|²` (I. Kåsa, 1976; the squared
/// radii eliminated).
///
/// It is exact for exact points and otherwise a start: noise on a short arc pulls it inwards.
/// For collinear points it is the origin.
fn algebraic_centre(groups: &[Vec<Vector3<f64>>], frame: &Matrix3<f64>) -> Vector2<f64> {
    let (mut a, mut b) = (nalgebra::Matrix2::zeros(), Vector2::zeros());
    for group in groups {
        let centroid = frame.fixed_columns::<2>(0).tr_mul(&mean(group));
        let squares = in_plane(group, frame).map(|p| p.norm_squared());
        let mean_square = squares.sum::<f64>() / group.len().max(1) as f64;
        for p in in_plane(group, frame) {
            let d = p - centroid;
            a += d * d.transpose();
            b += d * (p.norm_squared() - mean_square);
        }
    }
    a.cholesky()
        .map_or_else(Vector2::zeros, |cholesky| cholesky.solve(&b) * 0.5)
}

/// Twice the area that the arms from the centre sweep from point to point, positive if they go
/// round `frame[2]` by the right-hand rule. A target near the axis, whose travel is mostly noise,
/// sweeps little and does not decide.
fn travel(groups: &[Vec<Vector3<f64>>], frame: &Matrix3<f64>, centre: Vector2<f64>) -> f64 {
    let swept = |group: &Vec<Vector3<f64>>| -> f64 {
        let arms: Vec<_> = in_plane(group, frame).map(|p| p - centre).collect();
        arms.windows(2).map(|pair| pair[0].perp(&pair[1])).sum()
    };
    groups.iter().map(swept).sum()
}

/// The points in the coordinates of the first two columns of `frame`.
fn in_plane<'a>(
    points: &'a [Vector3<f64>],
    frame: &'a Matrix3<f64>,
) -> impl Iterator<Item = Vector2<f64>> + 'a {
    points.iter().map(|p| frame.fixed_columns::<2>(0).tr_mul(p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    /// Third derivatives are about one: truncation 1e-10 and rounding 1e-11 are balanced.
    const H: f64 = 1e-5;

    /// Off the minimum, at random-looking values: two circles of three points.
    #[test]
    fn jacobian_agrees_with_differences() {
        let near = [[1.0, 0.2, 0.1], [0.1, 1.1, 0.0], [-0.9, 0.3, 0.2]].map(Point3::from);
        let far = [[0.4, -0.7, 1.6], [0.9, 0.1, 1.4], [0.2, 0.6, 1.5]].map(Point3::from);
        let cloud = Cloud::new(&[&near, &far]).unwrap();
        let n = Vector3::new(0.1, -0.2, 1.0).normalize();
        let a = n.cross(&Vector3::y()).normalize();
        let axis = Axis {
            groups: &cloud.groups,
            frame: Matrix3::from_columns(&[a, n.cross(&a), n]),
            point: Vector3::new(0.15, 0.05, 0.1),
        };
        let here = [0.02, -0.1, 0.3, -0.2, 0.1, 0.8, 1.2, 0.7];
        let jacobian = axis.jacobian(&here);
        for k in 0..here.len() {
            let [ahead, behind] = [H, -H].map(|h| {
                let mut there = here;
                there[k] += h;
                axis.residuals(&there)
            });
            for (i, (ahead, behind)) in ahead.iter().zip(behind).enumerate() {
                let difference = (ahead - behind) / (2.0 * H);
                assert!((difference - jacobian[(i, k)]).abs() < 1e-8, "{i} {k}");
            }
        }
    }
}

//! The average line: orthogonal least squares.
//!
//! ```text
//! minimise Σ |d_i - (d_i·v) v|²   over |v| = 1,   d_i = p_i - centroid
//! ```
//!
//! The centroid lies on the line, `v` is the direction of the largest spread.

use nalgebra::{Matrix3, Matrix6, Point3, Unit, Vector3};

use crate::cloud::Cloud;
use crate::principal_axes::principal_axes;
use crate::{Error, Scatter};

/// A straight line with its uncertainty: an average line, or an axis of rotation.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The point of the line that is nearest to the centroid of the points, mm. For
    /// [`fit_line`] it is the centroid.
    pub point_mm: Point3<f64>,
    /// Direction; its sense is said at the function that makes the line.
    pub direction: Unit<Vector3<f64>>,
    /// Covariance of `point_mm` (across the line; mm) and of `direction` (rad), in this order,
    /// for independent coordinates of unit variance (1 mm²). It has rank four: along the line
    /// nothing is uncertain, by definition. First order in the noise.
    pub cofactor: Matrix6<f64>,
    /// Residuals of the fit.
    pub scatter: Scatter,
}

impl Line {
    /// Covariance of `point_mm` (mm) and `direction` (rad), in this order, when each coordinate of
    /// each point has the independent standard deviation `sigma_mm`.
    ///
    /// Without `sigma_mm` it is estimated from the residuals; `None` if there is none to estimate
    /// it from.
    pub fn covariance(&self, sigma_mm: Option<f64>) -> Option<Matrix6<f64>> {
        let variance_mm2 = self.scatter.variance_mm2(sigma_mm)?;
        Some(self.cofactor * variance_mm2)
    }

    /// The same line run through the other way.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.direction = -self.direction;
        for (position, tilt) in (0..3).flat_map(|i| (3..6).map(move |k| (i, k))) {
            self.cofactor[(position, tilt)] = -self.cofactor[(position, tilt)];
            self.cofactor[(tilt, position)] = -self.cofactor[(tilt, position)];
        }
        self
    }
}

/// Least relative difference between the spread along the line and across it. Closer than the
/// square root of the rounding, the points have no direction of their own.
const MAIN_DIRECTION_TOL: f64 = 1.5e-8;

/// The line with the least sum of squared orthogonal distances. Its direction leads from the
/// first point to the last.
///
/// # Errors
/// [`Error::TooFewPoints`] below two, [`Error::NotFinite`], [`Error::Coincident`],
/// [`Error::NoMainDirection`] if the points spread across the line as far as along it.
pub fn fit_line(points: &[Point3<f64>]) -> Result<Line, Error> {
    let &[first, .., last] = points else {
        return Err(Error::TooFewPoints {
            what: "line",
            need: 2,
            found: points.len(),
        });
    };
    let cloud = Cloud::new(&[points])?;
    let centred = cloud.pooled();
    let axes = principal_axes(&centred);
    let [along, across] = [axes.extents[0], axes.extents[1]];
    if along - across <= MAIN_DIRECTION_TOL * along {
        let mm = cloud.unit_mm / (points.len() as f64).sqrt();
        return Err(Error::NoMainDirection {
            along_mm: along * mm,
            across_mm: across * mm,
        });
    }
    let direction = axes.direction(0);
    let squares: f64 = centred
        .iter()
        .map(|d| d.cross(&direction).norm_squared())
        .sum();
    let sense = if (last - first).dot(&direction) < 0.0 {
        -direction
    } else {
        direction
    };
    let unit_mm2 = cloud.unit_mm * cloud.unit_mm;
    Ok(Line {
        point_mm: cloud.to_mm(Vector3::zeros()),
        direction: sense,
        cofactor: cofactor(&direction, points.len(), along * along * unit_mm2),
        scatter: Scatter::new(squares * unit_mm2, points.len(), 4),
    })
}

/// The centroid moves by the mean of the noise across the line, the direction by the regression
/// of the noise on the position `t` along it; the two do not correlate.
fn cofactor(direction: &Vector3<f64>, points: usize, sum_t_mm2: f64) -> Matrix6<f64> {
    let across = Matrix3::identity() - direction * direction.transpose();
    let mut cofactor = Matrix6::zeros();
    cofactor
        .fixed_view_mut::<3, 3>(0, 0)
        .copy_from(&(across / points as f64));
    cofactor
        .fixed_view_mut::<3, 3>(3, 3)
        .copy_from(&(across / sum_t_mm2));
    cofactor
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_from_the_first_point_to_the_last() {
        let points = [3.0, 2.0, 1.0].map(|x| Point3::new(x, 0.0, 5.0));
        let line = fit_line(&points).unwrap();
        assert!((line.direction.into_inner() + Vector3::x()).norm() < 1e-15);
        assert!((line.point_mm - points[1]).norm() < 1e-15);
    }

    /// Straight-line regression: residuals ±1 µm, three degrees of freedom for each side.
    #[test]
    fn estimates_sigma_with_two_n_less_four() {
        let points: Vec<_> = [(0.0, 1e-3), (1.0, -1e-3), (2.0, -1e-3), (3.0, 1e-3)]
            .map(|(x, y)| Point3::new(x * 100.0, y, 7.0))
            .into();
        let line = fit_line(&points).unwrap();
        assert_eq!(line.scatter.degrees_of_freedom, 4);
        let sigma_mm = line.scatter.sigma_mm.unwrap();
        assert!((sigma_mm - 1e-3).abs() < 1e-12);
        let covariance = line.covariance(None).unwrap();
        assert!((covariance[(1, 1)] - 1e-6 / 4.0).abs() < 1e-15);
        assert!((covariance[(5, 5)] - 1e-6 / 5e4).abs() < 1e-19);
        let stated = line.covariance(Some(2.0 * sigma_mm)).unwrap();
        assert!((stated - covariance * 4.0).norm() < 1e-18);
    }

    #[test]
    fn two_points_have_no_residuals_to_estimate_from() {
        let line = fit_line(&[Point3::origin(), Point3::new(0.0, 0.0, 2.0)]).unwrap();
        assert_eq!(line.scatter.sigma_mm, None);
        assert_eq!(line.covariance(None), None);
        assert!(line.covariance(Some(1e-3)).is_some());
    }

    #[test]
    fn refuses_what_has_no_direction() {
        let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
        let square = corners.map(|[x, y]| Point3::new(x, y, 3.0));
        assert!(matches!(
            fit_line(&square),
            Err(Error::NoMainDirection { .. })
        ));
        let one = fit_line(&square[..1]).unwrap_err();
        assert_eq!(one.to_string(), "line: need at least 2 points, found 1");
    }
}

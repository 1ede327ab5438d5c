//! The average line: orthogonal least squares.
//!
//! ```text
//! minimise Σ |d_i - (d_i·v) v|²   over |v| = 1,   d_i = p_i - centroid
//! ```
//!
//! The centroid lies on the line, `v` is the direction of the largest spread.

use nalgebra::{Point3, Unit, Vector3};

use crate::Error;
use crate::cloud::Cloud;
use crate::principal_axes::principal_axes;

/// A straight line: an average line, or an axis of rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// The point of the line that is nearest to the centroid of the points, mm. For
    /// [`fit_line`] it is the centroid.
    pub point_mm: Point3<f64>,
    /// Direction; the function that makes the line states its sense.
    pub direction: Unit<Vector3<f64>>,
}

/// Least relative difference between the spread along the line and across it. Below the square root of the rounding
/// the points have no direction of their own.
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
    let axes = principal_axes(&cloud.pooled());
    let [along, across] = [axes.extents[0], axes.extents[1]];
    if along - across <= MAIN_DIRECTION_TOL * along {
        let mm = cloud.unit_mm / (points.len() as f64).sqrt();
        return Err(Error::NoMainDirection {
            along_mm: along * mm,
            across_mm: across * mm,
        });
    }
    let direction = axes.direction(0);
    let is_reversed = (last - first).dot(&direction) < 0.0;
    Ok(Line {
        point_mm: cloud.to_mm(Vector3::zeros()),
        direction: if is_reversed { -direction } else { direction },
    })
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

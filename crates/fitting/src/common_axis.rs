//! One axis of rotation through the circles of several targets.

use nalgebra::{Matrix6, Point3, SMatrix, Unit, Vector3};

use crate::cloud::Cloud;
use crate::coaxial::{AXIS_UNKNOWNS, Coaxial};
use crate::gauss_newton::{Convergence, Minimum, minimise};
use crate::principal_axes::principal_axes;
use crate::{Error, Line, Scatter};

/// The average axis of rotation with the circle of each target about it.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonAxis {
    /// The axis. Its point is the one nearest to the centroid of all points; the points, in their
    /// order, travel round its direction by the right-hand rule (where that can be told).
    pub axis: Line,
    /// The circles in the order given.
    pub circles: Vec<AxisCircle>,
    /// How the iteration ended.
    pub convergence: Convergence,
}

/// The circle of one target about a common axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisCircle {
    /// Centre, on the axis, mm.
    pub center_mm: Point3<f64>,
    /// Height of the centre above the point of the axis, along its direction, mm.
    pub height_mm: f64,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Variance of the radius for independent coordinates of unit variance. Multiply by the
    /// variance of a coordinate (σ², mm²).
    pub radius_cofactor: f64,
}

/// The axis about which each group of points goes round in a circle of its own radius and height,
/// with the least sum of squared orthogonal distances.
///
/// The start needs no full turn: chords of a circle are perpendicular to the axis, so its
/// direction is the one in which the points of all groups, each relative to its own centroid,
/// spread least; the centre then solves a linear problem in the plane.
///
/// Unknowns are four for the axis and two for each circle. A rotary axis' own errors are not
/// independent noise from point to point: the uncertainty then says less than a repetition.
///
/// # Errors
/// [`Error::TooFewOnCircle`] if a circle has less than two points, [`Error::TooFewPoints`] if there
/// are less than two more points than circles, [`Error::NotFinite`], [`Error::Coincident`],
/// [`Error::Collinear`] if all chords are parallel, [`Error::Undetermined`] for arcs without a
/// bend, whose radii run away. Arcs whose bend is no more than their noise may also end
/// unconverged: see [`CommonAxis::convergence`].
pub fn fit_common_axis(circles: &[&[Point3<f64>]]) -> Result<CommonAxis, Error> {
    if let Some((circle, points)) = circles.iter().enumerate().find(|(_, c)| c.len() < 2) {
        return Err(Error::TooFewOnCircle {
            circle,
            need: 2,
            found: points.len(),
        });
    }
    // Two residuals for each point against 4 + 2 k unknowns; three points for no circle at all.
    let (need, found) = (
        circles.len().max(1) + 2,
        circles.iter().map(|c| c.len()).sum(),
    );
    if found < need {
        return Err(Error::TooFewPoints {
            what: "common axis",
            need,
            found,
        });
    }
    let cloud = Cloud::new(circles)?;
    let axes = principal_axes(&cloud.pooled());
    axes.check_planar(&cloud)?;
    let start = Coaxial::along(&cloud, axes.directions);
    Ok(to_common_axis(&cloud, &minimise(start)?))
}

/// In mm, with the covariance turned from shifts and tilts across the axis into coordinates.
fn to_common_axis(cloud: &Cloud, minimum: &Minimum<Coaxial<'_>>) -> CommonAxis {
    let fitted = &minimum.model;
    let unit_mm = cloud.unit_mm;
    let across = fitted.frame.fixed_columns::<2>(0);
    let mut from_unknowns = SMatrix::<f64, 6, AXIS_UNKNOWNS>::zeros();
    from_unknowns
        .fixed_view_mut::<3, 2>(0, 0)
        .copy_from(&across);
    from_unknowns
        .fixed_view_mut::<3, 2>(3, 2)
        .copy_from(&(across / unit_mm));
    let unknowns =
        SMatrix::<f64, AXIS_UNKNOWNS, AXIS_UNKNOWNS>::from_fn(|i, k| minimum.cofactor[(i, k)]);
    let cofactor: Matrix6<f64> = from_unknowns * unknowns * from_unknowns.transpose();

    let circle = |(k, &(height, radius)): (usize, &(f64, f64))| {
        let radius_unknown = AXIS_UNKNOWNS + 2 * k + 1;
        AxisCircle {
            center_mm: cloud.to_mm(fitted.centre(k)),
            height_mm: height * unit_mm,
            radius_mm: radius * unit_mm,
            radius_cofactor: minimum.cofactor[(radius_unknown, radius_unknown)],
        }
    };
    let unknown_count = AXIS_UNKNOWNS + 2 * fitted.circles.len();
    let squares_mm2 = minimum.squares * unit_mm * unit_mm;
    CommonAxis {
        axis: Line {
            point_mm: cloud.to_mm(fitted.point),
            direction: Unit::new_normalize(Vector3::from(fitted.frame.column(2))),
            cofactor,
            scatter: Scatter::new(squares_mm2, cloud.len(), unknown_count),
        },
        circles: fitted.circles.iter().enumerate().map(circle).collect(),
        convergence: minimum.convergence,
    }
}

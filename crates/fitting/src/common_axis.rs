//! One axis of rotation through the circles of several targets (paper 4.2.3).

use nalgebra::{Point3, Unit};
use trueaxis_leastsquares::dense::Termination;

use crate::circles::Circles;
use crate::cloud::Cloud;
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
    /// Steps of the iteration.
    pub iterations: usize,
    /// How it ended. A result that is not converged is returned, not hidden.
    pub termination: Termination,
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
/// unconverged: see [`CommonAxis::termination`].
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
    Ok(to_common_axis(
        &cloud,
        &Circles::fit(&cloud, axes.directions)?,
    ))
}

/// In mm: covariances of lengths then are of mm², those of angles of rad².
fn to_common_axis(cloud: &Cloud, fitted: &Circles) -> CommonAxis {
    let unit_mm = cloud.unit_mm;
    let mut cofactor = fitted.line_cofactor();
    for i in 3..6 {
        cofactor.row_mut(i).unscale_mut(unit_mm);
        cofactor.column_mut(i).unscale_mut(unit_mm);
    }
    let circle = |(k, &(height, radius)): (usize, &(f64, f64))| AxisCircle {
        center_mm: cloud.to_mm(fitted.centre(k)),
        height_mm: height * unit_mm,
        radius_mm: radius * unit_mm,
        radius_cofactor: fitted.radius_cofactor(k),
    };
    let squares_mm2 = fitted.squares * unit_mm * unit_mm;
    CommonAxis {
        axis: Line {
            point_mm: cloud.to_mm(fitted.point),
            direction: Unit::new_unchecked(fitted.direction),
            cofactor,
            scatter: Scatter::new(squares_mm2, cloud.len(), fitted.unknowns()),
        },
        circles: fitted.circles.iter().enumerate().map(circle).collect(),
        iterations: fitted.iterations,
        termination: fitted.termination.clone(),
    }
}

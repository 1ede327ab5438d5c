//! One axis of rotation through the circles of several targets (paper 4.2.3).

use nalgebra::Point3;
use trueaxis_leastsquares::dense::Termination;

use crate::cloud::Cloud;
use crate::principal_axes::principal_axes;
use crate::{Error, Line, circles};

/// The average axis of rotation with the circle of each target about it.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonAxis {
    /// The axis. Its point is the one nearest to the centroid of all points; in their order the points travel round
    /// its direction by the right-hand rule (undetermined if they go to and fro, or round by half turns).
    pub axis: Line,
    /// The circles in the order given.
    pub circles: Vec<Circle>,
    /// How the iteration ended. A result that is not converged is returned, not hidden.
    pub termination: Termination,
}

/// The circle of one target about a common axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Centre, on the axis, mm.
    pub center_mm: Point3<f64>,
    /// Radius, mm.
    pub radius_mm: f64,
}

/// The axis about which each group of points goes round in a circle of its own radius and height,
/// with the least sum of squared orthogonal distances. One group alone has its own circle in space.
///
/// The start needs no full turn: chords of a circle are perpendicular to the axis, so its
/// direction is the one in which the points of all groups, each relative to its own centroid,
/// spread least; the centre then solves a linear problem in the plane.
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
    let need = circles.len().max(1) + 2;
    let found = circles.iter().map(|c| c.len()).sum();
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
    circles::fit(&cloud, axes.directions)
}

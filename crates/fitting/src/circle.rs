//! The average circle in space, by NIST's two steps or by orthogonal distance.

use nalgebra::{Point3, Unit, Vector3};
use trueaxis_leastsquares::dense::Termination;

use crate::circles::Circles;
use crate::cloud::Cloud;
use crate::principal_axes::principal_axes;
use crate::{Error, Scatter};

/// A circle in space.
#[derive(Debug, Clone, PartialEq)]
pub struct Circle {
    /// Centre, mm.
    pub center_mm: Point3<f64>,
    /// Unit normal of its plane. The points, in their order, travel round it by the right-hand
    /// rule; where that cannot be told (they go to and fro, or round by half turns) either sense.
    pub normal: Unit<Vector3<f64>>,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Residuals of the fit, out of the plane and in it.
    pub scatter: Scatter,
    /// How the iteration ended. A result that is not converged is returned, not hidden.
    pub termination: Termination,
}

/// The circle as NIST defines it for its reference pairs: first the least-squares plane, then
/// the geometric least-squares circle of the points projected onto it.
///
/// The plane takes no account of the circle, so this is not quite the circle nearest to the
/// points; see [`fit_circle`].
///
/// # Errors
/// [`Error::TooFewPoints`] below three, [`Error::NotFinite`], [`Error::Coincident`],
/// [`Error::Collinear`], [`Error::Undetermined`] for an arc without a bend, whose radius runs away.
/// An arc whose bend is no more than its noise may also end unconverged: see
/// [`Circle::termination`].
pub fn fit_circle_two_step(points: &[Point3<f64>]) -> Result<Circle, Error> {
    let mut cloud = circle_cloud(points)?;
    let axes = principal_axes(&cloud.pooled());
    axes.check_planar(&cloud)?;
    let normal = axes.directions.column(2).into_owned();
    let mut out_of_plane = 0.0;
    for p in cloud.groups.iter_mut().flatten() {
        let height = normal.dot(p);
        out_of_plane += height * height;
        *p -= normal * height;
    }
    // Of points in a plane, the nearest circle in space lies in it.
    let mut circle = Circles::fit(&cloud, axes.directions)?;
    circle.squares += out_of_plane;
    Ok(to_circle(&cloud, &circle))
}

/// The circle with the least sum of squared orthogonal distances in space: `Σ h² + (ρ - R)²`
/// with `h` the distance from its plane and `ρ` the distance from its axis.
///
/// # Errors
/// As [`fit_circle_two_step`].
pub fn fit_circle(points: &[Point3<f64>]) -> Result<Circle, Error> {
    let cloud = circle_cloud(points)?;
    let axes = principal_axes(&cloud.pooled());
    axes.check_planar(&cloud)?;
    Ok(to_circle(&cloud, &Circles::fit(&cloud, axes.directions)?))
}

fn circle_cloud(points: &[Point3<f64>]) -> Result<Cloud, Error> {
    if points.len() < 3 {
        return Err(Error::TooFewPoints {
            what: "circle",
            need: 3,
            found: points.len(),
        });
    }
    Cloud::new(&[points])
}

/// In mm.
fn to_circle(cloud: &Cloud, fitted: &Circles) -> Circle {
    let unit_mm = cloud.unit_mm;
    let squares_mm2 = fitted.squares * unit_mm * unit_mm;
    Circle {
        center_mm: cloud.to_mm(fitted.centre(0)),
        normal: Unit::new_unchecked(fitted.direction),
        radius_mm: fitted.circles[0].1 * unit_mm,
        scatter: Scatter::new(squares_mm2, cloud.len(), fitted.unknowns()),
        termination: fitted.termination.clone(),
    }
}

//! The average circle in space, by NIST's two steps or by orthogonal distance.

use nalgebra::{Point3, SMatrix, Unit, Vector3};

use crate::cloud::Cloud;
use crate::coaxial::{AXIS_UNKNOWNS, Coaxial, in_plane};
use crate::gauss_newton::{Convergence, Minimum, cofactor, minimise};
use crate::planar_circle::PlanarCircle;
use crate::principal_axes::principal_axes;
use crate::{Error, Scatter};

/// A circle in space with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct Circle {
    /// Centre, mm.
    pub center_mm: Point3<f64>,
    /// Unit normal of its plane. The points, in their order, travel round it by the right-hand
    /// rule; where that cannot be told (they go to and fro, or round by half turns) either sense.
    pub normal: Unit<Vector3<f64>>,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Covariance of centre (mm), normal (rad) and radius (mm), in this order, for independent
    /// coordinates of unit variance (1 mm²). First order in the noise, where both definitions of
    /// the circle agree.
    pub cofactor: SMatrix<f64, 7, 7>,
    /// Residuals of the fit, out of the plane and in it.
    pub scatter: Scatter,
    /// How the iteration ended; for the two-step circle that of the second step.
    pub convergence: Convergence,
}

impl Circle {
    /// Covariance of centre (mm), normal (rad) and radius (mm), in this order, when each
    /// coordinate of each point has the independent standard deviation `sigma_mm`.
    ///
    /// Without `sigma_mm` it is estimated from the residuals; `None` if there is none to estimate
    /// it from.
    pub fn covariance(&self, sigma_mm: Option<f64>) -> Option<SMatrix<f64, 7, 7>> {
        let variance_mm2 = self.scatter.variance_mm2(sigma_mm)?;
        Some(self.cofactor * variance_mm2)
    }
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
/// [`Circle::convergence`].
pub fn fit_circle_two_step(points: &[Point3<f64>]) -> Result<Circle, Error> {
    let cloud = circle_cloud(points)?;
    let (circle, convergence) = two_steps(&cloud)?;
    let (squares, cofactor) = cofactor(&circle)?;
    Ok(to_circle(
        &cloud,
        &Minimum {
            model: circle,
            squares,
            cofactor,
            convergence,
        },
    ))
}

/// The circle with the least sum of squared orthogonal distances in space: `Σ h² + (ρ - R)²`
/// with `h` the distance from its plane and `ρ` the distance from its axis.
///
/// # Errors
/// As [`fit_circle_two_step`], from which it starts.
pub fn fit_circle(points: &[Point3<f64>]) -> Result<Circle, Error> {
    let cloud = circle_cloud(points)?;
    let (start, _) = two_steps(&cloud)?;
    Ok(to_circle(&cloud, &minimise(start)?))
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

/// Plane, then circle in the plane.
fn two_steps(cloud: &Cloud) -> Result<(Coaxial<'_>, Convergence), Error> {
    let centred = cloud.pooled();
    let axes = principal_axes(&centred);
    axes.check_planar(cloud)?;
    let planar = in_plane(&centred, &axes.directions);
    let circle = PlanarCircle::fit(&planar)?;
    Ok((
        Coaxial::about(cloud, axes.directions, circle.model.centre),
        circle.convergence,
    ))
}

/// In mm, with the covariance turned from shifts and tilts across the axis into coordinates.
fn to_circle(cloud: &Cloud, minimum: &Minimum<Coaxial<'_>>) -> Circle {
    let circle = &minimum.model;
    let unit_mm = cloud.unit_mm;
    let (height, radius) = circle.circles[0];
    let mut from_unknowns = SMatrix::<f64, 7, 6>::zeros();
    for k in 0..2 {
        let across = circle.frame.column(k);
        // The axis tilts about `q`, one height below the centre.
        from_unknowns
            .fixed_view_mut::<3, 1>(0, k)
            .copy_from(&across);
        from_unknowns
            .fixed_view_mut::<3, 1>(0, 2 + k)
            .copy_from(&(across * height));
        from_unknowns
            .fixed_view_mut::<3, 1>(3, 2 + k)
            .copy_from(&(across / unit_mm));
    }
    from_unknowns
        .fixed_view_mut::<3, 1>(0, AXIS_UNKNOWNS)
        .copy_from(&circle.frame.column(2));
    from_unknowns[(6, AXIS_UNKNOWNS + 1)] = 1.0;
    let unknowns = SMatrix::<f64, 6, 6>::from_fn(|i, k| minimum.cofactor[(i, k)]);
    let points = cloud.len();
    Circle {
        center_mm: cloud.to_mm(circle.centre(0)),
        normal: Unit::new_normalize(circle.frame.column(2).into_owned()),
        radius_mm: radius * unit_mm,
        cofactor: from_unknowns * unknowns * from_unknowns.transpose(),
        scatter: Scatter::new(minimum.squares * unit_mm * unit_mm, points, 6),
        convergence: minimum.convergence,
    }
}

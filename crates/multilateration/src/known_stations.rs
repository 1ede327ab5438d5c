//! The plain case: a point from stations that are known already.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::{Error, Noise};

/// A station whose position and dead path are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownStation {
    /// Position, mm.
    pub position_mm: Point3<f64>,
    /// Dead path, mm: the distance at which the interferometer reads zero.
    pub dead_path_mm: f64,
}

/// A point found from known stations.
#[derive(Debug, Clone, PartialEq)]
pub struct Located {
    /// Position, mm.
    pub position_mm: Point3<f64>,
    /// Covariance for the noise as given, mm².
    pub covariance_mm2: Matrix3<f64>,
    /// Observed minus computed lengths, mm.
    pub residuals_mm: Vec<f64>,
    /// Iterations used.
    pub iterations: usize,
    /// Length of the last correction, mm.
    pub last_correction_mm: f64,
}

/// Converged when the point moves by less than this: below a nanometre nothing is measured, above
/// the rounding of coordinates of some metres.
const CORRECTION_TOL_MM: f64 = 1e-9;

const MAX_ITERATIONS: usize = 50;

/// Ratio of the extreme pivots of the normal matrix below which the beams lie in one plane.
const PLANE_TOL: f64 = 1e-10;

/// Finds a point from its lengths to known stations: multilateration without self-calibration.
///
/// `lengths_mm[j]` is `|p - S_j| - L_j`. Three stations leave two mirror images; the iteration
/// goes to the one on `near_mm`'s side. The lengths are taken as independent: all of them belong to
/// the place where the target was, so the repeatability error has no part in the result.
///
/// # Errors
/// [`Error::TooFewStations`] below three stations, [`Error::PointNotDetermined`] if the beams lie
/// in one plane, [`Error::Malformed`] if the numbers of stations and lengths differ or a number is
/// not finite.
pub fn locate(
    stations: &[KnownStation],
    lengths_mm: &[f64],
    noise: &Noise,
    near_mm: Point3<f64>,
) -> Result<Located, Error> {
    noise.check()?;
    if stations.len() != lengths_mm.len() {
        let what = format!(
            "{} stations but {} lengths",
            stations.len(),
            lengths_mm.len()
        );
        return Err(Error::Malformed { what });
    }
    if stations.len() < 3 {
        return Err(Error::TooFewStations {
            need: 3,
            found: stations.len(),
        });
    }
    let finite = lengths_mm
        .iter()
        .chain(near_mm.iter())
        .all(|x| x.is_finite())
        && stations
            .iter()
            .all(|s| s.dead_path_mm.is_finite() && s.position_mm.iter().all(|x| x.is_finite()));
    if !finite {
        let what = "a length or a station is not finite".to_owned();
        return Err(Error::Malformed { what });
    }
    let mut point = near_mm;
    let mut iterations = 0;
    loop {
        let (normal, right) = normal_equations(stations, lengths_mm, noise, point);
        let inverse = inverted(&normal)?;
        let correction = inverse * right;
        point += correction;
        iterations += 1;
        let last_correction_mm = correction.norm();
        if last_correction_mm <= CORRECTION_TOL_MM || iterations == MAX_ITERATIONS {
            return Ok(Located {
                position_mm: point,
                covariance_mm2: inverse,
                residuals_mm: residuals(stations, lengths_mm, point),
                iterations,
                last_correction_mm,
            });
        }
    }
}

/// Weighted normal equations of one point.
fn normal_equations(
    stations: &[KnownStation],
    lengths_mm: &[f64],
    noise: &Noise,
    point: Point3<f64>,
) -> (Matrix3<f64>, Vector3<f64>) {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for (station, length) in stations.iter().zip(lengths_mm) {
        let beam = point - station.position_mm;
        let distance = beam.norm();
        let u = beam / distance;
        let weight = noise.length_sigma_at_mm(distance).powi(-2);
        normal += u * u.transpose() * weight;
        right += u * (weight * (length + station.dead_path_mm - distance));
    }
    (normal, right)
}

fn inverted(normal: &Matrix3<f64>) -> Result<Matrix3<f64>, Error> {
    let eigenvalues = normal.symmetric_eigenvalues();
    let pivot = eigenvalues.min() / eigenvalues.max();
    let not_determined = Error::PointNotDetermined {
        group: 0,
        point: 0,
        pivot,
        limit: PLANE_TOL,
    };
    if pivot.is_nan() || pivot < PLANE_TOL {
        return Err(not_determined);
    }
    normal.try_inverse().ok_or(not_determined)
}

fn residuals(stations: &[KnownStation], lengths_mm: &[f64], point: Point3<f64>) -> Vec<f64> {
    let computed = |s: &KnownStation| (point - s.position_mm).norm() - s.dead_path_mm;
    stations
        .iter()
        .zip(lengths_mm)
        .map(|(s, l)| l - computed(s))
        .collect()
}

//! How far the truth is off nominal, and a solution off the truth.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_multilateration::Solution;

use crate::world::Truth;

/// The rigid motion that fits the true points best to the nominal ones, by a singular value
/// decomposition (the solver has datum equations).
#[expect(
    clippy::disallowed_methods,
    reason = "matrices of three by three are decomposed by another algorithm, which is right"
)]
fn best_fit(points: &[Point3<f64>], nominal: &[Point3<f64>]) -> Isometry3<f64> {
    let centre =
        |all: &[Point3<f64>]| all.iter().map(|p| p.coords).sum::<Vector3<f64>>() / all.len() as f64;
    let (cp, cn) = (centre(points), centre(nominal));
    let mut covariance = Matrix3::zeros();
    for (p, n) in points.iter().zip(nominal) {
        covariance += (n.coords - cn) * (p.coords - cp).transpose();
    }
    let svd = covariance.svd(true, true);
    let (u, v_t) = (svd.u.unwrap(), svd.v_t.unwrap());
    let sign = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant()));
    let rotation =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(u * sign * v_t));
    Translation3::from(cn) * rotation * Translation3::from(-cp)
}

/// Largest distance between the solution and the truth brought into the solution's datum, mm.
pub(crate) fn largest_deviation_mm(
    solution: &Solution,
    truth: &Truth,
    nominal: &[Point3<f64>],
) -> f64 {
    let datum_from_truth = best_fit(&truth.points, nominal);
    let points = solution.points_mm.iter().zip(&truth.points);
    let stations = solution.stations.iter().zip(&truth.stations);
    points
        .map(|(found, p)| (found - datum_from_truth * p).norm())
        .chain(stations.map(|(found, (s, l))| {
            let shift = (found.position_mm - datum_from_truth * s).norm();
            shift.max((found.dead_path_mm - l).abs())
        }))
        .fold(0.0, f64::max)
}

/// The true points are up to `size_mm` off nominal.
pub(crate) fn disturbed(nominal: &[Point3<f64>], size_mm: f64, seed: u64) -> Vec<Point3<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut shift = || (rng.random::<f64>() - 0.5) * 2.0 * size_mm;
    nominal
        .iter()
        .map(|p| p + Vector3::new(shift(), shift(), shift()))
        .collect()
}

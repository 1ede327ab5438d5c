//! The rigid motion that fits points best to others (orthogonal Procrustes, no reflection).

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// `to_from_points`: minimises `Σ |to_i - T from_i|²` over all rotations and translations.
pub(crate) fn rigid_fit(from: &[Point3<f64>], to: &[Point3<f64>]) -> Isometry3<f64> {
    let (from_centre, to_centre) = (centroid(from), centroid(to));
    let mut covariance = Matrix3::zeros();
    for (f, t) in from.iter().zip(to) {
        covariance += (t - to_centre) * (f - from_centre).transpose();
    }
    let svd = covariance.svd(true, true);
    let rotation = match (svd.u, svd.v_t) {
        (Some(u), Some(v_t)) => {
            // The smallest singular value takes the sign that makes it a rotation.
            let sign = (u * v_t).determinant().signum();
            let mut signs = Vector3::repeat(1.0);
            signs[svd.singular_values.imin()] = sign;
            Rotation3::from_matrix_unchecked(u * Matrix3::from_diagonal(&signs) * v_t)
        }
        _ => Rotation3::identity(),
    };
    Translation3::from(to_centre.coords)
        * UnitQuaternion::from_rotation_matrix(&rotation)
        * Translation3::from(-from_centre.coords)
}

/// Mean of the points; the origin for none.
pub(crate) fn centroid(points: &[Point3<f64>]) -> Point3<f64> {
    let sum: Vector3<f64> = points.iter().map(|p| p.coords).sum();
    Point3::from(sum / points.len().max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_a_motion_and_never_a_mirror_image() {
        let from = [
            [0.0, 0.0, 0.0],
            [100.0, 0.0, 5.0],
            [0.0, 80.0, 1.0],
            [30.0, 20.0, 60.0],
        ]
        .map(Point3::from);
        let motion = Isometry3::new(Vector3::new(1e3, -50.0, 7.0), Vector3::new(2.0, -1.0, 0.5));
        let to = from.map(|p| motion * p);
        let found = rigid_fit(&from, &to);
        for (f, t) in from.iter().zip(&to) {
            assert!((found * f - t).norm() < 1e-10);
        }
        let mirrored = from.map(|p| Point3::new(-p.x, p.y, p.z));
        let found = rigid_fit(&from, &mirrored);
        assert!((found.rotation.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn three_points_suffice() {
        let from = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 80.0, 0.0]].map(Point3::from);
        let motion = Isometry3::new(Vector3::new(3.0, 2.0, 1.0), Vector3::new(0.1, 3.0, 0.2));
        let to = from.map(|p| motion * p);
        let found = rigid_fit(&from, &to);
        assert!(
            from.iter()
                .zip(&to)
                .all(|(f, t)| (found * f - t).norm() < 1e-10)
        );
    }
}

//! The rigid motion that brings points nearest to others.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// A decomposition of nine numbers needs a few.
const MOST_SWEEPS: usize = 100;

/// The motion that takes points to where they fit others best: about the centroids the rotation
/// `R = V diag(1, 1, det VUᵀ) Uᵀ` from `Σ (p - p̄)(n - n̄)ᵀ = U S Vᵀ` (W. Kabsch, *Acta Crystallographica* A
/// 32, 922, 1976).
#[expect(
    clippy::disallowed_methods,
    reason = "matrices of three by three are decomposed by another algorithm, which is right"
)]
pub fn best_fit(points: &[Point3<f64>], to: &[Point3<f64>]) -> Isometry3<f64> {
    let (from_centre, to_centre) = (centroid(points), centroid(to));
    let mut products = Matrix3::zeros();
    for (p, n) in points.iter().zip(to) {
        products += (p - from_centre) * (n - to_centre).transpose();
    }
    let largest = products.amax();
    if largest > 0.0 {
        products /= largest;
    }
    let svd = products.try_svd(true, true, f64::EPSILON, MOST_SWEEPS);
    let turn = match svd.map(|svd| (svd.u, svd.v_t)) {
        Some((Some(u), Some(v_t))) => {
            let sides = Vector3::new(1.0, 1.0, (u * v_t).determinant());
            let turn = v_t.transpose() * Matrix3::from_diagonal(&sides) * u.transpose();
            let turn = Rotation3::from_matrix_unchecked(turn);
            polished(UnitQuaternion::from_rotation_matrix(&turn), &products)
        }
        // Points that are not finite.
        _ => UnitQuaternion::identity(),
    };
    let shift = to_centre.coords - turn * from_centre.coords;
    Isometry3::from_parts(Translation3::from(shift), turn)
}

/// The rotation `R` that makes `R Σ q nᵀ` symmetric, from one that nearly does: the decomposition knows
/// a turn about the long axis of a thin network to rounding times the square of how thin it is, this
/// to rounding times that. With `C = R Σ q nᵀ` the turn that is left is `(tr C - C)⁻¹ Σ Rq × n`.
pub fn polished(turn: UnitQuaternion<f64>, products: &Matrix3<f64>) -> UnitQuaternion<f64> {
    let c = turn.to_rotation_matrix() * products;
    let symmetric = (c + c.transpose()) * 0.5;
    let hessian = Matrix3::from_diagonal_element(c.trace()) - symmetric;
    let moment = Vector3::new(
        c[(1, 2)] - c[(2, 1)],
        c[(2, 0)] - c[(0, 2)],
        c[(0, 1)] - c[(1, 0)],
    );
    match hessian.try_inverse() {
        Some(inverse) => UnitQuaternion::from_scaled_axis(inverse * moment) * turn,
        // Points on a line: any turn about it is as good.
        None => turn,
    }
}

/// Mean of some points; the origin for none.
pub fn centroid(points: &[Point3<f64>]) -> Point3<f64> {
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
        let found = best_fit(&from, &to);
        for (f, t) in from.iter().zip(&to) {
            assert!((found * f - t).norm() < 1e-10);
        }
        let mirrored = from.map(|p| Point3::new(-p.x, p.y, p.z));
        let found = best_fit(&from, &mirrored);
        assert!((found.rotation.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-12);
    }

    /// Thin and plane points, turned and shifted, come back to rounding.
    #[test]
    fn thin_and_plane_points_return() {
        for thin in [1.0, 1e-2, 1e-3] {
            for thick in [thin, 0.0] {
                let place = |i: usize| {
                    let wave = |k: f64| (k * (i as f64 + 0.3)).sin();
                    Point3::new(wave(1.7), thin * wave(2.9), thick * wave(4.3)) * 500.0
                };
                let nominal: Vec<_> = (0..40).map(place).collect();
                let turn = Vector3::new(0.02, -0.01, 0.03);
                let away = Isometry3::new(Vector3::new(3.0, -7.0, 2.0), turn);
                let moved: Vec<_> = nominal.iter().map(|p| away * p).collect();
                let back = best_fit(&moved, &nominal);
                for (moved, nominal) in moved.iter().zip(&nominal) {
                    let left = (back * moved - nominal).norm();
                    assert!(left < 1e-10, "{left} of {thin} and {thick}");
                }
            }
        }
    }

    #[test]
    fn three_points_suffice() {
        let from = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 80.0, 0.0]].map(Point3::from);
        let motion = Isometry3::new(Vector3::new(3.0, 2.0, 1.0), Vector3::new(0.1, 3.0, 0.2));
        let to = from.map(|p| motion * p);
        let found = best_fit(&from, &to);
        assert!(
            from.iter()
                .zip(&to)
                .all(|(f, t)| (found * f - t).norm() < 1e-10)
        );
    }
}

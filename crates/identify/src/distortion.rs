//! What no rigid motion does to three targets, and the weighted nine equations by way of it.
//!
//! Out of their plane three points always move like a rigid body. In it, and without their mean,
//! displacements are the 2 × 2 matrices `V` over two orthonormal contrasts `q_k` of the targets
//! (`Σ_j q_kj = 0`) and two unit vectors `e_l`:
//!
//! ```text
//! v_j = Σ_kl q_kj V_kl e_l        r_j = c + Σ_kl q_kj X_kl e_l
//! ```
//!
//! A rotation makes of `X` the matrix with `V_k1 = -X_k2`, `V_k2 = X_k1`. The three that are
//! orthogonal to it, the distortions, follow by permuting its four elements. With their basis `B`
//! (`BᵀB = I`, `BᵀA = 0`) and the plain least-squares operator `P₀`, generalised least squares is
//!
//! ```text
//! P = P₀ - P₀ C B (Bᵀ C B)⁻¹ Bᵀ
//! ```
//!
//! (`P A = I`, and the estimate does not correlate with the distortions: `P C B = 0`. C. R. Rao,
//! Least squares theory using an estimated dispersion matrix, 1967.)

use nalgebra::{Matrix3, Matrix6x3, SMatrix, SVector, Vector3, Vector4};

use crate::Error;
use crate::covariance::cholesky;
use crate::three_targets::ThreeTargets;

/// `B`: columns are distortions, rows the coordinates of P, Q, K.
pub(crate) type Distortions = SMatrix<f64, 9, 3>;

/// 9 x 9, mm².
pub(crate) type Covariance9 = SMatrix<f64, 9, 9>;

/// Components of the two contrasts: `(-1, 1, 0)/√2` and `(-1, -1, 2)/√6`.
const ROOT_HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
const ROOT_SIXTH: f64 = 0.408_248_290_463_863;

impl ThreeTargets<f64> {
    /// An orthonormal basis of what no rigid motion of the targets reaches.
    pub(crate) fn distortions(&self) -> Distortions {
        let [a, b] = self.sides_mm();
        let along = if a.norm_squared() > b.norm_squared() {
            a
        } else {
            b
        };
        let e_1 = along.normalize();
        let e_2 = self.normal().cross(&e_1);
        // Rows of X by the contrasts of the positions.
        let [x_1, x_2] = [a * ROOT_HALF, (b * 2.0 - a) * ROOT_SIXTH];
        let rotation =
            Vector4::new(-x_1.dot(&e_2), x_1.dot(&e_1), -x_2.dot(&e_2), x_2.dot(&e_1)).normalize();
        let [a, b, c, d]: [f64; 4] = rotation.into();
        let orthogonal = [[-b, a, -d, c], [-c, d, a, -b], [-d, -c, b, a]];
        let mut basis = Distortions::zeros();
        for (m, [v_11, v_12, v_21, v_22]) in orthogonal.into_iter().enumerate() {
            let first = (e_1 * v_11 + e_2 * v_12) * ROOT_HALF;
            let second = (e_1 * v_21 + e_2 * v_22) * ROOT_SIXTH;
            for (j, v) in [-first - second, first - second, second * 2.0]
                .iter()
                .enumerate()
            {
                basis.fixed_view_mut::<3, 1>(3 * j, m).copy_from(v);
            }
        }
        basis
    }

    /// The columns of the generalised least squares operator that belong to each target.
    ///
    /// # Errors
    /// [`Error::Covariance`] if the covariance of the distortions is not safely positive definite.
    pub(crate) fn weighted_blocks(
        &self,
        covariance: &Covariance9,
    ) -> Result<[Matrix6x3<f64>; 3], Error> {
        let basis = self.distortions();
        let with_distortions = covariance * basis;
        let own = basis.tr_mul(&with_distortions);
        let variances_mm2 = Vector3::repeat(covariance.diagonal().max());
        let own = cholesky(&symmetric(own), &variances_mm2)?;
        let mut blocks = self.blocks();
        let mut correlated = Matrix6x3::zeros();
        for (j, block) in blocks.iter().enumerate() {
            correlated += block * with_distortions.fixed_rows::<3>(3 * j);
        }
        // P₀ C B (Bᵀ C B)⁻¹
        let share = own.solve(&correlated.transpose()).transpose();
        for (j, block) in blocks.iter_mut().enumerate() {
            *block -= share * basis.fixed_rows::<3>(3 * j).transpose();
        }
        Ok(blocks)
    }

    /// `(BᵀΔ)ᵀ (Bᵀ C B)⁻¹ BᵀΔ`: the weighted sum of squares of what no rigid motion explains.
    ///
    /// # Errors
    /// As [`ThreeTargets::weighted_blocks`].
    pub(crate) fn distortion_squares(
        &self,
        delta: &[Vector3<f64>; 3],
        covariance: &Covariance9,
    ) -> Result<f64, Error> {
        let basis = self.distortions();
        let own = symmetric(basis.tr_mul(&(covariance * basis)));
        let variances_mm2 = Vector3::repeat(covariance.diagonal().max());
        let [p, q, k] = delta;
        let delta = SVector::<f64, 9>::from_iterator([p, q, k].into_iter().flatten().copied());
        let distortion = basis.tr_mul(&delta);
        Ok(distortion.dot(&cholesky(&own, &variances_mm2)?.solve(&distortion)))
    }
}

fn symmetric(matrix: Matrix3<f64>) -> Matrix3<f64> {
    (matrix + matrix.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nine::whitened;
    use crate::{equations, nine_weighted};
    use nalgebra::DMatrix;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn random(rng: &mut ChaCha8Rng, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| rng.random_range(-size..size))
    }

    #[test]
    fn distortions_are_orthonormal_and_no_rigid_motion() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..200 {
            let r = [(); 3].map(|()| random(&mut rng, 400.0));
            let basis = ThreeTargets::new(&r).unwrap().distortions();
            assert!((basis.tr_mul(&basis) - Matrix3::identity()).norm() < 1e-14);
            // Lever arms are some hundred mm.
            assert!((basis.transpose() * equations(&r)).norm() < 1e-10);
        }
    }

    /// The operator is that of orthogonal factors of the whitened equations.
    #[test]
    fn weighted_operator_equals_orthogonal_factors() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        for _ in 0..1_000 {
            let r = [(); 3].map(|()| random(&mut rng, 400.0));
            let l = DMatrix::from_fn(9, 9, |i, j| match i.cmp(&j) {
                std::cmp::Ordering::Greater => rng.random_range(-1.0..1.0),
                std::cmp::Ordering::Equal => rng.random_range(1.0..2.0),
                std::cmp::Ordering::Less => 0.0,
            });
            let product = &l * l.transpose();
            let covariance = (&product + product.transpose()) * 0.5;
            let found = nine_weighted(&r, &covariance).unwrap().matrix();
            let mut whitening = DMatrix::identity(9, 9);
            assert!(l.solve_lower_triangular_mut(&mut whitening));
            let expected = whitened(&r, whitening).unwrap().matrix();
            for rows in [0, 3] {
                let (found, expected) = (found.rows(rows, 3), expected.rows(rows, 3));
                let difference = (found - expected).norm() / expected.norm();
                // The condition of the random factors is some hundred, that of triangles too.
                assert!(difference < 1e-11, "{difference:e}");
            }
        }
    }
}

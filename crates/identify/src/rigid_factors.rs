//! Orthogonal factors of the equations, which split displacements of the targets into a rigid motion and a
//! distortion.
//!
//! With the centred equations `A = Q₁ R` and an orthonormal basis `B` of what no rigid motion
//! reaches (`Bᵀ A = 0`; 3T - 6 columns, three for a triangle),
//!
//! ```text
//! plain least squares        P₀ = R⁻¹ Q₁ᵀ
//! generalised least squares  P = P₀ - P₀ C B (Bᵀ C B)⁻¹ Bᵀ
//! test of rigidity           χ² = (Bᵀ Δ)ᵀ (Bᵀ C B)⁻¹ (Bᵀ Δ)
//! ```
//!
//! (`P A = I`, and the estimate is uncorrelated with the distortions: `P C B = 0`. C. R. Rao, Least squares theory
//! using an estimated dispersion matrix, 1967.)

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, OMatrix, U6, Vector3};

use crate::covariance::cholesky;
use crate::design::{CentredTargets, Extent};
use crate::{Error, Operator};

/// `R⁻¹ Q₁ᵀ` and `Bᵀ` of targets that span a plane.
pub(crate) struct RigidFactors {
    centred: CentredTargets,
    /// `P₀` for the centred and scaled unknowns, 6 x 3T.
    plain: OMatrix<f64, U6, Dyn>,
    /// `Bᵀ`, (3T - 6) x 3T.
    distortions: DMatrix<f64>,
}

impl RigidFactors {
    /// # Errors
    /// [`Error::TooFewTargets`], [`Error::NotFinite`], [`Error::Collinear`].
    pub(crate) fn new(r: &[Vector3<f64>]) -> Result<Self, Error> {
        let centred = CentredTargets::new(r)?;
        let size = 3 * r.len();
        let qr = centred.equations().qr();
        let mut q_transposed = DMatrix::identity(size, size);
        qr.q_tr_mul(&mut q_transposed);
        let mut plain = q_transposed.fixed_rows::<6>(0).into_owned();
        let upper = qr.r().fixed_rows::<6>(0).into_owned();
        // Targets that are not collinear give a regular R; a zero on its diagonal shows that they are.
        if !upper.solve_upper_triangular_mut(&mut plain) {
            return Err(Extent::of(r).collinear());
        }
        Ok(Self {
            centred,
            plain,
            distortions: q_transposed.rows(6, size - 6).into_owned(),
        })
    }

    /// The operator `P₀`.
    pub(crate) fn plain(&self, r: &[Vector3<f64>]) -> Operator {
        Operator::from_scaled(r, &self.centred, self.plain.clone())
    }

    /// The operator `P` for points with the covariance C.
    ///
    /// # Errors
    /// [`Error::Covariance`] if the covariance of the distortions is not safely positive definite.
    pub(crate) fn weighted(
        &self,
        r: &[Vector3<f64>],
        covariance: &DMatrix<f64>,
    ) -> Result<Operator, Error> {
        let with_distortions = covariance * self.distortions.transpose();
        let of_distortions = self.of_distortions(covariance, &with_distortions)?;
        let correlated = (&self.plain * with_distortions).transpose();
        let share = of_distortions.solve(&correlated);
        let scaled = &self.plain - share.tr_mul(&self.distortions);
        Ok(Operator::from_scaled(r, &self.centred, scaled))
    }

    /// χ² of the volumetric errors Δ of points with the covariance C.
    pub(crate) fn chi_squared(
        &self,
        delta: &[Vector3<f64>],
        covariance: &DMatrix<f64>,
    ) -> Result<f64, Error> {
        let with_distortions = covariance * self.distortions.transpose();
        let of_distortions = self.of_distortions(covariance, &with_distortions)?;
        let delta = DVector::from_iterator(3 * delta.len(), delta.iter().flatten().copied());
        let distortion = &self.distortions * delta;
        Ok(distortion.dot(&of_distortions.solve(&distortion)))
    }

    /// Factors of `Bᵀ C B`, from `C B`.
    fn of_distortions(
        &self,
        covariance: &DMatrix<f64>,
        with_distortions: &DMatrix<f64>,
    ) -> Result<Cholesky<f64, Dyn>, Error> {
        let product = &self.distortions * with_distortions;
        let symmetric = (&product + product.transpose()) * 0.5;
        let variances_mm2 = DVector::repeat(symmetric.nrows(), covariance.diagonal().max());
        cholesky(&symmetric, &variances_mm2)
    }
}

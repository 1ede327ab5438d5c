//! Generalised least squares and the test of rigidity.

use nalgebra::{DMatrix, DVector, Dyn, Matrix3, Matrix6, MatrixXx6, OMatrix, U6, Vector3, Vector6};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_identify::{Error, Operator, SixRows, equations, nine, nine_weighted, rigid_misfit};
use trueaxis_kinematics::MotionError;

use crate::targets::{
    THREE_AXIS, displacement, random_error, random_targets, random_vector, reach,
    relative_difference,
};

pub(crate) fn normal(rng: &mut impl Rng, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| StandardNormal.sample(rng))
}

/// Correlated coordinates with standard deviations of some µm, mm².
pub(crate) fn random_covariance(rng: &mut impl Rng) -> DMatrix<f64> {
    let root = normal(rng, 9, 9) * 1e-3;
    DMatrix::identity(9, 9) * 1e-6 + &root * root.transpose()
}

/// `A Φ Aᵀ`: an uncertain rigid motion of all targets by some µm and arcsec, mm².
fn rigid_covariance(rng: &mut impl Rng, r: &[Vector3<f64>]) -> DMatrix<f64> {
    let size = Vector6::new(2e-3, 2e-3, 2e-3, 1e-5, 1e-5, 1e-5);
    let displacements = equations(r) * Matrix6::from_diagonal(&size) * normal(rng, 6, 6);
    &displacements * displacements.transpose()
}

/// The matrix of an operator with ε times `reach_mm`, so that all rows are mm per mm.
fn in_mm(operator: &Operator, reach_mm: f64) -> OMatrix<f64, U6, Dyn> {
    let mut matrix = operator.matrix();
    matrix.fixed_rows_mut::<3>(3).scale_mut(reach_mm);
    matrix
}

/// The equations for ε times `reach_mm`.
fn equations_in_mm(r: &[Vector3<f64>], reach_mm: f64) -> MatrixXx6<f64> {
    let mut matrix = equations(r);
    matrix.fixed_columns_mut::<3>(3).unscale_mut(reach_mm);
    matrix
}

/// Of a symmetric matrix.
fn condition_number(matrix: DMatrix<f64>) -> f64 {
    let eigenvalues = matrix.symmetric_eigenvalues();
    eigenvalues.max() / eigenvalues.min()
}

/// Least squares over `W A x = W Δ` with `C⁻¹ = Wᵀ W`: of `W A = Q R` the operator is `R⁻¹ Qᵀ W`.
fn by_whitening(r: &[Vector3<f64>], whitening: &DMatrix<f64>, reach_mm: f64) -> DMatrix<f64> {
    let qr = (whitening * equations_in_mm(r, reach_mm)).qr();
    let mut solution = qr.q().tr_mul(whitening);
    let upper = qr.r().fixed_rows::<6>(0).into_owned();
    assert!(upper.solve_upper_triangular_mut(&mut solution));
    solution
}

/// The operator is that of orthogonal factors of the whitened equations, for three targets and more.
#[test]
fn weighted_operator_equals_that_of_whitened_equations() {
    let mut rng = ChaCha8Rng::seed_from_u64(40);
    for count in [3, 3, 3, 4, 7] {
        for _ in 0..200 {
            let corner = random_vector(&mut rng, 300.0);
            let r: Vec<_> = (0..count)
                .map(|_| corner + random_vector(&mut rng, 400.0))
                .collect();
            let size = 3 * count;
            let mut root = normal(&mut rng, size, size).lower_triangle();
            root.set_diagonal(&DVector::from_fn(size, |_, _| rng.random_range(1.0..2.0)));
            let mut whitening = DMatrix::identity(size, size);
            assert!(root.solve_lower_triangular_mut(&mut whitening));
            let product = &root * root.transpose();
            let covariance = (&product + product.transpose()) * 0.5;
            let reach_mm = r.iter().map(Vector3::norm).fold(0.0, f64::max);

            let found = in_mm(&nine_weighted(&r, &covariance).unwrap(), reach_mm);
            let expected = by_whitening(&r, &whitening, reach_mm);
            let difference = (found - &expected).norm() / expected.norm();
            let bound = f64::EPSILON * condition_number(covariance);
            assert!(difference < bound.max(1e-11), "{difference:e} {bound:e}");
        }
    }
}

/// Equal weights: the translation of the centroid is the mean, the rotation the moment of the
/// displacements over the inertia of the targets, `J ε = Σ s_j × Δ_j`, `J = Σ (|s_j|² I - s_j s_jᵀ)`.
#[test]
fn plain_operator_solves_the_equations_of_moments() {
    let mut rng = ChaCha8Rng::seed_from_u64(47);
    for count in [3, 3, 5] {
        for _ in 0..100 {
            let r: Vec<_> = (0..count).map(|_| random_vector(&mut rng, 400.0)).collect();
            let delta: Vec<_> = (0..count).map(|_| random_vector(&mut rng, 0.01)).collect();
            let mean = |v: &[Vector3<f64>]| v.iter().sum::<Vector3<f64>>() / count as f64;
            let centroid = mean(&r);
            let (mut moment, mut inertia) = (Vector3::zeros(), Matrix3::zeros());
            for (r, delta) in r.iter().zip(&delta) {
                let s = r - centroid;
                moment += s.cross(delta);
                inertia += Matrix3::identity() * s.norm_squared() - s * s.transpose();
            }
            let rotation = inertia.cholesky().unwrap().solve(&moment);
            let expected = MotionError::new(mean(&delta) - rotation.cross(&centroid), rotation);

            let found = nine(&r).unwrap().apply(&delta);
            let reach_mm = r.iter().map(Vector3::norm).fold(0.0, f64::max);
            let difference = relative_difference(&found, &expected, reach_mm);
            let eigenvalues = inertia.symmetric_eigenvalues();
            let bound = 10.0 * f64::EPSILON * eigenvalues.max() / eigenvalues.min();
            assert!(difference < bound, "{difference:e} {bound:e}");
        }
    }
}

/// `A Φ Aᵀ` in C does not change the estimate: a rigid motion passes every unbiased operator.
#[test]
fn weighted_operator_does_not_depend_on_rigid_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    for _ in 0..100 {
        let r = random_targets(&mut rng);
        let c = random_covariance(&mut rng);
        let with_rigid = &c + rigid_covariance(&mut rng, &r);
        let expected = in_mm(&nine_weighted(&r, &c).unwrap(), reach(&r));
        let found = in_mm(&nine_weighted(&r, &with_rigid).unwrap(), reach(&r));
        let difference = (&found - &expected).norm() / expected.norm();
        let bound = f64::EPSILON * condition_number(with_rigid);
        assert!(difference < bound, "{difference:e} {bound:e}");
    }
}

/// `P C Pᵀ` is the inverse of `Aᵀ C⁻¹ A`, and smaller than that of unweighted least squares.
#[test]
fn covariance_is_that_of_generalised_least_squares() {
    let mut rng = ChaCha8Rng::seed_from_u64(42);
    for _ in 0..100 {
        let r = random_targets(&mut rng);
        let c = random_covariance(&mut rng);
        let a = equations_in_mm(&r, reach(&r));
        let information = a.transpose() * c.clone().try_inverse().unwrap() * &a;
        let operator = nine_weighted(&r, &c).unwrap();
        let covariance = propagated(&operator, &c);
        let mut scale = Vector6::repeat(1.0);
        scale.fixed_rows_mut::<3>(3).fill(reach(&r));
        let scale = Matrix6::from_diagonal(&scale);

        let difference = (scale * covariance * scale * information - Matrix6::identity()).norm();
        let condition = condition_number(DMatrix::from_column_slice(6, 6, information.as_slice()));
        // The inverse of C, two products and the operator itself.
        let bound = 4.0 * f64::EPSILON * condition;
        assert!(difference < bound, "{difference:e} {bound:e}");

        let unweighted = propagated(&nine(&r).unwrap(), &c);
        // Gauss-Markov: no other unbiased linear estimate has smaller variances.
        assert!((0..6).all(|i| covariance[(i, i)] < unweighted[(i, i)]));
    }
}

/// `P C Pᵀ`.
fn propagated(operator: &Operator, c: &DMatrix<f64>) -> Matrix6<f64> {
    operator.matrix() * c * operator.matrix().transpose()
}

const TRIALS: u32 = 20_000;

/// Half-width of the accepted range in standard deviations of the mean over the trials. One
/// comparison fails by chance once in 1.7 million; the 22 of this test once in 80,000 seeds.
const SIGMAS: f64 = 5.0;

#[test]
fn scatter_agrees_with_the_covariance_and_chi_squared() {
    let mut rng = ChaCha8Rng::seed_from_u64(43);
    let r = THREE_AXIS;
    let c = random_covariance(&mut rng);
    let truth = random_error(&mut rng);
    let exact = r.map(|r| displacement(&truth, &r));
    let operator = nine_weighted(&r, &c).unwrap();
    let root = c.clone().cholesky().unwrap().unpack();
    let result_root = propagated(&operator, &c).cholesky().unwrap().unpack();

    let mut scatter = Matrix6::zeros();
    let mut chi_squared = 0.0;
    for _ in 0..TRIALS {
        let noise = &root * normal(&mut rng, 9, 1);
        let delta = [0, 1, 2].map(|j| exact[j] + noise.fixed_view::<3, 1>(3 * j, 0));
        let error = operator.apply(&delta).to_vector() - truth.to_vector();
        let unit = result_root.solve_lower_triangular(&error).unwrap();
        scatter += unit * unit.transpose() / f64::from(TRIALS);
        let misfit = rigid_misfit(&operator, &delta, &c).unwrap();
        chi_squared += misfit.chi_squared / f64::from(TRIALS);
    }
    for i in 0..6 {
        for j in 0..=i {
            let (expected, variance) = if i == j { (1.0, 2.0) } else { (0.0, 1.0) };
            let accepted = SIGMAS * (variance / f64::from(TRIALS)).sqrt();
            assert!((scatter[(i, j)] - expected).abs() < accepted, "{scatter}");
        }
    }
    // χ² with three degrees of freedom has mean 3 and variance 6.
    let accepted = SIGMAS * (6.0 / f64::from(TRIALS)).sqrt();
    assert!((chi_squared - 3.0).abs() < accepted, "{chi_squared}");
}

#[test]
fn chi_squared_is_that_of_the_weighted_residuals_for_any_operator() {
    let mut rng = ChaCha8Rng::seed_from_u64(44);
    let r = THREE_AXIS;
    for _ in 0..20 {
        let c = random_covariance(&mut rng);
        let delta = r.map(|_| random_vector(&mut rng, 5e-3));
        let weighted = nine_weighted(&r, &c).unwrap();
        let residual = weighted.residual_mm(&delta);
        let v = DVector::from_iterator(9, residual.iter().flatten().copied());
        let expected = v.dot(&(c.clone().try_inverse().unwrap() * &v));
        for operator in [
            weighted,
            nine(&r).unwrap(),
            SixRows::PAPER.operator(&r).unwrap(),
        ] {
            let misfit = rigid_misfit(&operator, &delta, &c).unwrap();
            assert!((misfit.chi_squared / expected - 1.0).abs() < 1e-12);
            assert_eq!(misfit.degrees_of_freedom, 3);
            assert_eq!(misfit.residual_mm, operator.residual_mm(&delta));
        }
    }
}

/// P and Q pulled apart along PQ: no force and no torque, so that no rigid motion helps.
#[test]
fn stretched_side_is_all_misfit_and_a_rigid_motion_is_none() {
    let r = THREE_AXIS;
    let (pull_mm, sigma_mm) = (3e-3, 1e-3);
    let along = (r[1] - r[0]).normalize() * pull_mm;
    let truth = random_error(&mut ChaCha8Rng::seed_from_u64(45));
    let rigid = r.map(|r| displacement(&truth, &r));
    let stretched = [rigid[0] - along, rigid[1] + along, rigid[2]];
    let c = DMatrix::identity(9, 9) * (sigma_mm * sigma_mm);
    let operator = nine(&r).unwrap();

    let misfit = rigid_misfit(&operator, &stretched, &c).unwrap();
    assert!((misfit.residual_mm[1] - along).norm() < 1e-14);
    assert!((misfit.rms_um - 3.0 * (2.0_f64 / 9.0).sqrt()).abs() < 1e-11);
    assert!((misfit.chi_squared - 18.0).abs() < 1e-9);

    let none = rigid_misfit(&operator, &rigid, &c).unwrap();
    assert!(none.rms_um < 1e-11 && none.chi_squared < 1e-20);
}

/// Points whose common rigid motion is known exactly have a singular covariance: the weighted
/// operator does not exist, the test of rigidity does. The opposite case has nothing to test.
#[test]
fn misfit_needs_only_the_covariance_of_the_distortion() {
    let mut rng = ChaCha8Rng::seed_from_u64(46);
    let r = THREE_AXIS;
    let operator = nine(&r).unwrap();
    let delta = r.map(|_| random_vector(&mut rng, 5e-3));
    let full = random_covariance(&mut rng);
    let leftover = DMatrix::identity(9, 9) - equations(&r) * operator.matrix();
    let mut distortion_only = &leftover * &full * leftover.transpose();
    distortion_only = (&distortion_only + distortion_only.transpose()) / 2.0;
    assert!(matches!(
        nine_weighted(&r, &distortion_only),
        Err(Error::Covariance { .. })
    ));
    let expected = rigid_misfit(&operator, &delta, &full).unwrap();
    let found = rigid_misfit(&operator, &delta, &distortion_only).unwrap();
    assert!((found.chi_squared / expected.chi_squared - 1.0).abs() < 1e-12);

    // What rounding leaves of the distortion's covariance is positive definite now and then.
    for _ in 0..100 {
        let rigid_only = rigid_covariance(&mut rng, &r);
        assert!(matches!(
            rigid_misfit(&operator, &delta, &rigid_only),
            Err(Error::Covariance { .. })
        ));
    }
}

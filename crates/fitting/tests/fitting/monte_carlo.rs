//! Stated covariances against the scatter of fits to noisy points.
//!
//! Errors `z` of one trial after another are whitened by the stated covariance, `w = L⁻¹ z` with
//! `L Lᵀ = C`; the mean of `w wᵀ` must be the unit matrix. With N trials an element of it has the
//! standard deviation √(2/N) on the diagonal and 1/√N off it. The limit is five of these: with
//! another seed one of the 24 figures looked at here fails with a probability below 2e-5.

use nalgebra::{DMatrix, DVector, Matrix3, Point3, Unit, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_fitting::{fit_common_axis, fit_line};

use crate::coaxial_scene::{arcs, axis_direction, axis_point, slices};

const TRIALS: usize = 4000;

const LIMIT_SIGMAS: f64 = 5.0;

/// A laser tracker's noise; against radii of 100 mm it leaves second-order effects of 1e-5.
const SIGMA_MM: f64 = 1e-3;

/// Coordinates with noise, one random stream for each trial.
fn noisy(points: &[Point3<f64>], rng: &mut ChaCha8Rng) -> Vec<Point3<f64>> {
    let mut noise = || {
        let unit: f64 = StandardNormal.sample(rng);
        unit * SIGMA_MM
    };
    points
        .iter()
        .map(|p| p + Vector3::new(noise(), noise(), noise()))
        .collect()
}

fn trials(seed: u64) -> impl Iterator<Item = ChaCha8Rng> {
    (0..TRIALS as u64).map(move |trial| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(trial);
        rng
    })
}

/// Two unit vectors across a direction, in columns, and the direction itself.
fn frame(direction: Unit<Vector3<f64>>) -> Matrix3<f64> {
    let a = direction
        .cross(&Vector3::ith(direction.iamin(), 1.0))
        .normalize();
    Matrix3::from_columns(&[a, direction.cross(&a), direction.into_inner()])
}

/// Errors of trials beside their stated covariance. Also the estimates of sigma².
struct Sample {
    errors: Vec<DVector<f64>>,
    variance_ratios: Vec<f64>,
    degrees_of_freedom: usize,
}

impl Sample {
    fn assert_covariance(&self, what: &str, stated: &DMatrix<f64>) {
        let whiten = stated
            .clone()
            .cholesky()
            .expect("stated covariance is positive")
            .l();
        let count = self.errors.len() as f64;
        let mut mean_square = DMatrix::zeros(stated.nrows(), stated.ncols());
        for error in &self.errors {
            let white = whiten.solve_lower_triangular(error).unwrap();
            mean_square += &white * white.transpose() / count;
        }
        for i in 0..stated.nrows() {
            for k in 0..=i {
                let (expected, variance) = if i == k { (1.0, 2.0) } else { (0.0, 1.0) };
                let limit = LIMIT_SIGMAS * (variance / count).sqrt();
                let found = mean_square[(i, k)];
                assert!(
                    (found - expected).abs() < limit,
                    "{what}: element ({i}, {k}) of the whitened covariance is {found}"
                );
            }
        }
        // Estimates of sigma² average to sigma² with the standard deviation √(2 / dof N).
        let mean = self.variance_ratios.iter().sum::<f64>() / count;
        let limit = LIMIT_SIGMAS * (2.0 / (count * self.degrees_of_freedom as f64)).sqrt();
        assert!(
            (mean - 1.0).abs() < limit,
            "{what}: estimated variance is off by the factor {mean}"
        );
    }
}

#[test]
fn line() {
    let truth = axis_direction();
    let points: Vec<_> = (0..10)
        .map(|i| axis_point() + truth.into_inner() * (40.0 * f64::from(i)))
        .collect();
    let exact = fit_line(&points).unwrap();
    let across = frame(truth).fixed_columns::<2>(0).into_owned();
    let mut sample = Sample {
        errors: Vec::new(),
        variance_ratios: Vec::new(),
        degrees_of_freedom: 16,
    };
    for mut rng in trials(1) {
        let line = fit_line(&noisy(&points, &mut rng)).unwrap();
        let shift = across.tr_mul(&(line.point_mm - exact.point_mm));
        let tilt = across.tr_mul(&(line.direction.into_inner() - truth.into_inner()));
        sample.errors.push(DVector::from_iterator(
            4,
            shift.iter().chain(&tilt).copied(),
        ));
        sample
            .variance_ratios
            .push((line.scatter.sigma_mm.unwrap() / SIGMA_MM).powi(2));
    }
    let stated = exact.covariance(Some(SIGMA_MM)).unwrap();
    sample.assert_covariance("line", &reduced(&stated, &across));
}

/// Partial arcs of 60 degrees: the axis, then the radii.
#[test]
fn common_axis() {
    let arcs = arcs(60_f64.to_radians());
    let exact = fit_common_axis(&slices(&arcs)).unwrap();
    let direction = axis_direction();
    let across = frame(direction).fixed_columns::<2>(0).into_owned();
    let new_sample = || Sample {
        errors: Vec::new(),
        variance_ratios: Vec::new(),
        degrees_of_freedom: 2 * 39 - 10,
    };
    let (mut axis, mut radius) = (new_sample(), new_sample());
    for mut rng in trials(3) {
        let noisy = arcs.each_ref().map(|arc| noisy(arc, &mut rng));
        let fitted = fit_common_axis(&slices(&noisy)).unwrap();
        let shift = across.tr_mul(&(fitted.axis.point_mm - exact.axis.point_mm));
        let tilt = across.tr_mul(&(fitted.axis.direction.into_inner() - direction.into_inner()));
        axis.errors.push(DVector::from_iterator(
            4,
            shift.iter().chain(&tilt).copied(),
        ));

        let radius_error = fitted.circles[2].radius_mm - exact.circles[2].radius_mm;
        radius.errors.push(DVector::from_element(1, radius_error));
        let ratio = (fitted.axis.scatter.sigma_mm.unwrap() / SIGMA_MM).powi(2);
        for sample in [&mut axis, &mut radius] {
            sample.variance_ratios.push(ratio);
        }
    }
    let stated = exact.axis.covariance(Some(SIGMA_MM)).unwrap();
    axis.assert_covariance("common axis", &reduced(&stated, &across));
    let stated = exact.circles[2].radius_cofactor * SIGMA_MM * SIGMA_MM;
    radius.assert_covariance("radius", &DMatrix::from_element(1, 1, stated));
}

/// The covariance of two vectors in the coordinates across a direction, 6 × 6 to 4 × 4.
fn reduced(stated: &nalgebra::Matrix6<f64>, across: &nalgebra::Matrix3x2<f64>) -> DMatrix<f64> {
    let mut both = DMatrix::zeros(6, 4);
    both.view_mut((0, 0), (3, 2)).copy_from(across);
    both.view_mut((3, 2), (3, 2)).copy_from(across);
    both.transpose() * stated * both
}

//! A few visits of one step without their pose and what the machine returns to.

use nalgebra::{Cholesky, DMatrix, Matrix3, Matrix4, Point3, SymmetricEigen, Vector3};

use crate::coordinate_noise::{CoordinateNoise, CoordinateReading, StepReadings};

/// Most visits that are adjusted together: more only take time.
const MOST_VISITS: usize = 4;

/// Eigenvalues below this part of the largest are rounding.
const DETERMINED: f64 = 1e-10;

/// The class of the variance of returns, after those of the directions.
pub(super) const RETURNS: usize = 3;

/// Visits of one step, at most some.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<'a> {
    rotation: Matrix3<f64>,
    pub(super) readings: &'a [CoordinateReading],
}

impl<'a> Block<'a> {
    pub(super) fn all_of(step: &'a StepReadings) -> Vec<Self> {
        let all = &step.readings;
        let visits: Vec<&[CoordinateReading]> = all.chunk_by(|a, b| a.visit == b.visit).collect();
        let mut first = 0;
        let chunks = visits.chunks(MOST_VISITS).map(|visits| {
            let count: usize = visits.iter().map(|own| own.len()).sum();
            first += count;
            Self {
                rotation: step.rotation,
                readings: &all[first - count..first],
            }
        });
        chunks.collect()
    }
}

/// A block without pose and returns: `M_A [T y]`, the rows of the returns last, and the diagonal of `M_A`.
pub(super) struct Reduced {
    pub(super) values: DMatrix<f64>,
    pub(super) diagonal: Vec<f64>,
    /// `Σ M_A,ij² / 2` over the rows of two classes of variances.
    pub(super) information: Matrix4<f64>,
    pub(super) ln_determinant: f64,
}

impl Block<'_> {
    pub(super) fn reduced(&self, targets: usize, noise: &CoordinateNoise, returns: f64) -> Reduced {
        let count = self.readings.len();
        let mut visits: Vec<usize> = self.readings.iter().map(|own| own.visit).collect();
        visits.dedup();
        // Of the modelled points: a rotation of all shapes is then one of the poses, exactly.
        let modelled_mm = || self.readings.iter().map(|own| own.point_mm - own.misfit_mm);
        let sum: Vector3<f64> = modelled_mm().map(|point| point.coords).sum();
        let centre = Point3::from(sum / count as f64);
        let arms = || modelled_mm().map(|point| point - centre);
        let squares: f64 = arms().map(|arm| arm.norm_squared()).sum();
        let usual_mm = (squares / count as f64).sqrt().max(f64::MIN_POSITIVE);
        // One visit alone does not differ from its pose.
        let returning = if visits.len() > 1 {
            3 * visits.len()
        } else {
            0
        };
        let mut motion = DMatrix::zeros(3 * count + returning, 6 + returning);
        let mut values = DMatrix::zeros(3 * count + returning, 3 * targets + 1);
        let (mut visit, mut ln_variances) = (0, 0.0);
        for (i, (own, arm)) in self.readings.iter().zip(arms()).enumerate() {
            if own.visit != visits[visit] {
                visit += 1;
            }
            let (rows, variances) = noise.at(&own.point_mm);
            let sigmas = variances.map(|variance| own.sigma * variance.sqrt());
            ln_variances += 2.0 * sigmas.iter().map(|sigma| sigma.ln()).sum::<f64>();
            let whiten = Matrix3::from_diagonal(&sigmas.map(f64::recip).into()) * rows;
            let put = |into: &mut DMatrix<f64>, column: usize, block: Matrix3<f64>| {
                into.fixed_view_mut::<3, 3>(3 * i, column).copy_from(&block);
            };
            put(&mut motion, 0, whiten);
            put(&mut motion, 3, whiten * -(arm / usual_mm).cross_matrix());
            if returning > 0 {
                put(&mut motion, 6 + 3 * visit, whiten);
            }
            put(&mut values, 3 * own.target, whiten * self.rotation);
            let y = whiten * own.misfit_mm;
            values
                .fixed_view_mut::<3, 1>(3 * i, 3 * targets)
                .copy_from(&y);
        }
        for k in 0..returning {
            motion[(3 * count + k, 6 + k)] = returns.sqrt().recip();
        }
        ln_variances += returning as f64 * returns.ln();
        let (inverse, ln_determinant) = pseudo_inverse(motion.tr_mul(&motion));
        let through = &motion * inverse;
        let taken = motion.tr_mul(&values);
        values.gemm(-1.0, &through, &taken, 1.0);
        let projector =
            DMatrix::identity(motion.nrows(), motion.nrows()) - &through * motion.transpose();
        let class = |row: usize| match row < 3 * count {
            true => noise.classes()[row % 3],
            false => RETURNS,
        };
        let mut information = Matrix4::zeros();
        for j in 0..motion.nrows() {
            for i in 0..motion.nrows() {
                information[(class(i), class(j))] += 0.5 * projector[(i, j)].powi(2);
            }
        }
        Reduced {
            values,
            diagonal: projector.diagonal().as_slice().to_vec(),
            information,
            ln_determinant: ln_variances + ln_determinant,
        }
    }
}

/// The pseudo-inverse of a normal matrix, and the logarithm of the product of its eigenvalues that are not 0.
pub(super) fn pseudo_inverse(normal: DMatrix<f64>) -> (DMatrix<f64>, f64) {
    let size = normal.nrows();
    if !normal.iter().all(|x| x.is_finite()) {
        return (DMatrix::zeros(size, size), f64::NAN);
    }
    let least = DETERMINED * normal.diagonal().amax();
    if let Some(cholesky) = Cholesky::new(normal.clone()) {
        let pivots = cholesky.l_dirty().diagonal();
        if pivots.iter().all(|pivot| pivot * pivot > least) {
            let ln_determinant = pivots.iter().map(|pivot| 2.0 * pivot.ln()).sum();
            return (cholesky.inverse(), ln_determinant);
        }
    }
    let eigen = SymmetricEigen::new(normal);
    let least = DETERMINED * eigen.eigenvalues.amax();
    let (mut inverse, mut ln_determinant) = (DMatrix::zeros(size, size), 0.0);
    for (value, vector) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *value > least {
            inverse.ger(1.0 / value, &vector, &vector, 1.0);
            ln_determinant += value.ln();
        }
    }
    (inverse, ln_determinant)
}

//! The likelihood of a noise, and the variances that make it greatest.
//!
//! Visits of one step from one side of approach share the pose of the stage but for what the machine returns to, `a`, and
//! share with all others the shapes `h` of the bodies. With whitened columns `A` of pose and returns, and `T` of shapes,
//!
//! ```text
//! y = A x + T h + e     0 = a / ρ + e     e ~ N(0, 1)     M_A = 1 - A (AᵀA)⁺ Aᵀ     M = M_A - M_A T (Tᵀ M_A T)⁺ Tᵀ M_A
//! -2 ln L = Σ ln s² + Σ ln ρ² + Σ ln |AᵀA| + ln |Tᵀ M_A T| + yᵀ M y
//! ```
//!
//! (D. A. Harville, *Journal of the American Statistical Association* 72, 320, 1977). With `e = M y` and sums over the rows
//! `k` of one direction, or those of the returns, a step of the scoring for the logarithms of the variances is
//!
//! ```text
//! I d = g     g_k = (Σ_k e² - Σ_k M_ii) / 2     I_kl = Σ_kl M_ij² / 2
//! ```
//!
//! in whose `I` the shapes count as known.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, SymmetricEigen, Vector3, Vector4};
use rayon::prelude::*;

use crate::coordinate_noise::CoordinateNoise;
use crate::coordinate_noise::block::{Block, RETURNS, Reduced, pseudo_inverse};

/// Variances have converged when none changes by more than this part.
const CONVERGED: f64 = 3e-3;
const MOST_PASSES: usize = 60;

/// Most that the logarithm of a variance changes at once: far off, steps are too long.
const LONGEST: f64 = 1.5;

/// No variance is smaller than the largest by more: what the points are compared with is not exact, either.
const LEAST_RATIO: f64 = 1e-5;

/// A noise with its likeliest variances, mm².
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub(super) noise: CoordinateNoise,
    /// Variance of a coordinate to which the machine returns, mm².
    returns: f64,
    /// Twice the logarithm of the restricted likelihood, but for a constant.
    pub(super) two_ln_l: f64,
    pub(super) redundancy: f64,
    /// Redundancy of the variance along each row.
    pub(super) redundancies: [f64; 3],
    /// Mean square of what is left of each block, 0 where nothing is redundant.
    pub(super) of_blocks: Vec<f64>,
    /// Principal directions of what is left, as rows.
    pub(super) principal: Matrix3<f64>,
}

impl Fitted {
    /// `None` if nothing is redundant.
    pub(super) fn new(blocks: &[Block<'_>], mut noise: CoordinateNoise) -> Option<Self> {
        let readings = || blocks.iter().flat_map(|block| block.readings);
        let squares: f64 = readings().map(|own| own.misfit_mm.norm_squared()).sum();
        let mean = squares / (3 * readings().count()) as f64;
        if !(mean > 0.0 && mean.is_finite()) {
            return None;
        }
        noise.variances = [mean; 3];
        Self::from_start(blocks, noise, mean, MOST_PASSES)
    }

    /// With the variances that one step from those of `near` gives, which are nearly the likeliest.
    pub(super) fn near(
        blocks: &[Block<'_>],
        mut noise: CoordinateNoise,
        near: &Self,
    ) -> Option<Self> {
        noise.variances = near.noise.variances;
        Self::from_start(blocks, noise, near.returns, 1)
    }

    fn from_start(
        blocks: &[Block<'_>],
        mut noise: CoordinateNoise,
        mut returns: f64,
        most_passes: usize,
    ) -> Option<Self> {
        let mut left = Left::new(blocks, &noise, returns)?;
        for _ in 0..most_passes {
            let before = (noise.variances, returns);
            (noise.variances, returns) = left.variances(&noise, returns);
            left = Left::new(blocks, &noise, returns)?;
            let changes = noise.variances.iter().zip(before.0);
            let mut changes = changes.chain([(&returns, before.1)]);
            if changes.all(|(now, before)| (now / before - 1.0).abs() < CONVERGED) {
                break;
            }
        }
        Some(Self {
            two_ln_l: left.two_ln_l,
            redundancy: left.redundancy.iter().sum(),
            redundancies: left.of_classes(&noise).map(|[_, redundancy]| redundancy),
            of_blocks: left.of_blocks,
            principal: SymmetricEigen::new(left.scatter).eigenvectors.transpose(),
            noise,
            returns,
        })
    }

    /// Of the variance that is known least.
    pub(super) fn least_redundancy(&self) -> f64 {
        self.redundancies.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The noise with the means of its variances given the readings, with the prior 1/σ².
    pub(super) fn expected(&self) -> CoordinateNoise {
        let mut noise = self.noise.clone();
        noise.degrees_of_freedom = self.least_redundancy();
        for (variance, redundancy) in noise.variances.iter_mut().zip(self.redundancies) {
            *variance *= redundancy / (redundancy - 2.0);
        }
        noise
    }
}

/// What the model leaves of whitened coordinates.
struct Left {
    two_ln_l: f64,
    /// Of the rows along each direction.
    squares: [f64; 3],
    redundancy: [f64; 3],
    /// The same of returns.
    of_returns: [f64; 2],
    information: Matrix4<f64>,
    of_blocks: Vec<f64>,
    /// `Σ v vᵀ` in the frame of the coordinates, `v` in units of the declared standard deviations, mm.
    scatter: Matrix3<f64>,
}

impl Left {
    fn new(blocks: &[Block<'_>], noise: &CoordinateNoise, returns: f64) -> Option<Self> {
        let readings = || blocks.iter().flat_map(|block| block.readings);
        let targets = readings().map(|own| own.target + 1).max()?;
        let reduced: Vec<Reduced> = blocks
            .par_iter()
            .map(|block| block.reduced(targets, noise, returns))
            .collect();
        let shapes = 3 * targets;
        let mut normal = DMatrix::zeros(shapes + 1, shapes + 1);
        for block in &reduced {
            normal.gemm_tr(1.0, &block.values, &block.values, 1.0);
        }
        let (inverse, ln_determinant) =
            pseudo_inverse(normal.view((0, 0), (shapes, shapes)).into());
        let shape: DVector<f64> = &inverse * normal.view((0, shapes), (shapes, 1)).column(0);
        let mut left = Self {
            two_ln_l: -ln_determinant,
            squares: [0.0; 3],
            redundancy: [0.0; 3],
            of_returns: [0.0; 2],
            information: Matrix4::zeros(),
            of_blocks: Vec::with_capacity(blocks.len()),
            scatter: Matrix3::zeros(),
        };
        for (block, reduced) in blocks.iter().zip(&reduced) {
            left.two_ln_l -= reduced.ln_determinant;
            left.information += reduced.information;
            let by_shape = reduced.values.columns(0, shapes);
            let e = reduced.values.column(shapes) - by_shape * &shape;
            let through = by_shape * &inverse;
            let of_points = 3 * block.readings.len();
            let (mut squares, mut redundancy) = (0.0, 0.0);
            for (i, e_i) in e.iter().enumerate() {
                let own = reduced.diagonal[i] - through.row(i).dot(&by_shape.row(i));
                let (of_squares, of_redundancy) = match i < of_points {
                    true => (&mut left.squares[i % 3], &mut left.redundancy[i % 3]),
                    false => left.of_returns.each_mut().into(),
                };
                *of_squares += e_i * e_i;
                *of_redundancy += own;
                squares += e_i * e_i;
                redundancy += own;
            }
            left.two_ln_l -= squares;
            left.of_blocks.push(if redundancy > 0.5 {
                squares / redundancy
            } else {
                0.0
            });
            for (own, e) in block.readings.iter().zip(e.as_slice().chunks_exact(3)) {
                let (rows, variances) = noise.at(&own.point_mm);
                let e = Vector3::from_fn(|k, _| e[k] * variances[k].sqrt());
                let e = rows.transpose() * e;
                left.scatter += e * e.transpose();
            }
        }
        left.two_ln_l.is_finite().then_some(left)
    }

    /// Squares and redundancy of the variance along each row.
    fn of_classes(&self, noise: &CoordinateNoise) -> [[f64; 2]; 3] {
        let classes = noise.classes();
        classes.map(|class| {
            let own = (0..3).filter(|k| classes[*k] == class);
            let sums = own.map(|k| [self.squares[k], self.redundancy[k]]);
            sums.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
        })
    }

    /// The next variances of a noise and of the returns.
    fn variances(&self, noise: &CoordinateNoise, returns: f64) -> ([f64; 3], f64) {
        let classes = noise.classes();
        let [squares, redundancy] = self.of_returns;
        let mut gradient = Vector4::new(0.0, 0.0, 0.0, 0.5 * (squares - redundancy));
        for (k, class) in classes.into_iter().enumerate() {
            gradient[class] += 0.5 * (self.squares[k] - self.redundancy[k]);
        }
        // A class without rows stays.
        let mut information = self.information;
        for k in 0..4 {
            if information[(k, k)] <= 0.0 {
                information[(k, k)] = 1.0;
            }
        }
        let step = information.cholesky().map(|own| own.solve(&gradient));
        let step = step.unwrap_or_else(|| gradient.component_div(&information.diagonal()));
        let factor = |class: usize| step[class].clamp(-LONGEST, LONGEST).exp();
        let next = [0, 1, 2].map(|k| noise.variances[k] * factor(classes[k]));
        let least = LEAST_RATIO * next.into_iter().fold(0.0, f64::max);
        (
            next.map(|own| own.max(least)),
            (returns * factor(RETURNS)).max(least),
        )
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use trueaxis_leastsquares::dense::Svd;

    use crate::coordinate_noise::{CoordinateReading, StepReadings};

    use super::*;

    /// Two steps of three targets, the first one visited twice.
    fn steps() -> Vec<StepReadings> {
        let wild = |i: usize| ((7 * i * i + 3 * i) as f64).sin();
        let shape = [[0.0, 0.0, 0.0], [200.0, 30.0, -10.0], [40.0, 150.0, 60.0]];
        let mut count = 0;
        let mut reading = |visit: usize, target: usize, x_mm: f64| {
            count += 4;
            let home_mm = Vector3::from(shape[target]);
            let misfit_mm = Vector3::from_fn(|k, _| 1e-3 * wild(count + k));
            CoordinateReading {
                visit,
                target,
                sigma: 1.0 + 0.3 * target as f64,
                point_mm: Point3::from(home_mm + Vector3::new(x_mm, 900.0, -300.0) + misfit_mm),
                misfit_mm,
            }
        };
        let mut step = |visits: std::ops::Range<usize>, x_mm: f64| StepReadings {
            rotation: Matrix3::identity(),
            readings: visits
                .flat_map(|visit| [0, 1, 2].map(|target| (visit, target)))
                .map(|(visit, target)| reading(visit, target, x_mm))
                .collect(),
        };
        vec![step(0..2, 0.0), step(2..3, 400.0)]
    }

    /// With the whole covariance, and columns of which an independent set is chosen by their singular values.
    fn dense(steps: &[StepReadings], noise: &CoordinateNoise, returns: f64) -> f64 {
        let all: Vec<(usize, &CoordinateReading)> = steps
            .iter()
            .enumerate()
            .flat_map(|(o, own)| own.readings.iter().map(move |reading| (o, reading)))
            .collect();
        let rows = 3 * all.len();
        let mut covariance = DMatrix::zeros(rows, rows);
        let mut columns = DMatrix::zeros(rows, 6 * steps.len() + 9);
        let mut y = DVector::zeros(rows);
        for (i, (step, own)) in all.iter().enumerate() {
            for (j, (_, other)) in all.iter().enumerate() {
                let mut block = Matrix3::zeros();
                // A visit alone does not differ from its pose.
                if own.visit == other.visit && *step == 0 {
                    block += Matrix3::from_diagonal_element(returns);
                }
                if i == j {
                    block += noise.covariance(&own.point_mm) * own.sigma.powi(2);
                }
                covariance
                    .fixed_view_mut::<3, 3>(3 * i, 3 * j)
                    .copy_from(&block);
            }
            let modelled_mm = |own: &CoordinateReading| own.point_mm - own.misfit_mm;
            let arm = modelled_mm(own) - modelled_mm(&steps[*step].readings[0]);
            let mut put = |column: usize, block: Matrix3<f64>| {
                columns
                    .fixed_view_mut::<3, 3>(3 * i, column)
                    .copy_from(&block);
            };
            put(6 * step, Matrix3::identity());
            put(6 * step + 3, -(arm / 100.0).cross_matrix());
            put(6 * steps.len() + 3 * own.target, Matrix3::identity());
            y.fixed_rows_mut::<3>(3 * i).copy_from(&own.misfit_mm);
        }
        let svd = Svd::new(&columns).unwrap();
        let basis = svd.u.columns(0, svd.rank(1e-9)).into_owned();
        let weight = covariance.clone().try_inverse().unwrap();
        let normal = basis.tr_mul(&(&weight * &basis));
        let projected = basis.tr_mul(&(&weight * &y));
        let explained = projected.dot(&normal.clone().cholesky().unwrap().solve(&projected));
        let squares = y.dot(&(&weight * &y)) - explained;
        -(covariance.determinant().ln() + normal.determinant().ln() + squares)
    }

    /// The constant that the columns add is the same for all noises.
    #[test]
    fn the_likelihood_is_that_of_the_whole_covariance() {
        let steps = steps();
        let blocks: Vec<Block<'_>> = steps.iter().flat_map(Block::all_of).collect();
        let points: Vec<Point3<f64>> = steps
            .iter()
            .flat_map(|own| own.readings.iter().map(|reading| reading.point_mm))
            .collect();
        let noises = [
            (CoordinateNoise::EQUAL, [1e-6; 3], 1e-6),
            (CoordinateNoise::EQUAL, [4e-6; 3], 1e-5),
            (
                CoordinateNoise::polar(Point3::origin(), &points).unwrap(),
                [1e-7, 4e-6, 4e-6],
                1e-6,
            ),
            (
                CoordinateNoise::directions(Matrix3::identity()),
                [1e-6, 2e-7, 5e-6],
                3e-7,
            ),
        ];
        let constants = noises.map(|(mut noise, variances, returns)| {
            noise.variances = variances;
            let own = Left::new(&blocks, &noise, returns).unwrap().two_ln_l;
            own - dense(&steps, &noise, returns)
        });
        for constant in constants {
            let off = constant - constants[0];
            assert!(off.abs() < 1e-8, "{constants:?}");
        }
    }
}

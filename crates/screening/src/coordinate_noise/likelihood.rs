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

use nalgebra::{
    Cholesky, DMatrix, DVector, Matrix3, Matrix4, Point3, SymmetricEigen, Vector3, Vector4,
};
use rayon::prelude::*;

use crate::coordinate_noise::{CoordinateNoise, Occasion, Sighting};

/// Most visits that are adjusted together: more only take time.
const MOST_VISITS: usize = 4;

/// Variances have converged when none changes by more than this part.
const CONVERGED: f64 = 3e-3;
const MOST_PASSES: usize = 60;

/// Most that the logarithm of a variance changes at once: far off, steps are too long.
const LONGEST: f64 = 1.5;

/// No variance is smaller than the largest by more: what the points are compared with is not exact, either.
const LEAST_RATIO: f64 = 1e-5;

/// Eigenvalues below this part of the largest are rounding.
const DETERMINED: f64 = 1e-10;

/// Visits of one occasion, at most some.
pub(super) struct Block<'a> {
    rotation: Matrix3<f64>,
    pub(super) sightings: &'a [Sighting],
}

impl<'a> Block<'a> {
    pub(super) fn all_of(occasion: &'a Occasion) -> Vec<Self> {
        let all = &occasion.sightings;
        let visits: Vec<&[Sighting]> = all.chunk_by(|a, b| a.visit == b.visit).collect();
        let mut first = 0;
        let chunks = visits.chunks(MOST_VISITS).map(|visits| {
            let count: usize = visits.iter().map(|own| own.len()).sum();
            first += count;
            Self {
                rotation: occasion.rotation,
                sightings: &all[first - count..first],
            }
        });
        chunks.collect()
    }
}

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
        let sightings = || blocks.iter().flat_map(|block| block.sightings);
        let squares: f64 = sightings().map(|own| own.misfit_mm.norm_squared()).sum();
        let mean = squares / (3 * sightings().count()) as f64;
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
            let before = noise.variances;
            (noise.variances, returns) = left.variances(&noise, returns);
            left = Left::new(blocks, &noise, returns)?;
            let mut changes = noise.variances.iter().zip(before);
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
}

impl Fitted {
    /// The noise with the means of its variances given the readings: the likeliest one of few is too small.
    pub(super) fn expected(&self) -> CoordinateNoise {
        let mut noise = self.noise.clone();
        for (variance, redundancy) in noise.variances.iter_mut().zip(self.redundancies) {
            *variance *= redundancy / (redundancy - 2.0);
        }
        noise
    }
}

/// The class of the variance of returns, after those of the directions.
const RETURNS: usize = 3;

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
    /// Σ e eᵀ in the frame of the coordinates.
    scatter: Matrix3<f64>,
}

/// A block without pose and returns: `M_A [T y]`, the rows of the returns last, and the diagonal of `M_A`.
struct Reduced {
    values: DMatrix<f64>,
    diagonal: Vec<f64>,
    /// `Σ M_A,ij² / 2` over the rows of two classes of variances.
    information: Matrix4<f64>,
    ln_determinant: f64,
}

impl Left {
    fn new(blocks: &[Block<'_>], noise: &CoordinateNoise, returns: f64) -> Option<Self> {
        let sightings = || blocks.iter().flat_map(|block| block.sightings);
        let targets = sightings().map(|own| own.target + 1).max()?;
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
            let of_points = 3 * block.sightings.len();
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
            for (own, e) in block.sightings.iter().zip(e.as_slice().chunks_exact(3)) {
                let rows = noise.at(&own.point_mm).0;
                let e = rows.transpose() * Vector3::from_column_slice(e);
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

impl Block<'_> {
    fn reduced(&self, targets: usize, noise: &CoordinateNoise, returns: f64) -> Reduced {
        let count = self.sightings.len();
        let mut visits: Vec<usize> = self.sightings.iter().map(|own| own.visit).collect();
        visits.dedup();
        let centre = self.sightings.iter().map(|own| own.point_mm.coords);
        let centre = Point3::from(centre.sum::<Vector3<f64>>() / count as f64);
        let arms = || self.sightings.iter().map(|own| own.point_mm - centre);
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
        for (i, (own, arm)) in self.sightings.iter().zip(arms()).enumerate() {
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
fn pseudo_inverse(normal: DMatrix<f64>) -> (DMatrix<f64>, f64) {
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
    let (mut inverse, mut ln_determinant) = (
        DMatrix::zeros(eigen.eigenvectors.nrows(), eigen.eigenvectors.nrows()),
        0.0,
    );
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

#[cfg(test)]
mod tests {
    use trueaxis_leastsquares::dense::Svd;

    use super::*;

    /// Two steps of three targets, the first one visited twice.
    fn occasions() -> Vec<Occasion> {
        let wild = |i: usize| ((7 * i * i + 3 * i) as f64).sin();
        let shape = [[0.0, 0.0, 0.0], [200.0, 30.0, -10.0], [40.0, 150.0, 60.0]];
        let mut count = 0;
        let mut sighting = |visit: usize, target: usize, x_mm: f64| {
            count += 4;
            let home_mm = Vector3::from(shape[target]);
            Sighting {
                visit,
                target,
                sigma: 1.0 + 0.3 * target as f64,
                point_mm: Point3::from(home_mm + Vector3::new(x_mm, 900.0, -300.0)),
                misfit_mm: Vector3::from_fn(|k, _| 1e-3 * wild(count + k)),
            }
        };
        let mut occasion = |visits: std::ops::Range<usize>, x_mm: f64| Occasion {
            rotation: Matrix3::identity(),
            sightings: visits
                .flat_map(|visit| [0, 1, 2].map(|target| (visit, target)))
                .map(|(visit, target)| sighting(visit, target, x_mm))
                .collect(),
        };
        vec![occasion(0..2, 0.0), occasion(2..3, 400.0)]
    }

    /// With the whole covariance, and columns of which an independent set is chosen by their singular values.
    fn dense(occasions: &[Occasion], noise: &CoordinateNoise, returns: f64) -> f64 {
        let all: Vec<(usize, &Sighting)> = occasions
            .iter()
            .enumerate()
            .flat_map(|(o, own)| own.sightings.iter().map(move |sighting| (o, sighting)))
            .collect();
        let rows = 3 * all.len();
        let mut covariance = DMatrix::zeros(rows, rows);
        let mut columns = DMatrix::zeros(rows, 6 * occasions.len() + 9);
        let mut y = DVector::zeros(rows);
        for (i, (occasion, own)) in all.iter().enumerate() {
            for (j, (_, other)) in all.iter().enumerate() {
                let mut block = Matrix3::zeros();
                // A visit alone does not differ from its pose.
                if own.visit == other.visit && *occasion == 0 {
                    block += Matrix3::from_diagonal_element(returns);
                }
                if i == j {
                    block += noise.covariance(&own.point_mm) * own.sigma.powi(2);
                }
                covariance
                    .fixed_view_mut::<3, 3>(3 * i, 3 * j)
                    .copy_from(&block);
            }
            let arm = own.point_mm - occasions[*occasion].sightings[0].point_mm;
            let mut put = |column: usize, block: Matrix3<f64>| {
                columns
                    .fixed_view_mut::<3, 3>(3 * i, column)
                    .copy_from(&block);
            };
            put(6 * occasion, Matrix3::identity());
            put(6 * occasion + 3, -(arm / 100.0).cross_matrix());
            put(6 * occasions.len() + 3 * own.target, Matrix3::identity());
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
        let occasions = occasions();
        let blocks: Vec<Block<'_>> = occasions.iter().flat_map(Block::all_of).collect();
        let points: Vec<Point3<f64>> = occasions
            .iter()
            .flat_map(|own| own.sightings.iter().map(|sighting| sighting.point_mm))
            .collect();
        let noises = [
            (CoordinateNoise::EQUAL, [1e-6; 3], 1e-6),
            (CoordinateNoise::EQUAL, [4e-6; 3], 1e-5),
            (
                CoordinateNoise::polar(Point3::origin(), &points),
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
            own - dense(&occasions, &noise, returns)
        });
        for constant in constants {
            let off = constant - constants[0];
            assert!(off.abs() < 1e-8, "{constants:?}");
        }
    }
}

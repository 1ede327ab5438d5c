//! Whether a body has another shape at one group than at the others.
//!
//! A group whose targets move as one body adds only its pose to the unknowns. Here deformations `d` of the body at
//! this group alone are freed beside all other unknowns. With the whitened residuals `v`, the rows `T` of the
//! hat matrix ([`crate::batch_influence`]), their columns `T_d` of the deformations, and
//!
//! ```text
//! A = T_dᵀ T_d     g = A^(-1/2) T_dᵀ v     G = A^(-1/2) T_dᵀ T     M = I - G Σ Gᵀ
//! ```
//!
//! the sum of squares of the whole adjustment drops by `gᵀ M⁻¹ g` at `d = A^(-1/2) M⁻¹ g`. The drop follows χ² if the
//! body is rigid: this is Baarda's test of several errors at once. `G Σ Gᵀ` is what the group has in common with
//! others: stations, constants of reflectors, and the shape that all groups determine. Free points are not needed.
//!
//! A freed group has no influence on the shared unknowns. These then change by `t`, and the other groups are tested
//! with that change:
//!
//! ```text
//! h = g - G t     t ← t - Σ Gᵀ M⁻¹ h     Σ ← Σ + Σ Gᵀ M⁻¹ G Σ
//! ```
//!
//! Binding a free group again would raise the sum of squares by `hᵀ (I + G Σ Gᵀ)⁻¹ h`; its shape differs from that of
//! the others by `d = A^(-1/2) h`.

use nalgebra::{DMatrix, DVector, Dyn, SymmetricEigen};
use trueaxis_leastsquares::{LANES, Lanes, lanes_only, zeros};

use crate::baarda::CHECKED_TOL;
use crate::batch_influence::{BatchInfluence, BatchRows};
use crate::batches::Batch;
use crate::{Network, Solution};

/// For each group of a body, what the residuals say about a shape of its own.
#[derive(Debug, Clone)]
pub struct OwnShapes {
    of_groups: Vec<Option<OwnShape>>,
    /// `Σ` and `t`.
    sigma: DMatrix<f64>,
    change: DVector<f64>,
}

/// The test of one group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnShapeTest {
    /// The drop of the sum of squares of the whitened residuals if the group has a shape of its own.
    pub drop: f64,
    /// Number of deformations that the lengths of the group determine.
    pub degrees_of_freedom: usize,
    /// Root mean square, over all coordinates of the group's targets, of the displacements by which its shape
    /// differs, mm; only principal deformations of more than two standard deviations count.
    pub rms_mm: f64,
}

/// A deformation counts from this many standard deviations on.
const SIGNIFICANT: f64 = 2.0;

#[derive(Debug, Clone)]
struct OwnShape {
    /// `A^(-1/2)`: deformations of unit variance that the lengths determine, mm, one in each column.
    modes: DMatrix<f64>,
    /// `g` and `G`.
    score: DVector<f64>,
    coupling: DMatrix<f64>,
    /// Coordinates of its points.
    coordinates: usize,
    is_free: bool,
}

impl Solution {
    /// The tests of the shape of each group; `network` must be the one that was solved.
    pub fn own_shapes(&self, network: &Network) -> OwnShapes {
        let influence = BatchInfluence::new(network, self);
        let batches = influence.batches();
        let found = influence.of_chunks(
            #[inline(always)]
            |chunk, rows| {
                let mut found = Vec::new();
                for b in chunk {
                    let batch = &batches[b];
                    if batch.body.is_some() {
                        influence.fill(b, rows);
                        found.extend(of_batch(batch, rows, influence.sigma()));
                    }
                }
                found
            },
        );
        let mut of_groups = vec![None; network.groups.len()];
        for (group, shape) in found.into_iter().flatten() {
            of_groups[group] = Some(shape);
        }
        OwnShapes {
            of_groups,
            sigma: influence.sigma().clone(),
            change: DVector::zeros(influence.width()),
        }
    }
}

impl OwnShapes {
    /// The test of a group against all groups that are not free; `None` where its lengths do not determine its shape.
    pub fn test(&self, group: usize) -> Option<OwnShapeTest> {
        let shape = self.of_groups.get(group)?.as_ref()?;
        let Standing { left, kept } = self.standing(shape);
        // Without this group the others may not determine the shared unknowns.
        if kept.eigenvalues.min() <= CHECKED_TOL {
            return None;
        }
        let inverse = kept.eigenvalues.map(f64::recip);
        let along = kept.eigenvectors.tr_mul(&left);
        let drop = along.component_mul(&along).dot(&inverse);
        // `d`, and its covariance.
        let (by, variances) = match shape.is_free {
            false => (along.component_mul(&inverse), inverse),
            true => (along, kept.eigenvalues),
        };
        let own = &shape.modes * &kept.eigenvectors;
        let deformation = &own * by;
        let covariance = &own * DMatrix::from_diagonal(&variances) * own.transpose();
        let principal = SymmetricEigen::new(covariance);
        let along = principal.eigenvectors.tr_mul(&deformation);
        let stands_out = |(d, variance): (&f64, &f64)| {
            let squared = d * d;
            (squared > SIGNIFICANT * SIGNIFICANT * variance).then_some(squared)
        };
        let squares: f64 = along
            .iter()
            .zip(&principal.eigenvalues)
            .filter_map(stands_out)
            .sum();
        Some(OwnShapeTest {
            drop,
            degrees_of_freedom: variances.len(),
            rms_mm: (squares / shape.coordinates as f64).sqrt(),
        })
    }

    /// Gives a group a shape of its own, and returns the drop of the sum of squares; `None`, without a change, if it
    /// has one or if the other groups would not determine the shared unknowns.
    pub fn free(&mut self, group: usize) -> Option<f64> {
        let shape = self.of_groups.get(group)?.as_ref()?;
        let Standing { left, kept } = self.standing(shape);
        if shape.is_free || kept.eigenvalues.min() <= CHECKED_TOL {
            return None;
        }
        let through = &shape.coupling * &self.sigma;
        let inverse = &kept.eigenvectors
            * DMatrix::from_diagonal(&kept.eigenvalues.map(f64::recip))
            * kept.eigenvectors.transpose();
        let own = &inverse * &left;
        self.change -= through.tr_mul(&own);
        self.sigma += through.tr_mul(&(inverse * &through));
        if let Some(Some(shape)) = self.of_groups.get_mut(group) {
            shape.is_free = true;
        }
        Some(left.dot(&own))
    }

    fn standing(&self, shape: &OwnShape) -> Standing {
        let sign = if shape.is_free { 1.0 } else { -1.0 };
        Standing {
            left: &shape.score - &shape.coupling * &self.change,
            kept: one_and(sign, &shape.coupling, &self.sigma),
        }
    }
}

/// The factors of `I ± G Σ Gᵀ`.
fn one_and(sign: f64, coupling: &DMatrix<f64>, sigma: &DMatrix<f64>) -> SymmetricEigen<f64, Dyn> {
    let through = coupling * sigma * coupling.transpose();
    let size = through.nrows();
    let symmetric = (&through + through.transpose()) * (0.5 * sign);
    SymmetricEigen::new(DMatrix::identity(size, size) + symmetric)
}

/// The eigenvectors for whose values `factor` has a number, each times that number; `None` if there is none.
fn scaled_columns(
    of: &SymmetricEigen<f64, Dyn>,
    factor: impl Fn(f64) -> Option<f64>,
) -> Option<DMatrix<f64>> {
    let columns = of.eigenvectors.column_iter().zip(&of.eigenvalues);
    let columns = columns.filter_map(|(column, &value)| Some(column * factor(value)?));
    let columns: Vec<DVector<f64>> = columns.collect();
    (!columns.is_empty()).then(|| DMatrix::from_columns(&columns))
}

/// What a group says at present: `h`, and the factors of its covariance.
struct Standing {
    left: DVector<f64>,
    kept: SymmetricEigen<f64, Dyn>,
}

/// The groups of a batch with their numbers.
#[inline(always)]
fn of_batch(
    batch: &Batch,
    rows: &BatchRows,
    sigma: &DMatrix<f64>,
) -> impl Iterator<Item = (usize, OwnShape)> {
    let width = sigma.nrows();
    let tie = rows.tie();
    let coordinates = 3 * batch.points;
    let deformations = tie.deformations.len() / coordinates;
    let columns = tie.first..tie.first + deformations;
    let shared = rows.hat.shared();
    // T_dᵀ T and, last in each row, T_dᵀ v, a row for each deformation; the sum of squares before elimination.
    let mut products = Vec::new();
    zeros(&mut products, deformations * (width + 1));
    let mut size = Lanes::ZERO;
    let mut whole = Vec::new();
    for (slot, residual) in rows.hat.residual().iter().enumerate() {
        for (d, column) in columns.clone().enumerate() {
            let x = shared.at(slot, column);
            let row = &mut products[d * (width + 1)..][..width + 1];
            for (k, sum) in row[..width].iter_mut().enumerate() {
                lanes_only();
                *sum = x.mul_add(shared.at(slot, k), *sum);
            }
            row[width] = x.mul_add(*residual, row[width]);
        }
        zeros(&mut whole, width);
        rows.copy_shared_row(slot, &mut whole);
        for x in &whole[columns.clone()] {
            size = x.mul_add(*x, size);
        }
    }
    let of_lane = move |lane: usize| {
        let product = |d: usize, k: usize| products[d * (width + 1) + k].0[lane];
        let all = DMatrix::from_fn(deformations, width, product);
        let own = SymmetricEigen::new(all.columns(columns.start, deformations).into_owned());
        let least = CHECKED_TOL * size.0[lane];
        let told = scaled_columns(&own, |x| (x > least).then(|| x.sqrt().recip()))?;
        // Modes that cannot be separated from the shared unknowns are left out.
        let kept = one_and(-1.0, &told.tr_mul(&all), sigma);
        let modes = told * scaled_columns(&kept, |x| (x > CHECKED_TOL).then_some(1.0))?;
        let score = DVector::from_fn(deformations, |d, _| product(d, width));
        Some(OwnShape {
            score: modes.tr_mul(&score),
            coupling: modes.tr_mul(&all),
            modes,
            coordinates,
            is_free: false,
        })
    };
    let groups = batch.groups.clone().zip(0..LANES);
    groups.filter_map(move |(group, lane)| Some((group, of_lane(lane)?)))
}

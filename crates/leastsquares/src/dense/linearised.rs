//! A model and its derivatives at one point.

use nalgebra::DMatrix;

use super::model::Model;
use super::scaled_svd::{ScaledSvd, column_lengths};
use crate::Error;

/// Least singular value of a Jacobian with unit columns, relative to the largest, that counts as
/// determined. Beyond the square root of the rounding, the error of the linearisation is as large
/// as the effect.
pub(super) const RANK_TOL: f64 = 1.5e-8;

/// Residuals, Jacobian and its singular values with unit columns; all finite.
#[derive(Debug)]
pub(super) struct Linearised {
    pub(super) unknowns: Vec<f64>,
    pub(super) residuals: Vec<f64>,
    pub(super) jacobian: DMatrix<f64>,
    pub(super) column_lengths: Vec<f64>,
    pub(super) svd: ScaledSvd,
    pub(super) rank: usize,
    /// Components of the residuals along the determined singular vectors: the part of the
    /// residuals that the linear model can still remove.
    pub(super) components: Vec<f64>,
    /// Length by which rounding can change the residuals.
    pub(super) rounding: f64,
}

impl Linearised {
    /// Nothing where the sum of squares or the Jacobian is not finite.
    ///
    /// # Panics
    /// If the Jacobian does not have a row for each residual and a column for each unknown.
    pub(super) fn at(
        model: &dyn Model,
        unknowns: Vec<f64>,
        residuals: Vec<f64>,
    ) -> Result<Option<Self>, Error> {
        if !squares(&residuals).is_finite() {
            return Ok(None);
        }
        let jacobian = model.jacobian(&unknowns);
        assert_eq!(
            (jacobian.nrows(), jacobian.ncols()),
            (residuals.len(), unknowns.len()),
            "rows and columns of the Jacobian"
        );
        let column_lengths = column_lengths(&jacobian);
        if !column_lengths.iter().all(|length| length.is_finite()) {
            return Ok(None);
        }
        let svd = ScaledSvd::new(&jacobian, column_lengths.clone())?;
        let rank = svd.rank(RANK_TOL);
        let mut components = svd.row_components(&residuals);
        components.truncate(rank);
        // No change of the unknowns by their own rounding can be told from none.
        let rounding_of_row = |i: usize| {
            let terms = unknowns.iter().enumerate();
            let size: f64 = terms.map(|(j, x)| (jacobian[(i, j)] * x).abs()).sum();
            f64::EPSILON * (size + residuals[i].abs())
        };
        let rounding_of_rows: Vec<f64> = (0..residuals.len()).map(rounding_of_row).collect();
        Ok(Some(Self {
            rounding: norm(&rounding_of_rows) + model.rounding(),
            unknowns,
            residuals,
            jacobian,
            column_lengths,
            svd,
            rank,
            components,
        }))
    }

    pub(super) fn has_full_rank(&self) -> bool {
        self.rank == self.unknowns.len()
    }

    /// `|J δx|` of the Gauss–Newton step in what is determined.
    pub(super) fn offset(&self) -> f64 {
        norm(&self.components)
    }

    /// Decrease of the sum of squares from here to other residuals, free of the cancellation
    /// between the two sums. Not a number or -∞ if they are not finite.
    pub(super) fn decrease(&self, residuals: &[f64]) -> f64 {
        let pairs = self.residuals.iter().zip(residuals);
        pairs.map(|(a, b)| (a - b) * (a + b)).sum()
    }

    /// A decrease of the sum of squares that rounding alone can feign or hide.
    pub(super) fn decrease_rounding(&self) -> f64 {
        // (|r| + ρ)² - |r|² for either sum
        2.0 * self.rounding * (2.0 * norm(&self.residuals) + self.rounding)
    }

    /// The unknowns changed by a step.
    pub(super) fn moved(&self, step: &[f64]) -> Vec<f64> {
        self.unknowns.iter().zip(step).map(|(x, s)| x + s).collect()
    }
}

pub(super) fn squares(values: &[f64]) -> f64 {
    values.iter().map(|x| x * x).sum()
}

/// Length of a vector, without the underflow and overflow of its square.
pub(super) fn norm(values: &[f64]) -> f64 {
    let largest = values.iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    if largest > 0.0 && largest.is_finite() {
        let scaled = values.iter().map(|x| x / largest);
        largest * scaled.map(|x| x * x).sum::<f64>().sqrt()
    } else {
        largest
    }
}

//! Six of the nine equations: the paper's six-equation method for any choice of rows.

use std::fmt;

use nalgebra::{Dyn, Matrix6, OMatrix, U6, Vector3};

use crate::design::{CentredTargets, GEOMETRY_TOL};
use crate::{Error, Operator};

/// A choice of six of the nine equations ①②③④⑤⑥⑦⑧⑨, that is Px Py Pz Qx Qy Qz Kx Ky Kz.
///
/// Of the 84 choices, 78 determine the six component errors of three targets in general position,
/// with noise that differs by orders of magnitude. Six never do:
///
/// - ①②③④⑤⑥, ①②③⑦⑧⑨, ④⑤⑥⑦⑧⑨ hold all coordinates of two targets and none of the third. Turning
///   the stage about the line through the two moves neither. (Their distance is measured twice instead.)
/// - ①②④⑤⑦⑧, ①③④⑥⑦⑨, ②③⑤⑥⑧⑨ hold no z, no y, no x: the column of δz, δy, δx is zero.
///
/// The paper's rule (one row at least from each target, and not the last three) says the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SixRows {
    /// Bit i stands for row i.
    mask: u16,
}

impl SixRows {
    /// ①②④⑥⑧⑨, the choice of the paper's Eqs. 10, 11, 17 and 18.
    pub const PAPER: Self = Self {
        mask: 0b1_1010_1011,
    };

    /// The choice of the rows with these indices from 0 (①) to 8 (⑨), in any order.
    ///
    /// # Errors
    /// [`Error::RowChoice`] if two are the same or one is greater than 8.
    pub fn new(rows: [usize; 6]) -> Result<Self, Error> {
        let mask = (0..9)
            .filter(|row| rows.contains(row))
            .fold(0, |mask, row| mask | 1 << row);
        let choice = Self { mask };
        if choice.rows().count() == 6 {
            Ok(choice)
        } else {
            Err(Error::RowChoice { rows })
        }
    }

    /// All 84 choices, including the 6 that never work.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..1 << 9)
            .filter(|mask: &u16| mask.count_ones() == 6)
            .map(|mask| Self { mask })
    }

    /// The chosen rows from 0 (①) to 8 (⑨), ascending.
    pub fn rows(self) -> impl Iterator<Item = usize> {
        (0..9).filter(move |row| self.mask >> row & 1 == 1)
    }

    /// Solves the six equations exactly (the paper's Eqs. 10 and 17 for [`SixRows::PAPER`]); the other three
    /// coordinates have no influence.
    ///
    /// `r` holds the generalised coordinates of P, Q, K relative to the reference point of δ, mm.
    ///
    /// # Errors
    /// [`Error::SingularRows`] if this choice does not work for these targets (condition number above
    /// 1e6: a shift of the targets by 1e-6 of their distances could make it singular), or for any,
    /// [`Error::NotFinite`], [`Error::Collinear`].
    pub fn operator(self, r: &[Vector3<f64>; 3]) -> Result<Operator, Error> {
        let centred = CentredTargets::new(r)?;
        let matrix = self.select(&centred);
        let condition = condition_number(&matrix);
        let inverse = matrix
            .try_inverse()
            .filter(|_| condition * GEOMETRY_TOL < 1.0)
            .ok_or_else(|| Error::SingularRows {
                rows: self,
                condition,
                // Moving δ does not change the determinant, scaling ε does.
                determinant_mm3: matrix.determinant() * centred.gyration_mm.powi(3),
            })?;
        let mut solution = OMatrix::<f64, U6, Dyn>::zeros(9);
        for (row, column) in self.rows().zip(inverse.column_iter()) {
            solution.set_column(row, &column);
        }
        Ok(Operator::from_scaled(r, &centred, solution))
    }

    /// Condition number of the centred and scaled six equations.
    ///
    /// # Errors
    /// [`Error::TooFewTargets`], [`Error::NotFinite`], [`Error::Collinear`].
    pub(crate) fn condition(self, r: &[Vector3<f64>]) -> Result<f64, Error> {
        Ok(condition_number(&self.select(&CentredTargets::new(r)?)))
    }

    fn select(self, centred: &CentredTargets) -> Matrix6<f64> {
        let equations = centred.equations();
        let mut matrix = Matrix6::zeros();
        for (i, row) in self.rows().enumerate() {
            matrix.set_row(i, &equations.row(row));
        }
        matrix
    }
}

/// Largest over smallest singular value.
fn condition_number(matrix: &Matrix6<f64>) -> f64 {
    let singular_values = matrix.singular_values();
    singular_values.max() / singular_values.min()
}

/// As ①②④⑥⑧⑨.
impl fmt::Display for SixRows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const CIRCLED: [char; 9] = ['①', '②', '③', '④', '⑤', '⑥', '⑦', '⑧', '⑨'];
        self.rows()
            .try_for_each(|row| write!(f, "{}", CIRCLED[row]))
    }
}

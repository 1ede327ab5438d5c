//! Singular values by rotations of pairs of columns.
//!
//! Pairs of columns of `A` are turned until all are orthogonal, `A V = U Σ` (M. R. Hestenes, *J. SIAM* 6, 51, 1958).
//! Small singular values come out as accurately as the columns determine them (J. Demmel, K. Veselić, *SIAM J. Matrix
//! Anal. Appl.* 13, 1204, 1992). The time goes with the cube of the columns and is a second for 400.

use nalgebra::DMatrix;

use crate::Error;
use crate::dot::dot;

/// `A = U Σ Vᵀ`, thin: one component for each row or column, whichever are fewer.
#[derive(Debug, Clone)]
pub struct Svd {
    /// A column of unit length for each singular value; zeros for a singular value of zero.
    pub u: DMatrix<f64>,
    /// Largest first.
    pub values: Vec<f64>,
    /// A column of unit length for each singular value; if there are fewer rows than columns, zeros for a singular value
    /// of zero.
    pub v: DMatrix<f64>,
}

/// Rounds over all pairs; matrices of hundreds of columns need ten, those without full rank fifteen.
const MAX_SWEEPS: usize = 60;

/// A column whose square, relative to that of the largest element, is below this is zero. If columns depend on others exactly,
/// every round makes what is left of them smaller by the rounding.
const ZERO: f64 = 1e-200;

impl Svd {
    /// # Errors
    /// [`Error::Decomposition`] if an element is not finite, or if the rounds do not come to an end, which has not been seen.
    pub fn new(matrix: &DMatrix<f64>) -> Result<Self, Error> {
        let (rows, columns) = matrix.shape();
        if rows < columns {
            let Self { u, values, v } = Self::new(&matrix.transpose())?;
            return Ok(Self { u: v, values, v: u });
        }
        let size = matrix.amax();
        if !matrix.iter().all(|x| x.is_finite()) {
            return Err(Error::Decomposition {
                what: "singular value decomposition",
            });
        }
        if size <= 0.0 {
            return Ok(Self {
                u: DMatrix::zeros(rows, columns),
                values: vec![0.0; columns],
                v: DMatrix::identity(columns, columns),
            });
        }
        let scaled = matrix / size;
        let (q, mut turned) = match rows > columns {
            true => {
                let (q, r) = scaled.qr().unpack();
                (Some(q), r)
            }
            false => (None, scaled),
        };
        let mut v = DMatrix::identity(columns, columns);
        orthogonalise(&mut turned, &mut v)?;
        let length = |squares: f64| if squares < ZERO { 0.0 } else { squares.sqrt() };
        let squares = turned.column_iter().map(|column| column.norm_squared());
        let lengths: Vec<f64> = squares.map(length).collect();
        let mut order: Vec<usize> = (0..columns).collect();
        order.sort_by(|&i, &j| lengths[j].total_cmp(&lengths[i]));
        for (mut column, &length) in turned.column_iter_mut().zip(&lengths) {
            match length > 0.0 {
                true => column /= length,
                false => column.fill(0.0),
            }
        }
        let u = turned.select_columns(&order);
        Ok(Self {
            u: match q {
                Some(q) => q * u,
                None => u,
            },
            values: order.iter().map(|&i| size * lengths[i]).collect(),
            v: v.select_columns(&order),
        })
    }

    /// The largest singular value; zero of an empty matrix.
    pub fn largest(&self) -> f64 {
        self.values.first().copied().unwrap_or(0.0)
    }

    /// How many singular values are above `least`.
    pub fn rank(&self, least: f64) -> usize {
        self.values.iter().filter(|&&value| value > least).count()
    }

    /// Moore and Penrose's inverse; singular values that are not above `least` are zero.
    pub fn pseudo_inverse(&self, least: f64) -> DMatrix<f64> {
        let rank = self.rank(least);
        let mut v = self.v.columns(0, rank).into_owned();
        for (mut column, value) in v.column_iter_mut().zip(&self.values) {
            column /= *value;
        }
        v * self.u.columns(0, rank).transpose()
    }
}

/// Turns pairs of columns until all are orthogonal, and those of `v` with them.
fn orthogonalise(matrix: &mut DMatrix<f64>, v: &mut DMatrix<f64>) -> Result<(), Error> {
    let columns = matrix.ncols();
    let tolerance = f64::EPSILON * (matrix.nrows().max(1) as f64).sqrt();
    for _ in 0..MAX_SWEEPS {
        let mut is_orthogonal = true;
        for i in 0..columns {
            for j in i + 1..columns {
                let [first, second] = [i, j].map(|k| matrix.column(k));
                let [first, second] = [first.as_slice(), second.as_slice()];
                let (a, b, c) = (dot(first, first), dot(second, second), dot(first, second));
                if a.min(b) < ZERO || c.abs() <= tolerance * a.sqrt() * b.sqrt() {
                    continue;
                }
                is_orthogonal = false;
                // The smaller angle of the two that make them orthogonal.
                let cotangent = (b - a) / (2.0 * c);
                let tangent = cotangent.signum() / (cotangent.abs() + cotangent.hypot(1.0));
                let cos = tangent.hypot(1.0).recip();
                turn(matrix, (i, j), cos, cos * tangent);
                turn(v, (i, j), cos, cos * tangent);
            }
        }
        if is_orthogonal {
            return Ok(());
        }
    }
    Err(Error::Decomposition {
        what: "singular value decomposition",
    })
}

fn turn(matrix: &mut DMatrix<f64>, (i, j): (usize, usize), cos: f64, sin: f64) {
    let (mut first, mut second) = matrix.columns_range_pair_mut(i, j);
    for (x, y) in first.iter_mut().zip(second.iter_mut()) {
        (*x, *y) = (cos * *x - sin * *y, sin * *x + cos * *y);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DVector, Vector3};

    use super::*;

    /// Numbers without a pattern, -1 to 1.
    fn wave(i: usize) -> f64 {
        (1.7 * (i * i + 3 * i) as f64 + 0.3).sin()
    }

    fn assert_decomposes(matrix: &DMatrix<f64>, rank: usize) {
        let svd = Svd::new(matrix).unwrap();
        let size = matrix.norm();
        let values = DMatrix::from_diagonal(&DVector::from_column_slice(&svd.values));
        assert!((&svd.u * values * svd.v.transpose() - matrix).norm() <= 1e-14 * size);
        assert!(svd.values.is_sorted_by(|a, b| a >= b));
        let least = 1e-13 * svd.largest();
        assert_eq!(svd.rank(least), rank, "{:?}", svd.values);
        for vectors in [&svd.u, &svd.v] {
            let vectors = vectors.columns(0, rank);
            let products = vectors.transpose() * vectors - DMatrix::identity(rank, rank);
            assert!(products.amax() < 1e-14);
        }
        let inverse = svd.pseudo_inverse(least);
        assert!((matrix * &inverse * matrix - matrix).norm() <= 1e-11 * size);
    }

    /// Of all shapes, some of them products of rank two.
    #[test]
    fn factors_give_the_matrix() {
        for rows in 1..9 {
            for columns in 1..9 {
                let any = |seed: usize, m: usize, n: usize| {
                    DMatrix::from_fn(m, n, |i, j| wave(seed + 31 * i + 7 * j + m * n))
                };
                assert_decomposes(&any(1, rows, columns), rows.min(columns));
                let of_rank_two = any(2, rows, 2) * any(3, 2, columns);
                assert_decomposes(&of_rank_two, rows.min(columns).min(2));
            }
        }
    }

    /// Rows of zeros and columns that are multiples of others: some columns of what is turned end at zero.
    #[test]
    fn columns_that_depend_on_others_exactly() {
        let inclined = [[1.0, 0.0, 0.6], [0.0, 0.0, 0.0], [0.0, 1.0, 0.8]];
        assert_decomposes(&DMatrix::from_fn(3, 3, |i, j| inclined[i][j]), 2);
        for rows in 3..12 {
            for columns in 2..8 {
                for filled in 1..3 {
                    let element = |i: usize, j: usize| match i % 4 < filled && i < 4 {
                        true => wave(5 * i + 11 * j),
                        false => 0.0,
                    };
                    assert_decomposes(&DMatrix::from_fn(rows, columns, element), filled);
                }
                let multiples = |i: usize, j: usize| wave(i) * [1.0, -2.5, 0.3][j % 3];
                assert_decomposes(&DMatrix::from_fn(rows, columns, multiples), 1);
            }
        }
    }

    /// All 19,683 matrices of -1, 0 and 1; the rank of whole numbers is that of fractions.
    #[test]
    fn every_matrix_of_small_whole_numbers() {
        for number in 1..3_usize.pow(9) {
            let digit = |place: usize| (number / 3_usize.pow(u32::try_from(place).unwrap())) % 3;
            let whole = |i: usize, j: usize| digit(3 * i + j) as f64 - 1.0;
            let matrix = DMatrix::from_fn(3, 3, whole);
            let rows: [Vector3<f64>; 3] = [0, 1, 2].map(|i| Vector3::from_fn(|j, _| whole(i, j)));
            let crosses = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| rows[i].cross(&rows[j]));
            let rank = match rows[0].dot(&crosses[2]).abs() > 0.5 {
                true => 3,
                false if crosses.iter().any(|cross| cross.amax() > 0.5) => 2,
                false => usize::from(matrix.amax() > 0.5),
            };
            assert_decomposes(&matrix, rank);
        }
    }

    /// Equal columns, and numbers of which another implementation's first singular value is 4.54 and 3.1686.
    #[test]
    fn whole_numbers_are_no_exception() {
        let ones = DMatrix::from_element(3, 5, 1.0);
        assert_decomposes(&ones, 1);
        assert!((Svd::new(&ones).unwrap().largest() - 15_f64.sqrt()).abs() < 1e-14);
        let whole = [1.0, 2.0, 2.0, 2.0, -1.0, -1.0, 2.0, 1.0, -1.0];
        let whole = DMatrix::from_row_slice(3, 3, &whole);
        assert_decomposes(&whole, 3);
        let values = Svd::new(&whole).unwrap().values;
        for (found, expected) in values.iter().zip([10_f64.sqrt(), 10_f64.sqrt(), 1.0]) {
            assert!((found - expected).abs() < 1e-14, "{values:?}");
        }
    }

    /// Columns of very different size: the small singular value has all its digits.
    #[test]
    fn small_singular_values_are_accurate() {
        let angle = 0.3_f64;
        let columns = [
            angle.cos(),
            angle.sin(),
            -1e-18 * angle.sin(),
            1e-18 * angle.cos(),
        ];
        let svd = Svd::new(&DMatrix::from_column_slice(2, 2, &columns)).unwrap();
        assert!((svd.values[0] - 1.0).abs() < 1e-15);
        assert!(
            (svd.values[1] / 1e-18 - 1.0).abs() < 1e-14,
            "{:?}",
            svd.values
        );
    }

    #[test]
    fn numbers_that_are_not_are_refused() {
        for x in [f64::NAN, f64::INFINITY] {
            assert!(Svd::new(&DMatrix::from_element(2, 3, x)).is_err());
        }
    }
}

//! Products of small matrices, eight side by side.
//!
//! ```text
//! S += A B     S -= A B
//! ```
//!
//! A tile of a few elements of the result stays in registers while the sum runs. A factor is a
//! [`View`] with any order of elements, so that a transpose costs nothing: a [`LaneMatrix`], one matrix in
//! each lane, or a [`SharedMatrix`], the same for all lanes. Each product takes the widest registers itself
//! ([`crate::in_widest_registers`]): inlined in all passes it would take minutes to compile.
//!
//! Sizes that do not fit panic.

use std::ops::Range;

use crate::in_widest_registers;
use crate::lanes::{Lanes, lanes_only};

/// Rows and columns of a tile: with them, sixteen of the widest registers hold sums.
const ROWS: usize = 4;
const COLUMNS: usize = 4;

/// A matrix, or a part of one, in a slice.
#[derive(Debug, Clone, Copy)]
pub struct View<'a, E> {
    elements: &'a [E],
    rows: usize,
    columns: usize,
    /// How far elements are apart from row to row, and from column to column.
    down: usize,
    along: usize,
}

/// Eight matrices of the same size, side by side.
pub type LaneMatrix<'a> = View<'a, Lanes>;

/// A matrix that is the same in all lanes.
pub type SharedMatrix<'a> = View<'a, f64>;

/// An element of a factor: a number in each lane, or one for all of them.
pub trait Element: Copy {
    /// The number in each lane.
    fn in_lanes(self) -> Lanes;
}

impl Element for Lanes {
    #[inline(always)]
    fn in_lanes(self) -> Lanes {
        self
    }
}

impl Element for f64 {
    #[inline(always)]
    fn in_lanes(self) -> Lanes {
        Lanes::splat(self)
    }
}

impl<'a, E: Element> View<'a, E> {
    /// So many rows and columns, rows one after the other.
    #[inline(always)]
    pub fn by_rows(elements: &'a [E], [rows, columns]: [usize; 2]) -> Self {
        assert_eq!(elements.len(), rows * columns, "elements of a matrix");
        Self {
            elements,
            rows,
            columns,
            down: columns,
            along: 1,
        }
    }

    /// The transpose.
    #[inline(always)]
    pub fn transposed(self) -> Self {
        Self {
            rows: self.columns,
            columns: self.rows,
            down: self.along,
            along: self.down,
            ..self
        }
    }

    /// Number of rows.
    #[inline(always)]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    #[inline(always)]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// An element, in each lane.
    #[inline(always)]
    pub fn at(&self, row: usize, column: usize) -> Lanes {
        self.elements[row * self.down + column * self.along].in_lanes()
    }

    /// Some rows of a matrix whose rows are one after the other.
    #[inline(always)]
    pub fn part(self, rows: Range<usize>) -> Self {
        Self::by_rows(self.contiguous(rows.clone()), [rows.len(), self.columns])
    }

    /// A row of a matrix whose rows are one after the other.
    #[inline(always)]
    pub fn row(self, row: usize) -> &'a [E] {
        self.contiguous(row..row + 1)
    }

    #[inline(always)]
    fn contiguous(self, rows: Range<usize>) -> &'a [E] {
        assert_eq!([self.down, self.along], [self.columns, 1], "rows in order");
        &self.elements[rows.start * self.columns..rows.end * self.columns]
    }
}

/// `S += A B`, rows of `S` one after the other.
#[inline(never)]
pub fn add_product<A: Element, B: Element>(sum: &mut [Lanes], a: View<'_, A>, b: View<'_, B>) {
    in_widest_registers(
        #[inline(always)]
        || Product::<_, _, false>::new(sum, a, b).add_rows(false),
    );
}

/// `S -= A B`.
#[inline(never)]
pub fn subtract_product<A: Element, B: Element>(sum: &mut [Lanes], a: View<'_, A>, b: View<'_, B>) {
    in_widest_registers(
        #[inline(always)]
        || Product::<_, _, true>::new(sum, a, b).add_rows(false),
    );
}

/// The upper triangle (and some of the lower) of `S += A B`, for a product that is symmetric.
#[inline(never)]
pub fn add_symmetric_product<A: Element, B: Element>(
    sum: &mut [Lanes],
    a: View<'_, A>,
    b: View<'_, B>,
) {
    in_widest_registers(
        #[inline(always)]
        || Product::<_, _, false>::new(sum, a, b).add_rows(true),
    );
}

struct Product<'a, A, B, const NEGATIVE: bool> {
    sum: &'a mut [Lanes],
    a: View<'a, A>,
    b: View<'a, B>,
}

impl<'a, A: Element, B: Element, const NEGATIVE: bool> Product<'a, A, B, NEGATIVE> {
    #[inline(always)]
    fn new(sum: &'a mut [Lanes], a: View<'a, A>, b: View<'a, B>) -> Self {
        assert_eq!(a.columns(), b.rows(), "columns of A and rows of B");
        assert_eq!(sum.len(), a.rows() * b.columns(), "elements of A B");
        Self { sum, a, b }
    }

    #[inline(always)]
    fn add_rows(&mut self, only_upper: bool) {
        let rows = self.a.rows();
        let mut i = 0;
        while i < rows {
            let first = if only_upper { i } else { 0 };
            // Threes first where fours would leave a row alone or two.
            i += match rows - i {
                left if left % ROWS == 0 => self.add_columns::<ROWS>(i, first),
                3.. => self.add_columns::<3>(i, first),
                2 => self.add_columns::<2>(i, first),
                _ => self.add_columns::<1>(i, first),
            };
        }
    }

    /// `R` rows from `i` on, in the columns from `first` on; returns `R`.
    #[inline(always)]
    fn add_columns<const R: usize>(&mut self, i: usize, first: usize) -> usize {
        let columns = self.b.columns();
        let mut j = first;
        while j < columns {
            j += match columns - j {
                COLUMNS.. => self.add_tile::<R, COLUMNS>(i, j),
                2.. => self.add_tile::<R, 2>(i, j),
                _ => self.add_tile::<R, 1>(i, j),
            };
        }
        R
    }

    /// Returns the number of columns.
    #[inline(always)]
    fn add_tile<const R: usize, const C: usize>(&mut self, i: usize, j: usize) -> usize {
        let mut tile = [[Lanes::ZERO; C]; R];
        for k in 0..self.a.columns() {
            lanes_only();
            let mut right = [Lanes::ZERO; C];
            for (c, right) in right.iter_mut().enumerate() {
                *right = self.b.at(k, j + c);
            }
            for (r, tile) in tile.iter_mut().enumerate() {
                let left = self.a.at(i + r, k);
                for (sum, right) in tile.iter_mut().zip(&right) {
                    *sum = left.mul_add(*right, *sum);
                }
            }
        }
        let columns = self.b.columns();
        for (r, tile) in tile.iter().enumerate() {
            let start = (i + r) * columns + j;
            for (sum, x) in self.sum[start..start + C].iter_mut().zip(tile) {
                *sum = if NEGATIVE { *sum - *x } else { *sum + *x };
            }
        }
        C
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;
    use crate::lanes::LANES;

    fn lanes(count: usize, seed: f64) -> Vec<Lanes> {
        let of_place =
            |k: usize| Lanes::from_fn(|lane| (seed + 1.7 * k as f64 - 0.9 * lane as f64).sin());
        (0..count).map(of_place).collect()
    }

    fn in_lane<E: Element>(matrix: View<'_, E>, lane: usize) -> DMatrix<f64> {
        DMatrix::from_fn(matrix.rows(), matrix.columns(), |i, j| {
            matrix.at(i, j).0[lane]
        })
    }

    #[test]
    fn rows_are_those_of_the_matrix() {
        let elements = lanes(4 * 3, 0.7);
        let matrix = LaneMatrix::by_rows(&elements, [4, 3]);
        let middle = matrix.part(1..3);
        assert_eq!([middle.rows(), middle.columns()], [2, 3]);
        for i in 0..2 {
            for j in 0..3 {
                assert_eq!(middle.at(i, j), elements[(i + 1) * 3 + j]);
                assert_eq!(middle.row(i)[j], elements[(i + 1) * 3 + j]);
                assert_eq!(matrix.transposed().at(j, i + 1), middle.at(i, j));
            }
        }
        let empty = LaneMatrix::by_rows(&[], [4, 0]);
        assert!(empty.row(3).is_empty());
        assert_eq!(empty.part(1..3).rows(), 2);
    }

    #[test]
    #[should_panic(expected = "rows in order")]
    fn a_transpose_has_no_contiguous_rows() {
        let elements = lanes(4 * 3, 0.7);
        LaneMatrix::by_rows(&elements, [3, 4]).transposed().row(1);
    }

    #[test]
    fn products_are_those_of_matrices() {
        for (n, k, m) in [
            (12, 9, 22),
            (3, 3, 1),
            (5, 1, 7),
            (6, 21, 6),
            (4, 0, 4),
            (2, 3, 0),
        ] {
            let (a, b) = (lanes(n * k, 0.3), lanes(k * m, 1.1));
            let a = LaneMatrix::by_rows(&a, [k, n]).transposed();
            let right = LaneMatrix::by_rows(&b, [k, m]);
            let numbers: Vec<f64> = b.iter().map(|b| b.0[0]).collect();
            let shared = SharedMatrix::by_rows(&numbers, [m, k]).transposed();
            let mut sums = [(); 3].map(|()| vec![Lanes::splat(1.0); n * m]);
            let mut square = vec![Lanes::ZERO; n * n];
            add_product(&mut sums[0], a, right);
            subtract_product(&mut sums[1], a, right);
            add_product(&mut sums[2], a, shared);
            add_symmetric_product(&mut square, a, a.transposed());
            for lane in 0..LANES {
                let [a, right, shared] = [
                    in_lane(a, lane),
                    in_lane(right, lane),
                    in_lane(shared, lane),
                ];
                let one = DMatrix::from_element(n, m, 1.0);
                let expected = [&one + &a * &right, &one - &a * &right, &one + &a * &shared];
                for (sum, expected) in sums.iter().zip(&expected) {
                    let found = in_lane(LaneMatrix::by_rows(sum, [n, m]), lane);
                    assert!((found - expected).amax() < 1e-13);
                }
                let squared = &a * a.transpose();
                for (i, row) in square.chunks_exact(n).enumerate() {
                    for j in i..n {
                        assert!((row[j].0[lane] - squared[(i, j)]).abs() < 1e-13);
                    }
                }
            }
        }
    }
}

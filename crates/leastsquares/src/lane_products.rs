//! Products of small matrices, eight side by side.
//!
//! ```text
//! S += A B     S -= A B
//! ```
//!
//! A tile of a few elements of the result stays in registers while the sum runs. A factor is a
//! [`LaneMatrix`], one matrix in each lane, or a [`SharedMatrix`], the same for all lanes; both are views
//! with any order of elements, so a transpose costs nothing. Each product takes the widest registers itself
//! ([`crate::in_widest_registers`]): inlined in all passes it would take minutes to compile.
//!
//! Sizes that do not fit panic.

use std::ops::Range;

use crate::in_widest_registers;
use crate::lanes::{Lanes, lanes_only};

/// Rows and columns of a tile: with them, sixteen of the widest registers hold sums.
const ROWS: usize = 4;
const COLUMNS: usize = 4;

/// A factor of a product.
pub trait Factor: Copy {
    /// Number of rows.
    fn rows(&self) -> usize;

    /// Number of columns.
    fn columns(&self) -> usize;

    /// An element, in each lane.
    fn at(&self, row: usize, column: usize) -> Lanes;
}

/// Eight matrices of the same size, side by side.
#[derive(Debug, Clone, Copy)]
pub struct LaneMatrix<'a> {
    elements: &'a [Lanes],
    layout: Layout,
}

/// A matrix that is the same in all lanes.
#[derive(Debug, Clone, Copy)]
pub struct SharedMatrix<'a> {
    elements: &'a [f64],
    layout: Layout,
}

/// Where the elements of a matrix are.
#[derive(Debug, Clone, Copy)]
struct Layout {
    rows: usize,
    columns: usize,
    /// How far elements are apart from row to row, and from column to column.
    down: usize,
    along: usize,
}

impl Layout {
    #[inline(always)]
    fn by_rows(elements: usize, [rows, columns]: [usize; 2]) -> Self {
        assert_eq!(elements, rows * columns, "elements of a matrix");
        Self {
            rows,
            columns,
            down: columns,
            along: 1,
        }
    }

    #[inline(always)]
    fn transposed(self) -> Self {
        Self {
            rows: self.columns,
            columns: self.rows,
            down: self.along,
            along: self.down,
        }
    }

    #[inline(always)]
    fn place(&self, row: usize, column: usize) -> usize {
        row * self.down + column * self.along
    }
}

impl<'a> LaneMatrix<'a> {
    /// So many rows and columns, rows one after the other.
    #[inline(always)]
    pub fn by_rows(elements: &'a [Lanes], sizes: [usize; 2]) -> Self {
        Self {
            elements,
            layout: Layout::by_rows(elements.len(), sizes),
        }
    }

    /// The same, columns one after the other.
    #[inline(always)]
    pub fn by_columns(elements: &'a [Lanes], [rows, columns]: [usize; 2]) -> Self {
        Self::by_rows(elements, [columns, rows]).transposed()
    }

    /// The transpose.
    #[inline(always)]
    pub fn transposed(self) -> Self {
        Self {
            layout: self.layout.transposed(),
            ..self
        }
    }

    /// Some rows of a matrix whose rows are contiguous.
    #[inline(always)]
    pub fn part(self, rows: Range<usize>) -> Self {
        let columns = self.layout.columns;
        assert_eq!(self.layout.along, 1, "contiguous rows");
        let elements = &self.elements[rows.start * columns..rows.end * columns];
        Self::by_rows(elements, [rows.len(), columns])
    }
}

impl<'a> SharedMatrix<'a> {
    /// So many rows and columns, rows one after the other.
    #[inline(always)]
    pub fn by_rows(elements: &'a [f64], sizes: [usize; 2]) -> Self {
        Self {
            elements,
            layout: Layout::by_rows(elements.len(), sizes),
        }
    }

    /// The same, columns one after the other.
    #[inline(always)]
    pub fn by_columns(elements: &'a [f64], [rows, columns]: [usize; 2]) -> Self {
        let by_rows = Self::by_rows(elements, [columns, rows]);
        Self {
            layout: by_rows.layout.transposed(),
            ..by_rows
        }
    }
}

impl Factor for LaneMatrix<'_> {
    #[inline(always)]
    fn rows(&self) -> usize {
        self.layout.rows
    }

    #[inline(always)]
    fn columns(&self) -> usize {
        self.layout.columns
    }

    #[inline(always)]
    fn at(&self, row: usize, column: usize) -> Lanes {
        self.elements[self.layout.place(row, column)]
    }
}

impl Factor for SharedMatrix<'_> {
    #[inline(always)]
    fn rows(&self) -> usize {
        self.layout.rows
    }

    #[inline(always)]
    fn columns(&self) -> usize {
        self.layout.columns
    }

    #[inline(always)]
    fn at(&self, row: usize, column: usize) -> Lanes {
        Lanes::splat(self.elements[self.layout.place(row, column)])
    }
}

/// `S += A B`, rows of `S` one after the other.
#[inline(never)]
pub fn add_product(sum: &mut [Lanes], a: impl Factor, b: impl Factor) {
    in_widest_registers(
        #[inline(always)]
        || Product::<_, _, false>::new(sum, a, b).add_rows(false),
    );
}

/// `S -= A B`.
#[inline(never)]
pub fn subtract_product(sum: &mut [Lanes], a: impl Factor, b: impl Factor) {
    in_widest_registers(
        #[inline(always)]
        || Product::<_, _, true>::new(sum, a, b).add_rows(false),
    );
}

/// The upper triangle (and some of the lower) of `S += A B`, for a product that is symmetric.
#[inline(never)]
pub fn add_symmetric_product(sum: &mut [Lanes], a: impl Factor, b: impl Factor) {
    in_widest_registers(
        #[inline(always)]
        || Product::<_, _, false>::new(sum, a, b).add_rows(true),
    );
}

struct Product<'a, A, B, const NEGATIVE: bool> {
    sum: &'a mut [Lanes],
    a: A,
    b: B,
}

impl<'a, A: Factor, B: Factor, const NEGATIVE: bool> Product<'a, A, B, NEGATIVE> {
    #[inline(always)]
    fn new(sum: &'a mut [Lanes], a: A, b: B) -> Self {
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
            i += match rows - i {
                ROWS.. => self.add_columns::<ROWS>(i, first),
                2.. => self.add_columns::<2>(i, first),
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
    use faer::Mat;

    use super::*;
    use crate::lanes::LANES;

    fn lanes(count: usize, seed: f64) -> Vec<Lanes> {
        let of_place =
            |k: usize| Lanes::from_fn(|lane| (seed + 1.7 * k as f64 - 0.9 * lane as f64).sin());
        (0..count).map(of_place).collect()
    }

    fn in_lane(matrix: impl Factor, lane: usize) -> Mat<f64> {
        Mat::from_fn(matrix.rows(), matrix.columns(), |i, j| {
            matrix.at(i, j).0[lane]
        })
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
            let a = LaneMatrix::by_columns(&a, [n, k]);
            let right = LaneMatrix::by_rows(&b, [k, m]);
            let numbers: Vec<f64> = b.iter().map(|b| b.0[0]).collect();
            let shared = SharedMatrix::by_columns(&numbers, [k, m]);
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
                let one = Mat::full(n, m, 1.0);
                let expected = [&one + &a * &right, &one - &a * &right, &one + &a * &shared];
                for (sum, expected) in sums.iter().zip(&expected) {
                    let found = in_lane(LaneMatrix::by_rows(sum, [n, m]), lane);
                    assert!((found - expected).norm_max() < 1e-13);
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

//! Products of columns, several at once: each is the same bits as by [`dot`].

use trueaxis_leastsquares::{dot, in_widest_registers};

/// Columns abreast: their sums do not wait for each other.
const ABREAST: usize = 4;

/// `aᵀ b` of one column with several of the same length, one after the other.
pub(crate) fn dots(a: &[f64], others: &[&[f64]]) -> Vec<f64> {
    let mut products = Vec::with_capacity(others.len());
    in_widest_registers(
        #[inline(always)]
        || {
            let (fours, rest) = others.as_chunks::<ABREAST>();
            for four in fours {
                products.extend(dots_of_four(a, four));
            }
            products.extend(rest.iter().map(|b| dot(a, b)));
        },
    );
    products
}

#[inline(always)]
fn dots_of_four(a: &[f64], others: &[&[f64]; ABREAST]) -> [f64; ABREAST] {
    let mut sums = [[0.0; 4]; ABREAST];
    let (a_fours, a_rest) = a.as_chunks::<4>();
    let others = others.map(|b| b[..a.len()].as_chunks::<4>());
    let [b, c, d, e] = others.map(|(fours, _)| fours);
    for ((((a, b), c), d), e) in a_fours.iter().zip(b).zip(c).zip(d).zip(e) {
        for (sums, x) in sums.iter_mut().zip([b, c, d, e]) {
            for ((sum, a), x) in sums.iter_mut().zip(a).zip(x) {
                *sum += a * x;
            }
        }
    }
    let mut products = [0.0; ABREAST];
    for ((product, sums), (_, rest)) in products.iter_mut().zip(sums).zip(others) {
        let rest: f64 = a_rest.iter().zip(rest).map(|(a, b)| a * b).sum();
        *product = (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest;
    }
    products
}

/// Several vectors side by side, row after row; lanes that are left over are zeros.
pub(crate) struct SideBySide {
    rows: Vec<[f64; SIDE_BY_SIDE]>,
}

pub(crate) const SIDE_BY_SIDE: usize = 8;

impl SideBySide {
    /// Of at most [`SIDE_BY_SIDE`] vectors of the same length.
    pub(crate) fn new(vectors: &[Vec<f64>]) -> Self {
        let mut rows = vec![[0.0; SIDE_BY_SIDE]; vectors.first().map_or(0, Vec::len)];
        for (lane, vector) in vectors.iter().enumerate() {
            for (row, x) in rows.iter_mut().zip(vector) {
                row[lane] = *x;
            }
        }
        Self { rows }
    }

    pub(crate) fn rows(&self) -> &[[f64; SIDE_BY_SIDE]] {
        &self.rows
    }

    /// The product of a column that begins at a row with each.
    pub(crate) fn dots(&self, first_row: usize, column: &[f64]) -> [f64; SIDE_BY_SIDE] {
        let rows = &self.rows[first_row..first_row + column.len()];
        in_widest_registers(
            #[inline(always)]
            || {
                let mut sums = [[0.0; SIDE_BY_SIDE]; 4];
                let (fours, rest) = rows.as_chunks::<4>();
                let (column_fours, column_rest) = column.as_chunks::<4>();
                for (rows, column) in fours.iter().zip(column_fours) {
                    for ((sums, row), x) in sums.iter_mut().zip(rows).zip(column) {
                        add_row(sums, row, *x);
                    }
                }
                let mut of_rest = [0.0; SIDE_BY_SIDE];
                for (row, x) in rest.iter().zip(column_rest) {
                    add_row(&mut of_rest, row, *x);
                }
                let [a, b, c, d] = sums;
                std::array::from_fn(|lane| {
                    (a[lane] + b[lane]) + (c[lane] + d[lane]) + of_rest[lane]
                })
            },
        )
    }
}

/// `sum += x · row`, lane by lane.
#[inline(always)]
pub(crate) fn add_row(sum: &mut [f64; SIDE_BY_SIDE], row: &[f64; SIDE_BY_SIDE], x: f64) {
    for (sum, own) in sum.iter_mut().zip(row) {
        *sum += x * own;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of every length that a multiple of four leaves over: the bits of one product after the other.
    #[test]
    fn several_products_are_the_bits_of_single_ones() {
        for rows in 20..24 {
            let column = |k: usize| -> Vec<f64> {
                let value = |i: usize| ((7 * i + 3 * k) as f64).sin() / (1.0 + k as f64);
                (0..rows).map(value).collect()
            };
            let own = column(17);
            let others: Vec<Vec<f64>> = (0..7).map(column).collect();
            let expected: Vec<f64> = others.iter().map(|b| dot(&own, b)).collect();
            let slices: Vec<&[f64]> = others.iter().map(Vec::as_slice).collect();
            assert_eq!(dots(&own, &slices), expected);
            let side_by_side = SideBySide::new(&others).dots(0, &own);
            assert_eq!(side_by_side[..7], expected[..]);
        }
    }
}

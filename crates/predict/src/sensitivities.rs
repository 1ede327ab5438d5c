//! A matrix of which most rows use few columns: how results answer to what some of them share.

use nalgebra::{DMatrix, DVectorView};

/// Rows of results, columns of what they share. The component errors of an axis answer to its own parameters and to
/// what all share: what only other axes have is not stored.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivities {
    columns: usize,
    blocks: Vec<Rows>,
}

/// Rows that follow each other, without the columns that are zero in all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// The number of the first row.
    first: usize,
    columns: Vec<usize>,
    /// Row after row.
    values: Vec<f64>,
    count: usize,
}

impl Rows {
    /// Rows `first` and the next ones.
    pub fn new(first: usize, dense: &DMatrix<f64>) -> Self {
        let factors = vec![1.0; dense.nrows()];
        Self::of_columns(first, &factors, dense.column_iter().enumerate())
    }

    /// The same of some columns with their numbers, ascending; each row times a factor.
    pub fn of_columns<'m>(
        first: usize,
        factors: &[f64],
        columns: impl Iterator<Item = (usize, DVectorView<'m, f64>)>,
    ) -> Self {
        let is_used = |(_, column): &(usize, DVectorView<'m, f64>)| {
            let mut elements = column.iter().zip(factors);
            elements.any(|(x, factor)| x * factor != 0.0)
        };
        let used: Vec<_> = columns.filter(is_used).collect();
        let mut values = Vec::with_capacity(factors.len() * used.len());
        for (i, factor) in factors.iter().enumerate() {
            values.extend(used.iter().map(|(_, column)| column[i] * factor));
        }
        Self {
            first,
            columns: used.iter().map(|(number, _)| *number).collect(),
            values,
            count: factors.len(),
        }
    }

    fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let width = self.columns.len();
        let values = self.values[i * width..(i + 1) * width].iter();
        self.columns.iter().copied().zip(values.copied())
    }
}

impl Sensitivities {
    /// Of rows that follow each other from the first on.
    pub(crate) fn new(columns: usize, blocks: Vec<Rows>) -> Self {
        Self { columns, blocks }
    }

    /// Numbers of rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        let last = self.blocks.last();
        (last.map_or(0, |last| last.first + last.count), self.columns)
    }

    /// The elements of a row, with their columns; the others are zero.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let block = self.blocks.partition_point(|block| block.first <= row) - 1;
        let block = &self.blocks[block];
        block.row(row - block.first)
    }

    /// All elements, row after row.
    pub fn elements(&self) -> impl Iterator<Item = f64> + '_ {
        let rows = self.blocks.iter();
        let rows = rows.flat_map(|block| (0..block.count).map(|i| block.row(i)));
        rows.flat_map(|row| {
            let mut dense = vec![0.0; self.columns];
            row.for_each(|(column, x)| dense[column] = x);
            dense
        })
    }

    /// Multiplies each row by a factor.
    pub(crate) fn multiply(&mut self, factors: &[f64]) {
        for block in &mut self.blocks {
            let rows = block.values.chunks_exact_mut(block.columns.len().max(1));
            for (row, factor) in rows.zip(&factors[block.first..]) {
                row.iter_mut().for_each(|x| *x *= factor);
            }
        }
    }

    /// Takes away the columns that no row uses, and says which are left.
    pub(crate) fn drop_unused_columns(&mut self) -> Vec<usize> {
        let mut used: Vec<usize> = Vec::new();
        for block in &self.blocks {
            used.extend(&block.columns);
            used.sort_unstable();
            used.dedup();
        }
        for column in self.blocks.iter_mut().flat_map(|block| &mut block.columns) {
            *column = used.partition_point(|u| u < column);
        }
        self.columns = used.len();
        used
    }

    /// Appends a column.
    pub(crate) fn push_column(&mut self, column: &[f64]) {
        for block in &mut self.blocks {
            let added = &column[block.first..block.first + block.count];
            let all = added.iter().enumerate().flat_map(|(i, &x)| {
                let row = block.row(i).map(|(_, value)| value);
                row.chain([x])
            });
            let values = all.collect();
            block.values = values;
            block.columns.push(self.columns);
        }
        self.columns += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_the_matrix_that_it_was_made_of() {
        let dense =
            DMatrix::from_row_slice(3, 4, &[1., 0., 0., 2., 0., 0., 0., 0., 0., 0., 3., 4.]);
        let blocks = |split: usize| {
            let (upper, lower) = (dense.rows(0, split), dense.rows(split, 3 - split));
            vec![
                Rows::new(0, &upper.into_owned()),
                Rows::new(split, &lower.into_owned()),
            ]
        };
        for split in [1, 2] {
            let mut found = Sensitivities::new(4, blocks(split));
            let as_matrix = |found: &Sensitivities| {
                let (rows, columns) = found.shape();
                DMatrix::from_row_iterator(rows, columns, found.elements())
            };
            assert_eq!(as_matrix(&found), dense);
            assert_eq!(found.row(2).collect::<Vec<_>>(), [(2, 3.0), (3, 4.0)]);
            assert_eq!(found.drop_unused_columns(), [0, 2, 3]);
            found.push_column(&[5.0, 6.0, 7.0]);
            found.multiply(&[1.0, 2.0, 10.0]);
            let expected = [1., 0., 2., 5., 0., 0., 0., 12., 0., 30., 40., 70.];
            assert_eq!(as_matrix(&found), DMatrix::from_row_slice(3, 4, &expected));
        }
    }
}

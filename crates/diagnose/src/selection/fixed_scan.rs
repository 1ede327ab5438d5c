//! A hypothesis with few shapes, each with columns of its own.

use std::ops::Range;

use crate::selection::projection::dot;
use crate::selection::{Gram, Hypothesis, Projection, Scan};

/// Columns for every shape.
pub(crate) struct FixedScan {
    hypothesis: Hypothesis,
    shapes: Vec<FixedShape>,
    rows: usize,
}

struct FixedShape {
    shape: f64,
    /// The rows from the first to the last that it concerns: one occupation of many for one station.
    concerned: Range<usize>,
    columns: Vec<Vec<f64>>,
    gram: Gram,
}

impl FixedScan {
    /// `columns(shape)` are the whitened columns. `None` if the data do not see any of them.
    pub(crate) fn new(
        hypothesis: Hypothesis,
        projection: &Projection,
        shapes: &[f64],
        columns: impl Fn(f64) -> Vec<Vec<f64>>,
    ) -> Option<Self> {
        let mut seen = Vec::new();
        for &shape in shapes {
            let columns = columns(shape);
            let gram = gram(projection, &columns);
            if gram.rank() > 0 {
                let concerned = concerned(&columns);
                let cut = |column: &Vec<f64>| column[concerned.clone()].to_vec();
                seen.push(FixedShape {
                    shape,
                    columns: columns.iter().map(cut).collect(),
                    concerned,
                    gram,
                });
            }
        }
        (!seen.is_empty()).then_some(Self {
            hypothesis,
            shapes: seen,
            rows: projection.rows(),
        })
    }
}

/// From the first to the last row with anything but zeros.
fn concerned(columns: &[Vec<f64>]) -> Range<usize> {
    let first = |column: &Vec<f64>| column.iter().position(|&x| x != 0.0);
    let last = |column: &Vec<f64>| column.iter().rposition(|&x| x != 0.0);
    let first = columns.iter().filter_map(first).min().unwrap_or(0);
    first
        ..columns
            .iter()
            .filter_map(last)
            .max()
            .map_or(first, |last| last + 1)
}

/// `Xᵀ M X` of whitened columns in its eigenvectors.
pub(crate) fn gram(projection: &Projection, columns: &[Vec<f64>]) -> Gram {
    let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
    Gram::new(&gram_matrix(projection, columns), &before)
}

/// `Xᵀ M X` of whitened columns, row after row, from what the base model takes of each.
pub(crate) fn gram_matrix(projection: &Projection, columns: &[Vec<f64>]) -> Vec<f64> {
    let n = columns.len();
    let taken: Vec<_> = columns.iter().map(|c| projection.taken_of(c)).collect();
    let mut matrix = vec![0.0; n * n];
    for i in 0..n {
        let own = concerned(&columns[i..=i]);
        for j in 0..=i {
            let all = dot(&columns[i][own.clone()], &columns[j][own.clone()]);
            let value = all - taken[i].product(&taken[j]);
            (matrix[i * n + j], matrix[j * n + i]) = (value, value);
        }
    }
    matrix
}

impl Scan for FixedScan {
    fn hypothesis(&self) -> &Hypothesis {
        &self.hypothesis
    }

    fn for_each(&self, residuals: &[f64], f: &mut dyn FnMut(f64, &Gram, &[f64])) {
        let mut s = Vec::new();
        for shape in &self.shapes {
            s.clear();
            let residuals = &residuals[shape.concerned.clone()];
            s.extend(shape.columns.iter().map(|column| dot(column, residuals)));
            f(shape.shape, &shape.gram, &s);
        }
    }

    fn columns(&self, shape: f64) -> Vec<Vec<f64>> {
        let nearest = self
            .shapes
            .iter()
            .min_by(|a, b| (a.shape - shape).abs().total_cmp(&(b.shape - shape).abs()));
        let whole = |shape: &FixedShape| -> Vec<Vec<f64>> {
            let columns = shape.columns.iter().map(|own| {
                let mut column = vec![0.0; self.rows];
                column[shape.concerned.clone()].copy_from_slice(own);
                column
            });
            columns.collect()
        };
        nearest.map(whole).unwrap_or_default()
    }
}

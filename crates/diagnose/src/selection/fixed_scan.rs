//! A hypothesis with few shapes, each with columns of its own.

use std::ops::Range;

use rayon::prelude::*;
use trueaxis_leastsquares::dot;

use crate::selection::dots::{SideBySide, dots};
use crate::selection::projection::Taken;
use crate::selection::scan::{OfOne, OfSeveral, Tried};
use crate::selection::{Gram, Hypothesis, Projection, Scan};

/// Columns for every shape.
pub(crate) struct FixedScan {
    hypothesis: Hypothesis,
    shapes: Vec<FixedShape>,
    rows: usize,
}

struct FixedShape {
    tried: Tried,
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
        let tried = shapes.iter().map(|&shape| Tried { shape, gap_s: None });
        Self::of(hypothesis, projection, tried, columns)
    }

    /// The same of instants in the middles of gaps.
    pub(crate) fn of_instants(
        hypothesis: Hypothesis,
        projection: &Projection,
        gaps_s: &[[f64; 2]],
        columns: impl Fn(f64) -> Vec<Vec<f64>>,
    ) -> Option<Self> {
        let tried = gaps_s.iter().map(|gap| Tried {
            shape: middle(gap),
            gap_s: Some(gap[1] - gap[0]),
        });
        Self::of(hypothesis, projection, tried, columns)
    }

    fn of(
        hypothesis: Hypothesis,
        projection: &Projection,
        tried: impl Iterator<Item = Tried> + Clone,
        columns: impl Fn(f64) -> Vec<Vec<f64>>,
    ) -> Option<Self> {
        let mut seen = Vec::new();
        let all: Vec<Vec<Vec<f64>>> = tried.clone().map(|one| columns(one.shape)).collect();
        let taken = projection.taken_of_all(all.iter().flatten().map(Vec::as_slice));
        let mut first = 0;
        for (columns, tried) in all.into_iter().zip(tried) {
            seen.extend(FixedShape::new(tried, &columns, (&taken, first)));
            first += columns.len();
        }
        (!seen.is_empty()).then_some(Self {
            hypothesis,
            shapes: seen,
            rows: projection.rows(),
        })
    }

    /// With one more shape, if the data see it.
    pub(crate) fn add(&mut self, projection: &Projection, shape: f64, columns: &[Vec<f64>]) {
        let taken = projection.taken_of_all(columns.iter().map(Vec::as_slice));
        let tried = Tried { shape, gap_s: None };
        self.shapes
            .extend(FixedShape::new(tried, columns, (&taken, 0)));
    }
}

/// The instant that stands for a gap.
pub(crate) fn middle([start, end]: &[f64; 2]) -> f64 {
    0.5 * (start + end)
}

impl FixedShape {
    /// `taken` is what the base model takes of columns, of which those of the shape begin with a number.
    fn new(tried: Tried, columns: &[Vec<f64>], taken: (&Taken, usize)) -> Option<Self> {
        let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
        let gram = Gram::new(&gram_matrix_of(columns, taken), &before);
        let concerned = concerned(columns);
        let cut = |column: &Vec<f64>| column[concerned.clone()].to_vec();
        (gram.rank() > 0).then(|| Self {
            tried,
            columns: columns.iter().map(cut).collect(),
            concerned: concerned.clone(),
            gram,
        })
    }
}

/// From the first to the last row with anything but zeros.
pub(crate) fn concerned(columns: &[impl AsRef<[f64]>]) -> Range<usize> {
    let columns = columns.iter().map(AsRef::as_ref);
    let first = |column: &[f64]| column.iter().position(|&x| x != 0.0);
    let last = |column: &[f64]| column.iter().rposition(|&x| x != 0.0);
    let start = columns.clone().filter_map(first).min().unwrap_or(0);
    start
        ..columns
            .filter_map(last)
            .max()
            .map_or(start, |last| last + 1)
}

/// `Xᵀ M X` of whitened columns in its eigenvectors.
pub(crate) fn gram(projection: &Projection, columns: &[Vec<f64>]) -> Gram {
    let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
    Gram::new(&gram_matrix(projection, columns), &before)
}

/// `Xᵀ M X` of whitened columns, row after row.
pub(crate) fn gram_matrix(projection: &Projection, columns: &[Vec<f64>]) -> Vec<f64> {
    let taken = projection.taken_of_all(columns.iter().map(Vec::as_slice));
    gram_matrix_of(columns, (&taken, 0))
}

/// The same from what the base model takes of columns, of which these begin with a number.
pub(crate) fn gram_matrix_of(columns: &[Vec<f64>], (taken, own): (&Taken, usize)) -> Vec<f64> {
    let n = columns.len();
    let mut matrix = vec![0.0; n * n];
    let rows: Vec<Range<usize>> = columns.iter().map(|c| concerned(&[c])).collect();
    let each = matrix.par_chunks_mut(n.max(1)).enumerate();
    each.with_min_len(ROWS_TOGETHER).for_each(|(i, row)| {
        let mut first = 0;
        // Columns of the same rows stand next to each other.
        for alike in rows[..=i].chunk_by(|a, b| a == b).map(<[_]>::len) {
            let others = first..first + alike;
            first += alike;
            let start = rows[i].start.max(rows[others.start].start);
            let both = start..rows[i].end.min(rows[others.start].end).max(start);
            let cut: Vec<&[f64]> = columns[others.clone()]
                .iter()
                .map(|c| &c[both.clone()])
                .collect();
            for (j, all) in others.zip(dots(&columns[i][both], &cut)) {
                row[j] = all - taken.product(own + i, own + j);
            }
        }
    });
    for i in 0..n {
        for j in 0..i {
            matrix[j * n + i] = matrix[i * n + j];
        }
    }
    matrix
}

/// Rows of a Gram matrix that are worth another thread.
const ROWS_TOGETHER: usize = 8;

impl Scan for FixedScan {
    fn hypothesis(&self) -> &Hypothesis {
        &self.hypothesis
    }

    fn for_each(&self, residuals: &[f64], f: &mut OfOne<'_>) {
        let mut s = Vec::new();
        for shape in &self.shapes {
            s.clear();
            let residuals = &residuals[shape.concerned.clone()];
            s.extend(shape.columns.iter().map(|column| dot(column, residuals)));
            f(shape.tried, &shape.gram, &s);
        }
    }

    fn for_each_of(&self, residuals: &SideBySide, f: &mut OfSeveral<'_>) {
        let mut s = Vec::new();
        for shape in &self.shapes {
            let start = shape.concerned.start;
            s.clear();
            s.extend(shape.columns.iter().map(|c| residuals.dots(start, c)));
            f(&shape.gram, &s);
        }
    }

    fn columns(&self, shape: f64) -> Vec<Vec<f64>> {
        let distance = |own: &FixedShape| (own.tried.shape - shape).abs();
        let shapes = self.shapes.iter();
        let nearest = shapes.min_by(|a, b| distance(a).total_cmp(&distance(b)));
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

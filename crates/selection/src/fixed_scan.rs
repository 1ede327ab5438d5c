//! A hypothesis with few shapes, each with its own columns.

use std::ops::Range;

use trueaxis_leastsquares::lane_products::{LaneMatrix, SharedMatrix, add_product};
use trueaxis_leastsquares::{Lanes, dot};

use crate::gram_matrix::{concerned, gram_matrix_of};
use crate::projection::Taken;
use crate::scan::{OfOne, OfSeveral, Tried};
use crate::{Gram, Hypothesis, Projection, Scan};

/// Columns for every shape.
pub struct FixedScan {
    hypothesis: Hypothesis,
    shapes: Vec<FixedShape>,
    /// Columns of one shape after the other, each cut to the rows that its shape concerns.
    columns: Vec<f64>,
    rows: usize,
}

struct FixedShape {
    tried: Tried,
    /// From the first row that the shape concerns to the last: one occupation of many for one station.
    concerned: Range<usize>,
    /// Its range in the columns of all shapes.
    columns: Range<usize>,
    gram: Gram,
}

impl FixedScan {
    /// `columns(shape)` are the whitened columns of a shape. `None` if the data see none of them.
    pub fn new(
        hypothesis: Hypothesis,
        projection: &Projection,
        shapes: &[f64],
        columns: impl Fn(f64) -> Vec<Vec<f64>>,
    ) -> Option<Self> {
        let tried = shapes.iter().copied().map(Tried::new);
        Self::of(hypothesis, projection, tried, columns)
    }

    /// The same for instants, in the middles of these gaps.
    pub fn of_instants(
        hypothesis: Hypothesis,
        projection: &Projection,
        gaps_s: &[[f64; 2]],
        columns: impl Fn(f64) -> Vec<Vec<f64>>,
    ) -> Option<Self> {
        let tried = gaps_s.iter().map(|gap| Tried {
            gap_s: Some(gap[1] - gap[0]),
            ..Tried::new(middle(gap))
        });
        Self::of(hypothesis, projection, tried, columns)
    }

    fn of(
        hypothesis: Hypothesis,
        projection: &Projection,
        tried: impl Iterator<Item = Tried> + Clone,
        columns: impl Fn(f64) -> Vec<Vec<f64>>,
    ) -> Option<Self> {
        let mut scan = Self {
            hypothesis,
            shapes: Vec::new(),
            columns: Vec::new(),
            rows: projection.rows(),
        };
        let all: Vec<Vec<Vec<f64>>> = tried.clone().map(|one| columns(one.shape)).collect();
        let taken = projection.taken_of_all(all.iter().flatten().map(Vec::as_slice));
        let mut first = 0;
        for (columns, tried) in all.into_iter().zip(tried) {
            scan.push(tried, &columns, (&taken, first));
            first += columns.len();
        }
        (!scan.shapes.is_empty()).then_some(scan)
    }

    /// Adds one more shape, if the data see it.
    pub fn add(&mut self, projection: &Projection, shape: f64, columns: &[Vec<f64>]) {
        let taken = projection.taken_of_all(columns.iter().map(Vec::as_slice));
        let tried = Tried::new(shape);
        self.push(tried, columns, (&taken, 0));
    }

    /// Adds a shape; `taken` is what the base model takes of columns, with the index of the first of this shape.
    fn push(&mut self, tried: Tried, columns: &[Vec<f64>], taken: (&Taken, usize)) {
        let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
        let gram = Gram::new(&gram_matrix_of(columns, taken), &before);
        if gram.rank() == 0 {
            return;
        }
        let (start, concerned) = (self.columns.len(), concerned(columns));
        for column in columns {
            self.columns.extend_from_slice(&column[concerned.clone()]);
        }
        self.shapes.push(FixedShape {
            tried,
            concerned,
            columns: start..self.columns.len(),
            gram,
        });
    }

    /// The columns of a shape, cut to the rows that it concerns.
    fn cut(&self, shape: &FixedShape) -> impl Iterator<Item = &[f64]> {
        self.columns[shape.columns.clone()].chunks_exact(shape.concerned.len())
    }
}

/// The instant that represents a gap.
pub fn middle([start, end]: &[f64; 2]) -> f64 {
    0.5 * (start + end)
}

impl Scan for FixedScan {
    fn hypothesis(&self) -> &Hypothesis {
        &self.hypothesis
    }

    fn for_each(&self, residuals: &[f64], f: &mut OfOne<'_>) {
        let mut s = Vec::new();
        for shape in &self.shapes {
            s.clear();
            let residuals = &residuals[shape.concerned.clone()];
            s.extend(self.cut(shape).map(|column| dot(column, residuals)));
            f(shape.tried, &shape.gram, &s);
        }
    }

    fn tests(&self) -> usize {
        self.shapes.len()
    }

    fn for_each_of(&self, residuals: LaneMatrix<'_>, f: &mut OfSeveral<'_>) {
        let concern_the_same = |a: &FixedShape, b: &FixedShape| a.concerned == b.concerned;
        for alike in self.shapes.chunk_by(concern_the_same) {
            let (Some(first), Some(last)) = (alike.first(), alike.last()) else {
                continue;
            };
            let residuals = residuals.part(first.concerned.clone());
            let columns = &self.columns[first.columns.start..last.columns.end];
            let (rows, batches) = (residuals.rows(), residuals.columns());
            let count = columns.len() / rows;
            let mut s = vec![Lanes::ZERO; count * batches];
            let columns = SharedMatrix::by_rows(columns, [count, rows]);
            add_product(&mut s, columns, residuals);
            let mut rest = &s[..];
            for shape in alike {
                let parameters = shape.columns.len() / rows;
                let (own, others) = rest.split_at(parameters * batches);
                f(&shape.gram, LaneMatrix::by_rows(own, [parameters, batches]));
                rest = others;
            }
        }
    }

    fn columns(&self, shape: f64) -> Vec<Vec<f64>> {
        let distance = |own: &FixedShape| (own.tried.shape - shape).abs();
        let shapes = self.shapes.iter();
        let nearest = shapes.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let whole = |shape: &FixedShape| -> Vec<Vec<f64>> {
            let columns = self.cut(shape).map(|own| {
                let mut column = vec![0.0; self.rows];
                column[shape.concerned.clone()].copy_from_slice(own);
                column
            });
            columns.collect()
        };
        nearest.map(whole).unwrap_or_default()
    }
}

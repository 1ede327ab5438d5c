//! The whitened columns of a hypothesis for each of its shapes, which the scans of several models share.

use std::ops::Range;

use crate::gram_matrix::concerned;
use crate::scan::Tried;

/// Columns of one shape after the other, each cut to the rows that its shape concerns.
#[derive(Debug)]
pub struct ShapeColumns {
    rows: usize,
    shapes: Vec<OneShape>,
    columns: Vec<f64>,
}

#[derive(Debug)]
struct OneShape {
    tried: Tried,
    /// From the first row that the shape concerns to the last: one occupation of many for one station.
    concerned: Range<usize>,
    /// Where its columns begin, and how many there are.
    first: usize,
    parameters: usize,
}

impl ShapeColumns {
    /// Of a list of shapes.
    pub fn of_each(shapes: &[f64], columns: impl Fn(f64) -> Vec<Vec<f64>>) -> Self {
        Self::new(shapes.iter().map(|&shape| (shape, columns(shape))))
    }

    /// Of shapes with their columns.
    pub fn new(shapes: impl IntoIterator<Item = (f64, Vec<Vec<f64>>)>) -> Self {
        let shapes = shapes.into_iter();
        Self::tried_with(shapes.map(|(shape, columns)| (Tried::new(shape), columns)))
    }

    /// Of shapes with their columns, instants with their gaps.
    pub(crate) fn tried_with(shapes: impl Iterator<Item = (Tried, Vec<Vec<f64>>)>) -> Self {
        let mut all = Self {
            rows: 0,
            shapes: Vec::new(),
            columns: Vec::new(),
        };
        for (tried, columns) in shapes {
            let concerned = concerned(&columns);
            all.rows = columns.first().map_or(all.rows, Vec::len);
            all.shapes.push(OneShape {
                tried,
                first: all.columns.len(),
                parameters: columns.len(),
                concerned: concerned.clone(),
            });
            for column in &columns {
                all.columns.extend_from_slice(&column[concerned.clone()]);
            }
        }
        all
    }

    /// The shapes, in the order of the list.
    pub fn shapes(&self) -> impl DoubleEndedIterator<Item = f64> + ExactSizeIterator {
        self.shapes.iter().map(|shape| shape.tried.shape)
    }

    /// All rows of the columns of shape `k`.
    pub fn whole(&self, k: usize) -> Vec<Vec<f64>> {
        let shape = &self.shapes[k];
        let columns = self.cut(k..k + 1).chunks(shape.concerned.len().max(1));
        let mut whole = vec![vec![0.0; self.rows]; shape.parameters];
        for (whole, own) in whole.iter_mut().zip(columns) {
            whole[shape.concerned.clone()].copy_from_slice(own);
        }
        whole
    }

    pub(crate) fn tried(&self, k: usize) -> Tried {
        self.shapes[k].tried
    }

    pub(crate) fn concerned(&self, k: usize) -> Range<usize> {
        self.shapes[k].concerned.clone()
    }

    /// The columns of some shapes in a row, each cut to the rows that its shape concerns.
    pub(crate) fn cut(&self, shapes: Range<usize>) -> &[f64] {
        let first = |k: usize| self.shapes.get(k).map(|shape| shape.first);
        let start = first(shapes.start).unwrap_or(self.columns.len());
        &self.columns[start..first(shapes.end).unwrap_or(self.columns.len())]
    }
}

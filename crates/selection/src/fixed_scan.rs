//! A hypothesis with few shapes, each with its own columns.

use std::sync::Arc;

use trueaxis_leastsquares::lane_products::{LaneMatrix, SharedMatrix, add_product};
use trueaxis_leastsquares::{Lanes, dot};

use crate::gram_matrix::gram_matrix_of;
use crate::scan::{OfOne, OfSeveral, Tried};
use crate::{Gram, Hypothesis, Projection, Scan, ShapeColumns};

/// A list of shapes, and those added to it.
pub struct FixedScan {
    hypothesis: Hypothesis,
    parts: Vec<Part>,
}

/// Shapes with their Gram matrices in this model; of rank zero where the data see none of its columns.
struct Part {
    columns: Arc<ShapeColumns>,
    grams: Vec<Gram>,
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
        tried: impl Iterator<Item = Tried>,
        columns: impl Fn(f64) -> Vec<Vec<f64>>,
    ) -> Option<Self> {
        let (tried, all): (Vec<Tried>, Vec<_>) = tried.map(|one| (one, columns(one.shape))).unzip();
        let grams = grams(projection, &all);
        let columns = ShapeColumns::tried_with(tried.into_iter().zip(all));
        Self::seen(hypothesis, Arc::new(columns), grams)
    }

    /// Of columns that other models share.
    pub fn of_columns(
        hypothesis: Hypothesis,
        projection: &Projection,
        columns: &Arc<ShapeColumns>,
    ) -> Option<Self> {
        let all = (0..columns.shapes().len()).map(|k| columns.whole(k));
        let all: Vec<_> = all.collect();
        Self::seen(hypothesis, Arc::clone(columns), grams(projection, &all))
    }

    fn seen(hypothesis: Hypothesis, columns: Arc<ShapeColumns>, grams: Vec<Gram>) -> Option<Self> {
        let is_seen = grams.iter().any(|gram| gram.rank() > 0);
        is_seen.then(|| Self {
            hypothesis,
            parts: vec![Part { columns, grams }],
        })
    }

    /// Adds one more shape.
    pub fn add(&mut self, projection: &Projection, shape: f64, columns: Vec<Vec<f64>>) {
        let grams = grams(projection, std::slice::from_ref(&columns));
        let columns = ShapeColumns::new([(shape, columns)]);
        self.parts.push(Part {
            columns: Arc::new(columns),
            grams,
        });
    }
}

/// The Gram matrix of the columns of each shape.
fn grams(projection: &Projection, all: &[Vec<Vec<f64>>]) -> Vec<Gram> {
    let taken = projection.taken_of_all(all.iter().flatten().map(Vec::as_slice));
    let mut first = 0;
    let of_shape = |columns: &Vec<Vec<f64>>| {
        let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
        let gram = Gram::new(&gram_matrix_of(columns, (&taken, first)), &before);
        first += columns.len();
        gram
    };
    all.iter().map(of_shape).collect()
}

impl Part {
    /// The shapes that the data see, by number.
    fn shapes(&self) -> impl Iterator<Item = (usize, &Gram)> {
        let grams = self.grams.iter().enumerate();
        grams.filter(|(_, gram)| gram.rank() > 0)
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
        for part in &self.parts {
            for (k, gram) in part.shapes() {
                s.clear();
                let residuals = &residuals[part.columns.concerned(k)];
                let columns = part.columns.cut(k..k + 1).chunks_exact(residuals.len());
                s.extend(columns.map(|column| dot(column, residuals)));
                f(part.columns.tried(k), gram, &s);
            }
        }
    }

    fn tests(&self) -> usize {
        self.parts.iter().map(|part| part.shapes().count()).sum()
    }

    fn for_each_of(&self, residuals: LaneMatrix<'_>, f: &mut OfSeveral<'_>) {
        for part in &self.parts {
            let shapes: Vec<(usize, &Gram)> = part.shapes().collect();
            let are_alike = |(a, _): &(usize, &Gram), (b, _): &(usize, &Gram)| {
                a + 1 == *b && part.columns.concerned(*a) == part.columns.concerned(*b)
            };
            for alike in shapes.chunk_by(are_alike) {
                let (Some((first, _)), Some((last, _))) = (alike.first(), alike.last()) else {
                    continue;
                };
                let residuals = residuals.part(part.columns.concerned(*first));
                let columns = part.columns.cut(*first..last + 1);
                let (rows, batches) = (residuals.rows(), residuals.columns());
                let mut s = vec![Lanes::ZERO; columns.len() / rows * batches];
                let columns = SharedMatrix::by_rows(columns, [columns.len() / rows, rows]);
                add_product(&mut s, columns, residuals);
                let mut rest = &s[..];
                for (k, gram) in alike {
                    let parameters = part.columns.cut(*k..k + 1).len() / rows;
                    let (own, others) = rest.split_at(parameters * batches);
                    f(gram, LaneMatrix::by_rows(own, [parameters, batches]));
                    rest = others;
                }
            }
        }
    }

    fn columns(&self, shape: f64) -> Vec<Vec<f64>> {
        let all = self.parts.iter();
        let seen = all.flat_map(|part| part.shapes().map(move |(k, _)| (part, k)));
        let distance = |(part, k): &(&Part, usize)| (part.columns.tried(*k).shape - shape).abs();
        let nearest = seen.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or_else(Vec::new, |(part, k)| part.columns.whole(k))
    }
}

//! How far an effect stands out from the rest of a curve, averaged over the sizes of that rest.
//!
//! For one size (s, w) of the rest the effect lowers the sum of squares by `T = uᵀ G⁺ u`, which under the rest alone
//! is χ² with as many degrees of freedom as the data see directions. Its p-value is the mean of these tails over all
//! sizes, with weights
//!
//! ```text
//! π(s, w) ∝ prior · L(s, w) · exp(T/2) / √det G
//! ```
//!
//! the restricted likelihood with the effect in the model. If the rest were white and unknown, this would
//! be Student's test.

use nalgebra::DMatrix;
use rayon::prelude::*;
use trueaxis_selection::{FixedScan, Gram, Score, ln_chi_squared};

use crate::components::background::Background;
use crate::components::candidates::Candidate;
use crate::components::curve_set::CurveSet;

/// A candidate judged for every size of the rest.
pub(crate) struct Judgement {
    /// For each shape, all sizes of the rest for which the data see the effect.
    tails: Vec<Vec<Tail>>,
}

/// One shape and one size of the rest.
struct Tail {
    ln_weight: f64,
    statistic: f64,
    rank: usize,
    ln_determinant: f64,
    two_ln_b: f64,
}

/// A tail with the coordinates from which its 2 ln B follows.
type WithCoordinates = (Tail, Vec<(f64, f64)>);

/// Logarithm of the weight, relative to the largest, below which a size of the rest is left out of 2 ln B: e⁻²⁰
/// of the sum.
const NEGLIGIBLE: f64 = -20.0;

impl Judgement {
    /// Whitens the candidate's columns for each size. Numbers as long as the curve are dropped at once: for many
    /// shapes and sizes they would not fit into memory.
    pub(crate) fn new(set: &CurveSet, backgrounds: &[Background], candidate: &Candidate) -> Self {
        let raw = columns(set, candidate);
        let alike = backgrounds.par_chunk_by(Background::is_turned_as);
        let judged = alike.flat_map_iter(|alike| of_sizes(alike, candidate, &raw));
        let mut tails: Vec<Vec<WithCoordinates>> =
            candidate.shapes.iter().map(|_| Vec::new()).collect();
        for (shape, tail) in judged.collect::<Vec<_>>() {
            tails[shape].push(tail);
        }
        let weighed = |tails: Vec<WithCoordinates>| {
            let weight = |tail: &Tail| tail.ln_weight + 0.5 * tail.statistic;
            let top = tails.iter().map(|(tail, _)| weight(tail));
            let top = top.fold(f64::NEG_INFINITY, f64::max);
            let with_two_ln_b = tails.into_iter().map(|(tail, coordinates)| Tail {
                two_ln_b: match weight(&tail) - top > NEGLIGIBLE {
                    true => Gram::two_ln_b_of(&coordinates),
                    false => 0.0,
                },
                ..tail
            });
            with_two_ln_b.collect()
        };
        Self {
            tails: tails.into_iter().map(weighed).collect(),
        }
    }

    /// The best shape and its judgement; `number` is that of the candidate. `None` if the data see no shape.
    pub(crate) fn score(
        &self,
        backgrounds: &[Background],
        candidate: &Candidate,
        number: usize,
    ) -> Option<Score> {
        let base = ln_sum(backgrounds.iter().map(|background| background.ln_weight));
        let has_shape = candidate.hypothesis.has_shape();
        let rows = backgrounds.first()?.projection.rows() as f64;
        let mut best: Option<Score> = None;
        let mut all_two_ln_b = Vec::new();
        for (&shape, tails) in candidate.shapes.iter().zip(&self.tails) {
            let Some(rank) = tails.first().map(|tail| tail.rank) else {
                continue;
            };
            let total = ln_sum(tails.iter().map(Tail::ln_posterior));
            let ln_p = ln_sum(tails.iter().map(|tail| {
                tail.ln_posterior() - total + ln_chi_squared(tail.statistic, tail.rank)
            }));
            let gained = |of: fn(&Tail) -> f64| {
                let all = tails.iter().map(|tail| tail.ln_weight + 0.5 * of(tail));
                2.0 * (ln_sum(all) - base)
            };
            let statistic = gained(|tail| tail.statistic);
            all_two_ln_b.push(gained(|tail| tail.two_ln_b));
            let parameters = rank + usize::from(has_shape);
            let score = Score {
                scan: number,
                shape,
                u_shape: 0.0,
                statistic,
                rank,
                ln_p: ln_p.min(0.0),
                bic: parameters as f64 * rows.ln() - statistic,
                two_ln_b: 0.0,
            };
            if best.is_none_or(|best| score.ln_p < best.ln_p) {
                best = Some(score);
            }
        }
        let mut best = best?;
        // Prior: all subjects and shapes of an effect are equally likely.
        let mean = ln_sum(all_two_ln_b.iter().map(|e| 0.5 * e)) - (all_two_ln_b.len() as f64).ln();
        best.two_ln_b = 2.0 * (mean - (candidate.hypothesis.subjects as f64).ln());
        Some(best)
    }
}

/// The scan for one size of the rest.
pub(crate) fn scan(
    set: &CurveSet,
    background: &Background,
    candidate: &Candidate,
) -> Option<FixedScan> {
    let whitened = |shape: f64| {
        let columns = set.columns(candidate, shape);
        let whitened = columns.iter().map(|c| background.whitening.whiten(c));
        whitened.collect()
    };
    FixedScan::new(
        candidate.hypothesis,
        &background.projection,
        &candidate.shapes,
        whitened,
    )
}

/// All shapes that are seen, by their number, under the sizes of the rest that turn columns alike. As `G = XᵀX - (TᵀX)ᵀ(TᵀX)` with
/// products of matrices: thousands of columns are whitened for hundreds of sizes.
fn of_sizes(
    alike: &[Background],
    candidate: &Candidate,
    raw: &DMatrix<f64>,
) -> Vec<(usize, WithCoordinates)> {
    let n = candidate.parameters;
    let turned = alike[0].whitening.turned_all(raw).transpose();
    let pair = |k: usize| (k / (n * n) * n + k / n % n, k / (n * n) * n + k % n);
    let products = DMatrix::from_fn(turned.nrows() * n, turned.ncols(), |k, row| {
        let (i, j) = pair(k);
        turned[(i, row)] * turned[(j, row)]
    });
    let variances = DMatrix::from_fn(turned.ncols(), alike.len(), |row, size| {
        alike[size].whitening.scales[row].powi(2)
    });
    let squares = products * variances;
    // Against the base model, and in the last column of each size against what it leaves.
    let widths = alike.iter().map(|size| size.projection.shared_width + 1);
    let width = widths.max().unwrap_or(1);
    let against = DMatrix::from_fn(turned.ncols(), alike.len() * width, |row, k| {
        let (projection, whitening) = (&alike[k / width].projection, &alike[k / width].whitening);
        let of_size = match k % width {
            k if k < projection.shared_width => projection.shared_row(row)[k],
            k if k + 1 == width => projection.residuals[row],
            _ => 0.0,
        };
        whitening.scales[row] * of_size
    });
    let along = &turned * against;
    let mut all = Vec::new();
    for (size, background) in alike.iter().enumerate() {
        let along = along.columns(size * width, width);
        for shape in 0..candidate.shapes.len() {
            let own = |k: usize| squares[(shape * n * n + k, size)];
            let gram: Vec<f64> = (0..n * n)
                .map(|k| {
                    let (i, j) = pair(shape * n * n + k);
                    let of_base = (0..width - 1).map(|b| along[(i, b)] * along[(j, b)]);
                    own(k) - of_base.sum::<f64>()
                })
                .collect();
            let before: Vec<f64> = (0..n).map(|k| own(k * n + k)).collect();
            let gram = Gram::new(&gram, &before);
            if gram.rank() == 0 {
                continue;
            }
            let s: Vec<f64> = (0..n).map(|k| along[(shape * n + k, width - 1)]).collect();
            let coordinates: Vec<(f64, f64)> = gram.standardised(&s).collect();
            let tail = Tail {
                ln_weight: background.ln_weight,
                statistic: coordinates.iter().map(|(_, z)| z * z).sum(),
                rank: gram.rank(),
                ln_determinant: coordinates.iter().map(|(value, _)| value.ln()).sum(),
                two_ln_b: 0.0,
            };
            all.push((shape, (tail, coordinates)));
        }
    }
    all
}

impl Tail {
    /// Logarithm of the posterior of the size of the rest, with the effect in the model; not normalised.
    fn ln_posterior(&self) -> f64 {
        self.ln_weight + 0.5 * (self.statistic - self.ln_determinant)
    }
}

/// The columns of all shapes side by side, one for each parameter of each shape.
fn columns(set: &CurveSet, candidate: &Candidate) -> DMatrix<f64> {
    let shapes = candidate.shapes.iter();
    let columns: Vec<Vec<f64>> = shapes.flat_map(|&s| set.columns(candidate, s)).collect();
    DMatrix::from_vec(set.values.len(), columns.len(), columns.concat())
}

/// `ln Σ exp x`.
pub(crate) fn ln_sum(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let top = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if top == f64::NEG_INFINITY {
        return top;
    }
    top + terms.map(|x| (x - top).exp()).sum::<f64>().ln()
}

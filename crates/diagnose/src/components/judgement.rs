//! How far an effect stands out of the rest of a curve, whatever the size of that rest.
//!
//! For one size (s, w) of the rest the effect lowers the sum of squares by `T = uᵀ G⁺ u`, which for
//! nothing but the rest is χ² with as many degrees of freedom as the data see directions. Its p-value is
//! the mean of these tails over all sizes, with weights
//!
//! ```text
//! π(s, w) ∝ prior · L(s, w) · exp(T/2) / √det G
//! ```
//!
//! the restricted likelihood with the effect in the model. If the rest were white and unknown, this would
//! be Student's test.

use crate::components::background::Background;
use crate::components::candidates::Candidate;
use crate::components::curve_set::CurveSet;
use crate::components::ln_chi_squared::ln_chi_squared;
use crate::selection::{FixedScan, Gram, Scan, Score};

/// A candidate in front of every size of the rest.
pub(crate) struct Judgement {
    /// For each shape, its columns.
    raw: Columns,
    /// For each size, its scan; none if the data do not see the effect.
    scans: Vec<Option<FixedScan>>,
}

/// One shape and one size of the rest.
struct Tail {
    ln_weight: f64,
    statistic: f64,
    rank: usize,
    ln_determinant: f64,
    evidence: f64,
}

/// Takes the number of a shape, the weight of a size of the rest, the Gram matrix and `Xᵀ e`.
type Visit<'a> = dyn FnMut(usize, f64, &Gram, &[f64]) + 'a;

/// Natural logarithm of the weight, against the largest, below which a size of the rest is left out of
/// the evidence: e⁻²⁰ of the sum.
const NEGLIGIBLE: f64 = -20.0;

impl Judgement {
    /// Whitens the candidate's columns for each size.
    pub(crate) fn new(set: &CurveSet, backgrounds: &[Background], candidate: &Candidate) -> Self {
        let shapes = candidate.shapes.iter();
        let raw = shapes.map(|&shape| (shape, set.columns(candidate, shape)));
        let raw: Columns = raw.collect();
        let mut turned: Option<(i32, Columns)> = None;
        let mut scans = Vec::with_capacity(backgrounds.len());
        for background in backgrounds {
            let of_smooth = turned.take().filter(|turned| turned.0 == background.smooth);
            let (_, columns) = turned
                .insert(of_smooth.unwrap_or_else(|| (background.smooth, turn(background, &raw))));
            scans.push(scan(background, candidate, columns));
        }
        Self { raw, scans }
    }

    /// The scan for one size of the rest.
    pub(crate) fn scan(&self, background: &Background, candidate: &Candidate) -> Option<FixedScan> {
        scan(background, candidate, &turn(background, &self.raw))
    }

    /// The best shape and its judgement; `number` is that of the candidate. None if no shape is seen.
    pub(crate) fn score(
        &self,
        backgrounds: &[Background],
        candidate: &Candidate,
        number: usize,
    ) -> Option<Score> {
        let tails = self.tails(backgrounds, candidate);
        let base = ln_sum(backgrounds.iter().map(|background| background.ln_weight));
        let has_shape = candidate.hypothesis.has_shape();
        let rows = backgrounds.first()?.projection.rows() as f64;
        let mut best: Option<Score> = None;
        let mut evidences = Vec::new();
        for (&shape, tails) in candidate.shapes.iter().zip(&tails) {
            let Some(rank) = tails.first().map(|tail| tail.rank) else {
                continue;
            };
            let total = ln_sum(tails.iter().map(Tail::ln_posterior));
            let ln_p = ln_sum(tails.iter().map(|tail| {
                tail.ln_posterior() - total + ln_chi_squared(tail.statistic, tail.rank)
            }));
            let with = ln_sum(
                tails
                    .iter()
                    .map(|tail| tail.ln_weight + 0.5 * tail.statistic),
            );
            let statistic = 2.0 * (with - base);
            let parameters = rank + usize::from(has_shape);
            let marginal = ln_sum(
                tails
                    .iter()
                    .map(|tail| tail.ln_weight + 0.5 * tail.evidence),
            );
            evidences.push(2.0 * (marginal - base));
            let score = Score {
                scan: number,
                shape,
                u_shape: 0.0,
                statistic,
                rank,
                ln_p: ln_p.min(0.0),
                bic: parameters as f64 * rows.ln() - statistic,
                evidence: 0.0,
            };
            if best.is_none_or(|best| score.ln_p < best.ln_p) {
                best = Some(score);
            }
        }
        let mut best = best?;
        // Prior: the subjects and shapes of an effect share alike.
        let mean = ln_sum(evidences.iter().map(|e| 0.5 * e)) - (evidences.len() as f64).ln();
        best.evidence = 2.0 * (mean - (candidate.hypothesis.subjects as f64).ln());
        Some(best)
    }

    /// For each shape, all sizes of the rest.
    fn tails(&self, backgrounds: &[Background], candidate: &Candidate) -> Vec<Vec<Tail>> {
        let mut tails: Vec<Vec<Tail>> = candidate.shapes.iter().map(|_| Vec::new()).collect();
        let mut top = vec![f64::NEG_INFINITY; candidate.shapes.len()];
        self.for_each(backgrounds, candidate, &mut |k, ln_weight, gram, s| {
            let (mut statistic, mut ln_determinant) = (0.0, 0.0);
            for (value, z) in gram.standardised(s) {
                statistic += z * z;
                ln_determinant += value.ln();
            }
            top[k] = top[k].max(ln_weight + 0.5 * statistic);
            tails[k].push(Tail {
                ln_weight,
                statistic,
                rank: gram.rank(),
                ln_determinant,
                evidence: 0.0,
            });
        });
        let mut places = vec![0; candidate.shapes.len()];
        self.for_each(backgrounds, candidate, &mut |k, _, gram, s| {
            let tail = &mut tails[k][places[k]];
            places[k] += 1;
            if tail.ln_weight + 0.5 * tail.statistic - top[k] > NEGLIGIBLE {
                tail.evidence = gram.evidence(s);
            }
        });
        tails
    }

    fn for_each(&self, backgrounds: &[Background], candidate: &Candidate, f: &mut Visit<'_>) {
        for (background, scan) in backgrounds.iter().zip(&self.scans) {
            let Some(scan) = scan else { continue };
            scan.for_each(&background.projection.residuals, &mut |tried, gram, s| {
                let is_it = |own: &f64| same(*own, tried.shape);
                if let Some(k) = candidate.shapes.iter().position(is_it) {
                    f(k, background.ln_weight, gram, s);
                }
            });
        }
    }
}

impl Tail {
    /// Of the size of the rest, with the effect in the model; not normalised.
    fn ln_posterior(&self) -> f64 {
        self.ln_weight + 0.5 * (self.statistic - self.ln_determinant)
    }
}

/// The columns of each shape.
type Columns = Vec<(f64, Vec<Vec<f64>>)>;

/// Turns the columns of all shapes.
fn turn(background: &Background, raw: &Columns) -> Columns {
    let turned = |columns: &Vec<Vec<f64>>| {
        columns
            .iter()
            .map(|c| background.whitening.turned(c))
            .collect()
    };
    raw.iter()
        .map(|(shape, columns)| (*shape, turned(columns)))
        .collect()
}

/// Whitens the turned columns of all shapes.
fn scan(background: &Background, candidate: &Candidate, turned: &Columns) -> Option<FixedScan> {
    let whitened = |shape: f64| {
        let columns = turned.iter().find(|(own, _)| same(*own, shape));
        let columns = columns.map_or(&[][..], |(_, columns)| columns);
        columns
            .iter()
            .map(|column| background.whitening.scaled(column))
            .collect()
    };
    FixedScan::new(
        candidate.hypothesis,
        &background.projection,
        &candidate.shapes,
        whitened,
    )
}

/// The same shape of the same list.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}

/// `ln Σ exp x`.
pub(crate) fn ln_sum(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let top = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if top == f64::NEG_INFINITY {
        return top;
    }
    top + terms.map(|x| (x - top).exp()).sum::<f64>().ln()
}

//! A hypothesis with an instant, profiled over all instants by running sums.
//!
//! The columns of an effect that begins at `t0` are its columns from the beginning of time, cut to the
//! visits after `t0`. Visit after visit from the last one back, `XᵀX`, `Oᵀ X`, `Tᵀ X` and `Xᵀ e` grow by
//! the rows of one visit, so all instants together cost little more than one:
//!
//! ```text
//! G(t0) = XᵀX - Σ_groups (OᵀX)ᵀ(OᵀX) - (TᵀX)ᵀ Σ (TᵀX)
//! ```
//!
//! An instant within a visit is told from its ends by seconds only; it is not looked for.

use std::ops::Range;

use trueaxis_leastsquares::{dot, in_widest_registers};

use crate::selection::dots::{SIDE_BY_SIDE, SideBySide, add_row};
use crate::selection::scan::{OfOne, OfSeveral, Tried};
use crate::selection::{Gram, Hypothesis, Projection, Scan, add};

/// Visits on either side of an instant: fewer are no jump but repeatability, or gross errors.
const LEAST_VISITS: usize = 3;

/// A visit of a network, or a stop, of several in time order.
#[derive(Debug, Clone)]
pub(crate) struct VisitTimes {
    /// Rows of the visit.
    pub(crate) rows: Range<usize>,
    /// First and last time, s.
    pub(crate) span_s: [f64; 2],
}

impl VisitTimes {
    pub(crate) fn new(rows: Range<usize>, times_s: impl Iterator<Item = f64> + Clone) -> Self {
        let first = times_s.clone().fold(f64::INFINITY, f64::min);
        Self {
            rows,
            span_s: [first, times_s.fold(f64::NEG_INFINITY, f64::max)],
        }
    }
}

/// All instants of one hypothesis.
pub(crate) struct StepScan {
    hypothesis: Hypothesis,
    /// Whitened columns from the beginning of time, row after row.
    by_rows: Vec<f64>,
    parameters: usize,
    instants: Vec<Instant>,
}

struct Instant {
    /// Its gap is from the start of the visit before it to that of the visit after it: it may lie in a visit.
    tried: Tried,
    /// First row after it.
    first_row: usize,
    gram: Gram,
}

impl StepScan {
    /// `columns` are the whitened columns from the beginning of time. `None` if no instant shows.
    pub(crate) fn new(
        hypothesis: Hypothesis,
        projection: &Projection,
        visits: &[VisitTimes],
        columns: &[Vec<f64>],
    ) -> Option<Self> {
        let n = columns.len();
        let rows = projection.rows();
        let mut by_rows = vec![0.0; rows * n];
        for (k, column) in columns.iter().enumerate() {
            for (i, x) in column.iter().enumerate() {
                by_rows[i * n + k] = *x;
            }
        }
        let row = |i: usize| &by_rows[i * n..(i + 1) * n];
        let concerns =
            |visit: &VisitTimes| visit.rows.clone().any(|i| row(i).iter().any(|&x| x != 0.0));
        let concerned: Vec<&VisitTimes> = visits.iter().filter(|v| concerns(v)).collect();
        let mut sums = Sums::new(projection, n);
        let mut instants = Vec::new();
        for (number, visit) in concerned.iter().enumerate().skip(1).rev() {
            in_widest_registers(
                #[inline(always)]
                || {
                    for i in visit.rows.clone() {
                        sums.add(projection, i, row(i));
                    }
                },
            );
            let before = concerned[number - 1];
            let is_of_a_few = number < LEAST_VISITS || concerned.len() - number < LEAST_VISITS;
            // On a clock that does not tell two visits apart there is no instant between them.
            if is_of_a_few || before.span_s[1] >= visit.span_s[0] {
                continue;
            }
            let gram = sums.gram(projection);
            if gram.rank() > 0 {
                instants.push(Instant {
                    tried: Tried {
                        shape: 0.5 * (before.span_s[1] + visit.span_s[0]),
                        gap_s: Some(visit.span_s[0] - before.span_s[0]),
                    },
                    first_row: visit.rows.start,
                    gram,
                });
            }
        }
        (!instants.is_empty()).then_some(Self {
            hypothesis,
            by_rows,
            parameters: n,
            instants,
        })
    }
}

impl Scan for StepScan {
    fn hypothesis(&self) -> &Hypothesis {
        &self.hypothesis
    }

    fn for_each(&self, residuals: &[f64], f: &mut OfOne<'_>) {
        let n = self.parameters;
        let mut s = vec![0.0; n];
        let mut end = residuals.len();
        for instant in &self.instants {
            for (i, e) in (instant.first_row..end).zip(&residuals[instant.first_row..end]) {
                for (s, x) in s.iter_mut().zip(&self.by_rows[i * n..(i + 1) * n]) {
                    *s += x * e;
                }
            }
            end = instant.first_row;
            f(instant.tried, &instant.gram, &s);
        }
    }

    fn for_each_of(&self, residuals: &SideBySide, f: &mut OfSeveral<'_>) {
        let n = self.parameters;
        let rows = residuals.rows();
        let mut s = vec![[0.0; SIDE_BY_SIDE]; n];
        let mut end = rows.len();
        for instant in &self.instants {
            let after = instant.first_row..end;
            in_widest_registers(
                #[inline(always)]
                || {
                    let by_rows = self.by_rows[n * after.start..n * after.end].chunks_exact(n);
                    for (x, e) in by_rows.zip(&rows[after]) {
                        s.iter_mut().zip(x).for_each(|(s, x)| add_row(s, e, *x));
                    }
                },
            );
            end = instant.first_row;
            f(&instant.gram, &s);
        }
    }

    fn columns(&self, shape: f64) -> Vec<Vec<f64>> {
        let n = self.parameters;
        let after = self.instants.iter().filter(|i| i.tried.shape >= shape);
        let first = after.map(|i| i.first_row).min().unwrap_or(usize::MAX);
        let value = |i: usize, k: usize| {
            if i >= first {
                self.by_rows[i * n + k]
            } else {
                0.0
            }
        };
        let rows = self.by_rows.len() / n.max(1);
        (0..n)
            .map(|k| (0..rows).map(|i| value(i, k)).collect())
            .collect()
    }
}

/// The running sums.
struct Sums {
    parameters: usize,
    /// `XᵀX`.
    squares: Vec<f64>,
    /// `OᵀX` of each group.
    own: Vec<f64>,
    /// `Σ_groups (OᵀX)ᵀ(OᵀX)`.
    own_squares: Vec<f64>,
    /// `TᵀX`, parameter after parameter.
    shared: Vec<f64>,
}

impl Sums {
    fn new(projection: &Projection, parameters: usize) -> Self {
        let (own, shared) = (projection.own_width, projection.shared_width);
        Self {
            parameters,
            squares: vec![0.0; parameters * parameters],
            own: vec![0.0; projection.groups * own * parameters],
            own_squares: vec![0.0; parameters * parameters],
            shared: vec![0.0; shared * parameters],
        }
    }

    /// Adds the outer product of each row of a matrix (`n` columns) with itself, times `sign`.
    #[inline(always)]
    fn add_squares(sum: &mut [f64], rows: &[f64], n: usize, sign: f64) {
        for row in rows.chunks_exact(n) {
            for (i, a) in row.iter().enumerate() {
                for (s, b) in sum[i * n..(i + 1) * n].iter_mut().zip(row) {
                    *s += sign * a * b;
                }
            }
        }
    }

    #[inline(always)]
    fn add(&mut self, projection: &Projection, row: usize, x: &[f64]) {
        let n = self.parameters;
        Self::add_squares(&mut self.squares, x, n, 1.0);
        let own_row = projection.own_row(row);
        let size = own_row.len() * n;
        let group = projection.group_of_row[row];
        let own = &mut self.own[group * size..(group + 1) * size];
        Self::add_squares(&mut self.own_squares, own, n, -1.0);
        for (sums, o) in own.chunks_exact_mut(n).zip(own_row) {
            for (s, x) in sums.iter_mut().zip(x) {
                *s += o * x;
            }
        }
        Self::add_squares(&mut self.own_squares, own, n, 1.0);
        let shared_row = projection.shared_row(row);
        let of_parameters = self.shared.chunks_exact_mut(shared_row.len().max(1));
        for (sums, x) in of_parameters.zip(x) {
            add(sums, shared_row, *x);
        }
    }

    fn gram(&self, projection: &Projection) -> Gram {
        let n = self.parameters;
        let mut gram: Vec<f64> = self
            .squares
            .iter()
            .zip(&self.own_squares)
            .map(|(all, own)| all - own)
            .collect();
        let width = projection.sigma_width;
        let of_parameters = || self.shared.chunks_exact(projection.shared_width.max(1));
        for (i, own) in of_parameters().enumerate() {
            let (dense, rest) = own.split_at(width);
            let through = (0..width).map(|k| dot(projection.sigma_row(k), dense));
            let through: Vec<f64> = through.chain(rest.iter().copied()).collect();
            for (g, other) in gram[i * n..(i + 1) * n].iter_mut().zip(of_parameters()) {
                *g -= dot(&through, other);
            }
        }
        let before: Vec<f64> = (0..n).map(|i| self.squares[i * n + i]).collect();
        Gram::new(&gram, &before)
    }
}

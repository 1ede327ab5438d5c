//! A hypothesis with an instant, for all instants by running sums.
//!
//! The columns of an effect that begins at `t0` are those of the effect from the beginning of time, cut to the visits
//! after `t0`. From the last visit back, `Xᵀ e` and the sums that make `G` ([`RunningSums`]) grow by the rows of one
//! visit at a time, so that all instants together cost little more than one.
//!
//! An instant within a visit leaves out its first readings. Whitening mixes the readings of a visit, so such a cut
//! has its own columns, for which the first `c` rows of every visit are zero before whitening: one set for each `c`.

use std::collections::BTreeMap;
use std::ops::Range;

use trueaxis_leastsquares::lane_products::LaneMatrix;
use trueaxis_leastsquares::{Lanes, in_widest_registers, lanes_only};

use crate::running_sums::RunningSums;
use crate::scan::{OfOne, OfSeveral, Tried};
use crate::visit_times::{VisitTimes, span_s};
use crate::{Gram, Hypothesis, Projection, Scan, middle};

/// Least number of visits on either side of an instant: fewer are repeatability or gross errors, not a jump.
const LEAST_VISITS: usize = 3;

/// Most cuts of visits that are tried: some of many readings of one stop are enough.
const MOST_CUTS: usize = 12;

/// Whitened columns of the effect from the beginning of time, with only the rows for which the argument is true.
pub(crate) type ColumnsAfter<'a> = dyn Fn(&dyn Fn(usize) -> bool) -> Vec<Vec<f64>> + 'a;

/// All instants of one hypothesis.
pub struct InstantScan {
    hypothesis: Hypothesis,
    /// For each cut the whitened columns without as many first rows of each visit, row after row; cut 0 is from the
    /// beginning of time.
    by_rows: BTreeMap<usize, Vec<f64>>,
    parameters: usize,
    /// In falling order of time.
    instants: Vec<Instant>,
}

struct Instant {
    /// Its gap is between two readings that show the effect.
    tried: Tried,
    /// The first row after it or, for an instant within a visit, after that visit.
    first_row: usize,
    /// For an instant within a visit, the rows of the visit and the number of them before the instant.
    cut: Option<(Range<usize>, usize)>,
    gram: Gram,
}

impl InstantScan {
    /// `None` if the data see no instant.
    pub fn new(
        hypothesis: Hypothesis,
        projection: &Projection,
        visits: &[VisitTimes],
        columns: &ColumnsAfter<'_>,
    ) -> Option<Self> {
        let by_rows = by_rows(visits, columns);
        let n = by_rows[&0].len() / projection.rows().max(1);
        let row = |cut: usize, i: usize| &by_rows[&cut][i * n..(i + 1) * n];
        let concerned: Vec<Concerned<'_>> = visits
            .iter()
            .filter_map(|visit| Concerned::new(visit, &by_rows, n))
            .collect();
        let mut sums = RunningSums::new(projection, n);
        let mut instants = Vec::new();
        for (number, own) in concerned.iter().enumerate().skip(1).rev() {
            let after = concerned.len() - number;
            let rows = &own.visit.rows;
            let mut push =
                |sums: &RunningSums, [from_s, to_s]: [f64; 2], first_row, cut: Option<_>| {
                    let gram = sums.gram(projection);
                    if gram.rank() > 0 {
                        instants.push(Instant {
                            tried: Tried {
                                shape: middle(&[from_s, to_s]),
                                gap_s: Some(to_s - from_s),
                                is_tested: cut.is_none(),
                            },
                            first_row,
                            cut,
                            gram,
                        });
                    }
                };
            let add = |sums: &mut RunningSums, cut: usize, sign: f64| {
                in_widest_registers(
                    #[inline(always)]
                    || {
                        for i in rows.start + cut..rows.end {
                            sums.add(projection, i, row(cut, i), sign);
                        }
                    },
                );
            };
            if number >= LEAST_VISITS && after > LEAST_VISITS {
                for &(cut, gap_s) in own.cuts.iter().rev() {
                    add(&mut sums, cut, 1.0);
                    push(&sums, gap_s, rows.end, Some((rows.clone(), cut)));
                    add(&mut sums, cut, -1.0);
                }
            }
            add(&mut sums, 0, 1.0);
            let gap_s = [concerned[number - 1].span_s[1], own.span_s[0]];
            let is_of_a_few = number < LEAST_VISITS || after < LEAST_VISITS;
            // If the clock does not separate two visits, there is no instant between them.
            if !is_of_a_few && gap_s[0] < gap_s[1] {
                push(&sums, gap_s, rows.start, None);
            }
        }
        (!instants.is_empty()).then_some(Self {
            hypothesis,
            by_rows,
            parameters: n,
            instants,
        })
    }

    /// Adds `Xᵀ e` of some rows, with this cut.
    fn add_products(&self, rows: Range<usize>, cut: usize, residuals: &[f64], s: &mut [f64]) {
        let n = self.parameters;
        let by_rows = self.by_rows[&cut][n * rows.start..n * rows.end].chunks_exact(n);
        for (x, e) in by_rows.zip(&residuals[rows]) {
            s.iter_mut().zip(x).for_each(|(s, x)| *s += x * e);
        }
    }
}

/// The columns without the first rows of each visit, for each number of first rows that is a cut of any visit.
fn by_rows(visits: &[VisitTimes], columns: &ColumnsAfter<'_>) -> BTreeMap<usize, Vec<f64>> {
    let mut cuts: Vec<usize> = visits.iter().flat_map(VisitTimes::cuts).collect();
    cuts.sort_unstable();
    cuts.dedup();
    let stride = cuts.len().div_ceil(MOST_CUTS).max(1);
    let last = visits.iter().map(|visit| visit.rows.end).max();
    let mut places = vec![0; last.unwrap_or_default()];
    for visit in visits {
        let rows = visit.rows.clone().enumerate();
        rows.for_each(|(place, row)| places[row] = place);
    }
    let of_cut = |cut: usize| {
        let is_after = |row: usize| places.get(row).is_none_or(|place| *place >= cut);
        let columns = columns(&is_after);
        let rows = columns.first().map_or(0, Vec::len);
        let row = |i: usize| columns.iter().map(move |column| column[i]);
        (cut, (0..rows).flat_map(row).collect())
    };
    let cuts = cuts.into_iter().step_by(stride);
    [0].into_iter().chain(cuts).map(of_cut).collect()
}

/// A visit in which the effect shows.
struct Concerned<'a> {
    visit: &'a VisitTimes,
    /// First and last time of readings that show it, s.
    span_s: [f64; 2],
    /// Cuts with readings that show it on either side, and the times of the nearest of these, s.
    cuts: Vec<(usize, [f64; 2])>,
}

impl<'a> Concerned<'a> {
    /// `n` is the number of columns; `None` if the effect does not show.
    fn new(visit: &'a VisitTimes, by_rows: &BTreeMap<usize, Vec<f64>>, n: usize) -> Option<Self> {
        let of_visit = |cut: usize| &by_rows[&cut][visit.rows.start * n..visit.rows.end * n];
        let cuts = visit.cuts().filter(|cut| by_rows.contains_key(cut));
        let starts: Vec<usize> = [0].into_iter().chain(cuts).collect();
        let mut shown: Vec<(usize, [f64; 2])> = Vec::new();
        for (i, &start) in starts.iter().enumerate() {
            let next = starts.get(i + 1);
            let is_shown = match next {
                // The effect does not show in rows that can be left out without a difference.
                Some(&next) => {
                    let mut pairs = of_visit(start).iter().zip(of_visit(next));
                    pairs.any(|(a, b)| a.to_bits() != b.to_bits())
                }
                None => of_visit(start).iter().any(|&x| x != 0.0),
            };
            if is_shown {
                let end = next.map_or(visit.times_s.len(), |next| *next);
                shown.push((start, span_s(&visit.times_s[start..end])));
            }
        }
        let span_s = [shown.first()?.1[0], shown.last()?.1[1]];
        let cuts = shown.windows(2).map(|pair| {
            let gap_s = [pair[0].1[1], pair[1].1[0]];
            (pair[1].0, gap_s)
        });
        Some(Self {
            cuts: cuts.collect(),
            visit,
            span_s,
        })
    }
}

impl InstantScan {
    /// The instants between visits. Those within a visit are a few readings away from a tested one, which shows the
    /// effect nearly as well; testing them all would take longer in proportion to their number.
    fn tested(&self) -> impl Iterator<Item = &Instant> {
        self.instants.iter().filter(|instant| instant.cut.is_none())
    }
}

impl Scan for InstantScan {
    fn hypothesis(&self) -> &Hypothesis {
        &self.hypothesis
    }

    fn for_each(&self, residuals: &[f64], f: &mut OfOne<'_>) {
        let mut s = vec![0.0; self.parameters];
        let mut end = residuals.len();
        for instant in &self.instants {
            self.add_products(instant.first_row..end, 0, residuals, &mut s);
            end = instant.first_row;
            match &instant.cut {
                None => f(instant.tried, &instant.gram, &s),
                Some((rows, cut)) => {
                    let mut with = s.clone();
                    self.add_products(rows.start + cut..rows.end, *cut, residuals, &mut with);
                    f(instant.tried, &instant.gram, &with);
                }
            }
        }
    }

    fn tests(&self) -> usize {
        self.tested().count()
    }

    fn for_each_of(&self, residuals: LaneMatrix<'_>, f: &mut OfSeveral<'_>) {
        let (n, batches) = (self.parameters, residuals.columns());
        let mut s = vec![Lanes::ZERO; n * batches];
        let mut end = residuals.rows();
        for instant in self.tested() {
            let after = instant.first_row..end;
            in_widest_registers(
                #[inline(always)]
                || {
                    let by_rows = &self.by_rows[&0][n * after.start..n * after.end];
                    for (x, row) in by_rows.chunks_exact(n).zip(after) {
                        let residuals = residuals.row(row);
                        for (s, x) in s.chunks_exact_mut(batches).zip(x) {
                            let x = Lanes::splat(*x);
                            for (s, e) in s.iter_mut().zip(residuals) {
                                lanes_only();
                                *s = x.mul_add(*e, *s);
                            }
                        }
                    }
                },
            );
            end = instant.first_row;
            f(&instant.gram, LaneMatrix::by_rows(&s, [n, batches]));
        }
    }

    fn columns(&self, shape: f64) -> Vec<Vec<f64>> {
        let n = self.parameters;
        let rows = self.by_rows[&0].len() / n.max(1);
        let mut columns = vec![vec![0.0; rows]; n];
        let mut instants = self.instants.iter().rev();
        let Some(instant) = instants.find(|i| i.tried.shape >= shape) else {
            return columns;
        };
        let mut take = |rows: Range<usize>, cut: usize| {
            for i in rows {
                for (k, column) in columns.iter_mut().enumerate() {
                    column[i] = self.by_rows[&cut][i * n + k];
                }
            }
        };
        take(instant.first_row..rows, 0);
        if let Some((rows, cut)) = &instant.cut {
            take(rows.start + cut..rows.end, *cut);
        }
        columns
    }
}

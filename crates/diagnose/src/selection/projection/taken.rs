//! What the base model takes of columns, `(I - M) x`.

use trueaxis_leastsquares::{dot, in_widest_registers};

use super::{Projection, add};

/// Columns that are taken of together: rows of `O` and `T` are read once for all of them, some of them at a time, so that
/// they stay near the processor.
const TOGETHER: usize = 8;
const ROWS_TOGETHER: usize = 128;

/// Columns of `T` whose sums stay in registers.
const ABREAST: usize = 16;

impl Projection {
    /// `x <- M x`.
    pub(crate) fn project(&self, x: &mut [f64]) {
        let taken = self.taken_of(x);
        for (i, value) in x.iter_mut().enumerate() {
            *value -= taken.at(self.group_of_row[i], self.own_row(i), self.shared_row(i));
        }
    }

    /// The same of several, which read `O` and `T` together.
    pub(in crate::selection) fn project_all(&self, columns: &mut [Vec<f64>]) {
        let all = self.taken_of_all(&*columns);
        for i in 0..self.rows() {
            let (own, shared) = (self.own_row(i), self.shared_row(i));
            for (column, taken) in columns.iter_mut().zip(&all) {
                column[i] -= taken.at(self.group_of_row[i], own, shared);
            }
        }
    }

    /// What the base model takes of a whitened column.
    pub(super) fn taken_of(&self, x: &[f64]) -> Taken {
        let mut taken = self.nothing_taken();
        self.add_taken(&mut [(x, &mut taken)]);
        taken
    }

    /// What the base model takes of each of some whitened columns.
    pub(crate) fn taken_of_all<'c>(
        &self,
        columns: impl IntoIterator<Item = &'c Vec<f64>>,
    ) -> Vec<Taken> {
        let columns: Vec<&[f64]> = columns.into_iter().map(Vec::as_slice).collect();
        let mut all: Vec<Taken> = columns.iter().map(|_| self.nothing_taken()).collect();
        let mut pairs: Vec<(&[f64], &mut Taken)> = columns.into_iter().zip(&mut all).collect();
        pairs
            .chunks_mut(TOGETHER)
            .for_each(|some| self.add_taken(some));
        all
    }

    fn nothing_taken(&self) -> Taken {
        Taken {
            own: vec![0.0; self.groups * self.own_width],
            shared: vec![0.0; self.shared_width],
            through: Vec::new(),
        }
    }

    /// Takes of some columns, row after row of `O` and `T`.
    fn add_taken(&self, columns: &mut [(&[f64], &mut Taken)]) {
        in_widest_registers(
            #[inline(always)]
            || {
                let mut first = 0;
                while first < self.rows() {
                    let rows = first..self.rows().min(first + ROWS_TOGETHER);
                    first = rows.end;
                    for (x, taken) in &mut *columns {
                        let x = &x[rows.clone()];
                        if x.iter().any(|x| *x != 0.0) {
                            self.add_own(rows.start, x, &mut taken.own);
                            self.add_shared(rows.start, x, &mut taken.shared);
                        }
                    }
                }
            },
        );
        for (_, taken) in columns {
            let (dense, rest) = taken.shared.split_at(self.sigma_width);
            let through = (0..self.sigma_width).map(|k| dot(self.sigma_row(k), dense));
            taken.through = through.chain(rest.iter().copied()).collect();
        }
    }

    /// Adds what the groups take of the rows `x` of a column, the first of which is `first`.
    #[inline(always)]
    fn add_own(&self, first: usize, x: &[f64], own: &mut [f64]) {
        for (i, x) in (first..).zip(x).filter(|(_, x)| **x != 0.0) {
            let group = &mut own[self.group_of_row[i] * self.own_width..][..self.own_width];
            add(group, self.own_row(i), *x);
        }
    }

    /// Adds `Tᵀx` of these rows, some columns of `T` at a time, whose sums then stay in registers.
    #[inline(always)]
    fn add_shared(&self, first: usize, x: &[f64], sums: &mut [f64]) {
        let rows = &self.shared[first * self.shared_width..];
        let mut start = 0;
        while start + ABREAST <= self.shared_width {
            add_columns::<ABREAST>(rows, self.shared_width, start, x, sums);
            start += ABREAST;
        }
        while start + 4 <= self.shared_width {
            add_columns::<4>(rows, self.shared_width, start, x, sums);
            start += 4;
        }
        for start in start..self.shared_width {
            add_columns::<1>(rows, self.shared_width, start, x, sums);
        }
    }
}

/// `Oᵀx` of each group, `Tᵀx` and `Σ Tᵀx`.
pub(crate) struct Taken {
    pub(in crate::selection) own: Vec<f64>,
    shared: Vec<f64>,
    pub(in crate::selection) through: Vec<f64>,
}

impl Taken {
    /// `(I - M) x` in a row of `O` and `T`.
    fn at(&self, group: usize, own: &[f64], shared: &[f64]) -> f64 {
        let of_group = &self.own[group * own.len()..][..own.len()];
        dot(own, of_group) + dot(shared, &self.through)
    }

    /// `xᵀ (I - M) y`.
    pub(crate) fn product(&self, other: &Self) -> f64 {
        dot(&self.own, &other.own) + dot(&self.shared, &other.through)
    }
}

/// Adds `Tᵀx` of `N` columns of `T` from `start` on, of which there are `width`.
#[inline(always)]
fn add_columns<const N: usize>(
    rows: &[f64],
    width: usize,
    start: usize,
    x: &[f64],
    sums: &mut [f64],
) {
    let Some(sums) = sums[start..].first_chunk_mut::<N>() else {
        return;
    };
    let mut own = *sums;
    for (row, x) in rows.chunks_exact(width).zip(x) {
        if *x != 0.0
            && let Some(row) = row[start..].first_chunk::<N>()
        {
            add(&mut own, row, *x);
        }
    }
    *sums = own;
}

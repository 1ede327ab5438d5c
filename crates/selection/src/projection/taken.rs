//! The part of columns that the base model absorbs, `(I - M) x`.

use std::ops::Range;

use nalgebra::{DMatrixView, DMatrixViewMut};
use rayon::prelude::*;
use trueaxis_leastsquares::{dot, in_widest_registers};

use super::{Projection, add};
use crate::gram_matrix::{SEVERAL, add_products, concerned};

/// Columns that read rows of `O` and `T` together, and number of these rows, so that they stay in the cache.
const TOGETHER: usize = 32;
const ROWS_TOGETHER: usize = 256;

/// Columns of `T` whose sums stay in registers.
const ABREAST: usize = 16;

impl Projection {
    /// `x <- M x`.
    pub fn project(&self, x: &mut [f64]) {
        self.project_all(&mut [x]);
    }

    /// The same for several columns, which read `O` and `T` together.
    pub(crate) fn project_all(&self, columns: &mut [impl AsRef<[f64]> + AsMut<[f64]>]) {
        let taken = self.taken_of_all(columns.iter().map(AsRef::as_ref));
        in_widest_registers(
            #[inline(always)]
            || {
                for i in 0..self.rows() {
                    let (group, own, shared) =
                        (self.group_of_row[i], self.own_row(i), self.shared_row(i));
                    for (k, column) in columns.iter_mut().enumerate() {
                        column.as_mut()[i] -= taken.at(k, group, own, shared);
                    }
                }
            },
        );
    }

    /// What the base model takes of each of some whitened columns.
    pub fn taken_of_all<'c>(&self, columns: impl IntoIterator<Item = &'c [f64]>) -> Taken {
        let columns: Vec<&[f64]> = columns.into_iter().collect();
        let (own_width, width) = (self.groups * self.own_width, self.shared_width);
        let mut own = vec![0.0; columns.len() * own_width];
        let mut shared = vec![0.0; columns.len() * width];
        let of_owns = parts_mut(&mut own, TOGETHER * own_width);
        let of_shared = parts_mut(&mut shared, TOGETHER * width);
        let some = columns.chunks(TOGETHER).zip(of_owns.zip(of_shared));
        let some: Vec<OfColumns<'_>> = some.collect();
        some.into_par_iter().for_each(|some| self.add_taken(some));
        let mut through = Vec::with_capacity(shared.len());
        for k in 0..columns.len() {
            let own = &shared[k * width..(k + 1) * width];
            let (dense, rest) = own.split_at(self.sigma_width);
            through.extend((0..self.sigma_width).map(|k| dot(self.sigma_row(k), dense)));
            through.extend_from_slice(rest);
        }
        Taken {
            own,
            own_width,
            shared,
            through,
            width,
        }
    }

    /// Adds what is taken of some columns, row after row of `O` and `T`.
    fn add_taken(&self, (columns, (own, shared)): OfColumns<'_>) {
        let (own_width, width) = (self.groups * self.own_width, self.shared_width);
        let concerned = concerned(columns);
        let mut tile = Vec::new();
        for first in concerned.clone().step_by(ROWS_TOGETHER) {
            let rows = first..concerned.end.min(first + ROWS_TOGETHER);
            in_widest_registers(
                #[inline(always)]
                || {
                    for (x, own) in columns.iter().zip(parts_mut(own, own_width)) {
                        self.add_own(first, &x[rows.clone()], own);
                    }
                },
            );
            if columns.len() < SEVERAL {
                in_widest_registers(
                    #[inline(always)]
                    || {
                        for (x, shared) in columns.iter().zip(parts_mut(shared, width)) {
                            self.add_shared(first, &x[rows.clone()], shared);
                        }
                    },
                );
            } else if width > 0 {
                tile.clear();
                columns
                    .iter()
                    .for_each(|x| tile.extend_from_slice(&x[rows.clone()]));
                let x = DMatrixView::from_slice(&tile, rows.len(), columns.len());
                let t = &self.shared[rows.start * width..rows.end * width];
                let t = DMatrixView::from_slice(t, width, rows.len());
                DMatrixViewMut::from_slice(shared, width, columns.len()).gemm(1.0, &t, &x, 1.0);
            }
        }
    }

    /// Adds what the groups take of the rows `x` of a column; `first` is the first row.
    #[inline(always)]
    fn add_own(&self, first: usize, x: &[f64], own: &mut [f64]) {
        for (i, x) in (first..).zip(x).filter(|(_, x)| **x != 0.0) {
            let group = &mut own[self.group_of_row[i] * self.own_width..][..self.own_width];
            add(group, self.own_row(i), *x);
        }
    }

    /// Adds `Tᵀx` of these rows, some columns of `T` at a time so that their sums stay in registers.
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

/// Columns, and what is taken of them: `Oᵀx` of each group, and `Tᵀx`, column after column.
type OfColumns<'a> = (&'a [&'a [f64]], (&'a mut [f64], &'a mut [f64]));

/// Consecutive parts of equal length, except the last; then empty ones.
fn parts_mut(mut rest: &mut [f64], length: usize) -> impl Iterator<Item = &mut [f64]> {
    std::iter::from_fn(move || {
        let all = std::mem::take(&mut rest);
        let (part, others) = all.split_at_mut(length.min(all.len()));
        rest = others;
        Some(part)
    })
}

/// `Oᵀx` of each group, `Tᵀx` and `Σ Tᵀx` of columns, one after the other.
pub struct Taken {
    own: Vec<f64>,
    own_width: usize,
    shared: Vec<f64>,
    through: Vec<f64>,
    width: usize,
}

impl Taken {
    /// `Oᵀx` of each group.
    pub(crate) fn own(&self, k: usize) -> &[f64] {
        &self.own[k * self.own_width..(k + 1) * self.own_width]
    }

    /// `Tᵀx`.
    fn shared(&self, k: usize) -> &[f64] {
        &self.shared[k * self.width..(k + 1) * self.width]
    }

    /// `Σ Tᵀx`.
    pub(crate) fn through(&self, k: usize) -> &[f64] {
        &self.through[k * self.width..(k + 1) * self.width]
    }

    /// `(I - M) x` in a row of `O` and `T`.
    #[inline(always)]
    fn at(&self, k: usize, group: usize, own: &[f64], shared: &[f64]) -> f64 {
        let of_group = &self.own(k)[group * own.len()..][..own.len()];
        dot(own, of_group) + dot(shared, self.through(k))
    }

    /// Adds `xᵀ (I - M) y` of each of the columns `x` with each `y` up to the last of them, counted from `first`.
    pub(crate) fn add_products(&self, sum: &mut [f64], x: Range<usize>, first: usize) {
        let (x, y) = (first + x.start..first + x.end, first..first + x.end);
        let of_groups = |all: Range<usize>| -> Vec<&[f64]> { all.map(|k| self.own(k)).collect() };
        add_products(sum, (&of_groups(x.clone()), &of_groups(y.clone())));
        let x: Vec<&[f64]> = x.map(|k| self.shared(k)).collect();
        let y: Vec<&[f64]> = y.map(|k| self.through(k)).collect();
        add_products(sum, (&x, &y));
    }

    /// `xᵀ (I - M) y` of two of the columns.
    pub fn product(&self, i: usize, j: usize) -> f64 {
        dot(self.own(i), self.own(j)) + dot(self.shared(i), self.through(j))
    }
}

/// Adds `Tᵀx` for `N` of the `width` columns of `T`, from `start` on.
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

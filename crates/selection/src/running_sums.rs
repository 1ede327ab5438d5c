//! Sums over rows that are added and removed, and the Gram matrix of their columns:
//!
//! ```text
//! G = XᵀX - Σ_groups (OᵀX)ᵀ(OᵀX) - (TᵀX)ᵀ Σ (TᵀX)
//! ```

use trueaxis_leastsquares::dot;

use crate::{Gram, Projection, add};

/// The sums over the rows added so far.
pub(crate) struct RunningSums {
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

impl RunningSums {
    pub(crate) fn new(projection: &Projection, parameters: usize) -> Self {
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

    /// Adds a row, or removes it, by the sign.
    #[inline(always)]
    pub(crate) fn add(&mut self, projection: &Projection, row: usize, x: &[f64], sign: f64) {
        let n = self.parameters;
        Self::add_squares(&mut self.squares, x, n, sign);
        let own_row = projection.own_row(row);
        let size = own_row.len() * n;
        let group = projection.group_of_row[row];
        let own = &mut self.own[group * size..(group + 1) * size];
        Self::add_squares(&mut self.own_squares, own, n, -1.0);
        for (sums, o) in own.chunks_exact_mut(n).zip(own_row) {
            for (s, x) in sums.iter_mut().zip(x) {
                *s += sign * o * x;
            }
        }
        Self::add_squares(&mut self.own_squares, own, n, 1.0);
        let shared_row = projection.shared_row(row);
        let of_parameters = self.shared.chunks_exact_mut(shared_row.len().max(1));
        for (sums, x) in of_parameters.zip(x) {
            add(sums, shared_row, sign * x);
        }
    }

    pub(crate) fn gram(&self, projection: &Projection) -> Gram {
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

//! The whitened rows of visits, as [`crate::influence`] defines them for a group.
//!
//! A length sees one point only, so a row of `A` has three elements, and before whitening
//!
//! ```text
//! o_i = u_iᵀ R⁻¹_p      t_i = b_i - u_iᵀ Z_p
//! ```
//!
//! take three rows of `R⁻¹` and `Z`. Nothing is allocated from visit to visit.

use std::ops::Range;

use faer::MatRef;
use trueaxis_leastsquares::Covariance;

use crate::free_points::{FreePoints, PER_STATION, State, zero_column};
use crate::influence::GroupRows;
use crate::network::Network;
use crate::noise::whiten;
use trueaxis_leastsquares::row_products::{append_product, dot};

/// The rows of one visit or of several visits to one group, one after the other.
#[derive(Debug, Default)]
pub(crate) struct VisitTerms {
    /// Number of rows, and of columns of `O` and `T`.
    count: usize,
    own_width: usize,
    width: usize,
    own: Vec<f64>,
    shared: Vec<f64>,
    residuals: Vec<f64>,
    /// The rows of `R⁻¹` and `Z` of the group, one after the other.
    factor: Vec<f64>,
    coupling: Vec<f64>,
}

impl VisitTerms {
    /// Number of rows.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Row `i` of `O`.
    pub(crate) fn own(&self, i: usize) -> &[f64] {
        &self.own[i * self.own_width..(i + 1) * self.own_width]
    }

    /// Row `i` of `T`.
    pub(crate) fn shared(&self, i: usize) -> &[f64] {
        &self.shared[i * self.width..(i + 1) * self.width]
    }

    /// Whitened residuals, observed minus computed.
    pub(crate) fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// Starts again without rows, for visits to a group of free points.
    pub(crate) fn clear(&mut self, covariance: &Covariance, group: usize) {
        let (factor, coupling) = (covariance.inverse_factor(group), covariance.coupling(group));
        self.reset(0, factor.ncols(), coupling.ncols());
        copy_rows(factor, &mut self.factor);
        copy_rows(coupling, &mut self.coupling);
    }

    /// Appends the rows of a visit to the group of free points that it was cleared for.
    pub(crate) fn append(
        &mut self,
        network: &Network,
        (model, state): (&FreePoints<'_>, &State),
        visit: usize,
    ) {
        let content = &network.visits[visit];
        let first = self.count;
        let (own_width, width) = (self.own_width, self.width);
        self.resize(first + content.readings.len());
        let (factor, coupling) = (&self.factor, &self.coupling);
        let own = &mut self.own[first * own_width..];
        let shared = &mut self.shared[first * width..];
        let residuals = &mut self.residuals[first..];

        let stations = network.stations.len();
        let station = PER_STATION * content.station;
        let rows = own
            .chunks_exact_mut(own_width)
            .zip(shared.chunks_exact_mut(width))
            .zip(&mut *residuals);
        for (((own, shared), residual), number) in rows.zip(content.readings.clone()) {
            let reading = &network.readings[number];
            let point = reading.point;
            let (u, distance_mm) = state.beam(content.station, network.point(content.group, point));
            let zero = model.zero_of(number);
            *residual = state.residual_mm(reading.length_mm, zero, distance_mm);
            let u: [f64; 3] = u.into();
            let first = 3 * point;
            let of_point = |columns: usize| first * columns..(first + 3) * columns;
            fill_product(own, &u, &factor[of_point(own_width)]);
            fill_product(shared, &u.map(|u| -u), &coupling[of_point(width)]);
            for (shared, u) in shared[station..station + 3].iter_mut().zip(u) {
                *shared -= u;
            }
            shared[zero_column(zero, stations)] -= 1.0;
        }
        let factor = model.factor(visit);
        whiten_rows(factor, own, own_width);
        whiten_rows(factor, shared, width);
        whiten(factor, residuals);
    }

    /// Some rows of a group.
    pub(crate) fn copy(&mut self, group: &GroupRows, rows: Range<usize>) {
        self.reset(rows.len(), group.own.ncols(), group.shared.ncols());
        for (i, row) in rows.enumerate() {
            for k in 0..self.own_width {
                self.own[i * self.own_width + k] = group.own[(row, k)];
            }
            for k in 0..self.width {
                self.shared[i * self.width + k] = group.shared[(row, k)];
            }
            self.residuals[i] = group.residuals[row];
        }
    }

    fn reset(&mut self, count: usize, own_width: usize, width: usize) {
        (self.own_width, self.width) = (own_width, width);
        self.own.clear();
        self.shared.clear();
        self.residuals.clear();
        self.resize(count);
    }

    /// So many rows; those that are new are zero.
    fn resize(&mut self, count: usize) {
        self.count = count;
        self.own.resize(count * self.own_width, 0.0);
        self.shared.resize(count * self.width, 0.0);
        self.residuals.resize(count, 0.0);
    }

    /// Number of columns of `O`.
    pub(crate) fn own_width(&self) -> usize {
        self.own_width
    }

    /// Rows of `O`, of `T`.
    pub(crate) fn own_rows(&self) -> &[f64] {
        &self.own
    }

    pub(crate) fn shared_rows(&self) -> &[f64] {
        &self.shared
    }

    /// `I - O Oᵀ - T Σ Tᵀ` of some rows, its rows contiguous: the part of their noise that the
    /// residuals keep. `sigma` holds the rows of `Σ`.
    pub(crate) fn kept(
        &self,
        of: Range<usize>,
        sigma: &[f64],
        kept: &mut Vec<f64>,
        memory: &mut Vec<f64>,
    ) {
        let n = of.len();
        kept.clear();
        kept.resize(n * n, 0.0);
        memory.clear();
        let shared = &self.shared[of.start * self.width..of.end * self.width];
        append_product(memory, shared, sigma, [self.width; 2]);
        for (i, through) in memory.chunks_exact(self.width.max(1)).enumerate() {
            let row = of.start + i;
            for (j, other) in (of.start..=row).enumerate() {
                let adjusted =
                    dot(self.own(row), self.own(other)) + dot(through, self.shared(other));
                let value = f64::from(u8::from(i == j)) - adjusted;
                kept[i * n + j] = value;
                kept[j * n + i] = value;
            }
        }
    }
}

/// `L⁻¹ X` for rows of `width` elements.
fn whiten_rows(factor: &[f64], x: &mut [f64], width: usize) {
    if width == 0 {
        return;
    }
    let mut elements = factor;
    for i in 0..x.len() / width {
        let (row, rest) = elements.split_at(i + 1);
        let (above, this) = x.split_at_mut(i * width);
        let this = &mut this[..width];
        for (l, above) in row.iter().zip(above.chunks_exact(width)) {
            for (x, above) in this.iter_mut().zip(above) {
                *x -= l * above;
            }
        }
        let scale = row[i].recip();
        this.iter_mut().for_each(|x| *x *= scale);
        elements = rest;
    }
}

/// `uᵀ X` with the three rows of a matrix one after the other.
fn fill_product(product: &mut [f64], u: &[f64; 3], rows: &[f64]) {
    let (x, rest) = rows.split_at(product.len());
    let (y, z) = rest.split_at(product.len());
    for (((value, x), y), z) in product.iter_mut().zip(x).zip(y).zip(z) {
        *value = u[0] * x + u[1] * y + u[2] * z;
    }
}

/// The rows of a matrix, one after the other.
fn copy_rows(matrix: MatRef<'_, f64>, rows: &mut Vec<f64>) {
    rows.clear();
    rows.resize(matrix.nrows() * matrix.ncols(), 0.0);
    for (k, column) in matrix.col_iter().enumerate() {
        let places = rows[k..].iter_mut().step_by(matrix.ncols());
        places.zip(column.iter()).for_each(|(row, x)| *row = *x);
    }
}

//! The whitened rows of visits, as [`crate::influence`] defines them for a group.
//!
//! A length sees one point only, so a row of `A` has three elements, and before whitening
//!
//! ```text
//! o_i = u_iᵀ R⁻¹_p      t_i = b_i - u_iᵀ Z_p
//! ```
//!
//! take three rows of `R⁻¹` and `Z`. Nothing is allocated from visit to visit.

use faer::MatRef;
use trueaxis_leastsquares::Covariance;

use crate::free_points::{FreePoints, PER_STATION, State, zero_column};
use crate::influence::GroupRows;
use crate::network::Network;
use crate::noise::whiten;
use crate::row_products::{append_product, dot};

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
    /// Of the readings of the present visit: unit vector from the station, first unknown of the
    /// point.
    beams: Vec<([f64; 3], usize)>,
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
        let own_width = covariance.inverse_factor(group).ncols();
        self.reset(0, own_width, covariance.coupling(group).ncols());
    }

    /// Appends the rows of a visit to free points.
    pub(crate) fn append(
        &mut self,
        network: &Network,
        model: &FreePoints<'_>,
        state: &State,
        covariance: &Covariance,
        visit: usize,
    ) {
        let content = &network.visits[visit];
        self.beams.clear();
        for reading in network.readings_of(content) {
            let point = network.point(content.group, reading.point);
            let (u, _) = state.beam(content.station, point);
            self.beams.push((u.into(), 3 * reading.point));
        }
        let first = self.count;
        let (own_width, width) = (self.own_width, self.width);
        self.resize(first + self.beams.len());
        let own = &mut self.own[first * own_width..];
        let shared = &mut self.shared[first * width..];
        let residuals = &mut self.residuals[first..];

        let factor = covariance.inverse_factor(content.group);
        for k in 0..own_width {
            let column = column(factor, k);
            // R⁻¹ is upper triangular.
            let rows = own.chunks_exact_mut(own_width).zip(&self.beams);
            for (row, (u, first)) in rows.filter(|(_, (_, first))| *first <= k) {
                row[k] = along(u, &column[*first..]);
            }
        }
        let coupling = covariance.coupling(content.group);
        for k in 0..width {
            let column = column(coupling, k);
            for (row, (u, first)) in shared.chunks_exact_mut(width).zip(&self.beams) {
                row[k] = -along(u, &column[*first..]);
            }
        }
        let stations = network.stations.len();
        let station = PER_STATION * content.station;
        let numbers = content.readings.clone();
        for ((row, (u, _)), number) in shared.chunks_exact_mut(width).zip(&self.beams).zip(numbers)
        {
            for (shared, u) in row[station..station + 3].iter_mut().zip(u) {
                *shared -= u;
            }
            row[zero_column(model.zero_of(number), stations)] -= 1.0;
        }
        for (value, residual) in residuals.iter_mut().zip(model.residuals_mm(state, content)) {
            *value = residual;
        }
        let factor = model.factor(visit);
        whiten_rows(factor, own, own_width);
        whiten_rows(factor, shared, width);
        whiten(factor, residuals);
    }

    /// Some rows of a group.
    pub(crate) fn copy(&mut self, group: &GroupRows, rows: std::ops::Range<usize>) {
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

    /// `I - O Oᵀ - T Σ Tᵀ`, rows contiguous: the part of the rows' noise that the residuals keep.
    /// `sigma` holds the rows of `Σ`.
    pub(crate) fn kept(&self, sigma: &[f64], kept: &mut Vec<f64>, memory: &mut Vec<f64>) {
        let n = self.count;
        kept.clear();
        kept.resize(n * n, 0.0);
        memory.clear();
        append_product(memory, &self.shared, sigma, [self.width; 2]);
        for (i, through) in memory.chunks_exact(self.width.max(1)).enumerate() {
            for j in 0..=i {
                let adjusted = dot(self.own(i), self.own(j)) + dot(through, self.shared(j));
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

/// A column of a matrix with contiguous columns.
fn column(matrix: MatRef<'_, f64>, k: usize) -> &[f64] {
    let column = matrix.col(k).try_as_col_major();
    column.map_or(&[], |column| column.as_slice())
}

/// `uᵀ x` for the first three elements.
fn along(u: &[f64; 3], x: &[f64]) -> f64 {
    u.iter().zip(x).map(|(u, x)| u * x).sum()
}

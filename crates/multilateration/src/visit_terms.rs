//! The whitened rows of one visit, as [`crate::influence`] defines them for a group.
//!
//! A length sees one point only, so a row of `A` has three elements, and before whitening
//!
//! ```text
//! o_i = u_iᵀ R⁻¹_p      t_i = b_i - u_iᵀ Z_p
//! ```
//!
//! take three rows of `R⁻¹` and `Z`. Nothing is allocated from visit to visit.

use trueaxis_leastsquares::Covariance;

use crate::free_points::{FreePoints, PER_STATION, State, zero_column};
use crate::influence::GroupRows;
use crate::network::Network;
use crate::noise::whiten;

/// One visit's rows, one after the other.
#[derive(Debug, Default)]
pub(crate) struct VisitTerms {
    /// Number of rows, and of columns of `O` and `T`.
    count: usize,
    own_width: usize,
    width: usize,
    own: Vec<f64>,
    shared: Vec<f64>,
    residuals: Vec<f64>,
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

    /// The rows of free points.
    pub(crate) fn fill(
        &mut self,
        network: &Network,
        model: &FreePoints<'_>,
        state: &State,
        covariance: &Covariance,
        visit: usize,
    ) {
        let content = &network.visits[visit];
        let stations = network.stations.len();
        let factor = covariance.inverse_factor(content.group);
        let coupling = covariance.coupling(content.group);
        self.reset(content.readings.len(), factor.ncols(), coupling.ncols());
        let readings = content.readings.clone().zip(network.readings_of(content));
        for (i, (number, reading)) in readings.enumerate() {
            let point = network.point(content.group, reading.point);
            let u = state.beam(content.station, point).0;
            let first = 3 * reading.point;
            let own = &mut self.own[i * self.own_width..(i + 1) * self.own_width];
            // R⁻¹ is upper triangular.
            for (k, own) in own.iter_mut().enumerate().skip(first) {
                *own = (0..3).map(|c| u[c] * factor[(first + c, k)]).sum();
            }
            let shared = &mut self.shared[i * self.width..(i + 1) * self.width];
            for (k, shared) in shared.iter_mut().enumerate() {
                *shared = -(0..3).map(|c| u[c] * coupling[(first + c, k)]).sum::<f64>();
            }
            let station = PER_STATION * content.station;
            for (c, shared) in shared[station..station + 3].iter_mut().enumerate() {
                *shared -= u[c];
            }
            shared[zero_column(model.zero_of(number), stations)] -= 1.0;
        }
        for (value, residual) in self
            .residuals
            .iter_mut()
            .zip(model.residuals_mm(state, content))
        {
            *value = residual;
        }
        let factor = model.factor(visit);
        whiten_rows(factor, &mut self.own, self.own_width);
        whiten_rows(factor, &mut self.shared, self.width);
        whiten(factor, &mut self.residuals);
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
        (self.count, self.own_width, self.width) = (count, own_width, width);
        for (memory, width) in [
            (&mut self.own, own_width),
            (&mut self.shared, width),
            (&mut self.residuals, 1),
        ] {
            memory.clear();
            memory.resize(count * width, 0.0);
        }
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
    /// `sigma` holds the columns of `Σ`.
    pub(crate) fn kept(&self, sigma: &[f64], kept: &mut Vec<f64>, memory: &mut Vec<f64>) {
        let n = self.count;
        kept.clear();
        kept.resize(n * n, 0.0);
        for i in 0..n {
            times_symmetric(sigma, self.shared(i), memory);
            for j in 0..=i {
                let adjusted = dot(self.own(i), self.own(j)) + dot(memory, self.shared(j));
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

/// `out = Σ x` for a symmetric matrix with contiguous columns.
pub(crate) fn times_symmetric(sigma: &[f64], x: &[f64], out: &mut Vec<f64>) {
    out.clear();
    out.resize(x.len(), 0.0);
    for (column, x) in sigma.chunks_exact(x.len().max(1)).zip(x) {
        for (o, s) in out.iter_mut().zip(column) {
            *o += s * x;
        }
    }
}

/// `sum += Aᵀ B` for matrices with contiguous rows, `columns` of them in `a` and `b`.
pub(crate) fn add_transposed_product(sum: &mut [f64], a: &[f64], b: &[f64], columns: [usize; 2]) {
    let [n, m] = columns.map(|columns| columns.max(1));
    for (a, b) in a.chunks_exact(n).zip(b.chunks_exact(m)) {
        for (sum, a) in sum.chunks_exact_mut(m).zip(a) {
            for (sum, b) in sum.iter_mut().zip(b) {
                *sum += a * b;
            }
        }
    }
}

/// `out = A B` for a square `A` and `B` with `columns` columns, rows contiguous.
pub(crate) fn product(a: &[f64], b: &[f64], columns: usize, out: &mut Vec<f64>) {
    out.clear();
    out.resize(b.len(), 0.0);
    let m = columns.max(1);
    let count = b.len() / m;
    for (a, out) in a.chunks_exact(count.max(1)).zip(out.chunks_exact_mut(m)) {
        for (a, b) in a.iter().zip(b.chunks_exact(m)) {
            for (out, b) in out.iter_mut().zip(b) {
                *out += a * b;
            }
        }
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

//! What the lengths' own noise alone does to the adjusted unknowns.
//!
//! The noise of a length is the laser's and the machine's return, `C = C_l + C_m`; the weights stay
//! those of `C`. With the whitened part `V = L⁻¹ C_l L⁻ᵀ` of each visit and the factors of
//! [`crate::influence`], the errors that it makes are
//!
//! ```text
//! dp_i = ξ_i - Z_i t     ξ_i = R⁻¹ Oᵀ e_i     t = Σ Σ_i T_iᵀ e_i
//! cov(ξ_i) = R⁻¹ Oᵀ V O R⁻ᵀ     cov(ξ_i, Tᵀe) = R⁻¹ Oᵀ V T = N_i     cov(Tᵀe) = Σ_i Tᵀ V T = M
//! ```
//!
//! Written with doubled couplings `[Z N]` this has the form of the whole covariance:
//!
//! ```text
//! cov(dp_i, dp_k) = [i = k] cov(ξ_i) + [Z_i N_i] S [Z_k N_k]ᵀ     S = | ΣMΣ  -Σ |
//!                                                                     | -Σ    0 |
//! ```
//!
//! The machine's part is the rest.

use faer::Mat;
use trueaxis_leastsquares::BlockRows;

use crate::influence::{GroupRows, Influence, VisitRows};
use crate::noise::whiten;
use crate::{Network, Solution};

/// Covariance of points and stations for the lengths' own noise alone, mm².
pub struct LengthNoise<'a> {
    influence: Influence<'a>,
    shared: Mat<f64>,
}

impl Solution {
    /// What the lengths' own noise alone does to the unknowns; `network` must be the one that was
    /// solved.
    pub fn length_noise<'a>(&'a self, network: &'a Network) -> LengthNoise<'a> {
        let influence = Influence::new(network, self);
        let width = influence.width();
        let mut middle = Mat::<f64>::zeros(width, width);
        let mut memory = BlockRows::default();
        for g in 0..influence.groups() {
            let group = influence.group(g, &mut memory);
            middle +=
                group.shared.transpose() * length_part_times(&influence, &group, &group.shared);
        }
        let sigma = influence.reduced_inverse();
        let mut shared = Mat::zeros(2 * width, 2 * width);
        shared
            .submatrix_mut(0, 0, width, width)
            .copy_from(sigma * middle * sigma);
        for (row, column) in [(0, width), (width, 0)] {
            shared
                .submatrix_mut(row, column, width, width)
                .copy_from(-sigma.to_owned());
        }
        LengthNoise { influence, shared }
    }
}

impl LengthNoise<'_> {
    /// Covariance of the points of a group with all stations held (3 rows and columns each), and
    /// its coupling to the shared sources: twice as many columns as
    /// [`trueaxis_leastsquares::Covariance::coupling`] has.
    pub fn group(&self, group: usize) -> (Mat<f64>, Mat<f64>) {
        let rows = self.influence.group(group, &mut BlockRows::default());
        let covariance = self.influence.covariance();
        let factor = covariance.inverse_factor(group);
        let from_lengths = factor * rows.own.transpose();
        let own = length_part_times(&self.influence, &rows, &rows.own) * factor.transpose();
        let own = &from_lengths * own;
        let cross = &from_lengths * length_part_times(&self.influence, &rows, &rows.shared);
        let z = covariance.coupling(group);
        let width = z.ncols();
        let coupling = Mat::from_fn(z.nrows(), 2 * width, |i, j| {
            if j < width {
                z[(i, j)]
            } else {
                cross[(i, j - width)]
            }
        });
        (own, coupling)
    }

    /// `S`: covariance of the shared sources. The first of them are the stations (x y z L each);
    /// the whole makes sense only between couplings.
    pub fn shared(&self) -> &Mat<f64> {
        &self.shared
    }
}

/// `V X` for whitened rows `X` of a group.
fn length_part_times(influence: &Influence<'_>, group: &GroupRows, x: &Mat<f64>) -> Mat<f64> {
    let mut product = Mat::zeros(x.nrows(), x.ncols());
    for visit in &group.visits {
        let part = length_part(influence, visit);
        product
            .as_mut()
            .subrows_mut(visit.first, visit.count)
            .copy_from(&part * x.as_ref().subrows(visit.first, visit.count));
    }
    product
}

/// `V = L⁻¹ diag(σ_l²) L⁻ᵀ` of one visit.
pub(crate) fn length_part(influence: &Influence<'_>, visit: &VisitRows) -> Mat<f64> {
    let sigmas_mm = influence.length_sigmas_mm(visit);
    let factor = influence.model().factor(visit.visit);
    let mut whitened = Mat::<f64>::zeros(visit.count, visit.count);
    for (i, &sigma_mm) in sigmas_mm.iter().enumerate() {
        let mut column = vec![0.0; visit.count];
        column[i] = sigma_mm;
        whiten(factor, &mut column);
        for (row, value) in column.into_iter().enumerate() {
            whitened[(row, i)] = value;
        }
    }
    &whitened * whitened.transpose()
}

//! Readings divided by their noise.
//!
//! Errors of consecutive arrivals may be alike: those of a first-order autoregressive process in continuous time
//! (Jones, *Fitting a continuous time autoregression to discrete data*, 1981) have the correlation `ρ^(t/T)`, where T
//! is the usual time between two arrivals. Less what is known from the previous one they are independent:
//!
//! ```text
//! y'_i = (y_i - r_i y_{i-1}) / (σ √(1 - r_i²))      r_i = ρ^((t_i - t_{i-1})/T),  r_0 = 0
//! ```

use trueaxis_leastsquares::median;

use crate::verification::arrivals::Arrival;

/// Least time between two arrivals, in units of the usual time: what a table rounds to zero is not zero.
const LEAST_LAG: f64 = 0.1;

/// For each arrival the time since the previous one, in units of the usual time; one without a clock.
pub(crate) fn lags(arrivals: &[Arrival], timed: bool) -> Vec<f64> {
    let gaps = arrivals.windows(2).map(|two| two[1].time_s - two[0].time_s);
    let mut sorted: Vec<f64> = gaps.clone().collect();
    let usual = median(&mut sorted).filter(|usual| timed && *usual > 0.0);
    let lag = |gap: f64| usual.map_or(1.0, |usual| (gap / usual).max(LEAST_LAG));
    std::iter::once(f64::INFINITY)
        .chain(gaps.map(lag))
        .collect()
}

/// Factors of columns over the readings, in µm, for noise of variance one.
#[derive(Clone, Copy)]
pub(crate) struct Whitening<'a> {
    /// For each reading the time since the previous one ([`lags`]).
    pub(crate) lags: &'a [f64],
    /// Standard deviation of an arrival, µm.
    pub(crate) sigma_um: f64,
    /// ρ of arrivals at the usual distance; 0 if they are independent.
    pub(crate) correlation: f64,
    /// Rows below the readings, for pseudo-observations.
    pub(crate) pseudo: usize,
}

impl Whitening<'_> {
    /// A column over the readings as one of the model.
    pub(crate) fn whiten(&self, column: &[f64]) -> Vec<f64> {
        let mut row: Vec<f64> = column.iter().map(|x| x / self.sigma_um).collect();
        if self.correlation > 0.0 {
            for i in (1..row.len()).rev() {
                let r = self.known(i);
                row[i] = (row[i] - r * row[i - 1]) / (1.0 - r * r).sqrt();
            }
        }
        row.resize(column.len() + self.pseudo, 0.0);
        row
    }

    /// The readings of a column of the model, µm.
    pub(crate) fn um(&self, whitened: &[f64]) -> Vec<f64> {
        let mut column: Vec<f64> = whitened[..whitened.len() - self.pseudo].to_vec();
        if self.correlation > 0.0 {
            for i in 1..column.len() {
                let r = self.known(i);
                column[i] = r * column[i - 1] + (1.0 - r * r).sqrt() * column[i];
            }
        }
        column.iter().map(|x| x * self.sigma_um).collect()
    }

    /// `ln det` of the correlations of the readings.
    pub(crate) fn ln_determinant(&self) -> f64 {
        let variances = (1..self.lags.len()).map(|i| 1.0 - self.known(i).powi(2));
        variances.map(f64::ln).sum()
    }

    /// Share of the error of an arrival that is known from the previous one.
    fn known(&self, row: usize) -> f64 {
        self.correlation.powf(self.lags[row])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `W V Wᵀ = I` with `V_ij = ρ^(t between i and j)`, and back again.
    #[test]
    fn correlated_noise_becomes_white() {
        let lags = [f64::INFINITY, 1.0, 0.5, 3.0, 1.0];
        let times: Vec<f64> = (0..5).map(|i| lags[1..=i].iter().sum()).collect();
        let whitening = Whitening {
            lags: &lags,
            sigma_um: 0.7,
            correlation: 0.6,
            pseudo: 1,
        };
        let of_unit = |k: usize| {
            let unit: Vec<f64> = (0..5).map(|i| f64::from(u8::from(i == k))).collect();
            assert!((whitening.um(&whitening.whiten(&unit))[k] - 1.0).abs() < 1e-12);
            whitening.whiten(&unit)
        };
        let w: Vec<Vec<f64>> = (0..5).map(of_unit).collect();
        let v = |i: usize, j: usize| 0.49 * 0.6_f64.powf((times[i] - times[j]).abs());
        for a in 0..5 {
            for b in 0..5 {
                let terms = (0..5).flat_map(|i| (0..5).map(move |j| (i, j)));
                let sum: f64 = terms.map(|(i, j)| w[i][a] * v(i, j) * w[j][b]).sum();
                assert!(
                    (sum - f64::from(u8::from(a == b))).abs() < 1e-12,
                    "{a} {b}: {sum}"
                );
            }
        }
    }
}

//! Arrivals against all others.

use trueaxis_leastsquares::dot;
use trueaxis_selection::{Gram, Projection};

use crate::engine::Tested;

/// An arrival that stands out: error and its standard uncertainty, µm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outlier {
    pub(crate) arrival: usize,
    pub(crate) error_um: f64,
    pub(crate) u_um: f64,
}

/// Arrivals with values of their own in the model.
pub(crate) struct Outliers {
    pub(crate) outliers: Vec<Outlier>,
    /// Drop of the sum of squares.
    pub(crate) drop: f64,
    pub(crate) ln_p: f64,
}

impl Outliers {
    /// `None` if the model takes them as they are: then they cannot be tested.
    pub(crate) fn new(left: &Projection, arrivals: &[usize], resolution_um: f64) -> Option<Self> {
        let n = arrivals.len();
        let left_of = |i: usize, k: usize| {
            let taken = dot(left.shared_row(arrivals[i]), left.shared_row(arrivals[k]));
            f64::from(u8::from(i == k)) - taken
        };
        let matrix: Vec<f64> = (0..n * n).map(|ik| left_of(ik / n, ik % n)).collect();
        let gram = Gram::new(&matrix, &vec![1.0; n]);
        let residuals = arrivals.iter().map(|&arrival| left.residuals[arrival]);
        let residuals: Vec<f64> = residuals.collect();
        // At least the variance of the last digit of the readings.
        let squares = (left.squares(), left.degrees_of_freedom);
        let tested = Tested::new(squares, (&gram, &residuals), resolution_um.powi(2));
        let outlier = |k: usize| Outlier {
            arrival: arrivals[k],
            error_um: tested.errors[k],
            u_um: tested.covariance[k * n + k].sqrt(),
        };
        (gram.rank() == n).then(|| Self {
            outliers: (0..n).map(outlier).collect(),
            drop: tested.drop,
            ln_p: tested.ln_p,
        })
    }
}

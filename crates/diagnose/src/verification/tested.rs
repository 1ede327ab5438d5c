//! Arrivals against all others, by the residuals of these:
//!
//! ```text
//! F = (d/k)/((S - d)/(ν - k))      d = e_Aᵀ (M_AA)⁻¹ e_A      k arrivals A
//! ```

use nalgebra::{DMatrix, DVector};
use trueaxis_leastsquares::dot;
use trueaxis_selection::{Projection, ln_f_test};

/// Arrivals of which the model takes more cannot be tested.
const LEAST_REDUNDANCY: f64 = 1e-6;

/// An arrival that stands out: error and its standard uncertainty, µm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slip {
    pub(crate) arrival: usize,
    pub(crate) error_um: f64,
    pub(crate) u_um: f64,
}

/// Arrivals with values of their own in the model.
pub(crate) struct Tested {
    pub(crate) slips: Vec<Slip>,
    /// d.
    pub(crate) drop: f64,
    pub(crate) ln_p: f64,
}

impl Tested {
    /// `None` if the model takes them as they are: then they cannot be tested.
    pub(crate) fn new(left: &Projection, arrivals: &[usize], resolution_um: f64) -> Option<Self> {
        let rank = arrivals.len();
        let m = DMatrix::from_fn(rank, rank, |i, k| {
            let taken = dot(left.shared_row(arrivals[i]), left.shared_row(arrivals[k]));
            f64::from(u8::from(i == k)) - taken
        });
        let inverse = m.try_inverse()?;
        if (0..rank).any(|k| !(0.0..LEAST_REDUNDANCY.recip()).contains(&inverse[(k, k)])) {
            return None;
        }
        let e = DVector::from_fn(rank, |k, _| left.residuals[arrivals[k]]);
        let errors = &inverse * &e;
        let drop = errors.dot(&e);
        let freedom = left.degrees_of_freedom - rank as f64;
        // At least the variance of the last digit of the readings.
        let rest = (left.squares() - drop).max(freedom * resolution_um.powi(2));
        let s = (rest / freedom).sqrt();
        let slip = |(k, error_um): (usize, &f64)| Slip {
            arrival: arrivals[k],
            error_um: *error_um,
            u_um: s * inverse[(k, k)].sqrt(),
        };
        Some(Self {
            slips: errors.iter().enumerate().map(slip).collect(),
            ln_p: ln_f_test(drop, drop + rest, rank, left.degrees_of_freedom),
            drop,
        })
    }
}

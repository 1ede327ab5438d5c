//! What a calibration is: plain data, and what can be asked of it.

pub(crate) mod added_uncertainty;
pub(crate) mod budget;
pub(crate) mod calibration;
pub(crate) mod factored_covariance;
pub(crate) mod interpolation;
pub(crate) mod numbered;
pub(crate) mod output;
pub(crate) mod sensitivities;

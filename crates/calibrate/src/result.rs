//! A calibration as plain data, with its methods.

pub(crate) mod added_uncertainty;
pub(crate) mod budget;
mod calibrated_machine;
pub(crate) mod calibration;
pub(crate) mod numbered;

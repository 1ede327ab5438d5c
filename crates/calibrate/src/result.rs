//! What a calibration is: plain data, and what can be asked of it.

pub(crate) mod added_uncertainty;
pub(crate) mod budget;
mod calibrated_machine;
pub(crate) mod calibration;
pub(crate) mod numbered;

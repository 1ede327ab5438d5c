//! Poses to component errors, location errors and the reference frame.

pub(crate) mod apply_frame;
pub(crate) mod axis_data;
pub(crate) mod basis;
pub(crate) mod context;
pub(crate) mod frame;
pub(crate) mod gauge;
pub(crate) mod identify_axes;
pub(crate) mod plausibility;
pub(crate) mod pose_errors;
pub(crate) mod start;
pub(crate) mod state;

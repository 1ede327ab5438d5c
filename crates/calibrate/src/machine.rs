//! The machine as measured: its errors anywhere, and how well they are known.

pub(crate) mod approach;
pub(crate) mod calibrated_machine;
pub(crate) mod compare;
pub(crate) mod curve;
pub(crate) mod pivoted_cholesky;
pub(crate) mod predict;
pub(crate) mod readings;
pub(crate) mod remainder;
pub(crate) mod same_machine;
pub(crate) mod volume;

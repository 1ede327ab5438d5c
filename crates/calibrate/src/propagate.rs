//! From the errors of the poses to those of all results.

pub(crate) mod axis_noise;
pub(crate) mod base_response;
pub(crate) mod dependence;
pub(crate) mod factored_covariance;
pub(crate) mod frame_map;
pub(crate) mod node_functions;
pub(crate) mod propagation;
pub(crate) mod sources;
pub(crate) mod variance;

//! What is reported beside the values of the results.

pub(crate) mod axis_results;
pub(crate) mod expansion;
pub(crate) mod home;
pub(crate) mod method_loss;
pub(crate) mod notices;
pub(crate) mod relative_locations;
pub(crate) mod run_misfit;
pub(crate) mod triangle;
pub(crate) mod uncertainty;

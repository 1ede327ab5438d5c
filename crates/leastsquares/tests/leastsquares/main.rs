//! Tests of the crate as a whole: the arrowhead against one dense system, the dense solvers
//! against NIST's reference data.

#![expect(
    clippy::print_stdout,
    reason = "the tables of the reference sets are a result"
)]

mod arrowhead_properties;
mod dense_outcomes;
mod eigenvalues_along;
mod nist_strd;
mod nist_strd_linear;
mod scattered_starts;
mod shortened_steps;
mod strd_file;
mod strd_models;

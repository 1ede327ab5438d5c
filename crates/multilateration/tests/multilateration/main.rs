//! Multilateration against known truth.

#![expect(clippy::print_stdout, reason = "statistical tests show their counts")]

mod bodies;
mod deviation;
mod hat_matrix;
mod irregular;
mod own_shapes;
mod properties;
mod reflectors;
mod seen;
mod trials;
mod world;

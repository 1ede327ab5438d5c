//! Multilateration against known truth.

#![expect(clippy::print_stdout, reason = "statistical tests show their counts")]

mod bodies;
mod gross_errors;
mod hat_matrix;
mod irregular;
mod noise_components;
mod properties;
mod reflectors;
mod trials;
mod world;

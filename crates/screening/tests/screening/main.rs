//! Screening of lengths with known truth.

#![expect(clippy::print_stdout, reason = "statistical tests show their counts")]

mod bodies;
mod gross_errors;
mod growing;
mod noise_components;
mod sweeps;
mod unnoticed;
#[path = "../../../multilateration/tests/multilateration/world.rs"]
mod world;

//! Poses from lengths, against the truth and against each other.

#![expect(clippy::print_stdout, reason = "statistical tests show their counts")]

mod alike;
mod methods;
mod rigid_steps;

//! Simulated campaigns with known truth through the whole path.

mod coverage;
mod round_trip;

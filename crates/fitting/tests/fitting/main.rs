//! Tests of the fits as a whole: reference data, uncertainties, invariance, recovery.

mod coaxial_scene;
mod monte_carlo;
mod nist_pairs;
mod properties;
mod recovery;

//! Tests of the fits as a whole: reference data, invariance, recovery.

mod coaxial_scene;
mod nist_pairs;
mod properties;
mod recovery;

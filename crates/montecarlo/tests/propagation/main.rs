//! Whole-crate tests: the published examples of the GUM and its supplements, distributions with a
//! closed form, threads, the adaptive number of trials and what is refused.

mod adaptive;
mod additive;
mod closed_forms;
mod comparison;
mod comparison_loss;
mod failures;
mod gauge_block;
mod impedance;
mod magnitude_phase;
mod mass;
mod model;
mod stefan_boltzmann;
mod streams;
mod thermometer;

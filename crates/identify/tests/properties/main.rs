//! Whole-crate tests: every choice of rows, the closed form, the published noise, weights and
//! invariances.

mod body;
mod choices;
mod closed_form;
mod invariance;
mod noise_table;
mod pose;
mod targets;
mod weighted;

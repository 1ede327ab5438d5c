//! Tests of the catalogue and of effects in files.

mod curves;
mod effects_file;
mod given_effect;
mod scene;
mod whole_catalogue;

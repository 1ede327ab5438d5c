//! Measuring campaigns of machine tools: checked reading of campaign files.
mod model;
pub use model::*;

//! Tests of the crate as a whole: exact motions, their first order, and worked examples.

mod properties;
mod volumetric;
mod workpiece_axes;

//! Tests of the simulator as its users see it.

mod campaigns;
mod exactness;
mod gauge;
mod noise;
mod order;
mod refusals;
mod shipped;
mod truth_file;

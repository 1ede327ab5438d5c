//! Tests of the simulator as its users see it.

mod by_hand;
mod campaigns;
mod effects;
mod effects_exactly;
mod exactness;
mod gauge;
mod noise;
mod order;
mod refusals;
mod replay;
mod scenario_file;
mod shipped;
mod systematic;
mod truth_file;

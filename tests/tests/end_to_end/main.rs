//! Simulated campaigns with known truth through the whole path.

#![expect(
    clippy::print_stdout,
    reason = "statistical claims are printed with their counts"
)]

mod angular_repeatability;
mod bed;
mod confounded;
mod contradicting_runs;
mod coupled_axes;
mod coverage;
mod declared;
mod diagnosis;
mod differing_stations;
mod expansion;
mod first_order;
mod gross_errors;
mod ideal_observer;
mod interruptions;
mod known;
mod lost_motion;
mod machines;
mod mistakes;
mod nests;
mod one_wrong_length;
mod parked;
mod planar;
mod prediction;
mod reference_frame;
mod reflectors;
mod repeating_errors;
mod report;
mod round_trip;
mod settled;
mod settling;
mod sides;
mod slipped_target;
mod temperatures;
mod triangle;
mod uneven_axes;
mod verification;
mod volume;
mod wandering;

//! Lengths without gross errors, stations without interruptions, and the noise of what is left.
//!
//! One wrong length bends a least-squares adjustment. Whether an error of the form `c ∇` is in the lengths is tested on
//! their residuals `v`, with the covariance `C` of the lengths and `Q_v` of the residuals (Baarda 1968):
//!
//! ```text
//! w = cᵀC⁻¹v / √(cᵀC⁻¹ Q_v C⁻¹c)
//! ```
//!
//! `c` is a single length, all lengths of a visit, or all lengths of a station from an instant on, when its beam was
//! interrupted and found again with another zero.
//!
//! Noun in: a [`Network`]; noun out: a [`Screened`] network with its solution, the lengths that were removed, the
//! jumps of zeros, and the noise that the residuals show ([`estimate_noise`]). [`Screened::tests`] says how far
//! the lengths check each other. Where groups are steps of [`Axes`], some of these may return worse than others
//! ([`Axes::returned`]). Lengths are mm; indices are those of the network that came in.
//!
//! Measured coordinates need no adjustment here; how their noise depends on place and direction is estimated
//! ([`CoordinateNoise::estimated`]).
//!
//! The adjustment is that of [`trueaxis_multilateration`]. Screening uses only these quantities of its solution: the
//! tests of all readings and visits ([`Solution::tests`]), the whitened rows of the hat matrix ([`Whitened`]), from
//! which steps are tested, and one step towards the variance components ([`Solution::variance_components`]). A
//! rejected reading stays in the network with its variance inflated so far ([`Network::variance_factors`]) that it
//! has no influence, and can come back; an interruption gives its station one more dead path
//! ([`Network::interruptions`]). The network is then solved again near its last solution.
//!
#![doc = "```"]
#![doc = include_str!("../examples/screen.rs")]
#![doc = "```"]
//!
//! # What it does not do
//!
//! It does not say why a length is wrong, and knows nothing of machines or campaigns. Zeros that wander are found
//! ([`Screened::wandering`]) but not corrected.
//!
//! [`Network`]: trueaxis_multilateration::Network
//! [`Network::variance_factors`]: trueaxis_multilateration::Network::variance_factors
//! [`Network::interruptions`]: trueaxis_multilateration::Network::interruptions
//! [`Solution::tests`]: trueaxis_multilateration::Solution::tests
//! [`Solution::variance_components`]: trueaxis_multilateration::Solution::variance_components
//! [`Whitened`]: trueaxis_multilateration::Whitened

mod alike;
mod coordinate_noise;
mod error;
mod estimate_noise;
mod guard;
mod interruption;
mod jump_tests;
mod reflector_set;
mod reliability;
mod returns;
mod robust_weights;
mod screen;
mod screened;
mod search;
mod slip;
mod slow;
mod uneven;
mod unnoticed;

pub use alike::{Alike, alike};
pub use coordinate_noise::{CoordinateNoise, CoordinateReading, StepReadings};
pub use error::{Error, Part};
pub use estimate_noise::{
    LEAST_DEGREES_OF_FREEDOM, LEAST_SEPARATION, NoiseBasis, NoiseEstimate, PartEstimate, TOO_GOOD,
    estimate_noise, scaled,
};
pub use guard::{MOST_OF_A_PART, MOST_REMOVED, is_concentrated};
pub use reflector_set::{USUAL_DIFFERENCE_MM, adjust_as_a_set, solve_as_a_set};
pub use returns::{Axes, AxisReturn, Returned, Sweep};
pub use screen::{is_clean, screen, screen_unless, screen_within};
pub use screened::{Jump, Removed, Screened, WanderingZero};
pub use slip::{Slip, Slips};
pub use slow::{Slow, slow};
pub use uneven::{
    LessWeight, MoreScatter, Scatter, Weighed, Whose, uneven, uneven_axes, weigh_uneven,
};
pub use unnoticed::Unnoticed;

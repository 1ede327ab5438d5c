//! Exact simulation of measuring campaigns on machine tools with known errors.
//!
//! A tracker at the station S with the dead path L shows, for a target with the true home position
//! h on a machine at the axis positions q,
//!
//! ```text
//! length = |T1(q1) T2(q2) ... h + d + D_p - (S + D_S)| (1 + s) + c - L + D_l + e
//! ```
//!
//! with the exact rigid motions T of `trueaxis-kinematics` (location errors, six component errors
//! and lost motion in rotation matrices, never the linear form `δ + ε × r`), the random deviation
//! `d` of the machine at a stop, common to the targets measured there, the random error `e` of the
//! instrument, its scale `s` and the reflector's constant `c`, and the displacements `D` by the effects
//! of `trueaxis-effects` that the scenario gives (drift, jumps, bending, refraction, lost motion and so
//! on). Scale, constants and nests are drawn once for a campaign ([`SystematicSpec`]); axes may expand
//! with temperatures that are logged ([`TemperatureSpec`]).
//!
//! Noun in: a [`Scenario`]; nouns out: the [`Campaign`](trueaxis_campaign::Campaign) that would be
//! measured and the [`Truth`] about it, in the shape of a calibration so that both can be laid side
//! by side. The rigid machine and the noise are shared with none of the estimators that are tested with
//! them; the forms of the effects are those that a diagnosis looks for, but here they displace points
//! and the exact distance is taken, never `u·D`. It does not write the campaign (`trueaxis-campaign`
//! does). [`replay()`] is the inverse: from a campaign and what is believed of it to a scenario.
//!
//! # Example
//!
#![doc = "```"]
#![doc = include_str!("../examples/simulate.rs")]
#![doc = "```"]
//!
//! # Frame and gauge of the truth
//!
//! Location errors and component errors mean something only in a frame and a gauge. The truth has those of a
//! calibration (`docs/scenario.md` of the repository). Over the different commanded positions of all runs of an axis the
//! curves lose what belongs to the average line or axis ([`Gauge::LeastSquares`]), so that the location errors of the
//! scenario are those that an ideal measurement finds. The frame is that of `trueaxis_kinematics::FrameRule`; a scenario
//! that contradicts it is refused with the reason.
//!
//! A shift along itself of another rotary axis (`Z0C`) is only told from the mounting of its targets if
//! their mounting errors have zero mean along it.
//!
//! # Noise
//!
//! Each stop of the machine has its own stream of the random generator: the same seed gives the same
//! campaign, and neither later stops nor the size of the noise change the deviates of a stop. What is
//! drawn once for a campaign has streams of its own.
//! Lengths are rounded to 1e-7 mm and times to 1 ms; a scenario without noise can ask for exact
//! lengths ([`NoiseSpec::exact`]).
//!
//! The file format is described in `docs/scenario.md` of the repository and field by field at
//! [`Scenario`].

mod check;
mod circumstances;
mod error;
mod frame;
mod gauge;
mod mounting;
mod noise;
mod plan;
mod plan_bed;
mod plan_runs;
mod read;
mod read_errors;
mod replay;
mod scenario;
mod schedule;
mod simulate;
mod systematic;
mod temperature;
mod term;
mod true_errors;
mod true_machine;
mod truth;
mod truth_file;

pub use error::{Error, Problem};
pub use noise::Noise;
pub use replay::{Replay, ReplayError, replay};
pub use scenario::{
    AxisErrors, BedSpec, Gauge, LocationValue, NoiseSpec, RunSpec, Scenario, StationSpec, Sweep,
    TargetSpec, Timing,
};
pub use simulate::{Simulated, simulate};
pub use systematic::{KnownLengthSpec, ReflectorSpec, SystematicSpec};
pub use temperature::{TemperatureSpec, TemperatureTerm};
pub use term::Term;
pub use true_machine::TrueMachine;
pub use truth::{TrueComponents, TrueLocation, TrueStation, TrueTarget, Truth};

//! The catalogue of physical effects that a rigid, quasi-static model of a machine does not contain.
//!
//! Every effect is a hypothesis with a form of its own: how it displaces the target, how the station,
//! and how it lengthens what the instrument shows,
//!
//! ```text
//! length = | p + D_p - (S + D_S) | - L + D_l        D = Σ_k θ_k D_k(circumstances; shape)
//! ```
//!
//! linear in its parameters θ once its *shape* (an instant, a time constant, a period) is given.
//! One form serves both sides: a simulator displaces target and station by it and measures
//! exactly ([`Effect::displacement`]); a diagnosis takes what a unit of a parameter does to one reading
//! ([`Displaced::along`]).
//!
//! Noun in: the [`Circumstances`] of a reading; noun out: what each effect of the [`catalogue()`] does
//! to it. All effects share one structure, one file each ([`Effect`]); adding one takes one new file
//! and two lines in the catalogue. The crate estimates nothing.
//!
//! In files an effect with its values is a [`GivenEffect`], by names; in a [`Scene`] it becomes a
//! [`ResolvedEffect`], by indices, and goes back. Several with their covariance are an [`EffectsFile`].
//!
//! ```
//! use nalgebra::{Point3, Vector3};
//! use trueaxis_effects::{Circumstances, Subject, effect};
//! use trueaxis_kinematics::{Axis, Machine};
//!
//! let x = Axis::linear("X", Vector3::x(), [0.0, 400.0])?;
//! let machine = Machine::new(vec![x], vec![0], vec![])?;
//! let at = Circumstances {
//!     time_s: 60.0,
//!     positions: &[100.0],
//!     point_mm: Point3::new(100.0, 0.0, 0.0),
//!     ..Circumstances::new(&machine)
//! };
//! let shift = effect("machine_shift").ok_or("no such effect")?;
//! // One µm along y at the instant 50 s.
//! let after = shift.displacement(&Subject::default(), &[0.0, 1.0, 0.0], 50.0, &at);
//! assert_eq!(after.point_mm, Vector3::new(0.0, 1e-3, 0.0));
//! let before = shift.displacement(&Subject::default(), &[0.0, 1.0, 0.0], 70.0, &at);
//! assert_eq!(before.point_mm, Vector3::zeros());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod catalogue;
mod circumstances;
mod displaced;
mod effect;
mod effects_file;
mod error;
mod form;
mod given_effect;
mod given_subject;
mod resolved_effect;
mod scene;
mod shape;
mod subject;
mod temperature;
mod waves;

pub use catalogue::{
    BACKLASH, CROSS_COUPLING, LOST_MOTION_OF_BOTH_SIGNS, POSITION_DEPENDENT_BACKLASH,
    WORN_IN_THE_MIDDLE, catalogue, effect,
};
pub use circumstances::Circumstances;
pub use displaced::Displaced;
pub(crate) use effect::{BUMPED, CREPT};
pub use effect::{Effect, Explanation, Layer, Level, Parameter};
pub use effects_file::{EffectsFile, ResolvedEffects};
pub use error::{Error, Problem};
pub use form::AxisPosition;
pub use given_effect::{GivenEffect, GivenParameter, resolve_all};
pub use given_subject::GivenSubject;
pub use resolved_effect::ResolvedEffect;
pub use scene::{Scene, SceneTarget};
pub use shape::{Shape, shape_parameter};
pub use subject::Subject;
pub use temperature::{Medium, SceneTemperature, TemperatureHistory};

pub(crate) use form::Form;
pub(crate) use trueaxis_kinematics::MICROMETRE;

/// One part per million.
pub(crate) const PPM: f64 = 1e-6;

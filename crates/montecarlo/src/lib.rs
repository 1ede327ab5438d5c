//! Propagation of distributions by Monte Carlo (JCGM 101:2008, GUM Supplement 1).
//!
//! Input quantities `X` with known distributions pass through a model to outputs `Y`. Trial `t`
//! draws the inputs from its own random stream and evaluates the model,
//!
//! ```text
//! y_t = f(ξ_t),   ξ_t drawn from g_X,   t = 0 … M - 1
//! ```
//!
//! and the `M` values of each output stand for its distribution. Noun in: a [`Model`], whose trial
//! draws and evaluates; noun out: a [`Propagation`] with a [`Summary`] per output: mean, standard
//! uncertainty, the probabilistically symmetric and the shortest coverage interval, and the
//! [`Scatter`] that the Monte Carlo itself leaves in them. The trials are a fixed number or as many
//! as a number of significant digits asks for ([`Trials`], clause 7.9). [`validate`] compares a
//! first-order result with the Monte Carlo (clause 8).
//!
//! ```
//! use rand_distr::{Distribution, StandardNormal};
//! use trueaxis_montecarlo::{ChaCha8Rng, FirstOrder, Model, Outcome, Settings, propagate, validate};
//!
//! /// The area of a square whose side is measured as (10.0 ± 0.5) mm.
//! struct Area;
//!
//! impl Model for Area {
//!     type Workspace = ();
//!
//!     fn outputs(&self) -> usize {
//!         1
//!     }
//!
//!     fn workspace(&self) {}
//!
//!     fn trial(&self, rng: &mut ChaCha8Rng, _: &mut (), outputs: &mut [f64]) {
//!         let deviate: f64 = StandardNormal.sample(rng);
//!         outputs[0] = (10.0 + 0.5 * deviate).powi(2);
//!     }
//! }
//!
//! let found = propagate(&Area, &Settings::default(), &|_| {})?;
//! let area = &found.outputs[0];
//! assert!((area.mean - 100.25).abs() < 4.0 * area.scatter.mean); // mm²
//! assert!((area.u - 10.006).abs() < 4.0 * area.scatter.u);
//!
//! // The first-order result, 100 mm² with u = 10 mm², has the ends of the interval wrong by 1 mm²:
//! // too much for a u that is stated to two significant digits, (10 ± 0.5) mm², but not for one that is stated to one.
//! let first_order = FirstOrder::normal(100.0, 10.0, 0.95);
//! let two_digits = validate(&first_order, area, 2)?;
//! assert_eq!(two_digits.outcome, Outcome::NotValidated);
//! assert_eq!(two_digits.tolerance, 0.5);
//! assert_eq!(validate(&first_order, area, 1)?.outcome, Outcome::Validated);
//! # Ok::<(), trueaxis_montecarlo::Error>(())
//! ```
//!
//! Same model and seed: the same bits on any number of threads, because every trial has a stream
//! of its own and every sum runs in the order of the trials.
//!
//! The crate knows no distributions (`rand_distr` has them), no geometry and no files. It keeps
//! every value, 8 bytes per output and trial. It makes intervals output by output; joint coverage
//! regions (JCGM 102) are not made, only [`Propagation::correlation`].

mod coverage;
mod error;
mod model;
mod moments;
mod propagate;
mod settings;
mod stability;
mod summary;
mod tolerance;
mod validate;
mod values;

pub use coverage::Interval;
pub use error::Error;
pub use model::Model;
pub use propagate::{Propagation, propagate};
pub use rand_chacha::ChaCha8Rng;
pub use settings::{Settings, Trials};
pub use stability::{OutputStability, Stability};
pub use summary::{Scatter, Summary};
pub use validate::{FirstOrder, Outcome, Validation, chance_of_ratio, validate};

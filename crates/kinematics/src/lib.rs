//! Exact rigid-body kinematics of multi-axis machine tools with geometric errors.
//!
//! A machine is two branches of linear and rotary axes that start at the bed: one carries the
//! tool, one the workpiece. Where a point `h` (given in the reference frame at home) goes is
//!
//! ```text
//! p = T1(q1) T2(q2) ... Tk(qk) h
//! ```
//!
//! with one exact rigid motion `T` for each axis between the bed and the point's carrier. Each
//! `T` holds the commanded motion, the axis' location errors and its six component errors:
//!
//! ```text
//! linear  T(q) h = o + q d' + δ + exp(ε) (h - o)
//! rotary  T(θ) h = c' + δ + exp(ε) R(d', θ) (h - c' + l_axial)
//! ```
//!
//! (`d'`: average direction, `c'`: average position of the axis, `o`: reference point of δ.)
//! The linear form `Δ = δ + ε × r` of the same errors is [`MotionError::displacement_mm`].
//!
//! Noun in: a [`Machine`] and its [`GeometricErrors`]; noun out: positions in the reference frame.
//! Lengths are mm, angles rad; signs follow the right-hand rule throughout. The crate does not
//! estimate anything and knows no files.
//!
//! ```
//! use nalgebra::{Point3, Vector3};
//! use trueaxis_kinematics::{Axis, Ideal, Machine};
//!
//! let machine = Machine::new(
//!     vec![
//!         Axis::linear("X", Vector3::x(), [0.0, 400.0])?,
//!         Axis::rotary("C", Vector3::z(), [0.0, 6.3], Point3::new(100.0, 0.0, 0.0))?,
//!     ],
//!     vec![0], // bed to tool
//!     vec![1], // bed to workpiece
//! )?;
//! let home = Point3::new(110.0, 0.0, 5.0);
//! let quarter_turn = std::f64::consts::FRAC_PI_2;
//! let p = machine.position(&Ideal, 1, &[0.0, quarter_turn], home);
//! assert!((p - Point3::new(100.0, 10.0, 5.0)).norm() < 1e-12);
//! # Ok::<(), trueaxis_kinematics::Error>(())
//! ```

mod axis;
pub mod axis_twist;
mod best_fit;
mod component;
mod error;
mod frame;
mod geometric_errors;
mod location;
mod machine;
mod motion_error;
mod twist;

pub use axis::{Axis, AxisKind};
pub use best_fit::{best_fit, centroid, polished};
pub use component::Component;
pub use error::Error;
pub use frame::{FrameRule, NominalTarget, SmallMotion};
pub use geometric_errors::{GeometricErrors, Ideal};
pub use location::{LocationComponent, LocationError};
pub use machine::{Branch, Machine};
pub use motion_error::MotionError;
pub use twist::Twist;

/// One arc second in rad.
pub const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

/// One micrometre in mm.
pub const MICROMETRE: f64 = 1e-3;

//! Average lines, circles and axes of rotation by least squares, and the location errors of a
//! machine tool that follow from them.
//!
//! ```text
//! line         minimise Σ |d - (d·v) v|²            d = p - centroid
//! common axis  minimise Σ_k Σ (h - z_k)² + (ρ - R_k)²   h along it, ρ from it; each target k its circle
//! ```
//!
//! Noun in: measured points; noun out: a [`Line`] ([`fit_line`]) or a [`CommonAxis`] with a circle for each
//! target ([`fit_common_axis`]). Average lines then give [`squareness`](squareness()) (paper 4.2.2),
//! average axes the location errors of a rotary axis ([`axis_location`], 4.2.3). A calibration starts from
//! these and continues with its own adjustment of all steps, which gives the uncertainties. Lengths are mm, angles rad;
//! signs follow the right-hand rule. The paper's own angles (Eq. 23), of which three have the opposite sign, are
//! [`paper_squareness`] and [`paper_c_axis_tilt`].
//!
//! Lines reproduce NIST's reference pairs, and circles the same points' answers in 60-digit arithmetic, to twelve digits.
//!
//! ```
//! use nalgebra::{Point3, UnitQuaternion, Vector3};
//! use trueaxis_fitting::{axis_location, fit_common_axis};
//! use trueaxis_kinematics::Axis;
//!
//! // A rotary table turns two targets by 10 degrees at a time, a fifth of a turn in all, about
//! // an axis that stands 20 µm off along x and leans by 50 µrad about y.
//! let targets = [Vector3::new(120.0, 10.0, 40.0), Vector3::new(-60.0, 70.0, 90.0)];
//! let centre = Point3::new(0.020, 0.0, 0.0);
//! let lean = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 50e-6, 0.0));
//! let arcs = targets.map(|arm| {
//!     let turn = |step: i32| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), f64::from(step) * 0.1745);
//!     (0..8).map(|step| centre + lean * (turn(step) * arm)).collect::<Vec<Point3<f64>>>()
//! });
//!
//! let fitted = fit_common_axis(&[&arcs[0], &arcs[1]])?;
//! let nominal = Axis::rotary("C", Vector3::z(), [0.0, 6.3], Point3::origin())?;
//! let location = axis_location(&nominal, &fitted.axis)?;
//! assert!((location.offset_mm - Vector3::new(0.020, 0.0, 0.0)).norm() < 1e-11); // X0C
//! assert!((location.tilt_rad - Vector3::new(0.0, 50e-6, 0.0)).norm() < 1e-13); // B0C
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What it does not do: weights, outliers, or uncertainties.

mod axis_location;
mod circles;
mod cloud;
mod common_axis;
mod error;
mod line;
mod paper_angles;
mod principal_axes;
mod squareness;

pub use axis_location::axis_location;
pub use common_axis::{Circle, CommonAxis, fit_common_axis};
pub use error::Error;
pub use line::{Line, fit_line};
pub use paper_angles::{PaperSquareness, PaperTilt, paper_c_axis_tilt, paper_squareness};
pub use squareness::squareness;

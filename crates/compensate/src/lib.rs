//! Corrected commands for a machine with known errors.
//!
//! A machine with errors is at `g(q)` when it is commanded to `q`, and should be at `g₀(q)` (tool against workpiece).
//! [`correct()`] finds the positions `c` with `g(c) = g₀(q)` as far as the axes can, and says what they cannot take away.
//!
//! [`export()`] makes tables for controls ([`Format`]), and says what they leave.
//!
//! [`import()`] makes a calibration from the tables of another system.
//!
//! Noun in: a machine with its errors, as a [`trueaxis_predict::CalibratedMachine`], and a commanded pose; noun out:
//! [`Corrected`] positions.
//!
#![doc = "```"]
#![doc = include_str!("../examples/correct.rs")]
#![doc = "```"]

mod correct;
mod error;
mod export;
mod freedom;
mod import;
mod remains;
mod sizes;
mod verify;

pub use correct::{Corrected, axis_deviations, correct};
pub use error::Error;
pub use export::{
    Announcement, Export, ExportedFile, Format, LineFigures, Request, TableSign, export,
};
pub use freedom::Moved;
pub use import::{DeclaredUncertainty, Import, Imported, import};
pub use remains::{Remains, remains};
pub use sizes::Sizes;
pub use verify::iso_230_2::{Positioning, Side};
pub use verify::iso_230_4::Circular;
pub use verify::mistaken::Mistaken;
pub use verify::notices::verify_notices;
pub use verify::parallel_lines::{AngleCurve, ParallelLines, parallel_lines};
pub use verify::{
    Checked, EXPECTED_ABOVE_ONE, Point, Verified, uncompensated, verification_json, verify,
};

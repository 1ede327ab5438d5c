//! Measuring campaigns of machine tools: checked reading and writing of campaign files.
//!
//! A campaign is what was measured on which machine: a `campaign.json` that names the machine's
//! axes, targets, stations and runs, and tables (CSV) of readings. A laser tracker at station `S`
//! with the unknown dead path `L` reads of a target at `p` the incremental length
//!
//! ```text
//! l = |p - S| - L
//! ```
//!
//! and any other 3D instrument reads coordinates of `p` in a rigid frame of its own. Laser
//! interferometers and ball bars may have verified single axes, and any instrument single places.
//!
//! Noun in: the path of a `campaign.json` ([`read()`]); noun out: a [`Campaign`], in which every index
//! is valid and every number finite. Files hold mm, degrees, s and µm; inside, angles and rotary
//! positions are rad. Rows are grouped:
//!
//! - a [`Stop`] is a maximal group of consecutive rows with the same station, repeat, run, direction
//!   and positions of all axes: one visit of the machine;
//! - a [`Step`] is a run with positions of all axes, shared by all stops there, numbered as steps
//!   first appear.
//!
//! What is wrong is an [`Error`] that says where, what was found, what is expected and how to correct it. That includes data
//! which the nominal machine cannot have caused, such as lengths in metres, degrees that are radians, or two stations under each
//! other's names; nothing is converted silently. What is only unusual is a text in [`Campaign::notices`].
//!
//! ```
//! use std::fs;
//! use trueaxis_campaign::{read, write};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("campaign.json");
//! fs::write(&path, r#"{
//!     "format": "trueaxis-campaign", "version": 1, "name": "turntable",
//!     "machine": {
//!         "name": "table",
//!         "kinematics": { "tool": [], "workpiece": ["C"] },
//!         "axes": [{ "name": "C", "kind": "rotary", "direction": [0, 0, 1], "travel": [0, 360],
//!                    "position_mm": [0, 0, 0] }]
//!     },
//!     "targets": [{ "name": "P", "position_mm": [100, 0, 0], "carried_by": "C" }],
//!     "runs": [{ "name": "c", "axis": "C" }],
//!     "points": "points.csv"
//! }"#)?;
//! let points = "time_s,repeat,run,direction,C,target,x_mm,y_mm,z_mm\n\
//!               0,1,c,1,0,P,100,0,50\n\
//!               9,1,c,1,90,P,0,100,50\n";
//! fs::write(folder.path().join("points.csv"), points)?;
//!
//! let campaign = read(&path)?;
//! assert_eq!(campaign.steps[1].positions, [std::f64::consts::FRAC_PI_2]);
//! let copy = write(&campaign, &folder.path().join("copy"))?;
//! assert_eq!(read(&copy)?, campaign);
//!
//! // A name in another case:
//! fs::write(folder.path().join("points.csv"), points.replace("c,1,90,P", "c,1,90,p"))?;
//! let error = read(&path).unwrap_err();
//! assert!(error.to_string().ends_with(
//!     "points.csv line 3, column target: unknown target `p`; did you mean `P`? known: P"
//! ));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crate estimates nothing: it corrects no length for the air, rejects no outlier and finds no station.

mod axis_columns;
mod cell;
mod checksums;
mod coverage;
mod date;
mod document;
mod duplicates;
mod expansion;
mod header;
mod known_lengths;
mod lengths;
mod logged;
mod machine;
mod model;
mod names;
mod near_positions;
mod notices;
mod plausibility;
mod point_checks;
mod point_columns;
mod points;
mod position_unit;
mod positions;
mod problem;
mod read;
mod reading;
mod reflectors;
mod rows;
mod run_axes;
mod setup;
mod steps;
mod stops;
mod table;
mod text_file;
mod verification;
mod write;

pub use checksums::{InputFile, checksums};
pub use coverage::{Coverage, Hole, Seen};
pub use document::{AxisKindSpec, AxisSpec, FORMAT, KinematicsSpec, MachineSpec, schema};
pub use header::ColumnFault;
pub use logged::{LoggedColumn, LoggedQuantity};
pub use machine::frame_rule;
pub use model::*;
pub use plausibility::UnitMistake;
pub use positions::{Position, read_positions};
pub use problem::{Error, Problem};
pub use read::{read, read_uncompared};
pub use reading::Sighting;
pub use reflectors::reflectors;
pub use setup::{check_instrument, check_reflectors};
pub use trueaxis_files::{Alternatives, Part, Place};
pub use write::write;

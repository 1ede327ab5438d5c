//! Exports of laser trackers and other instruments, whatever their columns, into the tables of a campaign.
//!
//! Noun in: the text of an export (any ASCII or CSV, as a point list of `SpatialAnalyzer` or `PolyWorks`) and a
//! [`Map`], which says what its columns mean; noun out: [`Imported`], the rows of `lengths.csv` or `points.csv`
//! in mm, degrees and s, with every line that was skipped and why. Nothing is guessed that changes a number: units are
//! stated, and a cell that is not understood is an [`Error`] with its line.
//!
//! An export knows the measured points but seldom where the machine stood. A map takes that from columns, from names
//! of points (`P_040` by the pattern `{target}_{X}`), or from the order of the rows: a fixed number of rows makes a stop, the
//! stops follow a path, and the path is repeated.
//!
//! ```
//! use trueaxis_import::{Kind, Map, import};
//!
//! let map = Map::parse(r#"
//!     separator = ";"
//!     decimal = ","
//!     [columns]
//!     x_mm = { column = "X", unit = "in" }
//!     y_mm = { column = "Y", unit = "in" }
//!     z_mm = { column = "Z", unit = "in" }
//!     [axes]
//!     C = { unit = "deg" }
//!     [stops]
//!     targets = ["P", "Q"]
//!     path = [{ run = "c", axis = "C", positions = [0, 90] }]
//! "#, None)?;
//! let text = "X;Y;Z\n1,0;0;0\n2,0;0;0\n0;1,0;0\n0;2,0;0\n";
//! let imported = import(Kind::Points, text.as_bytes(), None, &map)?;
//! assert!(imported.text().ends_with("\n3,1,c,1,90,Q,0,50.8,0\n"));
//! # Ok::<(), trueaxis_import::Error>(())
//! ```
//!
//! It does not know the machine: [`trueaxis-campaign`](https://docs.rs/trueaxis-campaign) checks the table against it.

mod cells;
mod clock;
mod columns;
mod decode;
mod error;
mod finder;
mod import;
mod map;
mod path;
mod pattern;
mod reader;
mod stops;
mod unit;

pub use error::{Error, Problem};
pub use import::{Imported, Kind, Skipped, import, read};
pub use map::{ColumnMap, ColumnName, Leg, Map, Split, Stops};
pub use unit::Unit;

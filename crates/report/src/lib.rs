//! One page of HTML that shows what a calibration found, on what evidence, and what a diagnosis says of it.
//!
//! Noun in: the files of a folder ([`report()`] reads `calibration.json`, `residuals.csv`, `diagnosis.json`,
//! `volume.json`, `verification.json` and, for its seed, `montecarlo.json`, each if it is there). Noun out: a [`Report`],
//! the page and its figures as SVG. Positions are mm or degrees, errors µm and arcsec, as in the files; bands and U are for
//! 95 %, k = 2 or Student's factor
//!
//! ```text
//! U = max(2, t₀.₉₇₅(dof)) u
//! ```
//!
//! The page stands alone: figures, style and script are in it, and nothing is asked of a network. Whatever comes from a
//! file is text, never markup. The same files give the same bytes.
//!
//! The page is a template of [minijinja](https://docs.rs/minijinja) which another one, given to [`report()`], may
//! replace; it gets the files as they stand (`calibration`, `diagnosis`, `volume`) beside the figures
//! and numbers made of them, and missing values are undefined and raise no error.
//!
//! It does not calculate: every number is in the files, but for rms and quantiles of residuals.
//!
#![doc = "```"]
#![doc = include_str!("../examples/report.rs")]
#![doc = "```"]

mod calibration;
mod causes;
mod comparison;
mod components;
mod diagnosis;
mod disturbances;
mod error;
mod evidence;
mod fitted_figure;
mod input;
mod largest;
mod locations;
mod numbers;
mod page;
mod report;
mod residuals;
mod scene;
mod svg;
mod verdict;
mod verification;
mod words;

pub use error::Error;
pub use report::{Report, report};

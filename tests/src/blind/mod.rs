//! Blind campaigns: measured on a machine with hidden disturbances, to test the diagnosis.
//!
//! The seed draws the machine's errors, targets, stations and noise; [`draw`] draws a disturbance with
//! its subject, direction, size and instant. Every length is the distance of two exactly placed points
//!
//! ```text
//! l = (1 + s) |T(q + a) (h + d) + m + r - (S + v)| + z - L + e
//! ```
//!
//! (T: the exact motion of the erroneous machine, q: commanded positions, h: the target at home, S, L:
//! station and dead path, r: the repeatability error at the stop, e: noise of the length). A
//! disturbance acts on s, a, d, m, v or z where it acts in reality. Nothing of the linear forms of the
//! catalogue of effects is used, and [`misshapen`] disturbances have no shape of the catalogue.
//!
//! A disturbance is as strong as what the rigid, quasi-static model cannot take: [`strength`] is the
//! length λ of its whitened effect on the lengths after everything that the model may take is
//! projected out, which a test with known direction sees as `N(λ, 1)`. It is proportional to the size:
//!
//! ```
//! use trueaxis_tests::blind;
//!
//! let kind = blind::Kind::rotary_stage();
//! let hidden = blind::draw(&kind, "target_slip", 5).expect("there are targets to slip");
//! let hidden = blind::at_strength(&kind, &hidden, 5, 7.0);
//! let campaign = blind::campaign(&kind, &[hidden], 5);
//! assert_eq!(campaign.lengths.unwrap().readings.len(), 4 * 3 * 19 * 3);
//! ```

mod course;
mod derivatives;
mod dice;
mod disturbance;
mod draw;
mod experiment;
mod hidden;
mod kind;
mod layout;
mod parameters;
mod projection;
mod random;
mod schedule;
mod setup;
#[cfg(test)]
mod tests;

pub use course::Course;
pub use draw::{CATALOGUED, COMMON_STATION_DRIFT, UNCATALOGUED, draw, misshapen, names};
pub use hidden::{Act, Hidden, scaled};
pub use kind::{Geometry, Kind, Noise};
pub use parameters::TrueParameter;

use std::path::{Path, PathBuf};

use experiment::Experiment;
use projection::Projection;
use trueaxis_campaign::Campaign;

/// What would be measured. The same seed gives the same machine and the same noise with any
/// disturbances.
pub fn campaign(kind: &Kind, hidden: &[Hidden], seed: u64) -> Campaign {
    let experiment = Experiment::new(kind, seed);
    experiment.campaign(&experiment.noisy_mm(hidden))
}

/// Writes the campaign for inspection; returns the path of its `campaign.json`.
///
/// # Errors
/// As [`trueaxis_campaign::write`].
pub fn write(
    kind: &Kind,
    hidden: &[Hidden],
    seed: u64,
    folder: &Path,
) -> Result<PathBuf, trueaxis_campaign::Error> {
    trueaxis_campaign::write(&campaign(kind, hidden, seed), folder)
}

/// λ: the length of the whitened effect of the disturbances on the lengths of the campaign of that
/// seed, after everything that the base model may take is projected out. λ² is the mean rise of the
/// sum of squares.
pub fn strength(kind: &Kind, hidden: &[Hidden], seed: u64) -> f64 {
    let experiment = Experiment::new(kind, seed);
    let disturbed = experiment.exact_mm(hidden);
    let undisturbed = experiment.exact_mm(&[]);
    let change = disturbed.iter().zip(&undisturbed).map(|(a, b)| a - b);
    let change: Vec<f64> = change.collect();
    Projection::new(&experiment).residuals(&change).norm()
}

/// What a hall does beside all else: it breathes and one tripod sways, each with the strength `lambda`; to be
/// measured with [`Kind::with_heavy_tails`].
pub fn mess(kind: &Kind, seed: u64, lambda: f64) -> Vec<Hidden> {
    let drawn = ["air_conditioning", "tripod_sway"].map(|name| draw(kind, name, seed));
    let drawn = drawn.into_iter().flatten();
    drawn
        .map(|hidden| at_strength(kind, &hidden, seed, lambda))
        .collect()
}

/// The same disturbance as large as gives it the strength `lambda`; as it is if it has none.
#[must_use]
pub fn at_strength(kind: &Kind, hidden: &Hidden, seed: u64, lambda: f64) -> Hidden {
    let now = strength(kind, std::slice::from_ref(hidden), seed);
    if now > 0.0 {
        scaled(hidden, lambda / now)
    } else {
        hidden.clone()
    }
}

/// As the campaign names its stations, from 0.
fn station_name(station: usize) -> String {
    format!("S{}", station + 1)
}

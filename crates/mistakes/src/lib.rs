//! What people do wrong: for data that contradict each other, the mistakes that would explain the contradiction.
//!
//! Each mistake (names of targets or stations exchanged, an axis reversed or in another unit, lengths reversed, nominal positions that
//! are not those at home, a target elsewhere, axes that carry each other otherwise, a wrong prism constant) is undone in a copy of the campaign, and that copy is calibrated; long runs are
//! thinned first. A mistake is reported, with where it was made and what to change, if undoing it makes the lengths (or points) fit with
//! only isolated rejections, and the axes move as commanded. Mistakes that fit alike are all named, of those made in the
//! largest part of the measurement; the first is one that targets and stations do not speak against ([`OffNominal`]). A
//! constant may be of any size: the lengths to one target are left out, and it is their mean difference from what the others
//! predict.
//!
//! Noun in: a [`trueaxis_campaign::Campaign`], and how one is calibrated (a function to a [`Trial`]); noun out: an
//! explanation for the user ([`Mistakes::explanation`]). [`Mistakes::lost_sweeps`] explains sweeps of which most lengths were
//! thrown away. [`displaced_once`] distinguishes targets that were moved in the course of a run from an axis that jumped.
//!
//! ```
//! use trueaxis_campaign::Campaign;
//! use trueaxis_mistakes::{Mistakes, Refused, Trial};
//!
//! fn explained(
//!     campaign: &Campaign,
//!     calibrate: &(dyn Fn(&Campaign, bool) -> Result<Trial, Refused> + Sync),
//! ) -> String {
//!     let mistakes = Mistakes { campaign, robust: true, calibrate };
//!     mistakes.explanation().unwrap_or("nothing simple explains it".to_owned())
//! }
//! ```
//!
//! # What it does not do
//!
//! It finds one mistake at a time, and none that no length or point contradicts.

mod displaced;
mod elsewhere;
mod lost_sweeps;
mod mistake;
mod off_nominal;
mod offsets;
mod scope;
mod search;
mod setups;
mod shown;
mod suspects;

pub use displaced::{DisplacedOnce, displaced_once};
pub use off_nominal::OffNominal;
pub use search::{MOST_ACCIDENTS, Mistakes, PredictedLengths, Refused, Trial};
pub use shown::{FoundTarget, absurd_scale, common_scale, stations_elsewhere, targets_elsewhere};

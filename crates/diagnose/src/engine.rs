//! One search for causes, whatever was measured.
//!
//! Every kind of data asks the same: which effects of the catalogue explain what a base model leaves, what explains it
//! as well, how large each is, what is left, and what is gained on data that were not used. A [`Level`] says what
//! differs:
//!
//! | | lengths | points | verification | runs |
//! | --- | --- | --- | --- | --- |
//! | rows | whitened lengths | three whitened coordinates | arrivals over σ | whitened differences of poses |
//! | base model | stations, poses, shapes | poses, shapes | zero of a line, set-up of a bar, errors of the prediction | error curves, places |
//! | covariance | noise, repeatability, what wanders | noise, repeatability | that of the prediction | that of the poses |
//! | refit | nonlinear adjustment | linear, variances anew | linear | linear |
//! | instants | between visits | between stops | a hundred of a list | none |
//!
//! Common to them, here:
//!
//! - [`hypotheses`]: every effect of a level on every subject becomes whitened columns, with a list of shapes or all
//!   instants at once.
//! - [`ranking`]: all of them against what a model leaves by the numbers of [`crate::selection`]; the best and its
//!   rivals.
//! - [`search`]: lengths and points. One cause joins after the other; each is judged beside the others, gives way to a
//!   better one, or leaves.
//! - [`culprit`]: whether two causes are one trouble under two names.
//! - [`estimated`]: parameters with their uncertainties, shapes included.

mod culprit;
mod estimated;
mod hypotheses;
mod level;
mod ranking;
mod search;

pub(crate) use culprit::{Culprit, Culprits};
pub(crate) use estimated::cause;
pub(crate) use hypotheses::{duration_s, in_equal_ratios, of_catalogue, scan, scans};
pub(crate) use level::{Found, Level, Suspect};
pub(crate) use ranking::Ranking;
pub(crate) use search::{Search, find_causes, settle};

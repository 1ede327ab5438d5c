//! What the search for causes shares between all kinds of data.
//!
//! Every kind of data asks the same: which effects in the catalogue explain what a base model leaves, what explains
//! it as well, how large each effect is, what is left, and what is gained on unused data. [`Measured`] data state
//! what differs:
//!
//! | | lengths | points | verification | runs |
//! | --- | --- | --- | --- | --- |
//! | rows | whitened lengths | three whitened coordinates | arrivals over σ | whitened differences of poses |
//! | base model | stations, poses, shapes | poses, shapes | zero of a line, set-up of a bar, errors of the prediction | error curves, places |
//! | covariance | noise, repeatability, disturbances | noise, repeatability | that of the prediction | that of the poses |
//! | refit | nonlinear adjustment | linear, variances anew | linear | linear |
//! | instants | between readings | between readings | a hundred of a list, then those beside the best | none |
//!
//! The common parts are here:
//!
//! - [`hypotheses`]: every effect of a level on every subject as whitened columns, for a list of shapes or all
//!   instants at once.
//! - [`ranking`]: all hypotheses against what a model leaves, by the numbers of [`trueaxis_selection`]; best and
//!   rivals.
//! - [`between`]: a shape between two of a list.
//! - [`search`]: lengths and points. Causes join one after the other; each is judged beside the others, gives way to
//!   a better one, or leaves.
//! - [`linear`]: the same for verification and runs, where nothing is adjusted anew.
//! - [`smooth`]: how much a process of unknown form explains; [`mod@disturbance`]: disturbances of lengths and points
//!   ([`mod@wandering`]), where they have more evidence than causes or are left beside them ([`competition`]);
//!   [`mod@wandered`] reports them.
//! - [`culprit`]: whether two causes are one trouble under two names.
//! - [`omnibus`]: whether anything is left, and what it varies with; causes that only imitate it.
//! - [`held_out`]: the gain on sweeps not used for the fit.
//! - [`mod@places`]: the misfit by groups of readings; [`mod@unseen`]: what the data cannot show.
//! - [`estimated`]: parameters with their uncertainties, shapes included.

mod accidents;
mod basis;
mod between;
mod competition;
pub(crate) mod coordinate;
mod culprit;
pub(crate) mod disturbance;
mod estimated;
mod held_out;
mod hypotheses;
pub(crate) mod linear;
mod measured;
mod omnibus;
mod opposed;
mod places;
mod ranking;
mod search;
mod smooth;
mod unseen;
mod wandered;
pub(crate) mod wandering;
mod wanders;

pub(crate) use accidents::{first_lines, most};
pub(crate) use between::golden_section;
pub(crate) use competition::{
    Candidates, Competed, add_rival_disturbances, compete, only_wandering, settled,
};
pub(crate) use culprit::{Culprit, Culprits};
pub(crate) use estimated::{ByShape, cause, derivative, with_uncertainties};
pub(crate) use held_out::{FOLDS, HeldOut, Sums, resampled_ratios, sought_again};
pub(crate) use hypotheses::{
    busy_s, duration_s, in_equal_ratios, is_tested, of_catalogue, scan, scans,
};
pub(crate) use measured::{Found, Measured, Suspect, are_two};
pub(crate) use omnibus::{
    Family, MOST_OF_FREEDOM, OMNIBUS_LEVEL, Omnibus, family_wise, is_imitation, still_left,
    unexplained, waves_of,
};
pub(crate) use opposed::{are_opposed, fitted_effects};
pub(crate) use places::{places, side};
pub(crate) use ranking::{Ranking, plausible};
pub(crate) use search::{FURTHER_LEVEL, SHAPE_ERROR, Search, find_causes, settle};
pub(crate) use smooth::{Posterior, SMOOTH_LEVEL, Smooth, beside_one_of, correlation_lengths};
pub(crate) use unseen::{in_words, length_scale, unseen, untested, without_trace};
pub(crate) use wandered::wandered;
pub(crate) use wandering::{JudgedDisturbance, wandered_mm, whitened_columns};
pub(crate) use wanders::Wanders;

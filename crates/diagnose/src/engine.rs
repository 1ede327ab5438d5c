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
//! Causes are sought by one loop, [`mod@forward`]: one after the other, each judged beside the others, until nothing is
//! left that is a cause of its own. The calibrated error curves go through it, too, each with the rest of the curve
//! averaged over. What a kind of data decides by itself, and why:
//!
//! | | lengths, points ([`search`]) | readings, runs ([`linear`]) | error curves |
//! | --- | --- | --- | --- |
//! | most causes | 6, 4 | 3; 5 where they must leave nothing, as on a circle that all errors of two axes shape | 4 |
//! | a better name may replace a cause | yes | yes, but where causes are revised that were found otherwise: beside what wanders, each is asked for by its name | no: all curves of all sizes of the rest would be judged again, for one effect each |
//! | shapes of several causes | one at a time | together, since those of few readings hide each other | by Gauss-Newton, with the sizes |
//! | causes that hide each other | two names exchanged at once, at one station | two join at once, where few readings are left for the noise | none |
//! | nested forms | none in the catalogue | the simplest that is enough | none |
//! | causes in time | any, of different culprits | one, since readings have no culprits; two time constants, or a drift and a jump that leave nothing | none |
//! | only the shape of others | less than a twentieth | the same, unless they must leave nothing | never: an effect stands out from the rest of its curve |
//! | cancel each other | effects after the fit | the same | not in the catalogue |
//!
//! Disturbances are sought by one loop, too, [`mod@wandering`]: one after the other, each judged beside the others and
//! the causes. Here a kind of data decides by itself:
//!
//! | | lengths, points ([`wanders`]) | readings |
//! | --- | --- | --- |
//! | most disturbances | 3 | 2: a table has one coordinate, and few passes |
//! | swings, offsets in pauses | no: an occupation has few swings, and lengths have a clock | yes |
//! | subjects that share the prior | stations, targets, axes | none |
//! | impossible sizes | more than 5 mm | an axis that grows by more than axes do |
//! | lost motion | its change, where it is a cause, is tested alone | a rival, where a course in time hides it |
//!
//! The common parts are here:
//!
//! - [`hypotheses`]: every effect of a level on every subject as whitened columns, for a list of shapes or all
//!   instants at once.
//! - [`ranking`]: all hypotheses against what a model leaves, by the numbers of [`trueaxis_selection`]; best and
//!   rivals.
//! - [`between`]: a shape between two of a list.
//! - [`mod@forward`]: the search for causes; [`search`]: where everything is adjusted anew with each; [`linear`]: where
//!   nothing is, in the readings of a verification, of all together, and in runs.
//! - [`smooth`]: how much a process of unknown form explains; [`mod@disturbance`]: what wanders, and in what form;
//!   [`mod@wandering`]: the search for disturbances, in lengths and points by [`wanders`], where they have a larger 2 ln B
//!   than causes or are left beside them ([`competition`]); [`mod@wandered`] reports them.
//! - [`culprit`]: whether two causes are one trouble under two names.
//! - [`omnibus`]: whether anything is left, and what it varies with; causes that only imitate it.
//! - [`held_out`]: the gain on rows not used for the fit.
//! - [`mod@places`]: the misfit by groups of readings; [`mod@unseen`]: what the data cannot show.
//! - [`estimated`]: parameters with their uncertainties, shapes included.

mod accidents;
pub(crate) mod basis;
mod between;
mod competition;
pub(crate) mod coordinate;
mod culprit;
pub(crate) mod disturbance;
mod estimated;
pub(crate) mod form;
mod forward;
mod held_out;
mod hypotheses;
pub(crate) mod linear;
mod measured;
mod omnibus;
mod opposed;
mod places;
mod ranking;
mod report;
mod search;
mod smooth;
mod unseen;
mod wandered;
mod wandering;
mod wanders;

pub(crate) use accidents::{
    ACCIDENT_LEVEL, ACCIDENTS, LEAST_OTHERS, Tested, first_lines, left_out_in_words, most,
};
pub(crate) use between::golden_section;
pub(crate) use competition::{
    Candidates, Competed, PART, add_rival_disturbances, compete, only_wandering, price, revised,
    together,
};
pub(crate) use culprit::Culprit;
pub(crate) use estimated::{ByShape, cause, derivative, with_uncertainties};
pub(crate) use forward::{
    FURTHER_LEVEL, Forward, SHAPE_ERROR, Search, is_another, select, without,
};
pub(crate) use held_out::{FOLDS, HeldOut, Squares, in_blocks, sought_again};
pub(crate) use hypotheses::{
    TimeConstants, busy_s, duration_s, is_tested, of_catalogue, scan, scans, without_pauses,
};
pub(crate) use measured::{Found, Measured, Suspect, are_two, whitened};
pub(crate) use omnibus::{
    Family, MOST_OF_FREEDOM, OMNIBUS_LEVEL, Omnibus, is_imitation, still_left, unexplained,
    waves_of,
};
pub(crate) use opposed::{are_opposed, fitted_effects};
pub(crate) use places::{Misfits, side};
pub(crate) use ranking::{Ranking, plausible, rivals};
pub(crate) use report::{Findings, rms};
pub(crate) use search::{find_causes, revise, with_parameters};
pub(crate) use smooth::{Posterior, SMOOTH_LEVEL, Smooth, beside_all, correlation_lengths};
pub(crate) use unseen::{in_words, unseen, untested, without_trace};
pub(crate) use wandered::{Coefficients, wandered};
pub(crate) use wandering::{JudgedDisturbance, Wandering, instead_of_cause, sought};
pub(crate) use wanders::{Wanders, wandered_mm, whitened_columns};

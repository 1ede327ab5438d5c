//! Causes in data where nothing is adjusted anew: readings of one verification or of all together, and runs.
//!
//! Every hypothesis has whitened columns for a list of shapes ([`candidate`]); [`listed`] compares them with what a
//! model leaves, and [`search`] chooses causes one after the other. Rows that are left out are predicted by the others
//! without a further fit ([`left_out`]).

mod candidate;
mod left_out;
mod listed;
mod rivals;
mod search;

pub(crate) use candidate::{Candidate, Finer};
pub(crate) use left_out::LeftOut;
pub(crate) use listed::{Beside, Chosen, Judged, Listed};
pub(crate) use search::{Among, MOST_CAUSES, contains};

//! What each kind of data says, before it is put together.

use crate::{Cause, Disturbance, LevelReport, NotObservable, Rejected};

/// What one level, or one part of a campaign, says.
#[derive(Debug, Clone, Default)]
pub(crate) struct Said {
    /// Each set of data that was judged.
    pub(crate) entries: Vec<Entry>,
    /// Named parts of error curves, which have no part in the verdict.
    pub(crate) curves: Vec<Cause>,
    /// Points and readings that were left out.
    pub(crate) rejected: Vec<Rejected>,
    /// Effects that the data cannot show.
    pub(crate) not_observable: Vec<NotObservable>,
    /// What a user must know before using the outcome.
    pub(crate) notices: Vec<String>,
}

/// A set of data with its causes by rank, and what wanders; data and shares of all are those of the report.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) report: LevelReport,
    pub(crate) causes: Vec<Cause>,
    pub(crate) disturbances: Vec<Disturbance>,
}

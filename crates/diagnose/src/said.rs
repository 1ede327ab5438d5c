//! What each kind of data says, and how it is put together.

use crate::{
    Cause, Diagnosis, Disturbance, LevelReport, NotObservable, Rejected, Unexplained, Verdict,
};

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

impl Diagnosis {
    /// Takes in what is said.
    pub(crate) fn take(&mut self, said: Said) {
        said.entries
            .into_iter()
            .for_each(|entry| self.take_entry(entry));
        self.causes.extend(said.curves);
        self.rejected.extend(said.rejected);
        self.not_observable.extend(said.not_observable);
        self.notices.extend(said.notices);
    }

    /// Takes in what one set of data says.
    fn take_entry(&mut self, entry: Entry) {
        let Entry {
            mut report,
            mut causes,
            mut disturbances,
        } = entry;
        for (cause, share) in causes.iter_mut().zip(&report.shares.causes) {
            // What several verifications have in common has both already.
            if cause.data.is_empty() {
                cause.data.push(report.data.clone());
                cause.share = Some(*share);
            }
        }
        for (own, share) in disturbances.iter_mut().zip(&report.shares.disturbances) {
            own.data.clone_from(&report.data);
            own.share = *share;
        }
        report.unexplained = report.unexplained.map(|unexplained| Unexplained {
            data: report.data.clone(),
            share: report.shares.unexplained,
            ..unexplained
        });
        if let Some(left) = report
            .unexplained
            .as_mut()
            .filter(|left| left.is_scatter(&report.before))
        {
            left.note = format!(
                "the repeats scatter by it, and neither a known cause nor a smooth course explains that; {}",
                left.note
            );
        }
        let is_left = report.unexplained.is_some() || !disturbances.is_empty();
        let verdict = Verdict::of_causes(&causes, is_left);
        self.verdict = Verdict::of_all([self.verdict, verdict]);
        if self.unexplained.is_none() {
            self.unexplained.clone_from(&report.unexplained);
        }
        self.levels.push(report);
        causes.retain(|own| own.data.len() < 2 || !self.causes.iter().any(|known| known.is(own)));
        self.causes.extend(causes);
        self.disturbances.extend(disturbances);
    }
}

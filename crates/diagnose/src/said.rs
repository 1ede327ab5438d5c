//! The findings of each kind of data, and how they are combined.

use crate::{
    Cause, Diagnosis, Disturbance, LevelReport, NotObservable, Rejected, Unexplained, Verdict,
};

/// The findings of one level, or of one part of a campaign.
#[derive(Debug, Clone, Default)]
pub(crate) struct Said {
    /// Each set of data that was judged.
    pub(crate) entries: Vec<Entry>,
    /// Named parts of error curves, which do not enter the verdict.
    pub(crate) curves: Vec<Cause>,
    /// Points and readings that were left out.
    pub(crate) rejected: Vec<Rejected>,
    /// Effects that the data cannot show.
    pub(crate) not_observable: Vec<NotObservable>,
    /// Notices for the user.
    pub(crate) notices: Vec<String>,
}

/// A set of data with its causes by rank, and its disturbances; data and shares of all are those of the report.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) report: LevelReport,
    pub(crate) causes: Vec<Cause>,
    pub(crate) disturbances: Vec<Disturbance>,
}

impl Diagnosis {
    /// Adds the findings of one level.
    pub(crate) fn take(&mut self, said: Said) {
        said.entries
            .into_iter()
            .for_each(|entry| self.take_entry(entry));
        self.causes.extend(said.curves);
        self.rejected.extend(said.rejected);
        self.not_observable.extend(said.not_observable);
        self.notices.extend(said.notices);
    }

    /// Adds the findings of one set of data.
    fn take_entry(&mut self, entry: Entry) {
        let Entry {
            mut report,
            mut causes,
            mut disturbances,
        } = entry;
        for (cause, share) in causes.iter_mut().zip(&report.shares.causes) {
            // A cause common to several verifications has both already.
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

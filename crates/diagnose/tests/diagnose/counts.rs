//! Counts of outcomes against a hidden effect.

use trueaxis_diagnose::{Diagnosis, Verdict};
use trueaxis_effects::ResolvedEffect;

#[derive(Debug, Default)]
pub(crate) struct Counts {
    named: usize,
    among: usize,
    pub(crate) wrong: usize,
    unknown: usize,
    missed: usize,
    /// What else was said.
    odd: Vec<String>,
}

impl Counts {
    /// `axis` is that of the hidden effect.
    pub(crate) fn add(&mut self, found: &Diagnosis, effect: &str, axis: Option<usize>) {
        let is_it = |e: &ResolvedEffect| {
            e.effect.id == effect && (e.subject.axis.is_none() || e.subject.axis == axis)
        };
        let causes = &found.causes;
        let first = causes.iter().any(|c| is_it(&c.effect));
        let rival = causes.iter().any(|c| c.rival_effects().any(&is_it));
        let others = causes
            .iter()
            .any(|c| !is_it(&c.effect) && !c.rival_effects().any(&is_it));
        let before = self.right();
        match found.verdict {
            _ if others => self.wrong += 1,
            Verdict::Clean => self.missed += 1,
            Verdict::Unknown => self.unknown += 1,
            Verdict::Named if first => self.named += 1,
            _ if first || rival => self.among += 1,
            _ => self.wrong += 1,
        }
        if self.right() == before {
            self.odd.push(summary(found));
        }
    }

    pub(crate) fn right(&self) -> usize {
        self.named + self.among
    }

    /// By its name, or among names that the data cannot tell apart, in 9 of 10 at least, and at most one
    /// wrong.
    #[track_caller]
    pub(crate) fn assert_named(&self, of: u64, line: &str) {
        let line = format!("{line}: {self:?}");
        crate::report(&line);
        assert!(10 * self.right() as u64 >= 9 * of, "{line}");
        assert!(self.wrong <= 1 && (of > 1 || self.wrong == 0), "{line}");
    }
}

/// A diagnosis in short.
pub(crate) fn summary(found: &Diagnosis) -> String {
    let causes = found.causes.iter().map(|c| {
        let (id, subject) = (c.effect.effect.id, c.effect.subject);
        let (axis, component) = (subject.axis, subject.component);
        format!("{id} {axis:?} {component:?} p {:.1e}", c.p_value)
    });
    let causes: Vec<String> = causes.collect();
    let left = found.unexplained.as_ref().map(|u| u.varies_with.clone());
    format!("{:?} {causes:?} {left:?}", found.verdict)
}

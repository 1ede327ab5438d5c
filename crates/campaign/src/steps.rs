//! Steps: the different commanded positions of each run, and of targets on the bed, numbered as they first appear.

use std::collections::HashMap;

use crate::Step;

/// The steps found so far.
#[derive(Default)]
pub(crate) struct Steps {
    /// In order of first appearance.
    pub(crate) steps: Vec<Step>,
    /// The line where each first appears.
    pub(crate) lines: Vec<usize>,
    /// Run and bits of the positions of each step.
    index: HashMap<Box<[u64]>, usize>,
    key: Vec<u64>,
    last: usize,
}

impl Steps {
    /// The step of `run` at `positions`, if it has appeared. Positions must not hold -0.
    ///
    /// Rows stay at a step or go on to the next one, as at the station before, so these two are tried first.
    pub(crate) fn find(&mut self, run: Option<usize>, positions: &[f64]) -> Option<usize> {
        let is_here = |step: &Step| step.run == run && step.positions == positions;
        for likely in [self.last, self.last + 1] {
            if self.steps.get(likely).is_some_and(is_here) {
                self.last = likely;
                return Some(likely);
            }
        }
        self.key.clear();
        self.key.push(run.map_or(u64::MAX, |run| run as u64));
        self.key.extend(positions.iter().map(|q| q.to_bits()));
        self.last = *self.index.get(self.key.as_slice())?;
        Some(self.last)
    }

    /// Adds a step that [`Steps::find`] has just not found.
    pub(crate) fn add(&mut self, run: Option<usize>, positions: &[f64], line: usize) -> usize {
        self.last = self.steps.len();
        self.index.insert(self.key.as_slice().into(), self.last);
        self.steps.push(Step {
            run,
            positions: positions.to_owned(),
        });
        self.lines.push(line);
        self.last
    }
}

//! Names of axes, targets, stations and runs: looked up by row, unknown ones answered by the nearest known.

use trueaxis_files::DocumentProblem;

use crate::{Error, Place, Problem};

/// The names of one kind, in the order of the file.
pub(crate) struct Names<'a> {
    what: &'static str,
    names: Vec<&'a str>,
    last: usize,
}

impl<'a> Names<'a> {
    /// `what` is the kind in the singular, such as `target`.
    pub(crate) fn new(what: &'static str, names: impl IntoIterator<Item = &'a str>) -> Self {
        Self {
            what,
            names: names.into_iter().collect(),
            last: 0,
        }
    }

    /// Index of `name`. Rows repeat a name or go on to the next one, so these two are tried first.
    pub(crate) fn find(&mut self, name: &[u8]) -> Option<usize> {
        let is = |i: usize| self.names.get(i).is_some_and(|n| n.as_bytes() == name);
        let found = [self.last, self.last + 1]
            .into_iter()
            .chain(0..self.names.len())
            .find(|&i| is(i))?;
        self.last = found;
        Some(found)
    }

    pub(crate) fn name(&self, index: usize) -> &'a str {
        self.names.get(index).copied().unwrap_or_default()
    }

    /// The error for a name that [`Names::find`] does not know.
    pub(crate) fn unknown(&self, place: Box<Place>, name: &[u8]) -> Error {
        let name = String::from_utf8_lossy(name);
        let problem = DocumentProblem::unknown_name(self.what, &name, &self.names);
        Problem::Document(problem).at(place)
    }
}

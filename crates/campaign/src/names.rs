//! Names of axes, targets, stations and runs: looked up by row, unknown ones answered by the
//! nearest known.

use std::path::Path;

use crate::{Alternatives, Error, Place};

/// The names of one kind, in the order of the file.
pub(crate) struct Names<'a> {
    what: &'static str,
    names: Vec<&'a str>,
    last: usize,
}

impl<'a> Names<'a> {
    /// `what` is the kind in the singular, as `target`.
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

    /// The error for a name that [`Names::find`] does not know.
    pub(crate) fn unknown(&self, place: Box<Place>, name: &[u8]) -> Error {
        let name = String::from_utf8_lossy(name);
        Error::UnknownName {
            place,
            what: self.what,
            alternatives: Alternatives::new(&name, &self.names),
            name: name.into_owned(),
        }
    }

    /// Index of the name in the JSON field `path`.
    pub(crate) fn in_field(&mut self, name: &str, file: &Path, path: &str) -> Result<usize, Error> {
        self.find(name.as_bytes())
            .ok_or_else(|| self.unknown(Place::field(file, path), name.as_bytes()))
    }

    /// Checks the names themselves; `list` is the path of their list, as `targets`.
    ///
    /// Cells are read without the blanks around them, so a name must not have any.
    pub(crate) fn check(&self, file: &Path, list: &str) -> Result<(), Error> {
        for (i, name) in self.names.iter().enumerate() {
            let path = format!("{list}[{i}].name");
            if name.is_empty() || name.trim() != *name {
                return Err(Error::Value {
                    place: Place::field(file, path),
                    found: format!("name \"{name}\""),
                    expected: "a name, without blanks around it".to_owned(),
                });
            }
            if let Some(first) = self.names[..i].iter().position(|other| other == name) {
                return Err(Error::DuplicateName {
                    place: Place::field(file, path),
                    what: self.what,
                    name: (*name).to_owned(),
                    first: format!("{list}[{first}].name"),
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_in_any_order() {
        let mut names = Names::new("target", ["P", "Q", "K"]);
        for (name, index) in [("K", 2), ("P", 0), ("P", 0), ("Q", 1), ("K", 2), ("Q", 1)] {
            assert_eq!(names.find(name.as_bytes()), Some(index));
        }
        assert_eq!(names.find(b"R"), None);
        assert_eq!(Names::new("target", []).find(b"P"), None);
    }
}

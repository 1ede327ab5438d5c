//! Where in the files something was found.

use std::fmt;
use std::path::{Path, PathBuf};

/// A place in a file of a campaign, as `lengths.csv line 17, column length_mm`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file: the path given to [`crate::read`], or that path's folder joined with the name
    /// that `campaign.json` gives.
    pub file: PathBuf,
    /// Its line, from 1, where one line can be named.
    pub line: Option<usize>,
    /// The part of the line or of the document.
    pub part: Option<Part>,
}

/// What a [`Place`] points at within its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    /// A field of a JSON document by its path, as `targets[2].carried_by`.
    Field(String),
    /// A column of a CSV file by its name, as `length_mm`.
    Column(String),
}

impl Place {
    pub(crate) fn file(file: &Path) -> Box<Self> {
        Box::new(Self {
            file: file.to_owned(),
            line: None,
            part: None,
        })
    }

    pub(crate) fn line(file: &Path, line: usize) -> Box<Self> {
        Box::new(Self {
            line: Some(line),
            ..*Self::file(file)
        })
    }

    pub(crate) fn field(file: &Path, path: impl Into<String>) -> Box<Self> {
        Box::new(Self {
            part: Some(Part::Field(path.into())),
            ..*Self::file(file)
        })
    }

    pub(crate) fn column(file: &Path, line: usize, column: &str) -> Box<Self> {
        Box::new(Self {
            part: Some(Part::Column(column.to_owned())),
            ..*Self::line(file, line)
        })
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, " line {line}")?;
        }
        match &self.part {
            Some(Part::Field(path)) => write!(f, ", field {path}"),
            Some(Part::Column(name)) => write!(f, ", column {name}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_like_a_sentence() {
        let csv = Path::new("run/lengths.csv");
        let json = Path::new("run/campaign.json");
        assert_eq!(
            Place::column(csv, 17, "length_mm").to_string(),
            "run/lengths.csv line 17, column length_mm"
        );
        assert_eq!(
            Place::field(json, "targets[2].carried_by").to_string(),
            "run/campaign.json, field targets[2].carried_by"
        );
        assert_eq!(Place::line(csv, 3).to_string(), "run/lengths.csv line 3");
    }
}

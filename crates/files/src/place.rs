//! Where in the files something was found.

use std::fmt;
use std::path::{Path, PathBuf};

/// A place in a file, such as `lengths.csv line 17, column length_mm`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The file; none for text that came from none.
    pub file: Option<PathBuf>,
    /// Its line, from 1, where one line can be named.
    pub line: Option<usize>,
    /// The part of the line or of the document.
    pub part: Option<Part>,
}

/// What a [`Place`] points at within its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Part {
    /// A field of a JSON document by its path, such as `targets[2].carried_by`.
    Field(String),
    /// A column of a CSV file by its name, such as `length_mm`.
    Column(String),
    /// A character of the line, from 1; 0 after the last line.
    Character(usize),
}

impl Place {
    /// A file as a whole.
    pub fn file(file: &Path) -> Box<Self> {
        Box::new(Self {
            file: Some(file.to_owned()),
            ..Self::default()
        })
    }

    /// A line of a file, from 1.
    pub fn line(file: &Path, line: usize) -> Box<Self> {
        Box::new(Self {
            line: Some(line),
            ..*Self::file(file)
        })
    }

    /// A field of a JSON file by its path.
    pub fn field(file: &Path, path: impl Into<String>) -> Box<Self> {
        Box::new(Self {
            file: Some(file.to_owned()),
            ..*Self::in_field(path)
        })
    }

    /// A field of a JSON text by its path.
    pub fn in_field(path: impl Into<String>) -> Box<Self> {
        Box::new(Self {
            part: Some(Part::Field(path.into())),
            ..Self::default()
        })
    }

    /// A column in a line of a CSV file.
    pub fn column(file: &Path, line: usize, column: &str) -> Box<Self> {
        Box::new(Self {
            part: Some(Part::Column(column.to_owned())),
            ..*Self::line(file, line)
        })
    }

    /// Path of the field, if it is one.
    pub fn field_path(&self) -> Option<&str> {
        match &self.part {
            Some(Part::Field(path)) => Some(path),
            _ => None,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.as_ref().map(|file| file.display().to_string());
        let line = self.line.map(|line| format!("line {line}"));
        let start: Vec<String> = file.into_iter().chain(line).collect();
        let part = self.part.as_ref().map(|part| match part {
            Part::Field(path) => format!("field {path}"),
            Part::Column(name) => format!("column {name}"),
            Part::Character(character) => format!("character {character}"),
        });
        let start = Some(start.join(" ")).filter(|start| !start.is_empty());
        let all: Vec<String> = start.into_iter().chain(part).collect();
        f.write_str(&all.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_like_a_sentence() {
        let csv = Path::new("run/lengths.csv");
        let json = Path::new("run/campaign.json");
        let text = Place {
            line: Some(4),
            ..*Place::in_field("name")
        };
        for (place, expected) in [
            (
                *Place::column(csv, 17, "length_mm"),
                "run/lengths.csv line 17, column length_mm",
            ),
            (
                *Place::field(json, "targets[2].carried_by"),
                "run/campaign.json, field targets[2].carried_by",
            ),
            (*Place::line(csv, 3), "run/lengths.csv line 3"),
            (text, "line 4, field name"),
        ] {
            assert_eq!(place.to_string(), expected);
        }
    }
}

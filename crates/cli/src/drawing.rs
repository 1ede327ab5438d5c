//! An error drawn on the line of the file where it is, with a mark below.

use std::borrow::Cow;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use trueaxis_campaign::Error as Campaign;
use trueaxis_compensate::Error as Compensate;
use trueaxis_effects::Error as Effects;
use trueaxis_files::{DocumentError, DocumentProblem, Part, Place, field_span};
use trueaxis_import::{Error as Import, Problem as ImportProblem};
use trueaxis_predict::ReadError;
use trueaxis_simulate::Error as Simulate;

/// Columns that a line takes at most; what is left and right of the mark is cut.
const WIDTH: usize = 100;

/// Files beyond this size are not read again for a drawing, bytes.
const LARGEST: u64 = 200 << 20;

/// Where an error is, in a line of a file that can be read.
pub(crate) struct Spot {
    file: PathBuf,
    /// The line, from 1.
    number: usize,
    line: String,
    /// The bytes of the line that are meant.
    mark: Range<usize>,
}

impl Spot {
    /// `None` if the error is in no line of a file.
    pub(crate) fn of(error: &anyhow::Error) -> Option<Self> {
        let place = error.chain().find_map(place)?;
        let place = place.as_ref();
        let file = place.file.as_ref()?;
        if fs::metadata(file).ok()?.len() > LARGEST {
            return None;
        }
        let text = fs::read_to_string(file).ok()?;
        let text = text.trim_start_matches('\u{feff}');
        let (number, mark) = mark(text, place)?;
        let line = text.lines().nth(number - 1)?;
        let word = error.chain().find_map(word);
        let word = word.and_then(|word| single(line, word));
        Some(Self {
            file: file.clone(),
            number,
            mark: word.unwrap_or(mark),
            line: line.to_owned(),
        })
    }

    /// The line, from 1, and the character in it, from 1.
    pub(crate) fn line_and_column(&self) -> (usize, usize) {
        (self.number, 1 + characters(&self.line, self.mark.start))
    }

    /// The lines of the drawing.
    pub(crate) fn drawn(&self) -> Vec<String> {
        let (file, number, line) = (self.file.display(), self.number, self.line.as_str());
        let start = characters(line, self.mark.start);
        let end = characters(line, self.mark.end).max(start + 1);
        // The mark with what stands around it.
        let length = line.chars().count();
        let first = match length <= WIDTH {
            true => 0,
            false => start.saturating_sub(WIDTH / 3),
        };
        let shown = line.chars().skip(first).take(WIDTH);
        let shown: String = shown
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        let cut = |is_cut: bool| if is_cut { "…" } else { "" };
        let (left, right) = (cut(first > 0), cut(first + WIDTH < length));
        let margin = " ".repeat(number.to_string().len());
        let blanks = " ".repeat(start - first + left.chars().count());
        let marks = "^".repeat(end.min(first + WIDTH).saturating_sub(start).max(1));
        vec![
            format!("{margin}--> {file}:{number}:{}", start + 1),
            format!("{margin} |"),
            format!("{number} | {left}{shown}{right}"),
            format!("{margin} | {blanks}{marks}"),
        ]
    }
}

pub(crate) fn file(error: &anyhow::Error) -> Option<PathBuf> {
    error.chain().find_map(place)?.file.clone()
}

fn place<'e>(cause: &'e (dyn std::error::Error + 'static)) -> Option<Cow<'e, Place>> {
    if let Some(Compensate::Table { file, line, .. }) = cause.downcast_ref() {
        return Some(Cow::Owned(*Place::line(Path::new(file), *line)));
    }
    place_of_document(cause).map(Cow::Borrowed)
}

fn place_of_document<'e>(cause: &'e (dyn std::error::Error + 'static)) -> Option<&'e Place> {
    let of_calibration = |error: &'e ReadError| match error {
        ReadError::Document(error) => Some(&*error.place),
        ReadError::Machine(error) => Some(&*error.place),
        _ => None,
    };
    let found = cause.downcast_ref().and_then(of_calibration);
    found
        .or_else(|| cause.downcast_ref().map(|e: &Effects| &*e.place))
        .or_else(|| cause.downcast_ref().map(|e: &Campaign| &*e.place))
        .or_else(|| cause.downcast_ref().map(|e: &DocumentError| &*e.place))
        .or_else(|| cause.downcast_ref().map(|e: &Simulate| &*e.place))
        .or_else(|| cause.downcast_ref().map(|e: &Import| &*e.place))
}

/// What was found, where the separators of the file are not known.
fn word<'e>(cause: &'e (dyn std::error::Error + 'static)) -> Option<&'e str> {
    if let Some(Compensate::Table { found, .. }) = cause.downcast_ref() {
        return Some(found);
    }
    match &cause.downcast_ref::<Import>()?.problem {
        ImportProblem::Cell { found, .. } => Some(found),
        ImportProblem::NoSuchColumn { name, .. } => Some(name),
        ImportProblem::Document(
            DocumentProblem::UnknownName { name, .. } | DocumentProblem::UnknownField { name, .. },
        ) => Some(name),
        _ => None,
    }
}

/// The bytes of a word that stands in the line once.
fn single(line: &str, word: &str) -> Option<Range<usize>> {
    let mut found = line.match_indices(word).filter(|_| !word.is_empty());
    let (start, _) = found.next()?;
    found.next().is_none().then_some(start..start + word.len())
}

/// The line, from 1, and the bytes in it that are meant.
fn mark(text: &str, place: &Place) -> Option<(usize, Range<usize>)> {
    if let Some(Part::Field(path)) = &place.part
        && serde_json::from_str::<serde::de::IgnoredAny>(text).is_ok()
    {
        let span = innermost(text, path)?;
        let before = &text[..span.start];
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        let number = 1 + before.matches('\n').count();
        let line = text[start..].lines().next()?;
        return Some((
            number,
            span.start - start..(span.end - start).min(line.trim_end().len()),
        ));
    }
    let number = place.line?;
    let line = text.lines().nth(number.checked_sub(1)?)?;
    let whole = line.len() - line.trim_start().len()..line.trim_end().len();
    let part = match &place.part {
        Some(Part::Character(character)) => {
            let start = line.char_indices().nth(character.saturating_sub(1));
            start.map(|(start, c)| start..start + c.len_utf8())
        }
        Some(Part::Column(name)) => cell(text, line, name),
        _ => None,
    };
    Some((number, part.unwrap_or(whole)))
}

/// The bytes of the field or, where it is not there, of what should hold it.
fn innermost(json: &str, path: &str) -> Option<Range<usize>> {
    let mut path = path;
    loop {
        if let Some(span) = field_span(json, path) {
            return Some(span);
        }
        path = &path[..path.rfind(['.', '['])?];
    }
}

/// The cell of a column in a line of a table with commas.
fn cell(table: &str, line: &str, name: &str) -> Option<Range<usize>> {
    let header = table.lines().find(|line| !line.trim().is_empty())?;
    let mut names = header
        .split(',')
        .map(|name| name.trim().trim_matches('"').trim());
    let column = names.position(|column| column == name)?;
    let mut start = 0;
    for (index, cell) in line.split(',').enumerate() {
        if index == column {
            let text = cell.trim();
            let start = start + cell.find(text).unwrap_or(0);
            return Some(start..start + text.len());
        }
        start += cell.len() + 1;
    }
    None
}

/// Number of characters in the first bytes of a line.
fn characters(line: &str, bytes: usize) -> usize {
    line.get(..bytes).map_or(0, |text| text.chars().count())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(text: &str, line: Option<usize>, part: Option<Part>) -> String {
        let place = Place {
            line,
            part,
            ..Place::default()
        };
        let (number, mark) = mark(text, &place).unwrap();
        let spot = Spot {
            file: "f".into(),
            number,
            line: text.lines().nth(number - 1).unwrap().to_owned(),
            mark,
        };
        spot.drawn().join("\n")
    }

    #[test]
    fn a_field_is_marked_with_its_key() {
        let text = "{\n  \"µ\": 1, \"axis\": \"X\",\n  \"b\": { \"c\": [1,\n 2] }\n}\n";
        let field = |path: &str| drawn(text, Some(1), Some(Part::Field(path.to_owned())));
        assert_eq!(
            field("axis"),
            " --> f:2:11\n  |\n2 |   \"µ\": 1, \"axis\": \"X\",\n  |           ^^^^^^^^^^^"
        );
        let list = " --> f:3:10\n  |\n3 |   \"b\": { \"c\": [1,\n  |          ^^^^^^^^";
        assert_eq!(field("b.c"), list);
        assert_eq!(field("b.c[7]"), list);
        let element = " --> f:4:2\n  |\n4 |  2] }\n  |  ^";
        assert_eq!(field("b.c[1]"), element);
    }

    #[test]
    fn a_cell_is_marked() {
        let text = "a, b ,c\n1,  22,3\r\n";
        let column =
            |name: &str, line| drawn(text, Some(line), Some(Part::Column(name.to_owned())));
        assert_eq!(column("b", 2), " --> f:2:5\n  |\n2 | 1,  22,3\n  |     ^^");
        assert_eq!(column("b", 1), " --> f:1:4\n  |\n1 | a, b ,c\n  |    ^");
        // A column that is not there, and an empty cell.
        assert_eq!(column("z", 1), " --> f:1:1\n  |\n1 | a, b ,c\n  | ^^^^^^^");
        assert_eq!(
            drawn("a,b\n,1\n", Some(2), Some(Part::Column("a".to_owned()))),
            " --> f:2:1\n  |\n2 | ,1\n  | ^"
        );
    }

    #[test]
    fn long_lines_are_cut_around_the_mark() {
        let text = format!("{{{}\"x\": 5}}", "\"a\": [1, 2, 3], ".repeat(100));
        let lines = drawn(&text, None, Some(Part::Field("x".to_owned())));
        let lines: Vec<&str> = lines.lines().collect();
        assert_eq!(lines[0], " --> f:1:1602");
        let at = lines[3].find('^').unwrap();
        let below: String = lines[2].chars().skip(at).take(6).collect();
        assert_eq!(below, "\"x\": 5");
        assert!(lines[2].chars().count() < WIDTH + 10);
    }
}

//! A CSV file with a known header: columns by name in any order, rows without allocation.

use std::io;
use std::path::Path;

use csv::ByteRecord;
use trueaxis_files::FileProblem;

use crate::names::Names;
use crate::text_file::newlines;
use crate::{Direction, Error, Place, Problem, cell, header};

/// Least size of a chunk of a table: some milliseconds of work, beside which the hand-over to another thread is nothing.
const CHUNK_BYTES: usize = 1 << 20;

/// A CSV file that is read row by row.
pub(crate) struct Table<'a> {
    file: &'a Path,
    text: &'a [u8],
    header: Vec<&'a str>,
    header_line: usize,
    /// Where the rows begin.
    header_end: usize,
    reader: csv::Reader<&'a [u8]>,
    record: ByteRecord,
    /// Where the current record starts, and the number of line ends before it.
    start: usize,
    lines_before: usize,
}

/// Place of a column in every row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column(usize);

impl<'a> Table<'a> {
    /// Reads the header of `text`. Every column must be one of `required` or `optional`, in which `<name>` stands for any text.
    pub(crate) fn open(
        file: &'a Path,
        text: &'a str,
        required: &[&str],
        optional: &[&str],
    ) -> Result<Self, Error> {
        let (line, first) = (1..)
            .zip(text.lines())
            .find(|(_, line)| !line.is_empty())
            .unwrap_or((1, ""));
        let header: Vec<&str> = first.split(',').map(unquoted).collect();
        header::check(file, line, &header, required, optional)?;
        Ok(Self {
            file,
            text: text.as_bytes(),
            header,
            header_line: line,
            // Before the header are blank lines only.
            header_end: text.find(first).unwrap_or(0) + first.len(),
            reader: reader(text.as_bytes(), true),
            record: ByteRecord::new(),
            start: 0,
            lines_before: 0,
        })
    }

    /// The same table in chunks of some size each, to be read in any order. Where text is quoted it
    /// stays in one chunk: line ends may then be part of a cell.
    pub(crate) fn chunks(self) -> Vec<Self> {
        let text = self.text;
        if text.contains(&b'"') {
            return vec![self];
        }
        let mut chunks = Vec::new();
        let (mut start, mut lines_before) = (0, 0);
        while start < text.len() {
            let least = (start + CHUNK_BYTES).max(self.header_end).min(text.len());
            let line_end = text[least..].iter().position(|&b| b == b'\n');
            let end = line_end.map_or(text.len(), |length| least + length + 1);
            let chunk = &text[start..end];
            chunks.push(Self {
                text: chunk,
                header: self.header.clone(),
                reader: reader(chunk, start == 0),
                record: ByteRecord::new(),
                start: 0,
                lines_before,
                ..self
            });
            lines_before += newlines(chunk);
            start = end;
        }
        chunks
    }

    /// The column of that name, which must be there.
    pub(crate) fn column(&self, name: &str) -> Result<Column, Error> {
        self.optional_column(name).ok_or_else(|| {
            let place = Place::column(self.file, self.header_line, name);
            header::missing(&self.header).at(place)
        })
    }

    /// The column of that name, if it is there.
    pub(crate) fn optional_column(&self, name: &str) -> Option<Column> {
        self.header.iter().position(|c| *c == name).map(Column)
    }

    /// All columns with their names, in the order of the file.
    pub(crate) fn columns(&self) -> impl Iterator<Item = (&'a str, Column)> {
        let names = self.header.iter().enumerate();
        names.map(|(i, &name)| (name, Column(i)))
    }

    /// The next row that is not blank.
    pub(crate) fn next_row(&mut self) -> Result<Option<Row<'_>>, Error> {
        loop {
            let more = self.reader.read_byte_record(&mut self.record);
            if !more.map_err(|error| self.unreadable(error))? {
                return Ok(None);
            }
            self.advance();
            if self.record.len() != self.header.len() {
                if self.record.len() == 1 && self.record[0].trim_ascii().is_empty() {
                    continue;
                }
                return Err(Problem::FieldCount {
                    found: self.record.len(),
                    expected: self.header.len(),
                }
                .at(Place::line(self.file, self.lines_before + 1)));
            }
            return Ok(Some(Row {
                file: self.file,
                header: &self.header,
                record: &self.record,
                line: self.lines_before + 1,
            }));
        }
    }

    /// Counts the lines up to the current record. The csv reader's own count is one behind where
    /// lines end in CR LF or blank lines come before the record.
    fn advance(&mut self) {
        let reported = self.record.position().map_or(0, csv::Position::byte);
        let mut start = usize::try_from(reported).unwrap_or(usize::MAX);
        while matches!(self.text.get(start), Some(b'\r' | b'\n')) {
            start += 1;
        }
        let passed = self.text.get(self.start..start).unwrap_or_default();
        self.lines_before += newlines(passed);
        self.start = start;
    }

    fn unreadable(&self, error: csv::Error) -> Error {
        let source = io::Error::from(error);
        Problem::File(FileProblem::Unreadable { source }).at(Place::file(self.file))
    }

    /// What `read` makes of each row, of which there is one at least.
    pub(crate) fn read_rows<T>(
        &mut self,
        mut read: impl FnMut(&Row<'_>) -> Result<T, Error>,
    ) -> Result<Vec<T>, Error> {
        let mut found = Vec::new();
        while let Some(row) = self.next_row()? {
            found.push(read(&row)?);
        }
        match found.is_empty() {
            true => Err(self.no_rows()),
            false => Ok(found),
        }
    }

    pub(crate) fn no_rows(&self) -> Error {
        Problem::NoRows.at(Place::file(self.file))
    }
}

fn reader(text: &[u8], has_headers: bool) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .has_headers(has_headers)
        .flexible(true)
        .from_reader(text)
}

/// Names of columns hold no commas, so the header needs no more of CSV than this.
fn unquoted(name: &str) -> &str {
    name.trim().trim_matches('"').trim()
}

/// One row; each cell is read without the blanks around it.
pub(crate) struct Row<'t> {
    file: &'t Path,
    header: &'t [&'t str],
    record: &'t ByteRecord,
    line: usize,
}

impl Row<'_> {
    /// Its line in the file, from 1 (the header).
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// Where the cell in `column` is.
    pub(crate) fn place(&self, column: Column) -> Box<Place> {
        let name = self.header.get(column.0).copied().unwrap_or_default();
        Place::column(self.file, self.line, name)
    }

    /// The cell in `column`, without the blanks around it.
    pub(crate) fn cell(&self, column: Column) -> &[u8] {
        self.record.get(column.0).unwrap_or_default().trim_ascii()
    }

    /// A finite number.
    pub(crate) fn number(&self, column: Column) -> Result<f64, Error> {
        self.finite(column, cell::number_problem)
    }

    /// A finite number or, where the column is not there or the cell is empty, none.
    pub(crate) fn optional_number(&self, column: Option<Column>) -> Result<Option<f64>, Error> {
        match column {
            Some(column) if !self.cell(column).is_empty() => self.number(column).map(Some),
            _ => Ok(None),
        }
    }

    /// A time, s: a finite number.
    pub(crate) fn time_s(&self, column: Column) -> Result<f64, Error> {
        self.finite(column, cell::time_problem)
    }

    fn finite(&self, column: Column, problem: fn(&[u8]) -> (String, String)) -> Result<f64, Error> {
        let cell = self.cell(column);
        cell::number(cell).ok_or_else(|| {
            let (found, expected) = problem(cell);
            Problem::value(found, expected).at(self.place(column))
        })
    }

    /// A whole number from 1.
    pub(crate) fn counting_number(&self, column: Column) -> Result<u32, Error> {
        cell::counting_number(self.cell(column))
            .ok_or_else(|| self.refused(column, "a whole number from 1"))
    }

    /// +1 or -1.
    pub(crate) fn direction(&self, column: Column) -> Result<Direction, Error> {
        match self.cell(column) {
            b"1" | b"+1" => Ok(Direction::Forward),
            b"-1" => Ok(Direction::Backward),
            _ => Err(self.refused(column, "1 or -1, the side of approach")),
        }
    }

    pub(crate) fn name(&self, column: Column, names: &mut Names<'_>) -> Result<usize, Error> {
        let cell = self.cell(column);
        names
            .find(cell)
            .ok_or_else(|| names.unknown(self.place(column), cell))
    }

    fn refused(&self, column: Column, expected: &str) -> Error {
        Problem::value(
            format!("found \"{}\"", String::from_utf8_lossy(self.cell(column))),
            expected.to_owned(),
        )
        .at(self.place(column))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<usize> {
        let mut table = Table::open(Path::new("t.csv"), text, &["a", "b"], &[]).unwrap();
        let mut lines = Vec::new();
        while let Some(row) = table.next_row().unwrap() {
            lines.push(row.line());
        }
        lines
    }

    #[test]
    fn chunks_are_the_whole() {
        let row = "1234567,8901234\r\n";
        let rows = 3 * CHUNK_BYTES / row.len();
        for (quoted, chunks) in [("", 3), ("\"5\",6\n", 1)] {
            let text = format!("\n a, b\n\n{quoted}{}", row.repeat(rows));
            let open = || Table::open(Path::new("t.csv"), &text, &["a", "b"], &[]).unwrap();
            let found = open().chunks();
            assert_eq!(found.len(), chunks);
            let mut lines = Vec::new();
            for mut chunk in found {
                while let Some(row) = chunk.next_row().unwrap() {
                    lines.push(row.line());
                }
            }
            let first = 4;
            let count = rows + usize::from(!quoted.is_empty());
            assert!(lines.into_iter().eq(first..first + count));
        }
    }

    #[test]
    fn lines_are_counted_whatever_ends_them() {
        assert_eq!(lines("a,b\n1,2\n3,4"), [2, 3]);
        assert_eq!(lines("a,b\r\n1,2\r\n3,4\r\n"), [2, 3]);
        assert_eq!(lines("a,b\n\n1,2\n  \n\n3,4\n\n"), [3, 6]);
        assert_eq!(lines("a,b\r\n\r\n1,2\r\n\r\n3,4\r\n\r\n"), [3, 5]);
        assert_eq!(lines("\"a\", b\n\"1\n\",2\n3,4\n"), [2, 4]);
    }
}

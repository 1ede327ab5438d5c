//! Building the text of a CSV file.

use std::fmt::{Display, Write};

use trueaxis_files::csv_cell;
use trueaxis_kinematics::Machine;

use crate::position_unit;

/// Decimals of a length in mm, 0.1 nm: below every instrument's resolution.
const LENGTH_DECIMALS: usize = 7;

/// Decimals of a time in s.
const TIME_DECIMALS: usize = 3;

/// CSV text that grows cell by cell.
#[derive(Default)]
pub(crate) struct Rows {
    text: String,
    row_has_cells: bool,
}

impl Rows {
    pub(crate) fn with_header<'a>(columns: impl IntoIterator<Item = &'a str>) -> Self {
        let mut rows = Self::default();
        columns.into_iter().for_each(|column| rows.name(column));
        rows.end_row();
        rows
    }

    /// A name, in quotes if it needs them.
    pub(crate) fn name(&mut self, name: &str) {
        self.separate();
        self.text.push_str(&csv_cell(name));
    }

    /// A number in the fewest digits that give all its bits again.
    pub(crate) fn number(&mut self, number: impl Display) {
        self.separate();
        self.push(format_args!("{number}"));
    }

    /// A number, or an empty cell.
    pub(crate) fn optional(&mut self, number: Option<impl Display>) {
        match number {
            Some(number) => self.number(number),
            None => self.separate(),
        }
    }

    /// A time, s; an empty cell, which no reading accepts, where only other readings have one.
    pub(crate) fn optional_time_s(&mut self, time_s: Option<f64>) {
        match time_s {
            Some(time_s) => self.time_s(time_s),
            None => self.separate(),
        }
    }

    /// A length, mm, on the grid of the file.
    pub(crate) fn length_mm(&mut self, length_mm: f64) {
        self.rounded(length_mm, LENGTH_DECIMALS);
    }

    /// A time, s, on the grid of the file.
    pub(crate) fn time_s(&mut self, time_s: f64) {
        self.rounded(time_s, TIME_DECIMALS);
    }

    /// Several cells made by [`position_cells`].
    pub(crate) fn positions(&mut self, cells: &str) {
        if !cells.is_empty() {
            self.separate();
            self.text.push_str(cells);
        }
    }

    pub(crate) fn end_row(&mut self) {
        self.text.push('\n');
        self.row_has_cells = false;
    }

    pub(crate) fn into_text(self) -> String {
        self.text
    }

    fn rounded(&mut self, number: f64, decimals: usize) {
        self.separate();
        let start = self.text.len();
        self.push(format_args!("{number:.decimals$}"));
        let shortened = self.text.trim_end_matches('0').trim_end_matches('.').len();
        self.text.truncate(shortened);
        if self.text.get(start..) == Some("-0") {
            self.text.replace_range(start.., "0");
        }
    }

    fn separate(&mut self) {
        if self.row_has_cells {
            self.text.push(',');
        }
        self.row_has_cells = true;
    }

    fn push(&mut self, number: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = self.text.write_fmt(number);
    }
}

/// The cells of the axes, in the units of the files.
pub(crate) fn position_cells(machine: &Machine, positions: &[f64]) -> String {
    let axes = machine.axes().iter().zip(positions);
    let cells = axes.map(|(axis, &q)| position_unit::in_file(axis.kind(), q).to_string());
    cells.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(fill: impl Fn(&mut Rows)) -> String {
        let mut rows = Rows::default();
        fill(&mut rows);
        rows.into_text()
    }

    #[test]
    fn rounded_numbers_have_no_idle_digits() {
        for (length_mm, expected) in [
            (1234.5, "1234.5"),
            (100.0, "100"),
            (0.0, "0"),
            (-1e-9, "0"),
            (-0.1 - 0.2, "-0.3"),
            (1.234_567_89, "1.2345679"),
        ] {
            assert_eq!(text(|rows| rows.length_mm(length_mm)), expected);
        }
        assert_eq!(text(|rows| rows.time_s(10.000_4)), "10");
    }

    #[test]
    fn names_are_quoted_if_they_need_it() {
        let names = ["P", "left, \"upper\""];
        assert_eq!(
            Rows::with_header(names).into_text(),
            "P,\"left, \"\"upper\"\"\"\n"
        );
    }
}

//! Copies of shipped campaigns, and ways to damage them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::program::{run, shipped};

/// The files of a campaign by name.
#[derive(Clone)]
pub(crate) struct CampaignFiles(BTreeMap<String, Vec<u8>>);

/// Cells of `lengths.csv`.
pub(crate) struct Table {
    pub(crate) header: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
}

/// A row with its header.
pub(crate) struct Row<'a> {
    header: &'a [String],
    cells: &'a [String],
}

impl CampaignFiles {
    /// `campaign.json` and `lengths.csv` of a shipped campaign.
    pub(crate) fn shipped(campaign: &str) -> Self {
        Self::read(&shipped(campaign))
    }

    /// The campaign that a changed scenario of a shipped campaign gives.
    pub(crate) fn simulated(campaign: &str, change: impl FnOnce(&mut Value)) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let text = fs::read(shipped(campaign).join("scenario.json")).unwrap();
        let mut scenario = serde_json::from_slice(&text).unwrap();
        change(&mut scenario);
        fs::write(folder.path().join("scenario.json"), scenario.to_string()).unwrap();
        run(folder.path(), &["simulate", "scenario.json", "--out", "."]).assert_good();
        Self::read(folder.path())
    }

    fn read(folder: &Path) -> Self {
        let read = |name: &str| (name.to_owned(), fs::read(folder.join(name)).unwrap());
        Self(BTreeMap::from(["campaign.json", "lengths.csv"].map(read)))
    }

    /// Writes the files to a folder.
    pub(crate) fn write(&self, folder: &Path) {
        for (name, bytes) in &self.0 {
            fs::write(folder.join(name), bytes).unwrap();
        }
    }

    /// Adds a file.
    pub(crate) fn add(&mut self, name: &str, bytes: impl Into<Vec<u8>>) {
        self.0.insert(name.to_owned(), bytes.into());
    }

    /// Takes a file away.
    pub(crate) fn remove(&mut self, name: &str) {
        self.0.remove(name).unwrap();
    }

    /// Changes the text of a file.
    pub(crate) fn text(&mut self, name: &str, change: impl FnOnce(String) -> String) {
        let bytes = self.0.get_mut(name).unwrap();
        *bytes = change(String::from_utf8(bytes.clone()).unwrap()).into_bytes();
    }

    /// Replaces the first `from` in the text of a file.
    pub(crate) fn replace(&mut self, name: &str, from: &str, to: &str) {
        self.text(name, |text| {
            assert!(text.contains(from), "no {from} in {name}");
            text.replacen(from, to, 1)
        });
    }

    /// Sets the value at a JSON pointer of `campaign.json`, as `/runs/0/axis`.
    pub(crate) fn set(&mut self, pointer: &str, value: Value) {
        self.json(|json| *json.pointer_mut(pointer).unwrap() = value);
    }

    /// Changes `campaign.json` as a document.
    pub(crate) fn json(&mut self, change: impl FnOnce(&mut Value)) {
        let bytes = self.0.get_mut("campaign.json").unwrap();
        let mut json = serde_json::from_slice(bytes).unwrap();
        change(&mut json);
        *bytes = serde_json::to_vec_pretty(&json).unwrap();
    }

    /// Changes `lengths.csv` as a table.
    pub(crate) fn table(&mut self, change: impl FnOnce(&mut Table)) {
        self.text("lengths.csv", |text| {
            let mut table = Table::parse(&text);
            change(&mut table);
            table.to_text()
        });
    }

    /// Puts a text into the cell of a line (the header is line 1) and column of `lengths.csv`.
    pub(crate) fn cell(&mut self, line: usize, column: &str, text: &str) {
        self.table(|table| {
            let place = table.place(column);
            table.rows[line - 2][place] = text.to_owned();
        });
    }

    /// Gives every cell of a column of `lengths.csv` a new text.
    pub(crate) fn column(&mut self, column: &str, new: impl Fn(&Row<'_>) -> String) {
        self.table(|table| {
            let place = table.place(column);
            for cells in &mut table.rows {
                let header = &table.header;
                cells[place] = new(&Row { header, cells });
            }
        });
    }

    /// Multiplies the numbers of a column of `lengths.csv`.
    pub(crate) fn scale(&mut self, column: &str, factor: f64) {
        self.column(column, |row| (row.number(column) * factor).to_string());
    }

    /// Removes the rows of `lengths.csv` that are not to be kept.
    pub(crate) fn keep(&mut self, is_kept: impl Fn(&Row<'_>) -> bool) {
        self.table(|table| {
            let header = &table.header;
            table.rows.retain(|cells| is_kept(&Row { header, cells }));
        });
    }

    /// Exchanges two names in those rows of `lengths.csv` where `is_exchanged`.
    pub(crate) fn exchange(
        &mut self,
        column: &str,
        names: [&str; 2],
        is_exchanged: impl Fn(&Row<'_>) -> bool,
    ) {
        self.column(column, |row| {
            let name = row.text(column);
            let other = match names.iter().position(|&n| n == name) {
                Some(place) if is_exchanged(row) => names[1 - place],
                _ => name,
            };
            other.to_owned()
        });
    }
}

impl Table {
    fn parse(text: &str) -> Self {
        let mut lines = text
            .lines()
            .map(|line| line.split(',').map(str::to_owned).collect());
        Self {
            header: lines.next().unwrap(),
            rows: lines.collect(),
        }
    }

    fn to_text(&self) -> String {
        let lines = std::iter::once(&self.header).chain(&self.rows);
        lines.map(|cells| cells.join(",") + "\n").collect()
    }

    fn place(&self, column: &str) -> usize {
        self.header.iter().position(|name| name == column).unwrap()
    }

    /// Adds a column with the same text in every row.
    pub(crate) fn add_column(&mut self, column: &str, text: &str) {
        self.header.push(column.to_owned());
        self.rows
            .iter_mut()
            .for_each(|row| row.push(text.to_owned()));
    }
}

impl Row<'_> {
    /// The cell of a column.
    pub(crate) fn text(&self, column: &str) -> &str {
        let place = self.header.iter().position(|name| name == column);
        &self.cells[place.unwrap()]
    }

    /// The number in a column.
    pub(crate) fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap()
    }

    /// Whether the columns hold these texts.
    pub(crate) fn is(&self, texts: &[(&str, &str)]) -> bool {
        texts
            .iter()
            .all(|&(column, text)| self.text(column) == text)
    }
}

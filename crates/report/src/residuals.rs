//! `residuals.csv`: what is left of each length, or of each coordinate of a point.

use std::path::Path;

use crate::Error;
use crate::input::read_text;

/// The residuals of all lengths or coordinates, in measuring order.
#[derive(Debug, Default)]
pub(crate) struct Residuals {
    /// Whether they are of coordinates.
    pub(crate) of_points: bool,
    /// Names of the stations, or of the coordinates, and of targets, runs and axes that rows point to.
    pub(crate) series: Vec<String>,
    pub(crate) targets: Vec<String>,
    pub(crate) runs: Vec<String>,
    pub(crate) axes: Vec<String>,
    pub(crate) rows: Vec<Row>,
    /// Positions of the axes, mm or degrees: as many for each row as there are axes.
    positions: Vec<f64>,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    /// Line of the file of lengths or points.
    pub(crate) line: usize,
    pub(crate) series: usize,
    pub(crate) target: usize,
    pub(crate) run: usize,
    pub(crate) time_s: f64,
    pub(crate) residual_um: f64,
    pub(crate) standardized: f64,
    /// `None` where the length was removed.
    pub(crate) redundancy: Option<f64>,
    pub(crate) used: bool,
}

/// Columns before and behind those of the axes.
const BEFORE: usize = 5;
const BEHIND: usize = 4;

impl Residuals {
    /// The table, if there is one.
    pub(crate) fn read(file: &Path) -> Result<Option<Self>, Error> {
        let Some(text) = read_text(file)? else {
            return Ok(None);
        };
        let parsed = Self::parse(&text);
        let named = |source| Error::NotResiduals {
            file: file.to_path_buf(),
            source,
        };
        parsed.map(Some).map_err(named)
    }

    fn parse(text: &str) -> Result<Self, csv::Error> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers()?;
        let axes = header
            .len()
            .checked_sub(BEFORE + BEHIND)
            .ok_or_else(too_few)?;
        let mut residuals = Self {
            of_points: header.get(1) == Some("coordinate"),
            axes: (0..axes).map(|k| header[BEFORE + k].to_owned()).collect(),
            ..Self::default()
        };
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record)? {
            let number = |k: usize| record[k].parse::<f64>().unwrap_or(f64::NAN);
            let row = Row {
                line: record[0].parse().unwrap_or_default(),
                series: index(&mut residuals.series, &record[1]),
                target: index(&mut residuals.targets, &record[2]),
                run: index(&mut residuals.runs, &record[3]),
                time_s: number(4),
                residual_um: number(BEFORE + axes),
                standardized: number(BEFORE + axes + 1),
                redundancy: record[BEFORE + axes + 2].parse().ok(),
                used: &record[BEFORE + axes + 3] == "1",
            };
            residuals.rows.push(row);
            let positions = (0..axes).map(|k| number(BEFORE + k));
            residuals.positions.extend(positions);
        }
        Ok(residuals)
    }

    pub(crate) fn rms_um(&self) -> f64 {
        let squares: f64 = self.rows.iter().map(|row| row.residual_um.powi(2)).sum();
        (squares / self.rows.len().max(1) as f64).sqrt()
    }

    /// Those of the lengths that were used.
    pub(crate) fn used(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.used)
    }

    pub(crate) fn positions(&self, row: usize) -> &[f64] {
        let axes = self.axes.len();
        self.positions
            .get(row * axes..(row + 1) * axes)
            .unwrap_or_default()
    }
}

fn too_few() -> csv::Error {
    std::io::Error::new(std::io::ErrorKind::InvalidData, "there are too few columns").into()
}

/// The place of a name among those met so far.
fn index(names: &mut Vec<String>, name: &str) -> usize {
    match names.iter().rposition(|known| known == name) {
        Some(known) => known,
        None => {
            names.push(name.to_owned());
            names.len() - 1
        }
    }
}

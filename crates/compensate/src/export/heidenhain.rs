//! `heidenhain`: HEIDENHAIN TNC, non-linear axis error compensation, as tables to be entered in the control's own table editor
//! (`X.com.csv` for `X.COM`, `config.cma.csv` for `CONFIG.CMA`).
//!
//! A `.COM` for each linear axis that moves, at most 256 points at equal distances, mm: `AXISPOS`, from the machine datum; a
//! column for each linear axis that is corrected, named as the axis, itself (positioning) and the others (straightness and
//! squareness on the lines through the point); `BACKLASH`, if the calibration kept the sides apart: positioning in the
//! negative direction, while the axis' own column is then that of the positive one. A line of the `.CMA` has the name of the
//! `.COM` under each axis that moves, and `*` under `ACTIVE`.
//!
//! Old tables ([`Request::onto`]), copied into the same columns, are contained in the new ones: the values of both at the
//! points of both, which must then have equal distances; those of the new one alone in the column of an axis that the targets did
//! not see move.
//!
//! Source: technical manual `MANUALplus` 620 (January 2012), 6.10.3, alone, so this is experimental. Neither there nor in the
//! pages that were found of those of TNC 306, 335, 407, 426, 430 and iTNC 530 is the sign of a value ([`TableSign`] is the
//! user's, taken for all columns), are the lines around the columns, what is added beyond the points (here the first and the
//! last value), or how a rotary axis with negative angles is entered (none gets a table). TNC 407 wants the "error curve", and
//! calls the linear error (MP720) positive if an axis goes too far; it and TNC 430 space points by 2ⁿ · 0.1 µm from a datum.
//! Per axis the linear or the non-linear compensation is active (TNC 430, iTNC 530).

use std::collections::BTreeMap;

use trueaxis_files::round;
use trueaxis_kinematics::AxisKind;

use crate::Error;
use crate::export::line::{Line, Sums, interpolate, spacing};
use crate::export::named_errors::wrong;
use crate::export::old_files::reach;
use crate::export::sides::Sides;
use crate::export::{
    Description, ExportedFile, OldFiles, Request, TableSign, Tables, check_points, csv, rising,
};

pub(super) const FORMAT: Description = Description {
    name: "heidenhain",
    text: "HEIDENHAIN TNC: columns of .COM and .CMA to be entered; wants --sign (experimental)",
    old_files: OldFiles::OfAxes {
        ending: ENDING,
        linear_alone: true,
        of_all: None,
        beside: &[ASSIGNMENT, README],
    },
    sides: Sides::Columns,
    is_experimental: true,
    tables,
};

const ENDING: &str = ".com.csv";

const ASSIGNMENT: &str = "config.cma.csv";

const README: &str = "README.txt";

const AXISPOS: &str = "AXISPOS";

const BACKLASH: &str = "BACKLASH";

const MOST_POINTS: usize = 256;

/// Decimals of mm; the control rounds to its own.
const DECIMALS: i32 = 7;

/// Positions this close are one, mm.
const SAME: f64 = 1e-6;

fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let sign = request.sign.ok_or(Error::NoSign {
        format: request.format.name(),
    })?;
    let asked = request.linear_axes()?;
    let axes = request.machine.machine().axes();
    let mut linear: Vec<usize> = (0..axes.len()).collect();
    linear.retain(|&axis| axes[axis].kind() == AxisKind::Linear);
    let names: Vec<&str> = linear.iter().map(|&axis| request.name(axis)).collect();
    let (mut files, mut lines, mut moving) = (Vec::new(), Vec::new(), Vec::new());
    let mut reached = Vec::new();
    for &axis in &linear {
        let name = request.name(axis);
        let file = format!("{name}{ENDING}");
        let old = request.onto.iter().find(|old| old.name == file);
        let old = old.map(|old| Com::read(old, &names)).transpose()?;
        if let Some(old) = &old {
            let ends = [old.positions[0], old.positions[old.positions.len() - 1]];
            reached.extend(reach(request, &file, axis, ends)?);
        }
        let mut new = None;
        if asked.contains(&axis) {
            let line = Line::new(request, axis)?;
            new = Some(Com::new(request, &line, &linear, sign));
            lines.push(line);
        }
        let table = match (new, old) {
            (Some(new), Some(mut old)) => {
                old.columns.retain(|column, _| {
                    let output = request.machine.machine().axis_index(column);
                    output.is_none_or(|output| request.is_seen(axis, output))
                });
                match old.columns.is_empty() {
                    true => new,
                    false => new.with(&old, name),
                }
            }
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => continue,
        };
        let what = || format!("axis {name}");
        check_points(request, what, table.positions.len(), MOST_POINTS)?;
        spacing(request, axis, &table.positions)?;
        files.push(ExportedFile::new(file, table.text()));
        moving.push(name);
    }
    let (axes_row, files_row) = (moving.join(","), moving.join(".com,"));
    let text = format!("ACTIVE,{axes_row}\n*,{files_row}.com\n");
    files.push(ExportedFile::new(ASSIGNMENT, text));
    let mut notes = notes(request, sign, linear.len() < axes.len());
    notes.extend(reached);
    let text = format!(
        "Experimental: the rule of the control is known in part, from one public manual.\n\
         Run one line at low feed, measure it, and only then trust the tables.\n\n- {}\n",
        notes.join("\n- ")
    );
    files.push(ExportedFile::new(README, text));
    Ok(Tables {
        files,
        notes,
        rule: Sums::new(request, lines).rule(),
    })
}

/// What must be known to enter the tables.
fn notes(request: &Request<'_>, sign: TableSign, has_rotary: bool) -> Vec<String> {
    let mut notes = vec![
        "enter the columns in the table editor of the control: the lines around them in a .COM or .CMA are in no manual \
         that was found, so these files cannot be loaded as they are"
            .to_owned(),
        format!(
            "--sign {}: {}, as you say; no manual that was found says it, nor that it is the same in the columns of the \
             other axes, as is taken here: try one of them, too",
            sign.name(),
            sign.description()
        ),
        "AXISPOS is from the machine datum; an axis' own column is for both directions or, beside BACKLASH, for the positive one, \
         BACKLASH for the negative one"
            .to_owned(),
        "leave the backlash parameters as they were while the machine was measured; a linear compensation of an axis (MP720) ends \
         when its table is switched on: if it was active, put it into an old table (--onto)"
            .to_owned(),
        request.origin(),
    ];
    if has_rotary {
        let rest = "rotary axes get no table: how negative angles are entered is in no manual that was found";
        notes.push(rest.to_owned());
    }
    notes
}

/// The columns of a `.COM` but the first, by their names, at rising positions; mm.
struct Com {
    positions: Vec<f64>,
    columns: BTreeMap<String, Vec<f64>>,
}

impl Com {
    fn new(request: &Request<'_>, line: &Line, linear: &[usize], sign: TableSign) -> Self {
        let apart = request.machine.keeps_sides_apart(line.axis);
        let factor = match sign {
            TableSign::Error => 1.0,
            TableSign::Correction => -1.0,
        };
        // With so much of the positive direction.
        let column = |of: usize, share: f64| -> Vec<f64> {
            let pairs = line.forward.iter().zip(&line.backward);
            pairs
                .map(|(f, b)| factor * (share * f[of] + (1.0 - share) * b[of]))
                .collect()
        };
        let of_axes = linear.iter().map(|&of| {
            let share = if apart && of == line.axis { 1.0 } else { 0.5 };
            (request.name(of).to_owned(), column(of, share))
        });
        let backlash = apart.then(|| (BACKLASH.to_owned(), column(line.axis, 0.0)));
        Self {
            positions: line.positions.clone(),
            columns: of_axes.chain(backlash).collect(),
        }
    }

    fn read(file: &ExportedFile, names: &[&str]) -> Result<Self, Error> {
        let header = csv::header(file);
        let is_known = |name: &&str| {
            let is_one = header.iter().filter(|other| *other == name).count() == 1;
            is_one && (*name == BACKLASH || names.contains(name))
        };
        if header[0] != AXISPOS || !header[1..].iter().all(is_known) {
            let expected = format!("{AXISPOS}, then once {BACKLASH} or {}", names.join(", "));
            return Err(wrong(&file.name, 1, &header.join(","), expected));
        }
        let rows = csv::rows(file, header.len())?;
        let falls = rows.windows(2).position(|pair| pair[1][0] <= pair[0][0]);
        if rows.is_empty() || falls.is_some() {
            let line = falls.map_or(1, |k| k + 3);
            return Err(wrong(&file.name, line, AXISPOS, "positions that rise"));
        }
        let column = |c: usize| rows.iter().map(|row| row[c]).collect::<Vec<f64>>();
        let columns = (1..header.len()).map(|c| (header[c].to_owned(), column(c)));
        Ok(Self {
            positions: column(0),
            columns: columns.collect(),
        })
    }

    /// A column at a position; without `BACKLASH` the own one is for both directions.
    fn at(&self, name: &str, own: &str, position: f64) -> f64 {
        let both = || (name == BACKLASH).then(|| self.columns.get(own)).flatten();
        let values = self.columns.get(name).or_else(both);
        values.map_or(0.0, |values| {
            interpolate(&self.positions, |k| values[k], position)
        })
    }

    /// The sum; `own` is the axis that moves.
    fn with(&self, other: &Self, own: &str) -> Self {
        let positions = rising(self.positions.iter().chain(&other.positions).copied(), SAME);
        let column = |name: &String| {
            let sum = |&q: &f64| self.at(name, own, q) + other.at(name, own, q);
            (name.clone(), positions.iter().map(sum).collect())
        };
        let names = self.columns.keys().chain(other.columns.keys());
        Self {
            columns: names.map(column).collect(),
            positions,
        }
    }

    fn text(&self) -> String {
        let names = self.columns.keys().map(String::as_str);
        let header: Vec<&str> = std::iter::once(AXISPOS).chain(names).collect();
        let mut text = format!("{}\n", header.join(","));
        for (k, &position) in self.positions.iter().enumerate() {
            let cells = self.columns.values().map(|values| values[k]);
            let cells = std::iter::once(position).chain(cells);
            let cells: Vec<String> = cells.map(|x| round(x, DECIMALS).to_string()).collect();
            text.push_str(&cells.join(","));
            text.push('\n');
        }
        text
    }
}

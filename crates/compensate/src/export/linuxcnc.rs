//! `linuxcnc`: a compensation file for each axis, and the matrix of `matrixkins`.
//!
//! `COMP_FILE` with `COMP_FILE_TYPE = 0`: lines `nominal forward reverse`, the position commanded and the actual ones
//! reached in positive and in negative direction, rising; the control adds `nominal - actual` of the side, linear between
//! the lines. Its reader ends in silence at the first line that is not three numbers, so there are neither header nor
//! comments, and it takes 256 lines. It replaces `BACKLASH`.
//!
//! `matrixkins` (three linear axes X, Y, Z): `joint = C axis`; here ones on the diagonal, because the files hold the
//! scale, and off it the mean slopes of the lines through the point.
//!
//! A file that was active while the machine was measured ([`Request::onto`]) is contained in the new one: at the points of both,
//! the deviations of both.
//!
//! Sources: `usrmotLoadComp` in `src/emc/motion/usrmotintf.cc`, `src/hal/components/matrixkins.comp`, and the chapter
//! "INI Configuration" of the manual.

use std::fmt::Write;

use crate::Error;
use crate::export::line::{Line, interpolate};
use crate::export::named_errors::wrong;
use crate::export::skew::Skew;
use crate::export::{Description, ExportedFile, OldFiles, Request, Rule, Tables, rising, round};

pub(super) const FORMAT: Description = Description {
    name: "linuxcnc",
    text: "LinuxCNC: a COMP_FILE for each axis (type 0), and the matrix of matrixkins",
    old_files: OldFiles::OfEachAxis(".comp"),
    tables,
};

const MOST_LINES: usize = 256;

/// Positions this close are one, mm or degrees.
const SAME: f64 = 1e-6;

fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let mut files = Vec::new();
    let mut notes = vec![
        "X.comp: nominal, actual forward, actual reverse; [JOINT_n] COMP_FILE = X.comp, COMP_FILE_TYPE = 0; remove BACKLASH"
            .to_owned(),
        request.origin(),
    ];
    let mut lines = Vec::new();
    for axis in request.axes()? {
        let line = Line::new(request, axis, FORMAT.name)?;
        let name = format!("{}.comp", request.name(axis));
        let old = request.onto.iter().find(|old| old.name == name);
        let old = old.map_or_else(|| Ok(Vec::new()), triplets)?;
        let triplets = summed(request, &line, &old);
        if triplets.len() > MOST_LINES {
            return Err(Error::TooManyPoints {
                what: format!("axis {}", request.name(axis)),
                format: FORMAT.name,
                points: triplets.len(),
                most: MOST_LINES,
            });
        }
        let mut text = String::new();
        for triplet in triplets {
            let [nominal, forward, backward] = triplet.map(|x| round(x, 7));
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{nominal} {forward} {backward}");
        }
        files.push(ExportedFile { name, text });
        lines.push(line);
    }
    // The matrix has no use for a part of the axes.
    let skew = request
        .axis
        .is_none()
        .then(|| Skew::new(request, FORMAT.name).ok())
        .flatten();
    if let Some(skew) = &skew {
        files.push(ExportedFile {
            name: "matrixkins.hal".to_owned(),
            text: matrix(request, skew),
        });
        notes.push("matrixkins.hal: [KINS] KINEMATICS = matrixkins, then source this file; add to it what an old one has off its diagonal".to_owned());
    }
    Ok(Tables {
        files,
        notes,
        is_experimental: false,
        rule: Box::new(Joints { lines, skew }),
    })
}

/// `nominal forward reverse` of an old file, rising.
fn triplets(old: &ExportedFile) -> Result<Vec<[f64; 3]>, Error> {
    let mut all: Vec<[f64; 3]> = Vec::new();
    for (number, line) in old.text.lines().enumerate() {
        let cells: Vec<f64> = line
            .split_whitespace()
            .map_while(|cell| cell.parse().ok())
            .filter(|x: &f64| x.is_finite())
            .collect();
        let &[nominal, forward, backward] = cells.as_slice() else {
            return Err(wrong(
                &old.name,
                number + 1,
                line,
                "three numbers; the control reads no further",
            ));
        };
        if all.last().is_some_and(|last| nominal <= last[0]) {
            let expected = "a position above the one before";
            return Err(wrong(&old.name, number + 1, line, expected));
        }
        all.push([nominal, forward, backward]);
    }
    Ok(all)
}

/// What an axis reaches, with the old table: the control adds what both subtract. mm or degrees.
fn summed(request: &Request<'_>, line: &Line, old: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let axis = line.axis;
    let own = line.positions.iter().map(|&q| request.in_file(axis, q));
    let own: Vec<f64> = own.collect();
    let of_old: Vec<f64> = old.iter().map(|triplet| triplet[0]).collect();
    let nominal = rising(own.iter().chain(&of_old).copied(), SAME);
    let deviation = |side: usize, position: f64| {
        let values = [&line.forward, &line.backward][side];
        let new = interpolate(&own, |k| request.in_file(axis, values[k][axis]), position);
        if old.is_empty() {
            return new;
        }
        new + interpolate(&of_old, |k| old[k][side + 1] - old[k][0], position)
    };
    let at = |&q: &f64| [q, q + deviation(0, q), q + deviation(1, q)];
    nominal.iter().map(at).collect()
}

fn matrix(request: &Request<'_>, skew: &Skew) -> String {
    let mut text = format!("# {}\n", request.origin());
    for (row, letter) in ["x", "y", "z"].into_iter().enumerate() {
        for (column, other) in ["x", "y", "z"].into_iter().enumerate() {
            let value = if row == column {
                1.0
            } else {
                -skew.slopes[row][column]
            };
            let _ = writeln!(
                text,
                "setp matrixkins.C_{letter}{other} {}",
                round(value, 10)
            );
        }
    }
    text
}

struct Joints {
    lines: Vec<Line>,
    skew: Option<Skew>,
}

impl Rule for Joints {
    fn added(&self, commanded: &[f64]) -> Result<Vec<f64>, Error> {
        let mut added = vec![0.0; commanded.len()];
        if let Some(skew) = &self.skew {
            for (row, &axis) in skew.axes.iter().enumerate() {
                for (column, &other) in skew.axes.iter().enumerate().filter(|(c, _)| *c != row) {
                    added[axis] -= skew.slopes[row][column] * commanded[other];
                }
            }
        }
        for line in &self.lines {
            let joint = commanded[line.axis] + added[line.axis];
            added[line.axis] -= line.at(line.axis, joint);
        }
        Ok(added)
    }
}

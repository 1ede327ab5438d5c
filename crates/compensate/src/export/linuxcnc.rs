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
//! Sources: `usrmotLoadComp` in `src/emc/motion/usrmotintf.cc`, `src/hal/components/matrixkins.comp`, and the chapter
//! "INI Configuration" of the manual.

use std::fmt::Write;

use crate::Error;
use crate::export::line::Line;
use crate::export::skew::Skew;
use crate::export::{ExportedFile, Request, Rule, Tables, round};

const FORMAT: &str = "linuxcnc";

const MOST_LINES: usize = 256;

pub(crate) fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let mut files = Vec::new();
    let mut notes = vec![
        "X.comp: nominal, actual forward, actual reverse; [JOINT_n] COMP_FILE = X.comp, COMP_FILE_TYPE = 0; remove BACKLASH"
            .to_owned(),
        request.origin(),
    ];
    let mut lines = Vec::new();
    for axis in request.axes()? {
        let line = Line::new(request, axis, FORMAT)?;
        let name = request.name(axis);
        if line.positions.len() > MOST_LINES {
            return Err(Error::TooManyPoints {
                what: format!("axis {name}"),
                format: FORMAT,
                points: line.positions.len(),
                most: MOST_LINES,
            });
        }
        let mut text = String::new();
        for (k, &position) in line.positions.iter().enumerate() {
            let actual = |deviation: f64| round(request.in_file(axis, position + deviation), 7);
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "{} {} {}",
                request.in_file(axis, position),
                actual(line.forward[k][axis]),
                actual(line.backward[k][axis])
            );
        }
        files.push(ExportedFile {
            name: format!("{name}.comp"),
            text,
        });
        lines.push(line);
    }
    // The matrix has no use for a part of the axes.
    let skew = request
        .axis
        .is_none()
        .then(|| Skew::new(request, FORMAT).ok())
        .flatten();
    if let Some(skew) = &skew {
        files.push(ExportedFile {
            name: "matrixkins.hal".to_owned(),
            text: matrix(request, skew),
        });
        notes.push(
            "matrixkins.hal: [KINS] KINEMATICS = matrixkins, then source this file".to_owned(),
        );
    }
    Ok(Tables {
        files,
        notes,
        is_experimental: false,
        rule: Box::new(Joints { lines, skew }),
    })
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

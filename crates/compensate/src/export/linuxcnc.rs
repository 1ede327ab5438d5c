//! `linuxcnc`: a compensation file for each axis, and the matrix of `matrixkins`.
//!
//! `COMP_FILE` with `COMP_FILE_TYPE = 0`: lines `nominal forward reverse`, the position commanded and the actual ones
//! reached in positive and in negative direction, rising, in the units of the machine (here mm and degrees); the control adds
//! `nominal - actual` of the side, linear between the lines, the first and the last value beyond them. Its reader ends in silence at the first line that is not three numbers, so there are neither header nor
//! comments, and it takes 256 lines. It replaces `BACKLASH`.
//!
//! `matrixkins` (three linear axes X, Y, Z): `joint = C axis`; here ones on the diagonal, because the files hold the
//! scale, and off it the mean slopes of the lines through the point.
//!
//! Files that were active while the machine was measured ([`Request::onto`]) are contained in the new ones: at the points of
//! both, the deviations of both; the product of both matrices, the old one without the cells between branches.
//!
//! Sources: `usrmotLoadComp` in `src/emc/motion/usrmotintf.cc`, `command.c` and `control.c` beside it,
//! `src/hal/components/matrixkins.comp`, and the chapter "INI Configuration" of the manual.

mod matrix;

use std::fmt::Write;

use nalgebra::Matrix3;
use trueaxis_files::round;

use crate::Error;
use crate::export::line::{Line, interpolate};
use crate::export::named_errors::wrong;
use crate::export::old_files::reach;
use crate::export::sides::Sides;
use crate::export::skew::Skew;
use crate::export::{Description, ExportedFile, OldFiles, Request, Tables, check_points, rising};

pub(super) const FORMAT: Description = Description {
    name: "linuxcnc",
    text: "LinuxCNC: a COMP_FILE for each axis (type 0), and the matrix of matrixkins",
    old_files: OldFiles::OfAxes {
        ending: ENDING,
        linear_alone: false,
        of_all: Some(matrix::FILE),
        beside: &[],
    },
    sides: Sides::Columns,
    is_experimental: false,
    tables,
};

const ENDING: &str = ".comp";

const MOST_LINES: usize = 256;

/// Positions this close are one, mm or degrees.
const SAME: f64 = 1e-6;

/// No machine has such deviations: what is beyond is no actual position, mm or degrees.
const MOST_DEVIATION: f64 = 5.0;

fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let mut files = Vec::new();
    let mut notes = vec![
        "X.comp: nominal, actual forward, actual reverse; [JOINT_n] COMP_FILE = X.comp, COMP_FILE_TYPE = 0; remove BACKLASH; \
         all files are in mm and degrees, as [TRAJ] LINEAR_UNITS = mm"
            .to_owned(),
        request.origin(),
    ];
    let asked = request.axes()?;
    let old = |name: &str| request.onto.iter().find(|old| old.name == name);
    let mut lines = Vec::new();
    for axis in 0..request.machine.machine().axes().len() {
        let name = format!("{}{ENDING}", request.name(axis));
        let old = old(&name).map(triplets).transpose()?;
        if let Some(old) = &old {
            let ends = [old[0][0], old[old.len() - 1][0]];
            notes.extend(reach(request, &name, axis, ends)?);
        }
        let is_asked = asked.contains(&axis);
        let new = is_asked.then(|| Line::alone(request, axis));
        let new = new.transpose()?;
        let triplets = match (&new, old) {
            (Some(line), old) => summed(request, line, &old.unwrap_or_default()),
            // What is there for other axes stays.
            (None, Some(old)) => old,
            (None, None) => continue,
        };
        let what = || format!("axis {}", request.name(axis));
        check_points(request, what, triplets.len(), MOST_LINES)?;
        let mut text = String::new();
        for triplet in triplets {
            let [nominal, forward, backward] = triplet.map(|x| round(x, 7));
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{nominal} {forward} {backward}");
        }
        files.push(ExportedFile { name, text });
        lines.extend(new);
    }
    let skew = Skew::new(request);
    // Who asks for one axis alone wants no squareness.
    if let (Err(error), None) = (&skew, request.axis) {
        notes.push(format!("no squareness: {error}"));
    }
    let skew = skew.ok();
    let old = old(matrix::FILE).map(matrix::read).transpose()?;
    let joined = match (old, &skew) {
        (Some(old), Some(skew)) => {
            // Only the cells that the targets saw.
            let cell = |row: usize, column: usize| match request
                .is_seen(skew.axes[column], skew.axes[row])
            {
                true => old[(row, column)],
                false => 0.0,
            };
            Some(Matrix3::from_fn(cell) * matrix::of_skew(skew))
        }
        (old, skew) => old.or(skew.as_ref().map(matrix::of_skew)),
    };
    if let Some(joined) = joined {
        let text = matrix::text(&request.origin(), &joined);
        files.push(ExportedFile::new(matrix::FILE, text));
        notes.push(format!(
            "{}: [KINS] KINEMATICS = matrixkins, then source this file; if a matrix was active while the machine was measured, give \
             its file with --onto",
            matrix::FILE
        ));
    }
    Ok(Tables {
        files,
        notes,
        rule: Box::new(move |commanded| Ok(added(&lines, skew.as_ref(), commanded))),
    })
}

/// `nominal forward reverse` of an old file, rising.
fn triplets(old: &ExportedFile) -> Result<Vec<[f64; 3]>, Error> {
    let mut all: Vec<[f64; 3]> = Vec::new();
    for (number, line) in (1..).zip(old.text.lines()) {
        let refused = |expected: &str| wrong(&old.name, number, line, expected);
        let cells: Vec<f64> = line
            .split_whitespace()
            .map_while(|cell| cell.parse().ok().filter(|x: &f64| x.is_finite()))
            .collect();
        let &[nominal, forward, backward] = cells.as_slice() else {
            return Err(refused("three numbers; the control reads no further"));
        };
        if all.last().is_some_and(|last| nominal <= last[0]) {
            return Err(refused("a position above the one before"));
        }
        let largest = (forward - nominal).abs().max((backward - nominal).abs());
        if largest > MOST_DEVIATION {
            return Err(refused(
                "actual positions behind the nominal one, as COMP_FILE_TYPE = 0 has them (a file of type 1 has differences)",
            ));
        }
        all.push([nominal, forward, backward]);
    }
    match all.is_empty() {
        true => Err(wrong(
            &old.name,
            1,
            "no lines",
            "position, forward, reverse in each line",
        )),
        false => Ok(all),
    }
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

/// What the control adds: the matrix takes the mean slopes away, the files what is left of each joint.
fn added(lines: &[Line], skew: Option<&Skew>, commanded: &[f64]) -> Vec<f64> {
    let mut added = vec![0.0; commanded.len()];
    if let Some(skew) = skew {
        for (row, &axis) in skew.axes.iter().enumerate() {
            for (column, &other) in skew.axes.iter().enumerate().filter(|(c, _)| *c != row) {
                added[axis] -= skew.slopes[row][column] * commanded[other];
            }
        }
    }
    for line in lines {
        let joint = commanded[line.axis] + added[line.axis];
        added[line.axis] -= line.at(line.axis, joint);
    }
    added
}

//! The matrix of `matrixkins`, as HAL lines: `joint = C axis`.

use std::fmt::Write;

use nalgebra::Matrix3;
use trueaxis_files::round;

use crate::Error;
use crate::export::ExportedFile;
use crate::export::named_errors::wrong;
use crate::export::skew::Skew;

pub(super) const FILE: &str = "matrixkins.hal";

const LETTERS: [&str; 3] = ["x", "y", "z"];

const PIN: &str = "matrixkins.C_";

/// Cells farther than this from those of the unit matrix are of another kind of machine: mm per mm.
const MOST: f64 = 0.1;

/// Ones on the diagonal, because the files of the axes hold the scale, and off it what takes the mean slopes away.
pub(super) fn of_skew(skew: &Skew) -> Matrix3<f64> {
    Matrix3::from_fn(|row, column| match row == column {
        true => 1.0,
        false => -skew.slopes[row][column],
    })
}

pub(super) fn text(origin: &str, matrix: &Matrix3<f64>) -> String {
    let mut text = format!("# {origin}\n");
    for (row, letter) in LETTERS.into_iter().enumerate() {
        for (column, other) in LETTERS.into_iter().enumerate() {
            let value = round(matrix[(row, column)], 10);
            // Writing to a String cannot fail.
            let _ = writeln!(text, "setp {PIN}{letter}{other} {value}");
        }
    }
    text
}

/// An old one; cells that are not set are those of the unit matrix, as in the component.
pub(super) fn read(file: &ExportedFile) -> Result<Matrix3<f64>, Error> {
    let mut matrix = Matrix3::identity();
    let mut is_set = [[false; 3]; 3];
    let mut last = 1;
    for (number, line) in (1..).zip(file.text.lines()) {
        let content = line.split('#').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        last = number;
        let refused = |expected: &str| wrong(&file.name, number, line, expected);
        let words: Vec<&str> = content.split_whitespace().collect();
        let cell = match words.as_slice() {
            &["setp", pin, value] => cell_of(pin).zip(value.parse().ok()),
            _ => None,
        };
        let ((row, column), value): (_, f64) =
            cell.ok_or_else(|| refused("a cell of the matrix, as `setp matrixkins.C_xy 0.0001`"))?;
        if std::mem::replace(&mut is_set[row][column], true) {
            return Err(refused("each cell once"));
        }
        let unit = f64::from(u8::from(row == column));
        // What is not a number is not near either.
        let is_near = (value - unit).abs() <= MOST;
        if !is_near {
            return Err(refused("a matrix near that of a machine without errors"));
        }
        matrix[(row, column)] = value;
    }
    match is_set.concat().contains(&true) {
        true => Ok(matrix),
        false => Err(wrong(
            &file.name,
            last,
            "no cell",
            "`setp matrixkins.C_xx 1` and so on",
        )),
    }
}

fn cell_of(pin: &str) -> Option<(usize, usize)> {
    let name = pin.strip_prefix(PIN)?;
    let place = |letter: &str| LETTERS.iter().position(|l| *l == letter);
    name.split_at_checked(1)
        .and_then(|(row, column)| place(row).zip(place(column)))
}

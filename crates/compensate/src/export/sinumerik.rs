//! `sinumerik`: Siemens SINUMERIK 840D and 828D, leadscrew error compensation (`$AA_ENC_COMP`) of each axis, and sag
//! compensation (`$AN_CEC`) of each linear axis by the position of each other one: straightness and squareness of the lines
//! through the point.
//!
//! Tables of equal spacing, linear between the points, the first and the last value beyond them. A positive value of
//! `$AA_ENC_COMP` makes the axis move in the negative direction, so the value is the deviation, actual minus commanded;
//! `$AN_CEC` is written with the same sign.
//!
//! Tables that were active while the machine was measured ([`Request::onto`]) are contained in the new ones: what is for the same
//! axes is added up at the points of both, others stay. `$AN_CEC_MULT_BY_TABLE`, which could make an angle times a lever,
//! stays 0: its product is added to the compensation value, and whether the two factors, of which one is the lever, are added
//! besides is in none of the pages that were found.
//!
//! Sources: "Function Manual, Extended Functions, K3: Compensations" (840D sl, 828D), "Function Manual" (808D); the sign of
//! `$AN_CEC` is in none of the pages that were found, so these tables are experimental: `$SN_CEC_TABLE_WEIGHT` turns them.

mod read;
mod table;

use std::fmt::Write;

use trueaxis_kinematics::AxisKind;

use crate::Error;
use crate::export::line::{Line, Sums};
use crate::export::sinumerik::table::Table;
use crate::export::{Description, ExportedFile, OldFiles, Request, Tables, round};

pub(super) const FORMAT: Description = Description {
    name: "sinumerik",
    text: "Siemens SINUMERIK: $AA_ENC_COMP and $AN_CEC (experimental)",
    old_files: OldFiles::Named(&["AX_EEC.INI", "NC_CEC.INI"]),
    tables,
};

/// Decimals of mm and degrees.
const DECIMALS: i32 = 7;

fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let axes = request.machine.machine().axes();
    let mut notes = vec![
        "values are actual minus commanded; a positive one moves the axis in the negative direction".to_owned(),
        "the sign of $AN_CEC is not in the pages that were found: run one line after activation; \
         $SN_CEC_TABLE_WEIGHT = -1 turns a table"
            .to_owned(),
    ];
    let mut lines = Vec::new();
    let mut tables = Vec::new();
    for axis in request.axes()? {
        let line = Line::new(request, axis, FORMAT.name)?;
        let step = line.spacing(request, FORMAT.name)?;
        let others = (0..axes.len()).filter(|&other| {
            // Straightness of rotary axes is no function of a position alone.
            other != axis
                && [axis, other]
                    .iter()
                    .all(|&i| axes[i].kind() == AxisKind::Linear)
        });
        for output in std::iter::once(axis).chain(others) {
            let values = (0..line.positions.len()).map(|k| value(request, &line, output, k));
            tables.push(Table {
                is_encoder: output == axis,
                input: axis,
                output,
                min: request.in_file(axis, line.positions[0]),
                step: request.in_file(axis, step),
                values: values.collect(),
            });
        }
        notes.extend(lost_motion(request, &line));
        lines.push(line);
    }
    for file in request.onto {
        for old in read::read(file, request.machine.machine())? {
            match tables.iter_mut().find(|new| new.is_like(&old)) {
                Some(new) => *new = new.with(&old, request.name(old.input), FORMAT.name)?,
                None => tables.push(old),
            }
        }
    }
    let [encoder, cross]: [Vec<&Table>; 2] =
        [true, false].map(|is| tables.iter().filter(|t| t.is_encoder == is).collect());
    for table in &encoder {
        notes.push(format!(
            "AX{} is {}: $MA_MM_ENC_COMP_MAX_POINTS at least {}",
            table.input + 1,
            request.name(table.input),
            table.values.len()
        ));
    }
    let mut files = vec![ExportedFile {
        name: "AX_EEC.INI".to_owned(),
        text: text("%_N_AX_EEC_INI", request, &encoder),
    }];
    if !cross.is_empty() {
        files.push(ExportedFile {
            name: "NC_CEC.INI".to_owned(),
            text: text("%_N_NC_CEC_INI", request, &cross),
        });
        notes.push(format!(
            "{} sag compensation tables; $MN_MM_CEC_MAX_POINTS for each, $MA_CEC_ENABLE, $SN_CEC_TABLE_ENABLE",
            cross.len()
        ));
    }
    notes.push(request.origin());
    Ok(Tables {
        files,
        notes,
        is_experimental: true,
        rule: Box::new(Sums::new(request, lines)),
    })
}

/// The file of some tables.
fn text(name: &str, request: &Request<'_>, tables: &[&Table]) -> String {
    let mut text = format!("{name}\n; {}\nCHANDATA(1)\n", request.origin());
    for (number, table) in tables.iter().enumerate() {
        let (of, by) = (request.name(table.output), request.name(table.input));
        // Writing to a String cannot fail.
        let _ = match table.is_encoder {
            true => writeln!(text, "; {of}"),
            false => writeln!(text, "; {of} by {by}"),
        };
        table.write(&mut text, number);
    }
    text.push_str("M17\n");
    text
}

/// The mean of both sides of approach, mm or degrees.
fn value(request: &Request<'_>, line: &Line, of: usize, k: usize) -> f64 {
    request.in_file(of, 0.5 * (line.forward[k][of] + line.backward[k][of]))
}

fn lost_motion(request: &Request<'_>, line: &Line) -> Option<String> {
    let own = request.machine.keeps_sides_apart(line.axis);
    own.then(|| {
        // Positive where the encoder leads the machine: forward it stops short.
        let backlash = round(request.in_file(line.axis, -line.reversal()), DECIMALS);
        let (name, unit) = (request.name(line.axis), request.unit(line.axis));
        format!("{name}: $MA_BACKLASH = {backlash} {unit}")
    })
}

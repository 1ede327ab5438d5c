//! `sinumerik`: Siemens SINUMERIK 840D and 828D, leadscrew error compensation (`$AA_ENC_COMP`) of each axis, and sag
//! compensation (`$AN_CEC`) of each linear axis by the position of each other one: straightness and squareness of the lines
//! through the point.
//!
//! Tables of equal spacing, linear between the points, the first and the last value beyond them. A positive value of
//! `$AA_ENC_COMP` makes the axis move in the negative direction, so the value is the deviation, actual minus commanded;
//! `$AN_CEC` is written with the same sign.
//!
//! With [`Request::levers`] the angles of the linear axes act on the positions of the others: products of two tables
//! (`levers.rs`).
//!
//! Tables that were active while the machine was measured ([`Request::onto`]) are contained in the new ones: what is for the same
//! axes is added up at the points of both if the targets saw what the old one did, and else is that of the new one alone; products
//! are zero along the lines that are measured. Other tables stay, products with both of their tables.
//!
//! Sources: "Function Manual, Extended Functions, K3: Compensations" (840D sl, 828D; 03/2013, pages 245, 248, 249, 252), "Function
//! Manual" (808D, 01/2017, page 106; 802D sl, 11/2012). The sign of `$AN_CEC` is in none of the pages that were found, and what
//! points to it contradicts itself (an "additional setpoint", page 250; a public program writes measured minus commanded), so
//! these tables are experimental: `$SN_CEC_TABLE_WEIGHT` turns them.

mod levers;
mod read;
mod sag;
mod table;
mod trial;

use std::fmt::Write;

use trueaxis_files::round;
use trueaxis_kinematics::AxisKind;

use crate::Error;
use crate::export::line::{Line, Sums, spacing};
use crate::export::old_files::reach;
use crate::export::sides::Sides;
use crate::export::sinumerik::levers::Lever;
use crate::export::sinumerik::sag::{Placed, Sag};
use crate::export::sinumerik::table::{Kind, Table};
use crate::export::{Description, EXPERIMENTAL, ExportedFile, OldFiles, Request, Tables};

pub(super) const FORMAT: Description = Description {
    name: "sinumerik",
    text: "Siemens SINUMERIK: $AA_ENC_COMP and $AN_CEC (experimental)",
    old_files: OldFiles::Named(&["AX_EEC.INI", "NC_CEC.INI"]),
    sides: Sides::Parameter,
    is_experimental: true,
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
        "mm and degrees: load them into a control that is set to metric; $AA_ENC_COMP[0, ...] is for measuring system 1".to_owned(),
    ];
    let mut lines = Vec::new();
    let mut sag = Sag::default();
    for axis in request.axes()? {
        let line = Line::new(request, axis)?;
        let step = spacing(request, line.axis, &line.positions)?;
        let others = (0..axes.len()).filter(|&other| {
            // Straightness of rotary axes is no function of a position alone.
            other != axis
                && [axis, other]
                    .iter()
                    .all(|&i| axes[i].kind() == AxisKind::Linear)
        });
        for output in std::iter::once(axis).chain(others) {
            let values = 0..line.positions.len();
            let values = values.map(|k| request.in_file(output, line.mean(output, k)));
            sag.tables.push(Table {
                kind: match output == axis {
                    true => Kind::Encoder,
                    false => Kind::Sag,
                },
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
    let levers = match request.levers {
        true => Lever::all(request, &lines)?,
        false => Vec::new(),
    };
    sag.products = levers.iter().map(|lever| lever.product(request)).collect();
    let trial = sag.products.first();
    let trial = trial.map(|product| trial::file(request, product));
    let new = sag.clone();
    for file in request.onto {
        let old = read::read(file, request.machine.machine())?;
        for table in old.tables {
            let ends = [table.min, table.max()];
            notes.extend(reach(request, &file.name, table.input, ends)?);
            if !new.replaces(&table, request) {
                sag.add(table, request)?;
            }
        }
        for product in old.products {
            if !new.replaces_product(&product, request)? {
                sag.products.push(product);
            }
        }
    }
    let [encoder, cross] = sag.numbered(request)?;
    for Placed { table, .. } in &encoder {
        notes.push(format!(
            "AX{} is {}: $MA_MM_ENC_COMP_MAX_POINTS at least {}",
            table.input + 1,
            request.name(table.input),
            table.values.len()
        ));
    }
    let encoder_text = text("%_N_AX_EEC_INI", request, &encoder);
    let mut files = vec![ExportedFile::new("AX_EEC.INI", encoder_text)];
    if !cross.is_empty() {
        let cross_text = text("%_N_NC_CEC_INI", request, &cross);
        files.push(ExportedFile::new("NC_CEC.INI", cross_text));
        notes.push(format!(
            "{} sag compensation tables; $MN_MM_CEC_MAX_POINTS for each, $MA_CEC_ENABLE, $SN_CEC_TABLE_ENABLE; a 828D has eight tables \
             of 200 points",
            cross.len()
        ));
    }
    if request.levers && axes.iter().any(|axis| axis.kind() == AxisKind::Rotary) {
        let rest = "levers: right with the rotary axes at home; what their errors do beside is in no table";
        notes.push(rest.to_owned());
    }
    if let Some(trial) = trial {
        notes.push(format!(
            "levers: that a table behind $AN_CEC_MULT_BY_TABLE does not act by itself follows from one example of the manual; load \
             {} first and read off what it says, for a lever of hundreds of mm that acts by itself would move the axis by all of it",
            trial.name
        ));
        files.push(trial);
    }
    notes.push(request.origin());
    let lines = Sums::new(request, lines);
    Ok(Tables {
        files,
        notes,
        rule: Box::new(move |commanded| {
            let mut added = lines.added(commanded);
            for lever in &levers {
                added[lever.output] -= lever.at(commanded);
            }
            Ok(added)
        }),
    })
}

/// The file of some tables.
fn text(name: &str, request: &Request<'_>, tables: &[Placed<'_>]) -> String {
    let mut text = format!(
        "{name}\n; {EXPERIMENTAL}\n; {}\nCHANDATA(1)\n",
        request.origin()
    );
    for (number, placed) in tables.iter().enumerate() {
        let (table, multiplied_by) = (placed.table, placed.multiplied_by);
        let (of, by) = (request.name(table.output), request.name(table.input));
        // Writing to a String cannot fail.
        let _ = match (table.kind, multiplied_by) {
            (Kind::Encoder, _) => writeln!(text, "; {of}"),
            (Kind::Sag, _) => writeln!(text, "; {of} by {by}"),
            (Kind::Factor, Some(lever)) => {
                let along = request.name(tables[lever].table.input);
                writeln!(
                    text,
                    "; {of} by {by}, for each mm of {along}: times table {}",
                    lever + 1
                )
            }
            (Kind::Factor, None) => writeln!(
                text,
                "; {by} as a lever for {of}: a factor, no compensation"
            ),
        };
        table.write(&mut text, number, multiplied_by);
    }
    text.push_str("M17\n");
    text
}

fn lost_motion(request: &Request<'_>, line: &Line) -> Option<String> {
    let own = request.machine.keeps_sides_apart(line.axis);
    own.then(|| {
        let (name, unit) = (request.name(line.axis), request.unit(line.axis));
        match line.known_lost_motion(request) {
            Some(lost) => format!(
                "{name}: $MA_BACKLASH: {} {unit} more than while the machine was measured",
                round(lost, DECIMALS)
            ),
            None => format!("{name}: lost motion is less than its U: leave $MA_BACKLASH as it is"),
        }
    })
}

//! `sinumerik`: Siemens SINUMERIK 840D and 828D, leadscrew error compensation (`$AA_ENC_COMP`) of each axis, and sag
//! compensation (`$AN_CEC`) of each linear axis by the position of each other one: straightness and squareness of the lines
//! through the point.
//!
//! Tables of equal spacing, linear between the points, the first and the last value beyond them. A positive value of
//! `$AA_ENC_COMP` makes the axis move in the negative direction, so the value is the deviation, actual minus commanded;
//! `$AN_CEC` is written with the same sign.
//!
//! Sources: "Function Manual, Extended Functions, K3: Compensations" (840D sl, 828D), "Function Manual" (808D); the sign of
//! `$AN_CEC` is in none of the pages that were found, so these tables are experimental: `$SN_CEC_TABLE_WEIGHT` turns them.

use std::fmt::Write;

use trueaxis_kinematics::AxisKind;

use crate::Error;
use crate::export::line::Line;
use crate::export::{ExportedFile, Request, Rule, Tables, round};

const FORMAT: &str = "sinumerik";

/// Decimals of mm and degrees.
const DECIMALS: i32 = 7;

pub(crate) fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let axes = request.machine.machine().axes();
    let mut notes = vec![
        "values are actual minus commanded; a positive one moves the axis in the negative direction".to_owned(),
        "the sign of $AN_CEC is not in the pages that were found: run one line after activation; \
         $SN_CEC_TABLE_WEIGHT = -1 turns a table"
            .to_owned(),
    ];
    let mut positioning = format!("%_N_AX_EEC_INI\n; {}\nCHANDATA(1)\n", request.origin());
    let mut cross = format!("%_N_NC_CEC_INI\n; {}\nCHANDATA(1)\n", request.origin());
    let mut lines = Vec::new();
    let mut table = 0;
    for axis in request.axes()? {
        let line = Line::new(request, axis, FORMAT)?;
        let step = line.spacing(request, FORMAT)?;
        let range = Range::new(request, &line, step);
        let number = axis + 1;
        let name = request.name(axis);
        notes.push(format!(
            "AX{number} is {name}: $MA_MM_ENC_COMP_MAX_POINTS at least {}{}",
            line.positions.len(),
            lost_motion(request, &line)
        ));
        // Writing to a String cannot fail.
        let _ = writeln!(positioning, "; {name}");
        for k in 0..line.positions.len() {
            let value = value(request, &line, axis, k);
            let _ = writeln!(positioning, "$AA_ENC_COMP[0,{k},AX{number}]={value}");
        }
        let _ = write!(
            positioning,
            "$AA_ENC_COMP_STEP[0,AX{number}]={}\n$AA_ENC_COMP_MIN[0,AX{number}]={}\n\
             $AA_ENC_COMP_MAX[0,AX{number}]={}\n$AA_ENC_COMP_IS_MODULO[0,AX{number}]=0\n",
            range.step, range.min, range.max
        );
        let others = (0..axes.len()).filter(|&other| {
            // Straightness of rotary axes is no function of a position alone.
            other != axis
                && [axis, other]
                    .iter()
                    .all(|&i| axes[i].kind() == AxisKind::Linear)
        });
        for other in others {
            let _ = writeln!(cross, "; {} by {name}", request.name(other));
            for k in 0..line.positions.len() {
                let value = value(request, &line, other, k);
                let _ = writeln!(cross, "$AN_CEC[{table},{k}]={value}");
            }
            let _ = write!(
                cross,
                "$AN_CEC_INPUT_AXIS[{table}]=(AX{number})\n$AN_CEC_OUTPUT_AXIS[{table}]=(AX{})\n\
                 $AN_CEC_STEP[{table}]={}\n$AN_CEC_MIN[{table}]={}\n$AN_CEC_MAX[{table}]={}\n\
                 $AN_CEC_DIRECTION[{table}]=0\n$AN_CEC_MULT_BY_TABLE[{table}]=0\n$AN_CEC_IS_MODULO[{table}]=0\n",
                other + 1,
                range.step,
                range.min,
                range.max
            );
            table += 1;
        }
        lines.push(line);
    }
    positioning.push_str("M17\n");
    cross.push_str("M17\n");
    let mut files = vec![ExportedFile {
        name: "AX_EEC.INI".to_owned(),
        text: positioning,
    }];
    if table > 0 {
        files.push(ExportedFile {
            name: "NC_CEC.INI".to_owned(),
            text: cross,
        });
        notes.push(format!("{table} sag compensation tables; $MN_MM_CEC_MAX_POINTS for each, $MA_CEC_ENABLE, $SN_CEC_TABLE_ENABLE"));
    }
    notes.push(request.origin());
    Ok(Tables {
        files,
        notes,
        is_experimental: true,
        rule: Box::new(Sums {
            lines,
            linear: axes.iter().map(|a| a.kind() == AxisKind::Linear).collect(),
        }),
    })
}

struct Range {
    step: f64,
    min: f64,
    max: f64,
}

impl Range {
    fn new(request: &Request<'_>, line: &Line, step: f64) -> Self {
        let in_file = |value| request.in_file(line.axis, value);
        Self {
            step: in_file(step),
            min: in_file(line.positions[0]),
            max: in_file(line.positions[line.positions.len() - 1]),
        }
    }
}

/// The mean of both sides of approach, mm or degrees.
fn value(request: &Request<'_>, line: &Line, of: usize, k: usize) -> f64 {
    round(
        request.in_file(of, 0.5 * (line.forward[k][of] + line.backward[k][of])),
        DECIMALS,
    )
}

fn lost_motion(request: &Request<'_>, line: &Line) -> String {
    if !request.machine.keeps_sides_apart(line.axis) {
        return String::new();
    }
    // Positive where the encoder leads the machine: forward it stops short.
    let backlash = round(request.in_file(line.axis, -line.reversal()), DECIMALS);
    format!("; $MA_BACKLASH = {backlash} {}", request.unit(line.axis))
}

struct Sums {
    lines: Vec<Line>,
    linear: Vec<bool>,
}

impl Rule for Sums {
    fn added(&self, commanded: &[f64]) -> Result<Vec<f64>, Error> {
        let mut added = vec![0.0; commanded.len()];
        for line in &self.lines {
            for (of, sum) in added.iter_mut().enumerate() {
                if of == line.axis || (self.linear[of] && self.linear[line.axis]) {
                    *sum -= line.at(of, commanded[line.axis]);
                }
            }
        }
        Ok(added)
    }
}

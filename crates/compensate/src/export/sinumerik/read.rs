//! Reading `$AA_ENC_COMP` and `$AN_CEC`.

use std::collections::BTreeMap;

use trueaxis_kinematics::Machine;

use crate::Error;
use crate::export::ExportedFile;
use crate::export::named_errors::wrong;
use crate::export::sinumerik::sag::{Product, Sag};
use crate::export::sinumerik::table::{Kind, Table};

/// The assignments of one table.
#[derive(Default)]
struct Assigned {
    line: usize,
    /// With their lines.
    values: BTreeMap<usize, (usize, f64)>,
    /// Names behind `$AA_ENC_COMP_` and `$AN_CEC_`.
    fields: BTreeMap<String, (usize, String)>,
}

/// Names behind `$AA_ENC_COMP_` and `$AN_CEC_`.
const OF_ENCODERS: [&str; 4] = ["STEP", "MIN", "MAX", "IS_MODULO"];
const OF_SAG: [&str; 8] = [
    "INPUT_AXIS",
    "OUTPUT_AXIS",
    "STEP",
    "MIN",
    "MAX",
    "DIRECTION",
    "MULT_BY_TABLE",
    "IS_MODULO",
];

const MULT_BY_TABLE: &str = "MULT_BY_TABLE";

/// No machine has such errors: beyond this a file is in another unit than mm and degrees.
const MOST: f64 = 5.0;

/// Lines around the assignments, as they begin.
const AROUND: [&str; 5] = ["%", "CHANDATA", "M17", "M30", "M02"];

/// The first line of a file of an archive, and its last.
const HEAD: &str = "%_N_";
const ENDS: [&str; 3] = ["M17", "M30", "M02"];

/// The tables of a file, for the axes of a machine.
pub(crate) fn read(file: &ExportedFile, machine: &Machine) -> Result<Sag, Error> {
    let mut all: BTreeMap<String, Assigned> = BTreeMap::new();
    for (number, line) in (1..).zip(file.text.lines()) {
        let content = without_number(line.split(';').next().unwrap_or_default().trim());
        if content.is_empty() || AROUND.iter().any(|begin| content.starts_with(begin)) {
            continue;
        }
        let refused = |expected: &str| wrong(&file.name, number, line, expected);
        let assignment = content.split_once('=').and_then(|(left, right)| {
            let (name, index) = left.trim().strip_suffix(']')?.split_once('[')?;
            let index: Vec<&str> = index.split(',').map(str::trim).collect();
            Some((name, index, right.trim()))
        });
        let (name, index, value) =
            assignment.ok_or_else(|| refused("an assignment, as $AA_ENC_COMP[0,0,AX1]=0.001"))?;
        let (table, point, field) = match (name, index.as_slice()) {
            ("$AA_ENC_COMP", ["0", point, axis]) => ((*axis).to_owned(), Some(*point), ""),
            ("$AN_CEC", [table, point]) => (format!("${table}"), Some(*point), ""),
            (name, index) => {
                let of_encoder = name.strip_prefix("$AA_ENC_COMP_");
                let of_encoder = of_encoder.filter(|field| OF_ENCODERS.contains(field));
                let of_sag = name.strip_prefix("$AN_CEC_");
                let of_sag = of_sag.filter(|field| OF_SAG.contains(field));
                match (of_encoder, of_sag, index) {
                    (Some(field), _, ["0", axis]) => ((*axis).to_owned(), None, field),
                    (_, Some(field), [table]) => (format!("${table}"), None, field),
                    _ => return Err(refused("$AA_ENC_COMP of encoder 0, or $AN_CEC")),
                }
            }
        };
        let table = all.entry(table).or_default();
        table.line = table.line.max(number);
        match point {
            None => {
                let value = (number, value.to_owned());
                if table.fields.insert(field.to_owned(), value).is_some() {
                    return Err(refused("each variable of a table once"));
                }
            }
            Some(point) => {
                let value = value.parse().ok().filter(|x: &f64| x.is_finite());
                let (Ok(point), Some(value)) = (point.parse(), value) else {
                    return Err(refused("a number for a point"));
                };
                if table.values.insert(point, (number, value)).is_some() {
                    return Err(refused("each point once"));
                }
            }
        }
    }
    let mut lines = file.text.lines().map(|line| without_number(line.trim()));
    let is_end = |line: &str| ENDS.iter().any(|end| line.starts_with(end));
    let begins = lines.clone().filter(|line| line.starts_with(HEAD)).count();
    if begins > lines.by_ref().filter(|line| is_end(line)).count() {
        let last = file.text.lines().count();
        let found = file.text.lines().last().unwrap_or_default();
        let expected = "M17 at the end, as the head of the file promises; the file may be cut off";
        return Err(wrong(&file.name, last, found, expected));
    }
    if all.is_empty() {
        let expected = "tables, as $AA_ENC_COMP[0,0,AX1]=0.001 and so on";
        return Err(wrong(&file.name, 1, "no assignment", expected));
    }
    let mut read = Sag::default();
    let mut multiplied_by = BTreeMap::new();
    for (name, assigned) in &all {
        if let Some(other) = assigned.multiplied_by(&file.name, &all)? {
            multiplied_by.insert(name.as_str(), other);
        }
    }
    let levers: Vec<&str> = multiplied_by.values().map(String::as_str).collect();
    for (name, assigned) in &all {
        let is_lever = levers.contains(&name.as_str());
        let table = assigned.table(&file.name, name, machine)?;
        match multiplied_by.get(name.as_str()) {
            None if is_lever => {}
            None => {
                assigned.check_sizes(&file.name)?;
                read.tables.push(table);
            }
            Some(other) => {
                let lever = all[other].table(&file.name, other, machine)?;
                if table.largest() * lever.largest() > MOST {
                    let found = format!("{} times {}", table.largest(), lever.largest());
                    let expected =
                        "the product an error of a machine: the file is in mm and degrees";
                    return Err(wrong(&file.name, assigned.line, &found, expected));
                }
                read.products.push(Product {
                    factor: as_factor(table),
                    lever: as_factor(lever),
                });
            }
        }
    }
    Ok(read)
}

fn as_factor(table: Table) -> Table {
    Table {
        kind: Kind::Factor,
        ..table
    }
}

/// Without the number of the block, as `N10`.
fn without_number(content: &str) -> &str {
    let numbered = content.strip_prefix('N').and_then(|rest| {
        let (number, rest) = rest.split_once(' ')?;
        let is_number = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
        is_number.then_some(rest.trim_start())
    });
    numbered.unwrap_or(content)
}

impl Assigned {
    fn field(&self, file: &str, name: &str) -> Result<(usize, &str), Error> {
        let found = self.fields.get(name);
        let found = found.map(|(line, value)| (*line, value.as_str()));
        found.ok_or_else(|| {
            let expected = format!("_{name} of the table; the file may be cut off");
            wrong(file, self.line, "the last of a table", expected)
        })
    }

    fn number(&self, file: &str, name: &str) -> Result<f64, Error> {
        let (line, value) = self.field(file, name)?;
        let number = value.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| wrong(file, line, value, "a number"))
    }

    /// The name of the table that this one is multiplied by.
    fn multiplied_by(
        &self,
        file: &str,
        all: &BTreeMap<String, Self>,
    ) -> Result<Option<String>, Error> {
        let Some((line, value)) = self.fields.get(MULT_BY_TABLE) else {
            return Ok(None);
        };
        let other = match value.parse::<usize>() {
            Ok(0) => return Ok(None),
            Ok(number) => format!("${}", number - 1),
            Err(_) => {
                let expected = "the number of a table from 1, or 0";
                return Err(wrong(file, *line, value, expected));
            }
        };
        let is_plain = |table: &Self| {
            let field = table.fields.get(MULT_BY_TABLE);
            field.is_none_or(|(_, value)| value == "0")
        };
        if all.get(&other).is_some_and(is_plain) {
            return Ok(Some(other));
        }
        let expected = "the number of a table in this file that is not multiplied itself";
        Err(wrong(file, *line, value, expected))
    }

    /// Whether values can be errors of a machine.
    fn check_sizes(&self, file: &str) -> Result<(), Error> {
        let too_large = self.values.values().find(|(_, value)| value.abs() > MOST);
        too_large.map_or(Ok(()), |(line, value)| {
            let expected = "an error of a machine: the file is in mm and degrees";
            Err(wrong(file, *line, &value.to_string(), expected))
        })
    }

    /// The table; `name` is its axis, or `$` and its number.
    fn table(&self, file: &str, name: &str, machine: &Machine) -> Result<Table, Error> {
        let is_encoder = !name.starts_with('$');
        // What is not there is 0.
        for kind in ["IS_MODULO", "DIRECTION"] {
            if let Some((line, value)) = self.fields.get(kind)
                && value.parse() != Ok(0.0)
            {
                let expected = format!("_{kind} 0: to others nothing can be added here");
                return Err(wrong(file, *line, value, expected));
            }
        }
        let axis = |line: usize, text: &str| {
            let plain = text.trim_matches(['(', ')']);
            let number = plain.strip_prefix("AX").and_then(|n| n.parse().ok());
            let place = number.map_or_else(
                || machine.axis_index(plain),
                |n: usize| n.checked_sub(1).filter(|&i| i < machine.axes().len()),
            );
            let expected = format!("AX1 to AX{}, or the name of an axis", machine.axes().len());
            place.ok_or_else(|| wrong(file, line, text, expected))
        };
        let (input, output) = match is_encoder {
            true => [axis(self.line, name)?; 2].into(),
            false => {
                let [input, output] =
                    ["INPUT_AXIS", "OUTPUT_AXIS"].map(|field| self.field(file, field));
                let ((a, input), (b, output)) = (input?, output?);
                (axis(a, input)?, axis(b, output)?)
            }
        };
        let [min, max, step] = ["MIN", "MAX", "STEP"].map(|field| self.number(file, field));
        let (min, max, step) = (min?, max?, step?);
        let values: Vec<f64> = self.values.values().map(|(_, value)| *value).collect();
        let intervals = (max - min) / step;
        let is_whole = self.values.keys().copied().eq(0..values.len())
            && values.len() > 1
            && step > 0.0
            && (intervals - (values.len() - 1) as f64).abs() < 1e-3;
        if !is_whole {
            let found = format!("{} points from {min} to {max}, {step} apart", values.len());
            let expected = "a value for each point; the file may be cut off";
            return Err(wrong(file, self.line, &found, expected));
        }
        Ok(Table {
            kind: match is_encoder {
                true => Kind::Encoder,
                false => Kind::Sag,
            },
            input,
            output,
            min,
            step,
            values,
        })
    }
}

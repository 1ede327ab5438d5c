//! Reading `$AA_ENC_COMP` and `$AN_CEC`.

use std::collections::BTreeMap;

use trueaxis_kinematics::Machine;

use crate::Error;
use crate::export::ExportedFile;
use crate::export::named_errors::wrong;
use crate::export::sinumerik::table::Table;

/// The assignments of one table.
#[derive(Default)]
struct Assigned {
    line: usize,
    values: BTreeMap<usize, f64>,
    /// Names behind `$AA_ENC_COMP_` and `$AN_CEC_`.
    fields: BTreeMap<String, (usize, String)>,
}

/// The tables of a file, for the axes of a machine.
pub(crate) fn read(file: &ExportedFile, machine: &Machine) -> Result<Vec<Table>, Error> {
    let mut all: BTreeMap<String, Assigned> = BTreeMap::new();
    for (number, line) in (1..).zip(file.text.lines()) {
        let content = line.split(';').next().unwrap_or_default().trim();
        if !content.starts_with('$') {
            // The header, CHANDATA, M17.
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
            (name, ["0", axis]) if name.starts_with("$AA_ENC_COMP_") => {
                ((*axis).to_owned(), None, &name["$AA_ENC_COMP_".len()..])
            }
            (name, [table]) if name.starts_with("$AN_CEC_") => {
                (format!("${table}"), None, &name["$AN_CEC_".len()..])
            }
            _ => return Err(refused("$AA_ENC_COMP of encoder 0, or $AN_CEC")),
        };
        let table = all.entry(table).or_default();
        table.line = table.line.max(number);
        match point {
            None => {
                let value = (number, value.to_owned());
                table.fields.insert(field.to_owned(), value);
            }
            Some(point) => {
                let value = value.parse().ok().filter(|x: &f64| x.is_finite());
                let (Ok(point), Some(value)) = (point.parse(), value) else {
                    return Err(refused("a number for a point"));
                };
                if table.values.insert(point, value).is_some() {
                    return Err(refused("each point once"));
                }
            }
        }
    }
    let tables = all.iter();
    tables
        .map(|(name, assigned)| assigned.table(&file.name, name, machine))
        .collect()
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

    /// The table; `name` is its axis, or `$` and its number.
    fn table(&self, file: &str, name: &str, machine: &Machine) -> Result<Table, Error> {
        let is_encoder = !name.starts_with('$');
        // What is not there is 0.
        for kind in ["IS_MODULO", "DIRECTION", "MULT_BY_TABLE"] {
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
        let values: Vec<f64> = self.values.values().copied().collect();
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
            is_encoder,
            input,
            output,
            min,
            step,
            values,
        })
    }
}

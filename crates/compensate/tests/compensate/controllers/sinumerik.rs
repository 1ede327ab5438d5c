//! The tables of SINUMERIK.

use std::collections::BTreeMap;

use trueaxis_compensate::Export;
use trueaxis_kinematics::Machine;

use super::{Control, from_file, in_file, linear};

/// What a control of the family makes of a table that names another one in `MULT_BY_TABLE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Products {
    /// The product alone.
    Alone,
    /// The product, and the table that names the other one.
    WithFactor,
    /// The product, and both tables.
    WithBoth,
    /// The product alone, with the other sign.
    OtherSign,
    /// Nothing.
    None,
}

/// A positive value moves the axis in the negative direction, in both kinds of tables, and in products.
pub(crate) fn sinumerik(export: &Export, machine: &Machine, products: Products) -> Control {
    let machine = machine.clone();
    let mut tables: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    let files = ["AX_EEC.INI", "NC_CEC.INI"];
    let files = export
        .files
        .iter()
        .filter(|file| files.contains(&file.name.as_str()));
    for line in files.flat_map(|file| file.text.lines()) {
        let Some((left, right)) = line.split_once('=').filter(|_| !line.starts_with(';')) else {
            continue;
        };
        let (name, index) = left.trim_end_matches(']').split_once('[').unwrap();
        let index: Vec<&str> = index.split(',').collect();
        // Of `$AA_ENC_COMP[e,N,AX]`, `$AA_ENC_COMP_STEP[e,AX]`, `$AN_CEC[t,N]`, `$AN_CEC_STEP[t]`.
        let (table, key) = match (name, index.as_slice()) {
            ("$AA_ENC_COMP", [_, n, axis]) => (format!("enc {axis}"), (*n).to_owned()),
            ("$AN_CEC", [t, n]) => (format!("cec {t}"), (*n).to_owned()),
            (name, [_, axis]) if name.starts_with("$AA_ENC_COMP_") => {
                (format!("enc {axis}"), name[13..].to_owned())
            }
            (name, [t]) => (format!("cec {t}"), name[8..].to_owned()),
            _ => panic!("{line}"),
        };
        let twice = tables
            .entry(table)
            .or_default()
            .insert(key, right.to_owned());
        assert_eq!(twice, None, "{line}");
    }
    // The table that multiplies, for those that have one.
    let multiplied_by = |table: &BTreeMap<String, String>| {
        let number = table.get("MULT_BY_TABLE")?.parse::<usize>().unwrap();
        number.checked_sub(1).map(|index| format!("cec {index}"))
    };
    let levers: Vec<String> = tables.values().filter_map(multiplied_by).collect();
    let axis = |name: &str| {
        let number = name.trim_matches(['(', ')']).strip_prefix("AX").unwrap();
        number.parse::<usize>().unwrap() - 1
    };
    let of = |name: &str| {
        let table = &tables[name];
        let number = |key: &str| table[key].parse::<f64>().unwrap();
        let (input, output) = match name.strip_prefix("enc ") {
            Some(own) => (axis(own), axis(own)),
            None => (axis(&table["INPUT_AXIS"]), axis(&table["OUTPUT_AXIS"])),
        };
        let (min, step) = (number("MIN"), number("STEP"));
        let numbered = (0_u32..).take_while(|n| table.contains_key(&n.to_string()));
        let points = numbered.map(|n| (min + step * f64::from(n), number(&n.to_string())));
        let points: Vec<(f64, f64)> = points.collect();
        assert!((points[points.len() - 1].0 - number("MAX")).abs() < 1e-6);
        Table {
            input,
            output,
            points,
        }
    };
    let (mut sums, mut pairs) = (Vec::new(), Vec::new());
    for (name, table) in &tables {
        let lever = multiplied_by(table);
        let acts = match &lever {
            Some(_) => matches!(products, Products::WithFactor | Products::WithBoth),
            None => !levers.contains(name) || products == Products::WithBoth,
        };
        sums.extend(acts.then(|| of(name)));
        pairs.extend(lever.map(|lever| [of(name), of(&lever)]));
    }
    let sign = match products {
        Products::None => 0.0,
        Products::OtherSign => -1.0,
        _ => 1.0,
    };
    Box::new(move |q| {
        let mut added = vec![0.0; q.len()];
        for table in &sums {
            added[table.output] -= from_file(&machine, table.output, table.value(&machine, q));
        }
        for [factor, lever] in &pairs {
            assert_eq!(factor.output, lever.output);
            let product = factor.value(&machine, q) * lever.value(&machine, q);
            added[factor.output] -= sign * product;
        }
        added
    })
}

/// Values by the position of an axis, for an axis.
struct Table {
    input: usize,
    output: usize,
    points: Vec<(f64, f64)>,
}

impl Table {
    fn value(&self, machine: &Machine, q: &[f64]) -> f64 {
        linear(&self.points, in_file(machine, self.input, q[self.input]))
    }
}

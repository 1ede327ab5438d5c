//! `grid`: a neutral table of the error over the linear axes, for whatever control takes vectors, and for eyes.
//!
//! One row for each node, the first axis fastest, all other axes at home: its positions, the error of the tool (actual
//! minus nominal, zero at home), and for each axis of the grid what to add to its commanded position (`add_X_um`), by the
//! inverse of the machine. Between nodes it is linear in each axis.

use std::fmt::Write;

use trueaxis_files::round;
use trueaxis_kinematics::{ARCSEC, MICROMETRE};
use trueaxis_predict::ERROR_COLUMNS;

use crate::Error;
use crate::correct::added;
use crate::export::line::{positions, take_off};
use crate::export::named_errors::wrong;
use crate::export::old_files::reach;
use crate::export::sides::Sides;
use crate::export::{
    Description, ExportedFile, OldFiles, Request, Tables, check_points, csv, rising,
};

pub(super) const FORMAT: Description = Description {
    name: "grid",
    text: "Neutral CSV of error vectors and corrections over the linear axes",
    old_files: OldFiles::Named(&["grid.csv"]),
    sides: Sides::Mean,
    is_experimental: false,
    tables,
};

/// Positions this close are one, mm.
const SAME: f64 = 1e-6;

/// Rows beyond this are no table.
const MOST_ROWS: usize = 1_000_000;

fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let axes = request.linear_axes()?;
    let nodes = axes.iter().map(|&axis| positions(request, axis));
    let nodes = nodes.collect::<Result<Vec<_>, _>>()?;
    let rows = nodes.iter().map(Vec::len).product();
    check_rows(request, rows)?;
    let machine = request.machine.machine();
    let at_home = vec![0.0; machine.axes().len()];
    let error_at_home = machine.tool_error(request.machine, &at_home, request.at);

    let names: Vec<&str> = axes.iter().map(|&axis| request.name(axis)).collect();
    // As it stands alone, at its own nodes.
    let mut values = Vec::with_capacity(rows);
    for row in 0..rows {
        let commanded = commanded(&axes, &nodes, row, &at_home);
        values.push(added(machine, request.machine, &commanded, request.at)?);
    }
    let mut own = Grid {
        axes: axes.clone(),
        nodes,
        values,
    };
    // What the table itself adds there, where no node may be.
    let home = own.added(&at_home);
    take_off(&mut own.values, &home);
    let mut reached = Vec::new();
    let written = match request.onto {
        [] => None,
        [old] => {
            let read = read_old(old, request, &axes)?;
            for (&axis, nodes) in axes.iter().zip(&read.nodes) {
                let ends = [nodes[0], nodes[nodes.len() - 1]];
                reached.extend(reach(request, &old.name, axis, ends)?);
            }
            Some(own.with(&read, request)?)
        }
        more => {
            let lacks = format!("{} were given", more.len());
            return Err(request.unsuitable("one old file", lacks));
        }
    };
    let Grid { nodes, values, .. } = written.as_ref().unwrap_or(&own);

    let mut text = names.join(",");
    text.push(',');
    text.push_str(&ERROR_COLUMNS.join(","));
    // Writing to a String cannot fail.
    names.iter().for_each(|name| {
        let _ = write!(text, ",add_{name}_um");
    });
    text.push('\n');
    for (row, added) in values.iter().enumerate() {
        let commanded = commanded(&axes, nodes, row, &at_home);
        for &axis in &axes {
            let _ = write!(text, "{},", request.in_file(axis, commanded[axis]));
        }
        let error = machine.tool_error(request.machine, &commanded, request.at);
        let e = (error.translation_mm - error_at_home.translation_mm) / MICROMETRE;
        let turned = (error.rotation_rad - error_at_home.rotation_rad) / ARCSEC;
        let own = axes.iter().map(|&axis| added[axis] / MICROMETRE);
        let cells = e.iter().chain(turned.iter()).copied().chain(own);
        let cells: Vec<String> = cells.map(|x| round(x, 4).to_string()).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    let mut notes = vec![
        "e: actual minus nominal, zero at home; add_: what to add to the commanded position; all other axes at home, and what \
         they do is not in it"
            .to_owned(),
        request.origin(),
    ];
    notes.extend(reached);
    Ok(Tables {
        files: vec![ExportedFile::new("grid.csv", text)],
        notes,
        rule: Box::new(move |commanded| Ok(own.added(commanded))),
    })
}

fn check_rows(request: &Request<'_>, rows: usize) -> Result<(), Error> {
    check_points(request, || "the grid".to_owned(), rows, MOST_ROWS)
}

/// The node of a row, the first axis fastest.
fn commanded(axes: &[usize], nodes: &[Vec<f64>], row: usize, at_home: &[f64]) -> Vec<f64> {
    let mut commanded = at_home.to_vec();
    let mut rest = row;
    for (&axis, nodes) in axes.iter().zip(nodes) {
        commanded[axis] = nodes[rest % nodes.len()];
        rest /= nodes.len();
    }
    commanded
}

/// What is not read must not be there: columns of other axes.
fn check_header(
    old: &ExportedFile,
    header: &[&str],
    request: &Request<'_>,
    axes: &[usize],
) -> Result<(), Error> {
    let of_axes = axes.iter().flat_map(|&axis| {
        let name = request.name(axis);
        [name.to_owned(), format!("add_{name}_um")]
    });
    let known: Vec<String> = of_axes.chain(ERROR_COLUMNS.map(str::to_owned)).collect();
    let is_one = |(k, name): (usize, &&str)| {
        known.iter().any(|known| known == name) && !header[..k].contains(name)
    };
    match header.iter().enumerate().find(|&found| !is_one(found)) {
        None => Ok(()),
        Some((_, name)) => {
            let expected = format!(
                "each column once, of the axes that the grid is for: {}",
                known.join(", ")
            );
            Err(wrong(&old.name, 1, name, expected))
        }
    }
}

/// What an old table adds.
fn read_old(old: &ExportedFile, request: &Request<'_>, axes: &[usize]) -> Result<Grid, Error> {
    let count = request.machine.machine().axes().len();
    let header = csv::header(old);
    check_header(old, &header, request, axes)?;
    let column = |name: String| {
        let found = header.iter().position(|cell| *cell == name);
        found.ok_or_else(|| wrong(&old.name, 1, &header.join(","), format!("a column {name}")))
    };
    let own = axes.iter().map(|&axis| {
        let name = request.name(axis);
        Ok([column(name.to_owned())?, column(format!("add_{name}_um"))?])
    });
    let own = own.collect::<Result<Vec<_>, Error>>()?;
    let rows = csv::rows(old, header.len())?;
    let nodes: Vec<Vec<f64>> = own
        .iter()
        .map(|&[at, _]| rising(rows.iter().map(|row| row[at]), SAME))
        .collect();
    let at_home = vec![0.0; count];
    let expected: usize = nodes.iter().map(Vec::len).product();
    let mut values = Vec::new();
    for (row, cells) in rows.iter().enumerate() {
        let node = commanded(axes, &nodes, row, &at_home);
        let is_there = axes.iter().zip(&own).all(|(&axis, &[at, _])| {
            (cells[at] - node[axis]).abs() <= SAME && expected == rows.len()
        });
        if !is_there {
            let found = format!("row {} of {}", row + 1, rows.len());
            let text = "every node of the grid once, the first axis fastest";
            return Err(wrong(&old.name, row + 2, &found, text));
        }
        let mut added = vec![0.0; count];
        for (&axis, &[_, added_um]) in axes.iter().zip(&own) {
            added[axis] = cells[added_um] * MICROMETRE;
        }
        values.push(added);
    }
    if values.is_empty() {
        return Err(wrong(&old.name, 1, "no rows", "a row for each node"));
    }
    Ok(Grid {
        axes: axes.to_vec(),
        nodes,
        values,
    })
}

/// Multilinear interpolation of what is added.
struct Grid {
    axes: Vec<usize>,
    nodes: Vec<Vec<f64>>,
    values: Vec<Vec<f64>>,
}

impl Grid {
    /// With what targets saw of an old one, exact at the nodes of both and between them.
    fn with(&self, old: &Self, request: &Request<'_>) -> Result<Self, Error> {
        let pairs = self.nodes.iter().zip(&old.nodes);
        let nodes: Vec<Vec<f64>> = pairs
            .map(|(a, b)| rising(a.iter().chain(b).copied(), SAME))
            .collect();
        let rows = nodes.iter().map(Vec::len).product();
        check_rows(request, rows)?;
        let at_home = vec![0.0; self.values[0].len()];
        let values = (0..rows).map(|row| {
            let node = commanded(&self.axes, &nodes, row, &at_home);
            let (a, b) = (self.added(&node), old.seen(&node, request));
            a.iter().zip(b).map(|(a, b)| a + b).collect()
        });
        Ok(Self {
            axes: self.axes.clone(),
            values: values.collect(),
            nodes,
        })
    }

    /// What it adds at home, and along the line of each axis through home to those of its branch.
    fn seen(&self, commanded: &[f64], request: &Request<'_>) -> Vec<f64> {
        let home = vec![0.0; commanded.len()];
        let at_home = self.added(&home);
        let mut seen = at_home.clone();
        for &input in &self.axes {
            let mut along = home.clone();
            along[input] = commanded[input];
            let along = self.added(&along);
            let outputs = self
                .axes
                .iter()
                .filter(|&&output| request.is_seen(input, output));
            for &output in outputs {
                seen[output] += along[output] - at_home[output];
            }
        }
        seen
    }

    fn added(&self, commanded: &[f64]) -> Vec<f64> {
        // Rows of the corners with their weights.
        let mut corners = vec![(0, 1.0)];
        let mut stride = 1;
        for (&axis, nodes) in self.axes.iter().zip(&self.nodes) {
            let position = commanded[axis].clamp(nodes[0], nodes[nodes.len() - 1]);
            let above = nodes
                .partition_point(|&node| node < position)
                .max(1)
                .min(nodes.len() - 1);
            let below = above.saturating_sub(1);
            let width = nodes[above] - nodes[below];
            let weight = if width > 0.0 {
                (position - nodes[below]) / width
            } else {
                0.0
            };
            corners = corners
                .into_iter()
                .flat_map(|(row, w)| {
                    [
                        (row + stride * below, w * (1.0 - weight)),
                        (row + stride * above, w * weight),
                    ]
                })
                .collect();
            stride *= nodes.len();
        }
        let mut sum = vec![0.0; commanded.len()];
        for (row, weight) in corners {
            let pairs = sum.iter_mut().zip(&self.values[row]);
            pairs.for_each(|(sum, value)| *sum += weight * value);
        }
        sum
    }
}

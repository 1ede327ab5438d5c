//! `grid`: a neutral table of the error over the linear axes, for whatever control takes vectors, and for eyes.
//!
//! One row for each node, the first axis fastest, all other axes at home: its positions, the error of the tool (actual
//! minus nominal, zero at home), and for each axis of the grid what to add to its commanded position (`add_X_um`), by the
//! inverse of the machine. Between nodes it is linear in each axis.

use std::fmt::Write;

use trueaxis_kinematics::{ARCSEC, MICROMETRE};

use crate::export::line::positions;
use crate::export::{ExportedFile, Request, Rule, Tables, round};
use crate::{Error, Moved, correct};

const FORMAT: &str = "grid";

/// Rows beyond this are no table.
const MOST_ROWS: usize = 1_000_000;

pub(crate) fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let axes = request.linear_axes()?;
    if axes.is_empty() {
        return Err(Error::Unsuitable {
            format: FORMAT,
            takes: "errors over linear axes",
            lacks: "none of those asked for is linear and was measured".to_owned(),
        });
    }
    let nodes = axes.iter().map(|&axis| positions(request, axis));
    let nodes = nodes.collect::<Result<Vec<_>, _>>()?;
    let rows = nodes.iter().map(Vec::len).product();
    if rows > MOST_ROWS {
        return Err(Error::TooManyPoints {
            what: "the grid".to_owned(),
            format: FORMAT,
            points: rows,
            most: MOST_ROWS,
        });
    }
    let machine = request.machine.machine();
    let at_home = vec![0.0; machine.axes().len()];
    let added = |commanded: &[f64]| -> Result<Vec<f64>, Error> {
        let found = correct(
            machine,
            request.machine,
            commanded,
            request.at,
            Moved::Linear,
        )?;
        let pairs = found.positions.iter().zip(commanded);
        Ok(pairs
            .map(|(corrected, commanded)| corrected - commanded)
            .collect())
    };
    let home = added(&at_home)?;
    let error_at_home = machine.tool_error(request.machine, &at_home, request.at);

    let names: Vec<&str> = axes.iter().map(|&axis| request.name(axis)).collect();
    let mut text = names.join(",");
    text.push_str(",ex_um,ey_um,ez_um,ea_arcsec,eb_arcsec,ec_arcsec");
    // Writing to a String cannot fail.
    names.iter().for_each(|name| {
        let _ = write!(text, ",add_{name}_um");
    });
    text.push('\n');
    let mut values = Vec::with_capacity(rows);
    for row in 0..rows {
        let mut commanded = at_home.clone();
        let mut rest = row;
        for (&axis, nodes) in axes.iter().zip(&nodes) {
            commanded[axis] = nodes[rest % nodes.len()];
            rest /= nodes.len();
            let _ = write!(text, "{},", request.in_file(axis, commanded[axis]));
        }
        let error = machine.tool_error(request.machine, &commanded, request.at);
        let e = (error.translation_mm - error_at_home.translation_mm) / MICROMETRE;
        let turned = (error.rotation_rad - error_at_home.rotation_rad) / ARCSEC;
        let added: Vec<f64> = added(&commanded)?
            .iter()
            .zip(&home)
            .map(|(a, b)| a - b)
            .collect();
        let own = axes.iter().map(|&axis| added[axis] / MICROMETRE);
        let cells = e.iter().chain(turned.iter()).copied().chain(own);
        let cells: Vec<String> = cells.map(|x| round(x, 4).to_string()).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
        values.push(added);
    }
    Ok(Tables {
        files: vec![ExportedFile { name: "grid.csv".to_owned(), text }],
        notes: vec![
            "e: actual minus nominal, zero at home; add_: what to add to the commanded position; all other axes at home, and what \
             they do is not in it"
                .to_owned(),
            request.origin(),
        ],
        is_experimental: false,
        rule: Box::new(Grid { axes, nodes, values }),
    })
}

/// Multilinear interpolation of what is added.
struct Grid {
    axes: Vec<usize>,
    nodes: Vec<Vec<f64>>,
    values: Vec<Vec<f64>>,
}

impl Rule for Grid {
    fn added(&self, commanded: &[f64]) -> Result<Vec<f64>, Error> {
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
        Ok(sum)
    }
}

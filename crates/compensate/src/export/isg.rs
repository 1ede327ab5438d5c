//! `isg`: tables of the ISG kernel and Beckhoff's TF5280 (`ISG_CSV`): all component and location errors, one to one.
//!
//! Blocks between `#`, each with a header of names: an argument and the errors that depend on it, or location errors
//! alone; comments after `//`. Values in mm and rad, arguments in mm and degrees. The control compensates the position of the
//! tool point, which is at `P0X P0Y P0Z` with all axes at 0 and a tool of length 0; between points linearly (`GRID`).
//!
//! Sources: "ISG CSV format", "Units of measure", "List of parameters supported", "Tool length", "Alternative model",
//! "Workpiece axes" in the documentation of ISG and of Beckhoff (one text); the sign is not in it, so the writer is experimental.

pub(crate) mod read;

use std::fmt::Write;

use trueaxis_files::round;
use trueaxis_kinematics::{AxisKind, Component};

use crate::Error;
use crate::export::components::Components;
use crate::export::sides::Sides;
use crate::export::{Description, EXPERIMENTAL, ExportedFile, OldFiles, Request, Tables};

pub(super) const FORMAT: Description = Description {
    name: "isg",
    text: "ISG kernel, Beckhoff TF5280 (ISG_CSV): all component and location errors (experimental)",
    old_files: OldFiles::None,
    sides: Sides::Mean,
    is_experimental: true,
    tables,
};

/// Decimals of mm and rad: 1e-6 µm, 2e-5″.
const DECIMALS: i32 = 10;

fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let components = Components::new(request)?;
    let mut notes = components.notes(request);
    let mut text = format!("// {EXPERIMENTAL}\n");
    for note in &notes {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "// {note}");
    }
    let numbers = |values: &[f64]| {
        let values = values.iter().map(|&x| round(x, DECIMALS).to_string());
        values.collect::<Vec<_>>().join(" ")
    };
    let constants =
        |names: &[&str], values: &[f64]| format!("{}\n{}\n", names.join(" "), numbers(values));
    let axes = &components.axes;
    let mut blocks = vec![constants(
        &["P0X", "P0Y", "P0Z"],
        request.at.coords.as_slice(),
    )];
    let locations = axes.iter().flat_map(|axis| &axis.locations);
    let (names, values): (Vec<&str>, Vec<f64>) = locations.map(|(n, v)| (n.as_str(), v)).unzip();
    if !names.is_empty() {
        blocks.push(constants(&names, &values));
    }
    for axis in axes {
        let geometry = &request.machine.machine().axes()[axis.axis];
        let name = geometry.name();
        if geometry.kind() == AxisKind::Rotary {
            let names = ["X", "Y", "Z"].map(|along| format!("P{along}{name}"));
            let centre = geometry.point_mm().coords;
            blocks.push(constants(
                &names.each_ref().map(String::as_str),
                centre.as_slice(),
            ));
        }
        let names = Component::ALL.map(|component| component.name(name));
        let mut block = format!("{name} {}\n", names.join(" "));
        for (&position, error) in axis.positions.iter().zip(&axis.errors) {
            let argument = request.in_file(axis.axis, position);
            let _ = writeln!(
                block,
                "{argument} {}",
                numbers(error.to_vector().as_slice())
            );
        }
        blocks.push(block);
    }
    let records: usize = blocks.iter().map(|block| block.lines().count() - 1).sum();
    text.push_str(&blocks.join("#\n"));
    notes.push(format!("max_records {records} or more"));
    Ok(Tables {
        files: vec![ExportedFile::new("volcomp.csv", text)],
        notes,
        rule: Box::new(move |commanded| components.added(commanded)),
    })
}

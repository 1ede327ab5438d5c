//! `isg`: tables of the ISG kernel and Beckhoff's TF5280 (`ISG_CSV`): all component and location errors, one to one.
//!
//! Blocks between `#`, each with a header of names: an argument and the errors that depend on it, or location errors
//! alone; comments after `//`. Values in mm and rad, arguments in mm and degrees. The control compensates the position of the
//! tool point; here between points linearly.
//!
//! Sources: "ISG CSV format", "Units of measure", "List of parameters supported" in the documentation of ISG and of
//! Beckhoff (one text); the sign is not in it, so the writer is experimental.

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
    let number = |value: f64| round(value, DECIMALS).to_string();
    let mut blocks = Vec::new();
    let axes = &components.axes;
    let locations: Vec<_> = axes.iter().flat_map(|axis| &axis.locations).collect();
    let mut records = 0;
    if !locations.is_empty() {
        let names: Vec<&str> = locations.iter().map(|(name, _)| name.as_str()).collect();
        let values: Vec<String> = locations.iter().map(|(_, value)| number(*value)).collect();
        blocks.push(format!("{}\n{}\n", names.join(" "), values.join(" ")));
        records += 1;
    }
    for axis in axes {
        let geometry = &request.machine.machine().axes()[axis.axis];
        let name = geometry.name();
        if geometry.kind() == AxisKind::Rotary {
            let centre: [f64; 3] = geometry.point_mm().coords.into();
            let [x, y, z] = centre.map(number);
            blocks.push(format!("PX{name} PY{name} PZ{name}\n{x} {y} {z}\n"));
            records += 1;
        }
        let names = Component::ALL.map(|component| component.name(name));
        let mut block = format!("{name} {}\n", names.join(" "));
        for (&position, error) in axis.positions.iter().zip(&axis.errors) {
            let values: Vec<String> = error.to_vector().iter().map(|&x| number(x)).collect();
            let argument = request.in_file(axis.axis, position);
            let _ = writeln!(block, "{argument} {}", values.join(" "));
            records += 1;
        }
        blocks.push(block);
    }
    text.push_str(&blocks.join("#\n"));
    notes.push(format!("max_records {records} or more"));
    Ok(Tables {
        files: vec![ExportedFile::new("volcomp.csv", text)],
        notes,
        rule: Box::new(move |commanded| components.added(commanded)),
    })
}

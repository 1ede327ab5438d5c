//! `etalon`: the exchange format of Etalon, which several controls read: all component and location errors, one to one.
//!
//! A section for each error: `[C0Y]` with `VALUE`, or `[EXX]` with `Gridpoints = {` lines of argument and value `}`;
//! comments after `//`. Values in mm and rad, arguments in mm and degrees.
//!
//! Source: "Etalon Exchange Format" in Beckhoff's TF5280 alone (the variant "Vendor"), so the writer is experimental.

pub(crate) mod read;

use std::fmt::Write;

use trueaxis_files::round;
use trueaxis_kinematics::Component;

use crate::Error;
use crate::export::components::Components;
use crate::export::sides::Sides;
use crate::export::{Description, EXPERIMENTAL, ExportedFile, OldFiles, Request, Tables};

pub(super) const FORMAT: Description = Description {
    name: "etalon",
    text: "Etalon exchange format: all component and location errors (experimental)",
    old_files: OldFiles::None,
    sides: Sides::Mean,
    is_experimental: true,
    tables,
};

/// Decimals of mm and rad.
const DECIMALS: usize = 12;

fn tables(request: &Request<'_>) -> Result<Tables, Error> {
    let components = Components::new(request)?;
    let axes = &components.axes;
    let [x, y, z] = request.at.coords.data.0[0].map(|x| round(x, 6));
    let mut notes = components.notes(request);
    notes.push(format!(
        "the zero position of the tool is not in this format: give the control P0X P0Y P0Z = {x} {y} {z} beside it"
    ));
    let mut text = format!("// {EXPERIMENTAL}\n");
    // Writing to a String cannot fail.
    for note in &notes {
        let _ = writeln!(text, "// {note}");
    }
    for (name, value) in axes.iter().flat_map(|axis| &axis.locations) {
        let _ = writeln!(text, "[{name}]\nVALUE = {:.DECIMALS$}", round(*value, 12));
    }
    for axis in axes {
        for component in Component::ALL {
            let name = component.name(request.name(axis.axis));
            let _ = writeln!(text, "[{name}]\nGridpoints = {{");
            for (&position, error) in axis.positions.iter().zip(&axis.errors) {
                let argument = request.in_file(axis.axis, position);
                let value = round(error.to_vector()[component.index()], 12);
                let _ = writeln!(text, "{argument} {value:.DECIMALS$}");
            }
            let _ = writeln!(text, "}}  // end of {name}");
        }
    }
    Ok(Tables {
        files: vec![ExportedFile::new("etalon.txt", text)],
        notes,
        rule: Box::new(move |commanded| components.added(commanded)),
    })
}

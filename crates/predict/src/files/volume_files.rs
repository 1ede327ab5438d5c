//! `volume.json`, `volumetric.csv` and `volumetric.vti`.

use std::fmt::Write;

use nalgebra::Vector3;
use rayon::prelude::*;
use serde_json::{Value, json};
use trueaxis_files::{round, value_to_json, without_nulls};
use trueaxis_kinematics::{ARCSEC, MICROMETRE, MotionError};

use crate::calibrated_machine::CalibratedMachine;
use crate::files::predicted_csv::{ERROR_COLUMNS, to_csv};
use crate::output::position_in_file;
use crate::volume::statistics::Sizes;
use crate::volume::{Figure, Volume};

/// Decimals of µm and ″.
const DECIMALS: i32 = 4;

/// Names of displacements and rotations.
const LETTERS: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];

fn um(value_mm: f64) -> f64 {
    round(value_mm / MICROMETRE, DECIMALS)
}

fn arcsec(value_rad: f64) -> f64 {
    round(value_rad / ARCSEC, DECIMALS)
}

impl Volume {
    /// The text of `volume.json`; `machine` is the one that was looked at.
    pub fn to_json(&self, machine: &CalibratedMachine) -> String {
        let nominal = machine.machine();
        let in_file = |axis: usize, position: f64| {
            let axis = &nominal.axes()[axis];
            (
                axis.name().to_owned(),
                json!(position_in_file(axis.kind(), position)),
            )
        };
        let grid = self.places.grid.iter().flatten();
        let grid = grid.map(|axis| {
            let (name, first) = in_file(axis.axis, axis.positions[0]);
            let last = axis.positions[axis.positions.len() - 1];
            json!({
                "axis": name,
                "from": first,
                "to": in_file(axis.axis, last).1,
                "points": axis.positions.len(),
            })
        });
        let sampled = self.places.sampled.iter();
        let sampled = sampled.map(|&(axis, [low, high])| {
            let (name, low) = in_file(axis, low);
            json!({ "axis": name, "from": low, "to": in_file(axis, high).1 })
        });
        let worst = self.worst.iter().enumerate();
        let worst: Value = worst.map(|(axis, &q)| in_file(axis, q)).collect();
        let [e, rotation] = [
            self.worst_error.translation_mm,
            self.worst_error.rotation_rad,
        ];
        let shares = self.shares.iter();
        let shares: Value = shares
            .map(|(name, share)| (name.clone(), json!(round(*share, DECIMALS))))
            .collect();
        let ranges = LETTERS.iter().zip(&self.figures.ranges).enumerate();
        let ranges: Value = ranges
            .map(|(i, (letter, range))| match i < 3 {
                true => (format!("{letter}_um"), figure(range, um)),
                false => (format!("{letter}_arcsec"), figure(range, arcsec)),
            })
            .collect();
        let point: [f64; 3] = self.places.tool_home_mm.coords.into();
        value_to_json(&json!({
            "format": "trueaxis-volume",
            "version": 1,
            "machine": machine.name,
            "campaign": machine.campaign,
            "effects_taken_out": machine.names_taken_out(),
            "not_measured": machine.unmeasured(),
            "tool_home_mm": point,
            "grid": grid.collect::<Value>(),
            "sampled": sampled.collect::<Value>(),
            "places": self.places.count(),
            "before": {
                "zeroed_at_home": sizes(&self.figures.zeroed_at_home),
                "best_fit": sizes(&self.figures.best_fit),
                "ranges": ranges,
                "worst": {
                    "at": worst,
                    "error_um": <[f64; 3]>::from(e.map(um)),
                    "rotation_arcsec": <[f64; 3]>::from(rotation.map(arcsec)),
                    "size_um": um(e.norm()),
                },
                "shares": shares,
            },
        }))
    }

    /// The errors at the nodes of the grid with all other axes at home (x runs fastest), less the displacement at
    /// home, mm and rad.
    pub fn map(&self, machine: &CalibratedMachine) -> Vec<MotionError> {
        let places: Vec<_> = self.places.map().collect();
        let places = places.par_iter().map(|&place| {
            let positions = self.places.at_node(place);
            let tool_mm = self.places.tool_home_mm;
            let error = machine.machine().tool_error(machine, &positions, tool_mm);
            MotionError::new(
                error.translation_mm - self.home.translation_mm,
                error.rotation_rad,
            )
        });
        places.collect()
    }

    /// The text of `volumetric.csv`: a row for each node of the map, with the positions of all axes and the error.
    pub fn map_csv(&self, machine: &CalibratedMachine, map: &[MotionError]) -> String {
        let axes = machine.machine().axes();
        let names = axes.iter().map(|axis| axis.name());
        let columns: Vec<&str> = names.chain(ERROR_COLUMNS).collect();
        let rows = map.iter().zip(self.places.map()).map(|(error, number)| {
            let positions = self.places.at_node(number);
            let positions = axes.iter().zip(positions);
            let positions = positions.map(|(axis, q)| position_in_file(axis.kind(), q));
            let e = error.translation_mm.map(um);
            let rotation = error.rotation_rad.map(arcsec);
            let numbers = positions.chain(e.iter().copied());
            numbers.chain(rotation.iter().copied()).collect()
        });
        to_csv(&columns, rows)
    }

    /// The text of `volumetric.vti` for `ParaView`: image data over the positions of the linear axes (mm) with the
    /// vectors `error_um` and `rotation_arcsec`.
    pub fn map_vti(&self, map: &[MotionError]) -> String {
        let first = |axis: usize| {
            self.places.grid[axis]
                .as_ref()
                .map_or(0.0, |a| a.positions[0])
        };
        let spacing = |axis: usize| {
            let axis = self.places.grid[axis].as_ref();
            // A direction without axis has one layer, whose distance from the next is nothing.
            axis.map_or(1.0, |axis| axis.positions[1] - axis.positions[0])
        };
        let extent = self.places.nodes().map(|nodes| nodes - 1);
        let extent = format!("0 {} 0 {} 0 {}", extent[0], extent[1], extent[2]);
        let mut file = format!(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\">\n  \
             <ImageData WholeExtent=\"{extent}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\">\n    \
             <Piece Extent=\"{extent}\">\n      <PointData Vectors=\"error_um\">\n",
            first(0),
            first(1),
            first(2),
            spacing(0),
            spacing(1),
            spacing(2)
        );
        array(
            &mut file,
            "error_um",
            map.iter().map(|e| e.translation_mm.map(um)),
        );
        let rotations = map.iter().map(|e| e.rotation_rad.map(arcsec));
        array(&mut file, "rotation_arcsec", rotations);
        file.push_str("      </PointData>\n    </Piece>\n  </ImageData>\n</VTKFile>\n");
        file
    }
}

fn array(file: &mut String, name: &str, vectors: impl Iterator<Item = Vector3<f64>>) {
    // Writing to a String cannot fail.
    let _ = writeln!(
        file,
        "        <DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"ascii\">"
    );
    for v in vectors {
        let _ = writeln!(file, "{} {} {}", v.x, v.y, v.z);
    }
    file.push_str("        </DataArray>\n");
}

fn sizes(sizes: &Sizes<Figure>) -> Value {
    json!({
        "rms_um": figure(&sizes.rms, um),
        "p95_um": figure(&sizes.p95, um),
        "max_um": figure(&sizes.max, um),
    })
}

fn figure(figure: &Figure, in_unit: impl Fn(f64) -> f64) -> Value {
    without_nulls(json!({
        "value": in_unit(figure.value),
        "interval": figure.drawn.map(|drawn| drawn.interval.map(&in_unit)),
        "bias": figure.drawn.map(|drawn| in_unit(drawn.bias)),
    }))
}

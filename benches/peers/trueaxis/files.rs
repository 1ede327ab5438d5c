//! Problems as files: a folder of tables without header, all in mm.
//!
//! ```text
//! noise.csv     σ of a length, σ of the repeatability per coordinate
//! stations.csv  x y z L of every station, where the iteration starts
//! targets.csv   x y z of the three targets at home, nominal
//! steps.csv     x y z: how far every step moves the targets, nominal
//! lengths.csv   station, step, and the lengths to the three targets, in measuring order
//! ```

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result};
use trueaxis_benches::{Problem, SIZES, fxyz, problem};

pub(crate) fn write_all(folder: &Path) -> Result<()> {
    for (name, ..) in SIZES {
        write(&problem(name), &folder.join(name))?;
    }
    Ok(())
}

fn write(problem: &Problem, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    let network = &problem.network;
    let noise = vec![
        network.noise.length_sigma_mm,
        network.noise.repeatability_mm,
    ];
    write_rows(&folder.join("noise.csv"), [noise])?;
    let stations = problem.start.stations.iter().map(|s| {
        let [x, y, z] = s.position_mm.into();
        vec![x, y, z, s.dead_path_mm]
    });
    write_rows(&folder.join("stations.csv"), stations)?;
    let targets = fxyz().targets;
    let home = targets.iter().map(|target| target.position_mm.to_vec());
    write_rows(&folder.join("targets.csv"), home)?;
    let steps = network.groups.iter().map(|group| {
        let moved: [f64; 3] = network.nominal_mm[group.start].into();
        let from = targets[0].position_mm;
        moved.iter().zip(from).map(|(to, from)| to - from).collect()
    });
    write_rows(&folder.join("steps.csv"), steps)?;
    let lengths = network.visits.iter().map(|visit| {
        let readings = &network.readings[visit.readings.clone()];
        let lengths = readings.iter().map(|reading| reading.length_mm);
        [visit.station as f64, visit.group as f64]
            .into_iter()
            .chain(lengths)
            .collect()
    });
    write_rows(&folder.join("lengths.csv"), lengths)
}

fn write_rows(path: &Path, rows: impl IntoIterator<Item = Vec<f64>>) -> Result<()> {
    let mut file = BufWriter::new(File::create(path).with_context(|| shown(path))?);
    for row in rows {
        // The shortest decimals that read back as the same number.
        let fields: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(file, "{}", fields.join(","))?;
    }
    Ok(file.flush()?)
}

/// The lines of a file, each split at `separator`.
pub(crate) fn read_rows(path: &Path, separator: char) -> Result<Vec<Vec<f64>>> {
    let text = fs::read_to_string(path).with_context(|| shown(path))?;
    let row = |line: &str| {
        line.split(separator)
            .map(|field| Ok(field.parse()?))
            .collect()
    };
    text.lines().map(row).collect()
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

//! The problems, as files that every solver reads.
//!
//! A folder has `stations.csv` (x y z L) and `points.csv` (x y z): where to start, mm; and
//! `lengths.csv` (station, point, length in mm). `trials.csv`, if there, has a trial a row: the
//! errors of all lengths, mm, to be added to them.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use trueaxis_benches::{STATIONS, network_from};
use trueaxis_multilateration::{Network, Noise, Reading, Station, Trials, Visit};

use crate::solve::solve;

/// Name, stations, points. The generator places points by threes.
pub(crate) const PROBLEMS: [(&str, usize, usize); 4] = [
    ("A", 4, 195),
    ("B", 4, 1_950),
    ("C", 4, 99_999),
    ("D", 8, 99_999),
];

/// The Monte Carlo on A.
pub(crate) const MONTE_CARLO: &str = "monte-carlo";

const TRIALS: usize = 200;
const LENGTH_SIGMA_MM: f64 = 0.269e-3;
/// Stations and dead paths start as far off, per coordinate; points are 20 µm off.
const STATION_OFF_MM: f64 = 5.0;
const SEED: u64 = 5;

/// What the files of a problem say.
pub(crate) struct Problem {
    pub(crate) network: Network,
    /// Where to start.
    pub(crate) stations: Vec<Station>,
    pub(crate) points: Vec<Point3<f64>>,
    pub(crate) trials: Vec<Vec<f64>>,
}

pub(crate) fn write_all(folder: &Path) -> Result<()> {
    for (name, stations, points) in PROBLEMS {
        generate(stations, points).write(&folder.join(name))?;
    }
    monte_carlo(generate(PROBLEMS[0].1, PROBLEMS[0].2))?.write(&folder.join(MONTE_CARLO))
}

fn generate(stations: usize, points: usize) -> Problem {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut network = network_from(stations, points, 0.0);
    let errors = Normal::new(0.0, LENGTH_SIGMA_MM).expect("a fixed standard deviation");
    for reading in &mut network.readings {
        reading.length_mm += errors.sample(&mut rng);
    }
    let mut off = || rng.random_range(-STATION_OFF_MM..STATION_OFF_MM);
    let stations = STATIONS[..stations]
        .iter()
        .map(|(position, dead_path)| Station {
            position_mm: Point3::from(*position) + Vector3::from_fn(|_, _| off()),
            dead_path_mm: dead_path + off(),
        });
    Problem {
        stations: stations.collect(),
        points: network.nominal_mm.clone(),
        network,
        trials: Vec::new(),
    }
}

/// From the minimum of `problem`: the lengths that follow from it, and errors for every trial.
fn monte_carlo(mut problem: Problem) -> Result<Problem> {
    let solution = solve(&problem)?.solution()?;
    let residuals = &solution.residuals_mm;
    for (reading, residual) in problem.network.readings.iter_mut().zip(residuals) {
        reading.length_mm -= residual;
    }
    let trials = Trials::new(&problem.network, &solution);
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut draw = || {
        let mut errors_mm = vec![0.0; trials.readings()];
        trials.draw(&mut rng, &mut errors_mm);
        errors_mm
    };
    Ok(Problem {
        trials: (0..TRIALS).map(|_| draw()).collect(),
        points: solution.points_mm,
        stations: solution.stations,
        ..problem
    })
}

impl Problem {
    fn write(&self, folder: &Path) -> Result<()> {
        fs::create_dir_all(folder)?;
        let stations = self.stations.iter().map(|station| {
            let [x, y, z] = station.position_mm.into();
            vec![x, y, z, station.dead_path_mm]
        });
        write_rows(&folder.join("stations.csv"), stations)?;
        let points = self.points.iter().map(|p| p.iter().copied().collect());
        write_rows(&folder.join("points.csv"), points)?;
        let lengths = self.network.visits.iter().map(|visit| {
            let point = self.network.groups[visit.group].start as f64;
            let reading = self.network.readings[visit.readings.start];
            vec![visit.station as f64, point, reading.length_mm]
        });
        write_rows(&folder.join("lengths.csv"), lengths)?;
        write_rows(&folder.join("trials.csv"), self.trials.iter().cloned())
    }

    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let stations = read_rows(&folder.join("stations.csv"))?;
        let points = read_rows(&folder.join("points.csv"))?;
        let points: Vec<_> = points
            .iter()
            .map(|p| Point3::new(p[0], p[1], p[2]))
            .collect();
        let lengths = read_rows(&folder.join("lengths.csv"))?;
        let visits = lengths.iter().enumerate().map(|(i, row)| Visit {
            station: index(row[0]),
            group: index(row[1]),
            readings: i..i + 1,
        });
        let reading = |row: &Vec<f64>| Reading {
            point: 0,
            length_mm: row[2],
        };
        let network = Network {
            stations: vec![None; stations.len()],
            nominal_mm: points.clone(),
            groups: (0..points.len()).map(|i| i..i + 1).collect(),
            visits: visits.collect(),
            readings: lengths.iter().map(reading).collect(),
            noise: Noise {
                length_sigma_mm: LENGTH_SIGMA_MM,
                ..Noise::default()
            },
            ..Network::default()
        };
        let stations = stations.iter().map(|s| Station {
            position_mm: Point3::new(s[0], s[1], s[2]),
            dead_path_mm: s[3],
        });
        Ok(Self {
            network,
            stations: stations.collect(),
            points,
            trials: read_rows(&folder.join("trials.csv"))?,
        })
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "written as one"
)]
fn index(value: f64) -> usize {
    value as usize
}

fn write_rows(path: &Path, rows: impl Iterator<Item = Vec<f64>>) -> Result<()> {
    let mut file = BufWriter::new(File::create(path).with_context(|| shown(path))?);
    for row in rows {
        // The shortest decimals that read back as the same number.
        let fields: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(file, "{}", fields.join(","))?;
    }
    Ok(file.flush()?)
}

pub(crate) fn read_rows(path: &PathBuf) -> Result<Vec<Vec<f64>>> {
    let text = fs::read_to_string(path).with_context(|| shown(path))?;
    let row = |line: &str| line.split(',').map(|field| Ok(field.parse()?)).collect();
    text.lines().map(row).collect()
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

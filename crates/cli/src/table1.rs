//! `trueaxis table1`: Table 1 of the paper again.

mod arrangement;
mod figures;
#[cfg(test)]
mod tests;

use anyhow::Context;
use serde::Serialize;

use self::arrangement::{optimised, points_mm, tetrahedron};
use self::figures::{Figures, LENGTH_SIGMA_UM, Measurement, figures};
use crate::args::Table1Args;
use crate::exit::Exit;
use crate::output;
use crate::talk::say_all;

/// Figures closer than this to the printed ones repeat them.
const CLOSE: f64 = 0.12;

pub(crate) fn execute(args: &Table1Args) -> anyhow::Result<Exit> {
    let table = Table::new(args.trials as usize, args.seed)?;
    say_all(table.lines());
    if args.json {
        output::print(&trueaxis_files::to_json(&table).context("table1.json")?)?;
    }
    Ok(Exit::Good)
}

/// The rows of the printed table: case, measurement, and standard deviation of x, y and z in µm.
/// The machine returns within 3σ = 3 µm in case 1, 5 µm in case 2.
const PRINTED: [(u32, Measurement, [f64; 3]); 4] = [
    (1, measured(3.0, 1), [1.27, 1.33, 1.29]),
    (1, measured(3.0, 10), [0.35, 0.41, 0.43]),
    (2, measured(5.0, 1), [2.03, 1.97, 2.14]),
    (2, measured(5.0, 10), [0.64, 0.71, 0.67]),
];

const fn measured(three_sigma_um: f64, repeats: u32) -> Measurement {
    Measurement {
        repeatability_um: three_sigma_um / 3.0,
        repeats,
    }
}

/// Streams of different rows never meet, whatever the seed.
const SEEDS_APART: u64 = 1 << 60;

#[derive(Debug, Serialize)]
struct Table {
    format: &'static str,
    version: u32,
    trials: usize,
    seed: u64,
    points: usize,
    length_sigma_um: f64,
    arrangements: Vec<ArrangementRows>,
}

#[derive(Debug, Serialize)]
struct ArrangementRows {
    stations: &'static str,
    positions_mm: [[f64; 3]; 4],
    rows: Vec<Row>,
}

/// The largest standard deviation over all points, of x, y and z.
#[derive(Debug, Serialize)]
struct Row {
    case: u32,
    #[serde(flatten)]
    measurement: Measurement,
    printed_um: [f64; 3],
    #[serde(flatten)]
    figures: Figures,
    /// Monte Carlo over printed.
    ratio: [f64; 3],
}

impl Table {
    fn new(trials: usize, seed: u64) -> anyhow::Result<Self> {
        let points_mm = points_mm();
        let mut row_seeds = (0..).map(|row: u64| seed.wrapping_add(row * SEEDS_APART));
        let mut arrangements = Vec::new();
        for arrangement in [tetrahedron(&points_mm), optimised()] {
            let mut rows = Vec::new();
            for ((case, measurement, printed_um), seed) in PRINTED.into_iter().zip(&mut row_seeds) {
                let figures = figures(&points_mm, &arrangement, measurement, trials, seed)?;
                let found = figures.monte_carlo_um;
                rows.push(Row {
                    case,
                    measurement,
                    printed_um,
                    figures,
                    ratio: std::array::from_fn(|axis| found[axis] / printed_um[axis]),
                });
            }
            arrangements.push(ArrangementRows {
                stations: arrangement.name,
                positions_mm: arrangement.stations_mm.map(Into::into),
                rows,
            });
        }
        Ok(Self {
            format: "trueaxis-table1",
            version: 1,
            trials,
            seed,
            points: points_mm.len(),
            length_sigma_um: LENGTH_SIGMA_UM,
            arrangements,
        })
    }

    fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "Table 1: largest standard deviation of x, y, z over {} points, µm; {} trials, seed {}",
            self.points, self.trials, self.seed
        )];
        for arrangement in &self.arrangements {
            lines.push(String::new());
            lines.push(format!("stations: {}", arrangement.stations));
            lines.push(format!(
                "{:<24}{:<21}{:<32}{:<21}{}",
                "", "printed", "Monte Carlo (± s.e.)", "analytic", "Monte Carlo / printed"
            ));
            lines.extend(arrangement.rows.iter().map(Row::line));
            lines.push(arrangement.verdict());
        }
        lines
    }
}

impl ArrangementRows {
    /// Which figures are not repeated.
    fn verdict(&self) -> String {
        let mut far = Vec::new();
        for row in &self.rows {
            for (axis, ratio) in ["x", "y", "z"].iter().zip(row.ratio) {
                if (ratio - 1.0).abs() > CLOSE {
                    far.push(format!(
                        "{} {axis} ({:+.0} %)",
                        row.name(),
                        100.0 * (ratio - 1.0)
                    ));
                }
            }
        }
        let all = 3 * self.rows.len();
        let mut text = format!(
            "{} of {all} within {:.0} % of the printed ones",
            all - far.len(),
            100.0 * CLOSE
        );
        if !far.is_empty() {
            text += &format!("; not: {}", far.join(", "));
        }
        text
    }
}

impl Row {
    fn name(&self) -> String {
        let repeats = match self.measurement.repeats {
            1 => "single".to_owned(),
            count => format!("mean of {count}"),
        };
        format!("case {}, {repeats}", self.case)
    }

    fn line(&self) -> String {
        let numbers = |values: [f64; 3], digits: usize| {
            values.map(|value| format!("{value:.digits$}")).join("  ")
        };
        let largest_error = self
            .figures
            .standard_error_um
            .into_iter()
            .fold(0.0, f64::max);
        format!(
            "  {:<22}{:<21}{:<32}{:<21}{}",
            self.name(),
            numbers(self.printed_um, 2),
            format!(
                "{} ± {largest_error:.3}",
                numbers(self.figures.monte_carlo_um, 3)
            ),
            numbers(self.figures.analytic_um, 3),
            numbers(self.ratio, 2)
        )
    }
}

//! `residuals.csv`: a row for each length with what the adjustment leaves of it.

use std::borrow::Cow;
use std::fmt::Write;

use trueaxis_campaign::Campaign;
use trueaxis_files::round;
use trueaxis_kinematics::MICROMETRE;

use crate::result::calibration::Calibration;
use crate::result::output::position_in_file;

/// Decimals of residuals, redundancy and times: far below anything measurable.
const DECIMALS: i32 = 4;

impl Calibration {
    /// File name of [`Calibration::residuals_csv`].
    pub const RESIDUALS_FILE: &str = "residuals.csv";

    /// The text of `residuals.csv`: the residuals (observed minus computed) of all lengths of `campaign`, which
    /// must be the one that was calibrated, in measuring order; `None` for a points campaign.
    pub fn residuals_csv(&self, campaign: &Campaign) -> Option<String> {
        let lengths = campaign.lengths.as_ref()?;
        let axes = campaign.machine.axes();
        let mut text = "row,station,target,run,time_s".to_owned();
        for axis in axes {
            text.push(',');
            text.push_str(&cell(axis.name()));
        }
        text.push_str(",residual_um,standardized,redundancy,used\n");
        let mut stops = lengths.stops.iter().peekable();
        for residual in &self.residuals {
            while stops
                .next_if(|stop| stop.readings.end <= residual.reading)
                .is_some()
            {}
            let (Some(stop), Some(reading)) =
                (stops.peek(), lengths.readings.get(residual.reading))
            else {
                break;
            };
            let step = &campaign.steps[stop.step];
            let run = step.run.map_or("", |run| &campaign.runs[run].name);
            // Writing to a String cannot fail.
            let _ = write!(
                text,
                "{},{},{},{},{}",
                reading.line,
                cell(&campaign.stations[stop.station].name),
                cell(&campaign.targets[reading.target].name),
                cell(run),
                round(reading.time_s, DECIMALS),
            );
            for (axis, &position) in axes.iter().zip(&step.positions) {
                let _ = write!(text, ",{}", position_in_file(axis.kind(), position));
            }
            let redundancy = residual.redundancy.map(|r| round(r, DECIMALS).to_string());
            let _ = writeln!(
                text,
                ",{},{},{},{}",
                round(residual.residual_mm / MICROMETRE, DECIMALS),
                round(residual.standardized, DECIMALS),
                redundancy.as_deref().unwrap_or_default(),
                u8::from(residual.redundancy.is_some()),
            );
        }
        Some(text)
    }
}

/// A name, in quotes if it needs them.
fn cell(name: &str) -> Cow<'_, str> {
    match name.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")).into(),
        false => name.into(),
    }
}

#[cfg(test)]
mod tests {
    use trueaxis_simulate::{Scenario, simulate};

    use crate::{Settings, calibrate};

    /// Each length once, by the line of its file, and together what the adjustment says of itself.
    #[test]
    fn each_length_has_a_row_and_their_redundancies_are_that_of_the_whole() {
        let scenario = include_str!("../../../../campaigns/rotary-stage/scenario.json");
        let simulated = simulate(&Scenario::from_json(scenario).unwrap(), 3).unwrap();
        let campaign = simulated.campaign;
        let calibration = calibrate(&campaign, &Settings::default()).unwrap();
        let text = calibration.residuals_csv(&campaign).unwrap();
        let mut lines = text.lines();
        let header = "row,station,target,run,time_s,C,residual_um,standardized,redundancy,used";
        assert_eq!(lines.next(), Some(header));
        let cells: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
        let column = |k: usize| -> Vec<f64> {
            let numbers = cells.iter().map(|row| row[k].parse().unwrap_or(0.0));
            numbers.collect()
        };
        let readings = &campaign.lengths.as_ref().unwrap().readings;
        assert_eq!(cells.len(), readings.len());
        for (row, reading) in cells.iter().zip(readings) {
            assert_eq!(row[0], reading.line.to_string());
            assert_eq!(row[2], campaign.targets[reading.target].name);
        }
        let report = &calibration.adjustment;
        let redundancy: f64 = column(8).iter().sum();
        assert!((redundancy - report.degrees_of_freedom as f64).abs() < 0.1);
        let squares: f64 = column(6).iter().map(|r| r * r).sum();
        let rms_um = (squares / report.observations as f64).sqrt();
        assert!((rms_um - report.rms_residual_mm * 1e3).abs() < 1e-3);
        // A clean campaign: w is standard normal; an rms beyond 10 % of 1 has a probability below 1e-6.
        let w: f64 = column(7).iter().map(|w| w * w).sum();
        let w = (w / report.observations as f64).sqrt();
        assert!((w - 1.0).abs() < 0.1, "{w}");
    }
}

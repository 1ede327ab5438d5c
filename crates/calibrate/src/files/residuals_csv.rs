//! `residuals.csv`: a row for each length with what the adjustment leaves of it.

use std::fmt::Write;

use trueaxis_campaign::Campaign;
use trueaxis_files::{csv_cell, round};
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
            text.push_str(&csv_cell(axis.name()));
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
                csv_cell(&campaign.stations[stop.station].name),
                csv_cell(&campaign.targets[reading.target].name),
                csv_cell(run),
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

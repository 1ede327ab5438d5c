//! `residuals.csv`: a row for each length, or each coordinate of a point, with what is left of it.

use std::fmt::Write;

use trueaxis_campaign::Campaign;
use trueaxis_files::{csv_cell, round};
use trueaxis_kinematics::MICROMETRE;

use crate::result::calibration::Calibration;
use trueaxis_predict::position_in_file;

/// Decimals of residuals, redundancy and times: far below anything measurable.
const DECIMALS: i32 = 4;

impl Calibration {
    /// File name of [`Calibration::residuals_csv`].
    pub const RESIDUALS_FILE: &str = "residuals.csv";

    /// The text of `residuals.csv`: the residuals (observed minus computed) of all lengths of `campaign`, or of all
    /// coordinates of its points that led to a result, in measuring order. It must be the campaign that was calibrated.
    pub fn residuals_csv(&self, campaign: &Campaign) -> String {
        let axes = campaign.machine.axes();
        let (by, stops) = match (&campaign.lengths, &campaign.points) {
            (None, Some(points)) => ("coordinate", &points.stops[..]),
            (lengths, _) => {
                let stops = lengths.as_ref().map(|lengths| &lengths.stops[..]);
                ("station", stops.unwrap_or_default())
            }
        };
        let mut text = format!("row,{by},target,run,time_s");
        for axis in axes {
            text.push(',');
            text.push_str(&csv_cell(axis.name()));
        }
        text.push_str(",residual_um,standardized,redundancy,used\n");
        let mut stops = stops.iter().peekable();
        for residual in &self.residuals {
            while stops
                .next_if(|stop| stop.readings.end <= residual.reading)
                .is_some()
            {}
            let Some(stop) = stops.peek() else { break };
            let Some((line, target, time_s)) = reading(campaign, residual.reading) else {
                break;
            };
            let by = match residual.coordinate {
                Some(coordinate) => ["x", "y", "z"][coordinate].into(),
                None => csv_cell(&campaign.stations[stop.station].name),
            };
            let step = &campaign.steps[stop.step];
            let run = step.run.map_or("", |run| &campaign.runs[run].name);
            // Writing to a String cannot fail.
            let _ = write!(
                text,
                "{line},{by},{},{},{}",
                csv_cell(&campaign.targets[target].name),
                csv_cell(run),
                round(time_s, DECIMALS),
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
        text
    }
}

/// Line, target and time (s) of a length or a point.
fn reading(campaign: &Campaign, number: usize) -> Option<(usize, usize, f64)> {
    match (&campaign.lengths, &campaign.points) {
        (Some(lengths), _) => {
            let reading = lengths.readings.get(number)?;
            Some((reading.line, reading.target, reading.time_s))
        }
        (None, points) => {
            let reading = points.as_ref()?.readings.get(number)?;
            Some((reading.line, reading.target, reading.time_s))
        }
    }
}

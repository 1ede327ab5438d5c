//! `residuals.csv`: a row for each length, or each coordinate of a point, with its residual.

use std::fmt::Write as _;
use std::io::{self, Write};

use trueaxis_campaign::Campaign;
use trueaxis_files::{csv_cell, push_rounded};
use trueaxis_kinematics::MICROMETRE;

use crate::result::calibration::Calibration;
use trueaxis_predict::position_in_file;

/// Decimals of residuals, redundancy and times: far below anything measurable.
const DECIMALS: u8 = 4;

impl Calibration {
    /// File name of [`Calibration::write_residuals_csv`].
    pub const RESIDUALS_FILE: &str = "residuals.csv";

    /// Writes `residuals.csv`: the residuals (observed minus computed) of all lengths, or of all coordinates of
    /// points that led to a result, in measuring order. `campaign` must be the one that was calibrated.
    pub fn write_residuals_csv(&self, campaign: &Campaign, out: &mut dyn Write) -> io::Result<()> {
        let axes = campaign.machine.axes();
        let by = match campaign.lengths {
            Some(_) => "station",
            None => "coordinate",
        };
        write!(out, "row,{by},target,run,time_s")?;
        for axis in axes {
            write!(out, ",{}", csv_cell(axis.name()))?;
        }
        out.write_all(b",residual_um,standardized,redundancy,used\n")?;
        let mut stops = campaign.stops().iter().peekable();
        // The rows of one stop share their positions. Writing to a String cannot fail.
        let (mut positions, mut of_stop) = (String::new(), None);
        let mut row = String::new();
        for residual in &self.residuals {
            while stops
                .next_if(|stop| stop.readings.end <= residual.reading)
                .is_some()
            {}
            let Some(stop) = stops.peek() else { break };
            let Some(seen) = campaign.sighting(residual.reading) else {
                break;
            };
            let by = match residual.coordinate {
                Some(coordinate) => ["x", "y", "z"][coordinate].into(),
                None => csv_cell(&campaign.stations[stop.station].name),
            };
            let step = &campaign.steps[stop.step];
            let run = step.run.map_or("", |run| &campaign.runs[run].name);
            if of_stop.replace(stop.readings.start) != Some(stop.readings.start) {
                positions.clear();
                for (axis, &position) in axes.iter().zip(&step.positions) {
                    let _ = write!(positions, ",{}", position_in_file(axis.kind(), position));
                }
            }
            row.clear();
            let _ = write!(
                row,
                "{},{by},{},{},",
                seen.line,
                csv_cell(&campaign.targets[seen.target].name),
                csv_cell(run),
            );
            push_rounded(&mut row, seen.time_s, DECIMALS);
            row.push_str(&positions);
            let residual_um = residual.residual_mm / MICROMETRE;
            let numbers = [
                Some(residual_um),
                Some(residual.standardized),
                residual.redundancy,
            ];
            for number in numbers {
                row.push(',');
                if let Some(number) = number {
                    push_rounded(&mut row, number, DECIMALS);
                }
            }
            row.push_str(match residual.redundancy {
                Some(_) => ",1\n",
                None => ",0\n",
            });
            out.write_all(row.as_bytes())?;
        }
        Ok(())
    }
}

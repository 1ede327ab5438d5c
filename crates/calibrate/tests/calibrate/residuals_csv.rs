//! `residuals.csv`.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_simulate::{Scenario, simulate};

/// Each length once, by the line of its file, and together what the adjustment says of itself.
#[test]
fn each_length_has_a_row_and_their_redundancies_are_that_of_the_whole() {
    let scenario = include_str!("../../../../campaigns/rotary-stage/scenario.json");
    let simulated = simulate(&Scenario::from_json(scenario).unwrap(), 3).unwrap();
    let campaign = simulated.campaign;
    let calibration = calibrate(&campaign, &Settings::default()).unwrap();
    let mut text = Vec::new();
    calibration
        .write_residuals_csv(&campaign, &mut text)
        .unwrap();
    let text = String::from_utf8(text).unwrap();
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

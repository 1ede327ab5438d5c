//! The lengths of a slide that is short by 15 µm.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use trueaxis_simulate::{Scenario, simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = Scenario::from_json(
        r#"{
      "format": "trueaxis-scenario", "version": 1, "name": "one slide",
      "machine": {
        "name": "slide", "kinematics": { "tool": ["X"] },
        "axes": [ { "name": "X", "kind": "linear", "direction": [1, 0, 0], "travel": [0, 400] } ]
      },
      "targets": [ { "name": "P", "position_mm": [0, 0, 0], "carried_by": "X" } ],
      "stations": [ { "name": "S1", "position_mm": [1000, 0, 0], "dead_path_mm": 600 } ],
      "errors": { "X": { "components": {
        "EXX": [ { "kind": "table", "positions": [0, 400], "values": [0, -15] } ]
      } } },
      "runs": [ { "name": "x", "axis": "X", "sweep": { "start": 0, "stop": 400, "step": 200 } } ]
    }"#,
    )?;
    let simulated = simulate(&scenario, 1)?;

    // At X = 400 the slide is 15 µm short, so the target is 15 µm further away than 600 mm.
    let readings = simulated.campaign.lengths.unwrap_or_default().readings;
    let lengths_mm: Vec<f64> = readings.iter().map(|reading| reading.length_mm).collect();
    assert_eq!(lengths_mm, [400.0, 200.0075, 0.015]);
    println!("lengths, mm: {lengths_mm:?}");
    Ok(())
}

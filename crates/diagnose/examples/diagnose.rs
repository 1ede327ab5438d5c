//! A target that slipped in its nest, found in simulated lengths.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use trueaxis_diagnose::{Settings, Verdict, diagnose};
use trueaxis_simulate::{Scenario, simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scenario = Scenario::from_json(include_str!(
        "../../../campaigns/rotary-stage/scenario.json"
    ))?;
    // A target slips in its nest by 9 µm.
    scenario.effects = serde_json::from_str(
        r#"[{
        "effect": "target_slip", "subject": { "target": "Q" },
        "parameters": [ { "name": "slip_x", "value": 2, "unit": "um" },
                        { "name": "slip_y", "value": -8, "unit": "um" },
                        { "name": "slip_z", "value": 3, "unit": "um" },
                        { "name": "time", "value": 2000, "unit": "s" } ]
    }]"#,
    )?;
    let campaign = simulate(&scenario, 1)?.campaign;
    let diagnosis = diagnose(&campaign, &Settings::default())?;
    assert_eq!(diagnosis.verdict, Verdict::Named);
    assert_eq!(diagnosis.causes[0].effect.effect.id, "target_slip");
    println!(
        "{:?}: {}",
        diagnosis.verdict, diagnosis.causes[0].effect.effect.id
    );
    Ok(())
}

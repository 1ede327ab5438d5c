//! `trueaxis schema`.
//!
//! Schemas of what serde reads or writes by its types are made from the types; those of results that are put together
//! by hand stand in files, and a test holds them against results.

use serde_json::{Value, json};
use trueaxis_diagnose::Diagnosis;
use trueaxis_effects::EffectsFile;
use trueaxis_simulate::Scenario;

use crate::args::{SchemaArgs, SchemaName};
use crate::exit::Exit;
use crate::output;

pub(crate) fn execute(args: &SchemaArgs) -> anyhow::Result<Exit> {
    output::print(&text(args.name)?)?;
    Ok(Exit::Good)
}

fn text(name: SchemaName) -> serde_json::Result<String> {
    match name {
        SchemaName::Campaign => Ok(trueaxis_campaign::schema()),
        SchemaName::Scenario => Ok(Scenario::schema()),
        SchemaName::Effects => Ok(EffectsFile::schema()),
        SchemaName::Calibration => Ok(include_str!("schema/calibration.json").to_owned()),
        SchemaName::Diagnosis => traced(&Diagnosis::schema()),
        SchemaName::Verification => traced(include_str!("schema/verification.json")),
        SchemaName::Volume => traced(include_str!("schema/volume.json")),
        SchemaName::Comparison => traced(include_str!("schema/comparison.json")),
        SchemaName::Montecarlo => traced(include_str!("schema/montecarlo.json")),
        SchemaName::Check => Ok(include_str!("schema/check.json").to_owned()),
        SchemaName::Truth => Ok(include_str!("schema/truth.json").to_owned()),
        SchemaName::Error => Ok(include_str!("schema/error.json").to_owned()),
    }
}

/// The schema of a result to which the program adds what it rests on.
fn traced(schema: &str) -> serde_json::Result<String> {
    let mut schema: Value = serde_json::from_str(schema)?;
    let text = json!({ "type": "string" });
    schema["properties"]["traceability"] = json!({
        "description": "What the result rests on: the program, its inputs with their checksums, a seed.",
        "type": "object",
        "properties": {
            "program": text,
            "inputs": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": { "name": text, "sha256": text },
                    "required": ["name", "sha256"],
                    "additionalProperties": false,
                },
            },
            "seed": { "type": "integer" },
        },
        "required": ["program", "inputs"],
        "additionalProperties": false,
    });
    if let Some(required) = schema["required"].as_array_mut() {
        required.push(json!("traceability"));
    }
    trueaxis_files::to_json(&schema)
}

//! `trueaxis schema`.
//!
//! Schemas of what serde reads or writes by its types are made from the types; those of results that are put together
//! by hand stand in files, and a test holds them against results.

use trueaxis_diagnose::Diagnosis;
use trueaxis_effects::EffectsFile;
use trueaxis_simulate::Scenario;

use crate::args::{SchemaArgs, SchemaName};
use crate::exit::Exit;
use crate::output;

pub(crate) fn run(args: &SchemaArgs) -> anyhow::Result<Exit> {
    output::print(&text(args.name))?;
    Ok(Exit::Good)
}

fn text(name: SchemaName) -> String {
    match name {
        SchemaName::Campaign => trueaxis_campaign::schema(),
        SchemaName::Scenario => Scenario::schema(),
        SchemaName::Effects => EffectsFile::schema(),
        SchemaName::Diagnosis => Diagnosis::schema(),
        SchemaName::Calibration => include_str!("schema/calibration.json").to_owned(),
        SchemaName::Verification => include_str!("schema/verification.json").to_owned(),
        SchemaName::Volume => include_str!("schema/volume.json").to_owned(),
        SchemaName::Comparison => include_str!("schema/comparison.json").to_owned(),
    }
}

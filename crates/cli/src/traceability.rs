//! What a result rests on: the program, its inputs with their checksums, a seed.

use std::path::Path;

use anyhow::Context;
use serde_json::{Value, json};
use trueaxis_campaign::InputFile;
use trueaxis_predict::{CalibratedMachine, FactoredCovariance};

/// The text of a result with its `traceability`.
pub(crate) fn traced(
    mut document: Value,
    inputs: &[InputFile],
    seed: Option<u64>,
) -> serde_json::Result<String> {
    let mut traceability = json!({
        "program": concat!("trueaxis ", env!("CARGO_PKG_VERSION")),
        "inputs": inputs,
    });
    if let Some(seed) = seed {
        traceability["seed"] = json!(seed);
    }
    document["traceability"] = traceability;
    trueaxis_files::to_json(&document)
}

/// A calibration and, if it has uncertainties, the covariance beside it.
pub(crate) fn of_calibration(
    path: &Path,
    machine: &CalibratedMachine,
) -> anyhow::Result<Vec<InputFile>> {
    let covariance = machine
        .has_uncertainties
        .then(|| path.with_file_name(FactoredCovariance::FILE));
    let all = std::iter::once(path.to_owned()).chain(covariance);
    let input =
        |path: std::path::PathBuf| InputFile::of(&path).with_context(|| path.display().to_string());
    all.map(input).collect()
}

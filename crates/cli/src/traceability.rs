//! What a result rests on: the program, its inputs with their checksums, a seed.

use std::path::Path;

use anyhow::Context;
use serde_json::{Value, json};
use trueaxis_calibrate::FactoredCovariance;
use trueaxis_campaign::InputFile;
use trueaxis_files::sha256;

/// The text of a result with its `traceability`.
pub(crate) fn traced(
    text: &str,
    inputs: &[InputFile],
    seed: Option<u64>,
) -> anyhow::Result<String> {
    let mut document: Value = serde_json::from_str(text)?;
    let mut traceability = json!({
        "program": concat!("trueaxis ", env!("CARGO_PKG_VERSION")),
        "inputs": inputs,
    });
    if let Some(seed) = seed {
        traceability["seed"] = json!(seed);
    }
    document["traceability"] = traceability;
    Ok(trueaxis_files::to_json(&document)?)
}

/// A calibration and the covariance beside it.
pub(crate) fn of_calibration(path: &Path) -> anyhow::Result<Vec<InputFile>> {
    let all = [
        path.to_owned(),
        path.with_file_name(FactoredCovariance::FILE),
    ];
    let input = |path: std::path::PathBuf| {
        let name = path.file_name().unwrap_or(path.as_os_str());
        let sha256 = sha256(&path).with_context(|| path.display().to_string())?;
        Ok(InputFile {
            name: name.to_string_lossy().into_owned(),
            sha256,
        })
    };
    all.into_iter().map(input).collect()
}

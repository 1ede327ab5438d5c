//! The scenarios of the repository, as JSON to be altered and as scenarios.

use std::path::{Path, PathBuf};

use serde_json::Value;
use trueaxis_simulate::Scenario;

pub(crate) const NAMES: [&str; 3] = ["fxyz", "rotary-stage", "five-axis"];

pub(crate) fn path(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.join("campaigns").join(name).join("scenario.json")
}

pub(crate) fn json(name: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path(name)).unwrap()).unwrap()
}

pub(crate) fn scenario(json: &Value) -> Scenario {
    Scenario::from_json(&json.to_string()).unwrap()
}

/// No noise and no rounding.
pub(crate) fn make_exact(json: &mut Value) {
    json["noise"] = serde_json::json!({
        "length_sigma_um": 0, "length_sigma_ppm": 0, "repeatability_um": 0, "exact": true
    });
}

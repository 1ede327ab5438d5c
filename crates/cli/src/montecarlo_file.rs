//! `montecarlo.json`, version 1.
//!
//! One entry for each result that neither gauge nor frame defines, in the units of
//! `calibration.json`.

use serde::Serialize;
use serde_json::Value;
use trueaxis_calibrate::{NumberedResult, Output};
use trueaxis_montecarlo::{FirstOrder, Outcome, Propagation, Summary, Validation};

/// One result by first order and by Monte Carlo, in the unit of its output.
pub(crate) struct Compared<'a> {
    pub(crate) result: &'a NumberedResult,
    pub(crate) first_order: FirstOrder,
    pub(crate) monte_carlo: Summary,
    pub(crate) validation: Validation,
}

#[derive(Serialize)]
struct File<'a> {
    format: &'static str,
    version: u32,
    campaign: &'a str,
    trials: usize,
    seed: u64,
    coverage: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    stabilised: Option<bool>,
    results: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    #[serde(flatten)]
    output: &'a Output,
    value: f64,
    u_first_order: f64,
    mean: f64,
    u: f64,
    u_standard_error: f64,
    symmetric: [f64; 2],
    shortest: [f64; 2],
    first_order_interval: &'static str,
}

/// The file.
pub(crate) fn document(
    campaign: &str,
    seed: u64,
    propagation: &Propagation,
    compared: &[Compared<'_>],
) -> serde_json::Result<Value> {
    serde_json::to_value(File {
        format: "trueaxis-montecarlo",
        version: 1,
        campaign,
        trials: propagation.trials,
        seed,
        coverage: propagation.coverage,
        stabilised: propagation.stability.as_ref().map(|s| s.stabilised),
        results: compared.iter().map(entry).collect(),
    })
}

fn entry<'a>(one: &Compared<'a>) -> Entry<'a> {
    let found = &one.monte_carlo;
    let rounded = |x: f64| (x * 1e9).round() / 1e9 + 0.0;
    Entry {
        output: &one.result.output,
        value: rounded(one.first_order.value),
        u_first_order: rounded(one.first_order.u),
        mean: rounded(found.mean),
        u: rounded(found.u),
        u_standard_error: rounded(found.scatter.u),
        symmetric: [found.symmetric.low, found.symmetric.high].map(rounded),
        shortest: [found.shortest.low, found.shortest.high].map(rounded),
        first_order_interval: match one.validation.outcome {
            Outcome::Validated => "validated",
            Outcome::NotValidated => "not validated",
            Outcome::Undecided => "not decided by so few trials",
        },
    }
}

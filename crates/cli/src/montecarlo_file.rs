//! `montecarlo.json`, version 1.
//!
//! One entry for each result that neither gauge nor frame defines, in the units of
//! `calibration.json`.

use serde_json::{Value, json};
use trueaxis_calibrate::NumberedResult;
use trueaxis_files::round;
use trueaxis_montecarlo::{FirstOrder, Outcome, Propagation, Summary, Validation};

/// One result by first order and by Monte Carlo, in the unit of its output.
pub(crate) struct Compared<'a> {
    pub(crate) result: &'a NumberedResult,
    pub(crate) first_order: FirstOrder,
    pub(crate) monte_carlo: Summary,
    pub(crate) validation: Validation,
}

pub(crate) fn document(
    campaign: &str,
    seed: u64,
    propagation: &Propagation,
    compared: &[Compared<'_>],
) -> serde_json::Result<Value> {
    let mut document = json!({
        "format": "trueaxis-montecarlo",
        "version": 1,
        "campaign": campaign,
        "trials": propagation.trials,
        "seed": seed,
        "coverage": propagation.coverage,
    });
    if let Some(stability) = &propagation.stability {
        document["stabilised"] = json!(stability.stabilised);
    }
    document["results"] = compared.iter().map(entry).collect::<Result<_, _>>()?;
    Ok(document)
}

fn entry(one: &Compared<'_>) -> serde_json::Result<Value> {
    let found = &one.monte_carlo;
    let rounded = |x: f64| round(x, 9);
    let mut entry = serde_json::to_value(&one.result.output)?;
    entry["value"] = json!(rounded(one.first_order.value));
    entry["u_first_order"] = json!(rounded(one.first_order.u));
    entry["mean"] = json!(rounded(found.mean));
    entry["u"] = json!(rounded(found.u));
    entry["u_standard_error"] = json!(rounded(found.scatter.u));
    for (field, interval) in [("symmetric", found.symmetric), ("shortest", found.shortest)] {
        entry[field] = json!([interval.low, interval.high].map(rounded));
    }
    entry["first_order_interval"] = json!(match one.validation.outcome {
        Outcome::Validated => "validated",
        Outcome::NotValidated => "not validated",
        Outcome::Undecided => "not decided by so few trials",
    });
    Ok(entry)
}

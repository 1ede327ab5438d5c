//! Verbs that say something about files and messages: `schema`, `explain`.

use clap::{Args as ClapArgs, ValueEnum};

#[derive(Debug, ClapArgs)]
pub(crate) struct SchemaArgs {
    /// The document.
    #[arg(value_name = "DOCUMENT", value_enum)]
    pub(crate) name: SchemaName,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum SchemaName {
    /// campaign.json, read by most verbs.
    Campaign,
    /// scenario.json, read by `simulate`.
    Scenario,
    /// effects.json, read by `calibrate --with-effects`.
    Effects,
    /// calibration.json, written by `calibrate`.
    Calibration,
    /// diagnosis.json, written by `diagnose`.
    Diagnosis,
    /// verification.json, written by `verify`.
    Verification,
    /// volume.json, written by `volume`.
    Volume,
    /// comparison.json, written by `compare`.
    Comparison,
    /// montecarlo.json, written by `montecarlo`.
    Montecarlo,
    /// What `check --json` prints.
    Check,
    /// truth.json, written by `simulate`.
    Truth,
    /// What a verb with --json prints if there is no result.
    Error,
}

#[derive(Debug, ClapArgs)]
pub(crate) struct ExplainArgs {
    /// The code, such as E104 [default: list all codes].
    #[arg(value_name = "CODE")]
    pub(crate) code: Option<String>,
}

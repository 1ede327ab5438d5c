//! What keeps a campaign from being diagnosed.

/// No diagnosis.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The campaign cannot be calibrated, so nothing can be predicted.
    #[error(transparent)]
    Calibrate(#[from] trueaxis_calibrate::Error),
    /// The lengths cannot be adjusted with rigid stages.
    #[error(transparent)]
    Adjustment(#[from] trueaxis_multilateration::Error),
    /// There is nothing to compare.
    #[error("the campaign has neither lengths nor verification readings to diagnose")]
    NothingMeasured,
}

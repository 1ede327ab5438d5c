//! Why a campaign cannot be diagnosed.

/// Why there is no diagnosis.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The campaign cannot be calibrated, so nothing can be predicted.
    #[error(transparent)]
    Calibrate(#[from] trueaxis_calibrate::Error),
    /// The lengths cannot be adjusted with rigid stages.
    #[error(transparent)]
    Adjustment(#[from] trueaxis_multilateration::Error),
    /// The calibration given is not of this machine.
    #[error(transparent)]
    OtherMachine(#[from] trueaxis_predict::OtherMachine),
    /// There is nothing to compare with the calibration given.
    #[error(
        "the campaign has no verification readings that a given calibration could be judged by; add them to `verification` of \
         campaign.json"
    )]
    NothingRead,
    /// There is nothing to compare.
    #[error("the campaign has neither lengths, points nor verification readings to diagnose")]
    NothingMeasured,
}

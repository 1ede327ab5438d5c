//! What to diagnose and how.

/// Settings of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// How the campaign is calibrated where the diagnosis says what a cause changes.
    pub calibration: trueaxis_calibrate::Settings,
}

//! What to diagnose and how.

/// Settings of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How the campaign is calibrated where the diagnosis says what a cause changes.
    pub calibration: trueaxis_calibrate::Settings,
    /// Whether to say what the calibrated error curves consist of (level components).
    pub explain_curves: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            calibration: trueaxis_calibrate::Settings::default(),
            explain_curves: true,
        }
    }
}

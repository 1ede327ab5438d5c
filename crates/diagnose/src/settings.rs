//! What to diagnose, and how.

/// Settings of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How to calibrate the campaign to find what a cause changes.
    pub calibration: trueaxis_calibrate::Settings,
    /// Whether to look for effects in the calibrated error curves (level components).
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

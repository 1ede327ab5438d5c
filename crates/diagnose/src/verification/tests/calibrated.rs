//! With a calibration.

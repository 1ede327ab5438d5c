//! Self-calibrating sequential multilateration with a laser tracker.

//! What a calibrated model of a machine gets wrong in the measured data, and why.

mod changes;
mod components;
mod diagnose;
mod diagnosis;
mod error;
mod lengths;
mod selection;
mod settings;
mod verification;

pub use diagnose::diagnose;
pub use diagnosis::{
    Cause, Change, Diagnosis, EstimatedParameter, Gain, LevelReport, Misfit, NotObservable,
    OmnibusTest, Place, Rival, Unexplained, Verdict,
};
pub use error::Error;
pub use settings::Settings;

//! The campaign that the command line names.

use std::path::Path;

use trueaxis_calibrate::{Settings, mistake_behind};
use trueaxis_campaign::{Campaign, read};

/// Reads it; an error begins with the mistake that would explain it.
pub(crate) fn read_campaign(path: &Path, settings: &Settings) -> anyhow::Result<Campaign> {
    read(path).map_err(|error| {
        let mistake = mistake_behind(&error, path, settings);
        let error = anyhow::Error::from(error);
        match mistake {
            Some(mistake) => error.context(format!("likely cause: {mistake}")),
            None => error,
        }
    })
}

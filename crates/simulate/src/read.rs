//! Reading a scenario from text, with the line of whatever is wrong.

use std::fs;
use std::path::Path;

use trueaxis_files::Place;

use crate::error::in_text;
use crate::plan::Plan;
use crate::{Error, Problem, Scenario};

impl Scenario {
    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// With file, line and reason.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let text = fs::read_to_string(path)
            .map_err(|source| Problem::Read(source).in_place(Place::file(path)))?;
        parse(&text, Some(path))
    }

    /// Reads and checks the text of a scenario.
    ///
    /// # Errors
    /// With line and reason.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        parse(text, None)
    }
}

fn parse(text: &str, file: Option<&Path>) -> Result<Scenario, Error> {
    let scenario: Scenario = Scenario::FORMAT.read(text, file)?;
    Plan::new(&scenario).map_err(|error| in_text(error, text, file))?;
    Ok(scenario)
}

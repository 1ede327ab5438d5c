//! The files of a folder of results.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde_json::Value;
use trueaxis_files::sha256;

use crate::Error;
use crate::calibration::Calibration;
use crate::diagnosis::Diagnosis;
use crate::residuals::Residuals;
use crate::verification::Verification;

/// The results of which at least one must be there.
pub(crate) const RESULTS: [&str; 3] = ["calibration.json", "diagnosis.json", "verification.json"];

/// What is in the folder; each file is optional.
pub(crate) struct Input {
    pub(crate) calibration: Option<Document<Calibration>>,
    pub(crate) diagnosis: Option<Document<Diagnosis>>,
    pub(crate) volume: Option<Value>,
    pub(crate) verification: Option<Document<Verification>>,
    pub(crate) residuals: Option<Residuals>,
    /// Files that do not belong to the others, in words.
    pub(crate) left_out: Vec<String>,
}

/// A JSON file as it stands, for the template, and in parts, for the figures.
pub(crate) struct Document<T> {
    pub(crate) raw: Value,
    pub(crate) parts: T,
}

impl Input {
    pub(crate) fn read(folder: &Path) -> Result<Self, Error> {
        let mut input = Self {
            calibration: read_parts(folder, "calibration")?,
            diagnosis: read_parts(folder, "diagnosis")?,
            volume: read_json(folder, "volume")?.map(|(_, value)| value),
            verification: read_parts(folder, "verification")?,
            residuals: Residuals::read(&folder.join("residuals.csv"))?,
            left_out: Vec::new(),
        };
        let has_u = |calibration: &Calibration| {
            let mut curves = calibration.axes.iter().flat_map(|a| a.components.values());
            curves.all(|curve| curve.u().len() == curve.values().len())
        };
        if input.calibration.take_if(|of| !has_u(&of.parts)).is_some() {
            input
                .left_out
                .push("calibration.json has no uncertainties and is left out.".to_owned());
        }
        if input.calibration.is_none() && input.diagnosis.is_none() && input.verification.is_none()
        {
            let folder = folder.to_path_buf();
            return Err(Error::NothingToReport { folder });
        }
        input.leave_out_strangers();
        input.leave_out_outdated(&folder.join("calibration.json"))?;
        Ok(input)
    }

    /// Lets go of what an earlier run on other data left in the folder.
    fn leave_out_strangers(&mut self) {
        let Some(calibration) = &self.calibration else {
            self.residuals = None;
            return;
        };
        let campaign = &calibration.parts.campaign;
        if self
            .diagnosis
            .as_ref()
            .is_some_and(|of| of.parts.campaign != *campaign)
        {
            self.diagnosis = None;
            self.left_out
                .push("diagnosis.json is of another campaign and left out.".to_owned());
        }
        let of_volume = self
            .volume
            .as_ref()
            .and_then(|volume| volume.get("campaign")?.as_str());
        if of_volume.is_some_and(|of| of != campaign) {
            self.volume = None;
            self.left_out
                .push("volume.json is of another campaign and left out.".to_owned());
        }
        let compared = self.verification.as_ref();
        if compared.is_some_and(|of| of.parts.calibration != *campaign) {
            self.verification = None;
            self.left_out
                .push("verification.json is of another calibration and left out.".to_owned());
        }
        let observations = calibration.parts.adjustment.observations;
        if self
            .residuals
            .as_ref()
            .is_some_and(|residuals| residuals.used() != observations)
        {
            self.residuals = None;
            self.left_out
                .push("residuals.csv is not of this calibration and left out.".to_owned());
        }
    }

    /// Lets go of what rests on other files than those of the calibration, or on another calibration.
    fn leave_out_outdated(&mut self, file: &Path) -> Result<(), Error> {
        let Some(calibration) = &self.calibration else {
            return Ok(());
        };
        let own = sha256(file).map_err(|source| Error::Unreadable {
            file: file.to_path_buf(),
            source,
        })?;
        let own = BTreeMap::from([("calibration.json", own.as_str())]);
        let is_other = |result: &Value| contradict(&checksums(result), &own);
        let of_campaign = checksums(&calibration.raw);
        let diagnosis = self.diagnosis.as_ref();
        let mut outdated = Vec::new();
        if diagnosis.is_some_and(|of| contradict(&checksums(&of.raw), &of_campaign)) {
            outdated.push("diagnosis.json is of other measurements");
            self.diagnosis = None;
        }
        if self.volume.as_ref().is_some_and(is_other) {
            outdated.push("volume.json is of another calibration");
            self.volume = None;
        }
        if self
            .verification
            .as_ref()
            .is_some_and(|of| is_other(&of.raw))
        {
            outdated.push("verification.json is of another calibration");
            self.verification = None;
        }
        let outdated = outdated.into_iter();
        self.left_out
            .extend(outdated.map(|what| format!("{what} and left out; make it again.")));
        Ok(())
    }
}

/// The checksums of the inputs of a result, by name.
fn checksums(result: &Value) -> BTreeMap<&str, &str> {
    let inputs = result["traceability"]["inputs"].as_array();
    let inputs = inputs.into_iter().flatten();
    let named =
        inputs.filter_map(|input| Some((input["name"].as_str()?, input["sha256"].as_str()?)));
    named.collect()
}

/// Whether a file of one name is another file in the other list.
fn contradict(a: &BTreeMap<&str, &str>, b: &BTreeMap<&str, &str>) -> bool {
    let mut both = a.iter().filter_map(|(name, sha)| Some((sha, b.get(name)?)));
    both.any(|(a, b)| a != b)
}

fn read_parts<T: DeserializeOwned>(
    folder: &Path,
    name: &str,
) -> Result<Option<Document<T>>, Error> {
    let Some((file, raw)) = read_json(folder, name)? else {
        return Ok(None);
    };
    match T::deserialize(&raw) {
        Ok(parts) => Ok(Some(Document { raw, parts })),
        Err(source) => Err(Error::NotAResult { file, source }),
    }
}

/// `<name>.json`, if it is there, of the format `trueaxis-<name>`, version 1.
fn read_json(folder: &Path, name: &str) -> Result<Option<(PathBuf, Value)>, Error> {
    let file = folder.join(format!("{name}.json"));
    let Some(text) = read_text(&file)? else {
        return Ok(None);
    };
    let value: Value = match serde_json::from_str(&text) {
        Ok(value) => value,
        Err(source) => return Err(Error::NotAResult { file, source }),
    };
    let expected = format!("trueaxis-{name} 1");
    let part = |field: &str| value.get(field).map_or("none".to_owned(), plain);
    let found = format!("{} {}", part("format"), part("version"));
    match found == expected {
        true => Ok(Some((file, value))),
        false => Err(Error::OtherFormat {
            file,
            found,
            expected,
        }),
    }
}

fn plain(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

/// The text of a file, if there is one.
pub(crate) fn read_text(file: &Path) -> Result<Option<String>, Error> {
    use std::io::ErrorKind::{NotADirectory, NotFound};
    match std::fs::read_to_string(file) {
        Ok(text) => Ok(Some(text)),
        Err(error) if matches!(error.kind(), NotFound | NotADirectory) => Ok(None),
        Err(source) => Err(Error::Unreadable {
            file: file.to_path_buf(),
            source,
        }),
    }
}

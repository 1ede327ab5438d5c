//! The files of a folder of results.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde_json::Value;
use trueaxis_files::sha256;

use crate::Error;
use crate::calibration::Calibration;
use crate::comparison::Comparison;
use crate::diagnosis::Diagnosis;
use crate::residuals::Residuals;
use crate::verification::Verification;

/// The results of which at least one must be there.
pub(crate) const RESULTS: [&str; 4] = [
    "calibration.json",
    "diagnosis.json",
    "verification.json",
    "comparison.json",
];

/// Within this, µm, residuals have the rms of the calibration: both are rounded to a ten-thousandth.
const ROUNDING_UM: f64 = 1e-3;

/// What is in the folder; each file is optional.
pub(crate) struct Input {
    pub(crate) calibration: Option<Document<Calibration>>,
    pub(crate) diagnosis: Option<Document<Diagnosis>>,
    pub(crate) volume: Option<Value>,
    pub(crate) montecarlo: Option<Value>,
    pub(crate) verification: Option<Document<Verification>>,
    pub(crate) comparison: Option<Document<Comparison>>,
    pub(crate) residuals: Option<Residuals>,
    /// Descriptions of the files that do not belong to the others.
    pub(crate) left_out: Vec<String>,
}

/// A JSON file as it stands, for the template, and in parts, for the figures.
pub(crate) struct Document<T> {
    pub(crate) raw: Value,
    pub(crate) parts: T,
}

impl Input {
    pub(crate) fn read(folder: &Path) -> Result<Self, Error> {
        // These two are large.
        let (calibration, residuals) = rayon::join(
            || read_parts(folder, "calibration"),
            || Residuals::read(&folder.join("residuals.csv")),
        );
        let mut input = Self {
            calibration: calibration?,
            diagnosis: read_parts(folder, "diagnosis")?,
            volume: read_json(folder, "volume")?.map(|(_, value)| value),
            montecarlo: read_json(folder, "montecarlo")?.map(|(_, value)| value),
            verification: read_parts(folder, "verification")?,
            comparison: read_parts(folder, "comparison")?,
            residuals: residuals?,
            left_out: Vec::new(),
        };
        let lacks_u = |calibration: &Calibration| {
            let mut curves = calibration.axes.iter().flat_map(|a| a.components.values());
            curves.any(|curve| curve.u().len() != curve.values().len())
        };
        let says = "calibration.json has no uncertainties and is left out.";
        let (calibration, left_out) = (&mut input.calibration, &mut input.left_out);
        leave_out(calibration, left_out, |of| lacks_u(&of.parts), says);
        let judged = (&input.diagnosis, &input.verification, &input.comparison);
        if input.calibration.is_none() && matches!(judged, (None, None, None)) {
            let folder = folder.to_path_buf();
            return Err(Error::NothingToReport { folder });
        }
        input.leave_out_strangers();
        input.leave_out_outdated(&folder.join("calibration.json"))?;
        Ok(input)
    }

    /// Leaves out results of other data that are still in the folder.
    fn leave_out_strangers(&mut self) {
        let Some(calibration) = &self.calibration else {
            self.residuals = None;
            return;
        };
        let (campaign, left_out) = (&calibration.parts.campaign, &mut self.left_out);
        let is_other = |of: &Document<Diagnosis>| of.parts.campaign != *campaign;
        let says = "diagnosis.json is of another campaign and left out.";
        leave_out(&mut self.diagnosis, left_out, is_other, says);
        let is_other =
            |result: &Value| result["campaign"].as_str().is_some_and(|of| of != campaign);
        let says = "volume.json is of another campaign and left out.";
        leave_out(&mut self.volume, left_out, is_other, says);
        let says = "montecarlo.json is of another campaign and left out.";
        leave_out(&mut self.montecarlo, left_out, is_other, says);
        let is_other = |of: &Document<Verification>| of.parts.calibration != *campaign;
        let says = "verification.json is of another calibration and left out.";
        leave_out(&mut self.verification, left_out, is_other, says);
        let is_other = |of: &Document<Comparison>| of.parts.second != *campaign;
        let says = "comparison.json is of another calibration and left out.";
        leave_out(&mut self.comparison, left_out, is_other, says);
        let adjustment = &calibration.parts.adjustment;
        // A point may be the mean of several readings: there are more residuals than observations.
        let is_other = |of: &Residuals| match (of.of_points, adjustment.rms_residual_um) {
            (true, Some(rms_um)) => (of.rms_um() - rms_um).abs() > ROUNDING_UM,
            _ => of.used().count() != adjustment.observations,
        };
        let says = "residuals.csv is not of this calibration and left out.";
        leave_out(&mut self.residuals, left_out, is_other, says);
    }

    /// Leaves out results of other files than those of the calibration, or of another calibration.
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
        let left_out = &mut self.left_out;
        let is_of_others = |of: &Document<_>| contradict(&checksums(&of.raw), &of_campaign);
        let says = "diagnosis.json is of other measurements and left out; make it again.";
        leave_out(&mut self.diagnosis, left_out, is_of_others, says);
        let is_of_others = |of: &Value| contradict(&checksums(of), &of_campaign);
        let says = "montecarlo.json is of other measurements and left out; make it again.";
        leave_out(&mut self.montecarlo, left_out, is_of_others, says);
        let says = "volume.json is of another calibration and left out; make it again.";
        leave_out(&mut self.volume, left_out, is_other, says);
        let says = "verification.json is of another calibration and left out; make it again.";
        leave_out(
            &mut self.verification,
            left_out,
            |of| is_other(&of.raw),
            says,
        );
        let says = "comparison.json is of another calibration and left out; make it again.";
        leave_out(&mut self.comparison, left_out, |of| is_other(&of.raw), says);
        Ok(())
    }
}

/// Leaves out a result that does not belong to the others, and says so.
fn leave_out<T>(
    result: &mut Option<T>,
    left_out: &mut Vec<String>,
    is_other: impl Fn(&T) -> bool,
    says: &str,
) {
    if result.take_if(|of| is_other(of)).is_some() {
        left_out.push(says.to_owned());
    }
}

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

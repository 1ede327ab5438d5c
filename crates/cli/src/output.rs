//! Result files: written whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use trueaxis_campaign::{Campaign, InputFile};

use crate::progress::end_clock;
use crate::report;
use crate::talk::say;

/// A result that cannot be written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OutputError {
    #[error(
        "{} cannot be written{}",
        path.display(),
        in_the_way(source)
    )]
    File { path: PathBuf, source: io::Error },
    #[error(
        "{} is there already and is not overwritten; move it away, or choose another place",
        path.display()
    )]
    Exists { path: PathBuf },
    #[error(
        "{} is of another machine, {machine}, whose campaign has the same name; choose another place with --out",
        path.display()
    )]
    OtherMachine { path: PathBuf, machine: String },
    #[error("standard output cannot be written")]
    StandardOutput(#[source] io::Error),
}

impl OutputError {
    fn at(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |source| Self::File { path, source }
    }
}

fn in_the_way(error: &io::Error) -> &'static str {
    use io::ErrorKind::{AlreadyExists, NotADirectory, QuotaExceeded, StorageFull};
    match error.kind() {
        StorageFull | QuotaExceeded => ": free space there, or choose another place",
        AlreadyExists | NotADirectory => {
            ": a file is in the way of a folder; choose another place, as with --out"
        }
        _ => "; choose another place, as with --out",
    }
}

/// The results of a verb in their folder.
pub(crate) struct Results {
    pub(crate) folder: PathBuf,
    written: Vec<PathBuf>,
    /// The page of all of them.
    page: Option<PathBuf>,
}

impl Results {
    /// In the folder that is given, or one in the current directory named after the campaign.
    pub(crate) fn new(given: Option<&Path>, campaign: &str) -> Result<Self, OutputError> {
        Ok(Self {
            folder: folder(given, campaign)?,
            written: Vec::new(),
            page: None,
        })
    }

    /// Writes a result whole or not at all.
    pub(crate) fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        self.write_by(name, |out| out.write_all(bytes))
    }

    /// Writes a result that is not held in memory, whole or not at all.
    pub(crate) fn write_by(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let path = self.folder.join(name);
        trueaxis_files::write_whole_by(&path, write).map_err(OutputError::at(&path))?;
        self.written.push(path);
        Ok(())
    }

    /// Writes a result that is large beside `others`, which are listed before it.
    pub(crate) fn write_beside(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()> + Send,
        others: impl FnOnce(&mut Self) -> anyhow::Result<()> + Send,
    ) -> anyhow::Result<()> {
        let path = self.folder.join(name);
        let large = || trueaxis_files::write_whole_by(&path, write).map_err(OutputError::at(&path));
        let (written, others) = rayon::join(large, || others(self));
        written?;
        self.written.push(path);
        others
    }

    /// Writes the page of all results in the folder.
    pub(crate) fn report(&mut self) -> anyhow::Result<()> {
        self.page = report::of_results(&self.folder)?;
        Ok(())
    }

    /// Notices of the files that are there from before: they would be taken for those of this one.
    pub(crate) fn left_from_before(&self, names: &[&str], says: &str) -> Vec<String> {
        let paths = names.iter().map(|name| self.folder.join(name));
        let earlier = paths.filter(|path| !self.written.contains(path) && path.exists());
        earlier
            .map(|path| format!("{} {says}", path.display()))
            .collect()
    }

    /// Says what was written and, for programs that ask for it, prints the result.
    pub(crate) fn end(&self, printed: Option<&str>) -> Result<(), OutputError> {
        for path in self.written.iter().chain(&self.page) {
            say(&format!("written: {}", path.display()));
        }
        printed.map_or(Ok(()), print)
    }
}

/// The folder for results: as given, or one in the current directory named after the campaign.
pub(crate) fn folder(given: Option<&Path>, campaign: &str) -> Result<PathBuf, OutputError> {
    let path = given.map_or_else(|| PathBuf::from(file_name(campaign)), Path::to_path_buf);
    std::fs::create_dir_all(&path).map_err(OutputError::at(&path))?;
    Ok(path)
}

/// Refuses to write a result beside or in place of those of another machine, where no folder is given and only the name of the
/// campaign chose it. That of other data of the machine can be made again: a notice.
pub(crate) fn replaced(
    given: Option<&Path>,
    name: &str,
    campaign: &Campaign,
    inputs: &[InputFile],
) -> Result<Option<String>, OutputError> {
    if given.is_some() {
        return Ok(None);
    }
    let folder = PathBuf::from(file_name(&campaign.name));
    for name in ["calibration.json", name] {
        let path = folder.join(name);
        let document = read_json(&path);
        let machine = [&document["machine"]["name"], &document["machine"]];
        let machine = machine.into_iter().find_map(Value::as_str);
        let is_other = |name: &&str| !name.is_empty() && *name != campaign.machine_name;
        if let Some(other) = machine.filter(is_other) {
            let machine = other.to_owned();
            return Err(OutputError::OtherMachine { path, machine });
        }
    }
    let path = folder.join(name);
    let before = &read_json(&path)["traceability"]["inputs"];
    let is_other = before.is_array() && *before != json!(inputs);
    let path = path.display();
    Ok(is_other.then(|| format!("{path} was of other data and is replaced; --out keeps both")))
}

/// A document that may be there from before; null if it is none.
fn read_json(path: &Path) -> Value {
    let bytes = std::fs::read(path).unwrap_or_default();
    serde_json::from_slice(&bytes).unwrap_or_default()
}

/// Writes a result whole or not at all.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    trueaxis_files::write_whole(path, bytes).map_err(OutputError::at(path))
}

/// The same for one of many files that can be made again.
pub(crate) fn write_derived(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    trueaxis_files::write_derived(path, bytes).map_err(OutputError::at(path))
}

/// Refuses to go on if one of these files is there already.
pub(crate) fn refuse_old(paths: impl IntoIterator<Item = PathBuf>) -> Result<(), OutputError> {
    let mut old = paths
        .into_iter()
        .filter(|path| path.symlink_metadata().is_ok());
    old.next()
        .map_or(Ok(()), |path| Err(OutputError::Exists { path }))
}

/// Writes files that become the user's own, whole or not at all. If one is there already, none is written.
pub(crate) fn write_all_new(files: &[(&Path, String)]) -> Result<(), OutputError> {
    refuse_old(files.iter().map(|(path, _)| path.to_path_buf()))?;
    for (path, text) in files {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(OutputError::at(folder))?;
        }
        write(path, text.as_bytes())?;
    }
    Ok(())
}

/// Data on standard output. A reader that stops early (`| head`) is no error.
pub(crate) fn print(text: &str) -> Result<(), OutputError> {
    end_clock();
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(OutputError::StandardOutput),
    }
}

/// A campaign's name as a folder name: lower case letters, digits and single hyphens.
fn file_name(campaign: &str) -> String {
    let mut name = String::new();
    for c in campaign.chars().flat_map(char::to_lowercase) {
        if c.is_alphanumeric() {
            name.push(c);
        } else if !name.is_empty() && !name.ends_with('-') {
            name.push('-');
        }
    }
    let name = name.trim_end_matches('-');
    match name {
        "" => "calibration".to_owned(),
        name => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folder_names_are_plain() {
        assert_eq!(file_name("FXYZ machine"), "fxyz-machine");
        assert_eq!(file_name("../..//etc: *Müller*"), "etc-müller");
        assert_eq!(file_name("/"), "calibration");
    }
}

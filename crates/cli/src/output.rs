//! Result files: written whole or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A result that cannot be written.
#[derive(Debug)]
pub(crate) struct OutputError {
    /// `None` for standard output.
    path: Option<PathBuf>,
    /// `None` if the file is there and is not to be overwritten.
    source: Option<io::Error>,
}

impl std::fmt::Display for OutputError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (&self.path, &self.source) {
            (Some(path), Some(source)) if is_file_in_the_way(source) => {
                let path = path.display();
                write!(
                    f,
                    "{path} cannot be written: a file is in the way of a folder; choose another place, as with --out"
                )
            }
            (Some(path), Some(_)) => {
                let path = path.display();
                write!(
                    f,
                    "{path} cannot be written; choose another place, as with --out"
                )
            }
            (Some(path), None) => {
                let path = path.display();
                write!(
                    f,
                    "{path} is there already and is not overwritten; move it away, or choose another place"
                )
            }
            (None, _) => write!(f, "standard output cannot be written"),
        }
    }
}

impl OutputError {
    /// The code of the error.
    pub(crate) fn code(&self) -> &'static str {
        match self.source {
            Some(_) => "E004",
            None => "E005",
        }
    }
}

impl std::error::Error for OutputError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.source.as_ref().map(|source| source as _)
    }
}

fn is_file_in_the_way(error: &io::Error) -> bool {
    use io::ErrorKind::{AlreadyExists, NotADirectory};
    matches!(error.kind(), AlreadyExists | NotADirectory)
}

/// The folder for results: as given, or one in the current directory named after the campaign.
pub(crate) fn folder(given: Option<&Path>, campaign: &str) -> Result<PathBuf, OutputError> {
    let path = given.map_or_else(|| PathBuf::from(file_name(campaign)), Path::to_path_buf);
    match std::fs::create_dir_all(&path) {
        Ok(()) => Ok(path),
        Err(source) => Err(OutputError {
            path: Some(path),
            source: Some(source),
        }),
    }
}

/// Writes a result whole or not at all.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write_by(path, |out| out.write_all(bytes))
}

/// Writes files that become the user's own, whole or not at all. If one is there already, none is written.
pub(crate) fn write_all_new(files: &[(&Path, String)]) -> Result<(), OutputError> {
    if let Some((path, _)) = files
        .iter()
        .find(|(path, _)| path.symlink_metadata().is_ok())
    {
        return Err(OutputError {
            path: Some(path.to_path_buf()),
            source: None,
        });
    }
    for (path, text) in files {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|source| OutputError {
                path: Some(folder.to_path_buf()),
                source: Some(source),
            })?;
        }
        write(path, text.as_bytes())?;
    }
    Ok(())
}

/// Writes a result that is not held in memory, whole or not at all.
pub(crate) fn write_by(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    let failed = |source| OutputError {
        path: Some(path.to_path_buf()),
        source: Some(source),
    };
    trueaxis_files::write_whole_by(path, write).map_err(failed)
}

/// Data on standard output. A reader that stops early (`| head`) is no error.
pub(crate) fn print(text: &str) -> Result<(), OutputError> {
    match io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(source) => Err(OutputError {
            path: None,
            source: Some(source),
        }),
        Ok(()) => Ok(()),
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
    if name.is_empty() {
        "calibration".to_owned()
    } else {
        name.to_owned()
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

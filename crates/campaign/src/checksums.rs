//! Which files a result is based on.

use std::path::{Path, PathBuf};

use serde::Serialize;
use trueaxis_files::{FileProblem, sha256};

use crate::document::{Document, FORMAT};
use crate::{Error, Place, Problem, text_file};

/// A file of a campaign.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct InputFile {
    /// Its name: that of the campaign file, and of others as that names them.
    pub name: String,
    /// SHA-256 of its bytes, 64 hexadecimal digits.
    pub sha256: String,
}

/// The campaign file at `path` and all files that it names, with their checksums.
///
/// # Errors
/// If one of them cannot be read, or `path` is no campaign file.
pub fn checksums(path: &Path) -> Result<Vec<InputFile>, Error> {
    let text = text_file::read(path, "give the path of a campaign.json")?;
    let document: Document = FORMAT.read(&text, Some(path))?;
    let tables = [document.lengths, document.points].into_iter().flatten();
    let readings = document
        .verification
        .into_iter()
        .map(|entry| entry.readings);
    let folder = path.parent().unwrap_or(Path::new(""));
    let named = tables.chain(readings);
    let named = named.map(|name| (folder.join(&name), name));
    let all = std::iter::once((path.to_owned(), own_name(path))).chain(named);
    let checksum = |(file, name): (PathBuf, String)| {
        let sha256 = sha256(&file).map_err(|source| {
            Problem::File(FileProblem::Unreadable { source }).at(Place::file(&file))
        })?;
        Ok(InputFile { name, sha256 })
    };
    all.map(checksum).collect()
}

fn own_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

impl InputFile {
    /// The file at `path`, by its own name.
    pub fn of(path: &Path) -> std::io::Result<Self> {
        let (name, sha256) = (own_name(path), sha256(path)?);
        Ok(Self { name, sha256 })
    }
}

//! Which files a result rests on.

use std::fmt::Write;
use std::fs::File;
use std::io;
use std::path::Path;

use serde::Serialize;
use sha2::{Digest, Sha256};

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
/// If one of them cannot be read, or the campaign file is none.
pub fn checksums(path: &Path) -> Result<Vec<InputFile>, Error> {
    let text = text_file::read(path, "give the path of a campaign.json")?;
    let document: Document = FORMAT.read(&text, Some(path))?;
    let own = path.file_name().unwrap_or(path.as_os_str());
    let readings = document
        .verification
        .into_iter()
        .map(|entry| entry.readings);
    let named = document
        .lengths
        .into_iter()
        .chain(document.points)
        .chain(readings);
    let folder = path.parent().unwrap_or(Path::new(""));
    let named = named.map(|name| (folder.join(&name), name));
    let all = std::iter::once((path.to_owned(), own.to_string_lossy().into_owned())).chain(named);
    let checksum = |(file, name): (std::path::PathBuf, String)| {
        let sha256 = sha256(&file)
            .map_err(|source| Problem::Unreadable { source }.at(Place::file(&file)))?;
        Ok(InputFile { name, sha256 })
    };
    all.map(checksum).collect()
}

impl InputFile {
    /// The file at `path`, by its own name.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn of(path: &Path) -> io::Result<Self> {
        let name = path.file_name().unwrap_or(path.as_os_str());
        Ok(Self {
            name: name.to_string_lossy().into_owned(),
            sha256: sha256(path)?,
        })
    }
}

fn sha256(file: &Path) -> io::Result<String> {
    let mut hasher = Sha256::new();
    io::copy(
        &mut io::BufReader::new(File::open(file)?),
        &mut HashWriter(&mut hasher),
    )?;
    let digits = hasher
        .finalize()
        .iter()
        .fold(String::new(), |mut text, byte| {
            // Writing to a string does not fail.
            let _ = write!(text, "{byte:02x}");
            text
        });
    Ok(digits)
}

/// What is written is hashed.
struct HashWriter<'h>(&'h mut Sha256);

impl io::Write for HashWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FIPS 180-2, appendix B.1.
    #[test]
    fn the_checksum_is_the_published_one() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "abc").unwrap();
        assert_eq!(
            sha256(file.path()).unwrap(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}

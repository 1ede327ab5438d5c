//! Named arrays in one file, as `numpy.savez` writes them: a ZIP archive of `.npy` files, not compressed.

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::npy::{Array, NpyError, from_npy};

/// Ending of the members' names.
const MEMBER: &str = ".npy";

/// A `.npz` file that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum NpzError {
    /// It is no ZIP archive, or one that was cut off.
    #[error("the file is no whole NumPy archive (.npz)")]
    Archive(#[source] ZipError),
    /// An array in it cannot be read.
    #[error("array `{name}`: {problem}")]
    Array {
        /// Its name.
        name: String,
        /// Why.
        problem: NpyError,
    },
}

/// The bytes of a `.npz` file of arrays with these names, each given as the bytes of its `.npy` file
/// ([`crate::to_npy`]): always the same for the same arrays, without the time of the day.
///
/// # Panics
/// If two arrays have the same name.
pub fn to_npz(arrays: &[(&str, Vec<u8>)]) -> Vec<u8> {
    // Writing to memory fails only for names that are used twice.
    write(arrays).expect("arrays with different names make an archive")
}

fn write(arrays: &[(&str, Vec<u8>)]) -> Result<Vec<u8>, ZipError> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in arrays {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::default())
            .large_file(u32::try_from(bytes.len()).is_err());
        archive.start_file(format!("{name}{MEMBER}"), options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// The arrays of a `.npz` file by name.
///
/// # Errors
/// [`NpzError`], with the name of the array.
pub fn from_npz(bytes: &[u8]) -> Result<BTreeMap<String, Array>, NpzError> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(NpzError::Archive)?;
    let mut arrays = BTreeMap::new();
    for i in 0..archive.len() {
        let mut member = archive.by_index(i).map_err(NpzError::Archive)?;
        let name = member.name().to_owned();
        let name = name.strip_suffix(MEMBER).unwrap_or(&name).to_owned();
        let mut content = Vec::new();
        let read = member.read_to_end(&mut content);
        read.map_err(|error| NpzError::Archive(error.into()))?;
        match from_npy(&content) {
            Ok(array) => arrays.insert(name, array),
            Err(problem) => return Err(NpzError::Array { name, problem }),
        };
    }
    Ok(arrays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::to_npy;

    #[test]
    fn arrays_come_back_and_a_file_that_was_cut_off_does_not() {
        let a = to_npy(&[2, 3], (0..6).map(f64::from));
        let b = to_npy(&[0], std::iter::empty());
        let bytes = to_npz(&[("a", a.clone()), ("b", b)]);
        let arrays = from_npz(&bytes).unwrap();
        assert_eq!(arrays["a"].shape, [2, 3]);
        assert_eq!(arrays["a"].data, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert!(arrays["b"].data.is_empty());
        let cut = from_npz(&bytes[..bytes.len() - 30]).unwrap_err();
        assert!(matches!(cut, NpzError::Archive(_)), "{cut}");
        let text = to_npz(&[("a", b"not an array".to_vec())]);
        let text = from_npz(&text).unwrap_err().to_string();
        assert!(text.contains("array `a`"), "{text}");
    }
}

//! Named arrays in one file, as `numpy.savez` writes them: a ZIP archive of `.npy` files, not compressed.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read, Seek, Write};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::npy::{Array, NpyError, from_npy, write_npy};

/// Ending of the members' names.
const MEMBER: &str = ".npy";

/// A member may be larger than 4 GiB if its elements take more: room for its header.
const SMALL: usize = u32::MAX as usize - (1 << 16);

/// A `.npz` file that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum NpzError {
    /// It is not a ZIP archive, or one that was cut off.
    #[error("the file is not a complete NumPy archive (.npz)")]
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

/// Where an archive is written: a file or memory.
pub trait WriteSeek: Write + Seek {}

impl<W: Write + Seek> WriteSeek for W {}

/// Writes a `.npz` file array by array: always the same bytes for the same arrays, without the time of day.
pub struct NpzWriter<W: Write + Seek>(ZipWriter<W>);

impl<W: Write + Seek> NpzWriter<W> {
    /// To `out`, from where that stands.
    pub fn new(out: W) -> Self {
        Self(ZipWriter::new(out))
    }

    /// Writes an array, `data` in C order (the last index runs fastest), as the elements come.
    ///
    /// # Errors
    /// Those of `out`; if there is an array with this name already.
    ///
    /// # Panics
    /// If `data` does not have as many elements as `shape` says, or `shape` more than 32 dimensions.
    pub fn array(
        &mut self,
        name: &str,
        shape: &[usize],
        data: impl Iterator<Item = f64>,
    ) -> io::Result<()> {
        let size = 8 * shape.iter().product::<usize>();
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(zip::DateTime::default())
            .large_file(size > SMALL);
        self.0.start_file(format!("{name}{MEMBER}"), options)?;
        write_npy(&mut self.0, shape, data)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn finish(self) -> io::Result<W> {
        Ok(self.0.finish()?)
    }
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

    #[test]
    fn arrays_come_back_and_a_file_that_was_cut_off_does_not() {
        let mut npz = NpzWriter::new(Cursor::new(Vec::new()));
        npz.array("a", &[2, 3], (0..6).map(f64::from)).unwrap();
        npz.array("b", &[0], std::iter::empty()).unwrap();
        let bytes = npz.finish().unwrap().into_inner();
        let arrays = from_npz(&bytes).unwrap();
        assert_eq!(arrays["a"].shape, [2, 3]);
        assert_eq!(arrays["a"].data, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert!(arrays["b"].data.is_empty());
        let cut = from_npz(&bytes[..bytes.len() - 30]).unwrap_err();
        assert!(matches!(cut, NpzError::Archive(_)), "{cut}");

        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default();
        archive.start_file("a.npy", options).unwrap();
        archive.write_all(b"not an array").unwrap();
        let bytes = archive.finish().unwrap().into_inner();
        let text = from_npz(&bytes).unwrap_err().to_string();
        assert!(text.contains("array `a`"), "{text}");
    }
}

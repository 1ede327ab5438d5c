//! Named arrays in one file, as `numpy.savez` writes them: a ZIP archive of `.npy` files, not compressed.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read, Seek, SeekFrom, Write};

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
pub struct NpzWriter<W: Write + Seek>(ZipWriter<FirstError<W>>);

/// Keeps the first error of a writer and takes everything after it: an archive that is dropped after an error tries to end itself, and
/// would say on the terminal that it cannot.
struct FirstError<W> {
    out: W,
    error: Option<io::Error>,
}

impl<W> FirstError<W> {
    fn done<T>(&mut self, done: io::Result<T>, instead: T) -> T {
        done.unwrap_or_else(|error| {
            self.error.get_or_insert(error);
            instead
        })
    }
}

impl<W: Write> Write for FirstError<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.error.is_some() {
            return Ok(bytes.len());
        }
        let done = self.out.write(bytes);
        Ok(self.done(done, bytes.len()))
    }

    fn flush(&mut self) -> io::Result<()> {
        let done = self.out.flush();
        self.done(done, ());
        Ok(())
    }
}

impl<W: Seek> Seek for FirstError<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let done = self.out.seek(to);
        Ok(self.done(done, 0))
    }
}

impl<W: Write + Seek> NpzWriter<W> {
    /// To `out`, from where that stands.
    pub fn new(out: W) -> Self {
        Self(ZipWriter::new(FirstError { out, error: None }))
    }

    /// Writes an array, `data` in C order (the last index runs fastest), as the elements come.
    ///
    /// # Errors
    /// If there is an array with this name already; those of `out` come at the end.
    ///
    /// # Panics
    /// If `data` does not have as many elements as `shape` says.
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
    pub fn finish(self) -> io::Result<W> {
        let mut out = self.0.finish()?;
        out.flush()?;
        match out.error {
            Some(error) => Err(error),
            None => Ok(out.out),
        }
    }
}

/// The arrays of a `.npz` file by name.
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

    /// A disk with this much room.
    struct Full(Cursor<Vec<u8>>, usize);

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.0.get_ref().len() + bytes.len() > self.1 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.0.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for Full {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.0.seek(to)
        }
    }

    #[test]
    fn a_full_disk_is_an_error_at_the_end() {
        for (room, fits) in [(1 << 20, true), (4000, false)] {
            let mut npz = NpzWriter::new(Full(Cursor::new(Vec::new()), room));
            npz.array("a", &[1000], (0..1000).map(f64::from)).unwrap();
            let end = npz.finish();
            let kind = end.map_err(|error| error.kind()).map(drop);
            let expected = if fits {
                Ok(())
            } else {
                Err(io::ErrorKind::StorageFull)
            };
            assert_eq!(kind, expected);
        }
    }
}

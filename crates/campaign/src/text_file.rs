//! Reading a text file as UTF-8.

use std::fs;
use std::io;
use std::path::Path;

use crate::{Error, Place};

const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// The text of `file` without a byte order mark. `mend` says what to do if it is not there.
pub(crate) fn read(file: &Path, mend: &str) -> Result<String, Error> {
    let place = || Place::file(file);
    if file.is_dir() {
        return Err(Error::Folder {
            place: place(),
            mend: mend.to_owned(),
        });
    }
    let mut bytes = fs::read(file).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => Error::NotFound {
            place: place(),
            mend: mend.to_owned(),
        },
        _ => Error::Unreadable {
            place: place(),
            source,
        },
    })?;
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    if bytes.trim_ascii().is_empty() {
        return Err(Error::Empty { place: place() });
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        Error::NotUtf8 {
            place: Place::line(file, 1 + newlines(valid)),
        }
    })
}

/// Number of line ends.
pub(crate) fn newlines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&b| b == b'\n').count()
}

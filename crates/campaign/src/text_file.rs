//! Reading a text file as UTF-8.

use std::path::Path;

use trueaxis_files::read_bytes;

use crate::{Error, Place, Problem};

const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// The text of `file` without a byte order mark. `hint` says what to do if it is not there.
pub(crate) fn read(file: &Path, hint: &str) -> Result<String, Error> {
    let place = || Place::file(file);
    let bytes = read_bytes(file, hint);
    let mut bytes = bytes.map_err(|problem| Problem::File(problem).at(place()))?;
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    if bytes.trim_ascii().is_empty() {
        return Err(Problem::Empty.at(place()));
    }
    if bytes.contains(&0) {
        return Err(Problem::NulBytes.at(place()));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        Problem::NotUtf8.at(Place::line(file, 1 + newlines(valid)))
    })
}

/// Number of line ends.
pub(crate) fn newlines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&b| b == b'\n').count()
}

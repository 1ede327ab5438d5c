//! Arrays as `NumPy` files.
//!
//! Format 1.0 (NEP 1): magic string, version, length of the header, the header as a Python literal
//! padded with spaces to a multiple of 64 bytes, then the elements.

use std::io::{self, Write};

/// What a file starts with: magic string and version 1.0.
const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// The elements begin at a multiple of this, so that the file can be mapped into memory.
const ALIGNMENT: usize = 64;

/// The bytes of a `.npy` file of an array with that `shape`, `data` in C order (the last index
/// runs fastest): little-endian f64, format 1.0.
///
/// ```
/// let bytes = trueaxis_files::to_npy(&[2, 2], [1.0, 2.0, 3.0, 4.0].into_iter());
/// assert_eq!(bytes.len(), 128 + 4 * 8);
/// ```
///
/// # Panics
/// If `data` does not have as many elements as `shape` says.
pub fn to_npy(shape: &[usize], data: impl Iterator<Item = f64>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(2 * ALIGNMENT + 8 * shape.iter().product::<usize>());
    // Memory takes everything.
    write_npy(&mut bytes, shape, data).expect("memory can be written");
    bytes
}

/// Elements that are written at a time.
const BUFFER: usize = 8192;

/// Writes the `.npy` file that [`to_npy`] makes, as the elements come.
///
/// # Errors
/// Those of the writer.
///
/// # Panics
/// As [`to_npy`].
pub(crate) fn write_npy(
    out: &mut impl Write,
    shape: &[usize],
    data: impl Iterator<Item = f64>,
) -> io::Result<()> {
    let count: usize = shape.iter().product();
    let header = header(shape);
    out.write_all(MAGIC)?;
    // The 32 dimensions of 20 digits that NumPy takes at the most stay far below the largest u16.
    out.write_all(&u16::try_from(header.len()).unwrap_or(0).to_le_bytes())?;
    out.write_all(header.as_bytes())?;
    let (mut found, mut used) = (0, 0);
    let mut bytes = vec![0; 8 * BUFFER];
    // As the iterator runs itself: one of nested rows would have to find its place for each element.
    data.map(f64::to_le_bytes).try_for_each(|value| {
        bytes[used..used + 8].copy_from_slice(&value);
        (found, used) = (found + 1, used + 8);
        if used == bytes.len() {
            out.write_all(&bytes)?;
            used = 0;
        }
        io::Result::Ok(())
    })?;
    assert_eq!(found, count, "elements of an array of shape {shape:?}");
    out.write_all(&bytes[..used])
}

fn header(shape: &[usize]) -> String {
    let sizes: Vec<String> = shape.iter().map(usize::to_string).collect();
    // A Python tuple of one element ends with a comma.
    let comma = if shape.len() == 1 { "," } else { "" };
    let mut header = format!(
        "{{'descr': '<f8', 'fortran_order': False, 'shape': ({}{comma}), }}",
        sizes.join(", ")
    );
    let unpadded = MAGIC.len() + 2 + header.len() + 1;
    let padding = unpadded.next_multiple_of(ALIGNMENT) - unpadded;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    header
}

/// An array of f64 in C order.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Size of each dimension.
    pub shape: Vec<usize>,
    /// Its elements, the last index runs fastest.
    pub data: Vec<f64>,
}

/// A `.npy` file that cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NpyError {
    /// The bytes do not begin as those of an array of the kind that [`to_npy`] writes.
    #[error("expected an array of little-endian f64 in C order (NumPy 1.0)")]
    NotThatArray,
    /// Too many or too few elements.
    #[error("found {found} bytes, expected {expected} for an array of shape {shape:?}")]
    Size {
        /// Bytes of the elements.
        found: usize,
        /// Those of the shape.
        expected: usize,
        /// The shape.
        shape: Vec<usize>,
    },
}

/// The array of the bytes of a `.npy` file as [`to_npy`] writes it.
///
/// # Errors
/// [`NpyError`] for any other bytes.
pub fn from_npy(bytes: &[u8]) -> Result<Array, NpyError> {
    let (shape, elements) = shape_of(bytes).ok_or(NpyError::NotThatArray)?;
    let count = shape
        .iter()
        .try_fold(1_usize, |n, &size| n.checked_mul(size));
    let expected = count
        .and_then(|n| n.checked_mul(8))
        .ok_or(NpyError::NotThatArray)?;
    if elements.len() != expected {
        let found = elements.len();
        return Err(NpyError::Size {
            found,
            expected,
            shape,
        });
    }
    let (elements, _) = elements.as_chunks::<8>();
    let data = elements.iter().map(|bytes| f64::from_le_bytes(*bytes));
    Ok(Array {
        shape,
        data: data.collect(),
    })
}

/// The shape, and the bytes behind the header.
fn shape_of(bytes: &[u8]) -> Option<(Vec<usize>, &[u8])> {
    let rest = bytes.strip_prefix(MAGIC)?;
    let (length, rest) = rest.split_first_chunk::<2>()?;
    let (header, elements) = rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))?;
    let header = std::str::from_utf8(header).ok()?;
    let plain = header.contains("'<f8'") && header.contains("'fortran_order': False");
    let (_, tuple) = header.split_once("'shape': (")?;
    let sizes = tuple.split_once(')')?.0.split(',').map(str::trim);
    let sizes = sizes.filter(|size| !size.is_empty());
    let shape: Option<Vec<usize>> = sizes.map(|size| size.parse().ok()).collect();
    Some((shape.filter(|_| plain)?, elements))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_is_that_of_numpy() {
        for (shape, text) in [
            (&[2, 3][..], "'shape': (2, 3), }"),
            (&[7], "'shape': (7,), }"),
            (&[], "'shape': (), }"),
        ] {
            let count = shape.iter().product::<usize>();
            let bytes = to_npy(shape, (0..count).map(|i| i as f64));
            assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
            let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            let start = 10 + length;
            assert_eq!(start % 64, 0);
            let header = std::str::from_utf8(&bytes[10..start]).unwrap();
            assert!(header.ends_with('\n') && header.contains(text), "{header}");
            assert_eq!(bytes.len(), start + 8 * count);
            assert_eq!(from_npy(&bytes).unwrap().shape, shape);
            assert!(from_npy(&bytes[..bytes.len() - 1]).is_err());
        }
    }

    #[test]
    fn elements_are_little_endian_in_the_order_given() {
        let bytes = to_npy(&[2], [1.0, -2.5].into_iter());
        let data = &bytes[bytes.len() - 16..];
        assert_eq!(data[..8], [0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
        assert_eq!(data[8..], (-2.5_f64).to_le_bytes());
    }

    #[test]
    #[should_panic(expected = "elements of an array")]
    fn a_wrong_number_of_elements_is_refused() {
        to_npy(&[2, 2], [1.0].into_iter());
    }
}

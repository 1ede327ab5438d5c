//! From bytes to text, in the encodings that exports come in.

use crate::Problem;

/// The text of a file in UTF-8, UTF-16 with a byte order mark, or, if it is neither, Latin-1.
///
/// Line ends of CR alone become LF. Digits, letters and separators are the same in all of them; only signs as µ and ° are at stake.
pub(crate) fn decode(bytes: &[u8]) -> Result<String, Problem> {
    let wide = |unit: fn([u8; 2]) -> u16| {
        let units = bytes[2..].chunks_exact(2).map(|b| unit([b[0], b[1]]));
        char::decode_utf16(units)
            .map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect::<String>()
    };
    let text = match bytes {
        [0xFF, 0xFE, ..] => wide(u16::from_le_bytes),
        [0xFE, 0xFF, ..] => wide(u16::from_be_bytes),
        [0xEF, 0xBB, 0xBF, rest @ ..] => narrow(rest),
        _ => narrow(bytes),
    };
    if text.contains('\0') {
        return Err(Problem::NoText);
    }
    if !text.contains('\n') {
        return Ok(text.replace('\r', "\n"));
    }
    Ok(text)
}

fn narrow(bytes: &[u8]) -> String {
    let latin_1 = |_| bytes.iter().map(|&byte| char::from(byte)).collect();
    std::str::from_utf8(bytes).map_or_else(latin_1, str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_encodings() {
        for bytes in [
            "1,5 µm".as_bytes(),
            b"\xEF\xBB\xBF1,5 \xC2\xB5m",
            b"1,5 \xB5m",
            b"\xFF\xFE1\0,\x005\0 \0\xB5\0m\0",
            b"\xFE\xFF\x001\0,\x005\0 \0\xB5\0m",
        ] {
            assert_eq!(decode(bytes).unwrap(), "1,5 µm");
        }
        assert!(matches!(decode(b"PK\x03\x04\0\0"), Err(Problem::NoText)));
    }
}

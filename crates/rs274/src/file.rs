//! Input files: regular files of limited size, as bytes or as text.
//!
//! Text may be UTF-8 or UTF-16, with or without a byte-order mark. Lines may end in LF, CR LF or CR.

use std::fs::{self, File, FileType};
use std::io::{self, Read};
use std::path::Path;

/// Largest program, tool table or parameter file, bytes.
pub const LARGEST_PROGRAM: u64 = 1 << 28;

/// The bytes of a regular file.
///
/// # Errors
/// When the file cannot be read, is a folder, device or pipe, or is larger than `limit` bytes. The size is checked while reading.
pub fn bytes(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let kind = fs::metadata(path)?.file_type();
    if !kind.is_file() {
        let message = format!("it is {}, not a regular file", what(kind));
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("it is larger than the limit of {limit} bytes"),
        ));
    }
    Ok(bytes)
}

/// The text of a regular file. Bytes that are not UTF-8 become U+FFFD: old programs have comments in any character set.
///
/// # Errors
/// As [`bytes`].
pub fn text(path: &Path, limit: u64) -> io::Result<String> {
    Ok(decode(bytes(path, limit)?))
}

/// Bytes as text without a byte-order mark, with LF at the ends of lines.
#[must_use]
pub fn decode(bytes: Vec<u8>) -> String {
    let text = match utf16_order(&bytes) {
        Some(order) => utf16(&bytes, order),
        None => String::from_utf8(bytes).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned()),
    };
    let text = match text.strip_prefix('\u{feff}') {
        Some(text) => text.to_owned(),
        None => text,
    };
    if text.contains('\r') { text.replace("\r\n", "\n").replace('\r', "\n") } else { text }
}

/// A UTF-16 unit from two bytes.
type Order = fn([u8; 2]) -> u16;

/// Pairs of bytes that show the byte order of UTF-16 without a mark.
const TELLING_PAIRS: usize = 4;

/// Byte order of UTF-16: by its mark, or else because the first characters are ASCII, a zero beside each.
#[must_use]
pub fn utf16_order(bytes: &[u8]) -> Option<Order> {
    let is_ascii = |byte: u8| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~');
    let first = &bytes.as_chunks::<2>().0[..TELLING_PAIRS.min(bytes.len() / 2)];
    match first {
        [[0xFF, 0xFE], ..] => Some(u16::from_le_bytes),
        [[0xFE, 0xFF], ..] => Some(u16::from_be_bytes),
        _ if first.len() < TELLING_PAIRS => None,
        _ if first.iter().all(|&[low, high]| is_ascii(low) && high == 0) => Some(u16::from_le_bytes),
        _ if first.iter().all(|&[high, low]| is_ascii(low) && high == 0) => Some(u16::from_be_bytes),
        _ => None,
    }
}

fn utf16(bytes: &[u8], unit: Order) -> String {
    let units: Vec<u16> = bytes.as_chunks::<2>().0.iter().map(|&pair| unit(pair)).collect();
    String::from_utf16_lossy(&units)
}

#[cfg(unix)]
fn what(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        _ if kind.is_dir() => "a folder",
        _ if kind.is_fifo() => "a pipe",
        _ if kind.is_char_device() || kind.is_block_device() => "a device",
        _ => "a socket",
    }
}

#[cfg(not(unix))]
fn what(kind: FileType) -> &'static str {
    if kind.is_dir() { "a folder" } else { "a device" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_encoding_and_line_end_gives_the_same_text() {
        let expected = "G0 X1\nG1 Y2 (ü)\n";
        let utf16 = |order: fn(u16) -> [u8; 2], mark: [u8; 2]| {
            let units = expected.encode_utf16().flat_map(order);
            mark.into_iter().chain(units).collect::<Vec<u8>>()
        };
        for bytes in [
            expected.as_bytes().to_vec(),
            format!("\u{feff}{expected}").into_bytes(),
            expected.replace('\n', "\r\n").into_bytes(),
            expected.replace('\n', "\r").into_bytes(),
            utf16(u16::to_le_bytes, [0xFF, 0xFE]),
            utf16(u16::to_be_bytes, [0xFE, 0xFF]),
            utf16(u16::to_le_bytes, [0xFF, 0xFE])[2..].to_vec(),
            utf16(u16::to_be_bytes, [0xFE, 0xFF])[2..].to_vec(),
            b"G0 X1\rG1 Y2 (\xC3\xBC)\r\n".to_vec(),
        ] {
            assert_eq!(decode(bytes), expected);
        }
        assert_eq!(decode(vec![b'(', 0xFC, b')']), "(\u{fffd})");
    }

    #[test]
    fn what_is_too_large_or_no_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ngc");
        fs::write(&path, "12345").unwrap();
        assert_eq!(bytes(&path, 5).unwrap(), b"12345");
        assert_eq!(bytes(&path, 4).unwrap_err().to_string(), "it is larger than the limit of 4 bytes");
        assert_eq!(bytes(folder.path(), 4).unwrap_err().to_string(), "it is a folder, not a regular file");
        #[cfg(unix)]
        assert_eq!(bytes(Path::new("/dev/zero"), 4).unwrap_err().to_string(), "it is a device, not a regular file");
        assert_eq!(bytes(&folder.path().join("none"), 4).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}

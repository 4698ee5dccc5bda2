//! Arrays as NPY files: what the runners of any language read and write.
//!
//! NumPy enhancement proposal 1, "A simple file format for NumPy arrays", version 1.0 of the format. Only what the protocol
//! needs: little-endian `f8`, `u8`, `u4` and `u1`, row by row (C order), one to three dimensions.

use crate::record::{RecordError, write_bytes};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Every NPY file begins with this, and with the version of the format.
const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// The data begin at a multiple of this many bytes.
const ALIGNMENT: usize = 64;
/// Largest file that is read, bytes: 30 million poses.
const LARGEST_FILE: u64 = 1 << 31;

/// Why an array could not be read.
#[derive(Debug, Error)]
pub enum NpyError {
    /// The file cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The file is not the array that is needed.
    #[error("{path}: {message}", path = path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
}

/// A number that an array may hold.
pub trait Element: Copy {
    /// The type's name in the file.
    const DESCR: &'static str;
    /// Appends the number.
    fn put(self, bytes: &mut Vec<u8>);
    /// The number in exactly as many bytes as it has.
    fn get(bytes: &[u8]) -> Self;
}

macro_rules! element {
    ($($type:ty => $descr:literal),*) => { $(impl Element for $type {
        const DESCR: &'static str = $descr;
        fn put(self, bytes: &mut Vec<u8>) {
            bytes.extend(self.to_le_bytes());
        }
        fn get(bytes: &[u8]) -> Self {
            let mut own = [0; size_of::<Self>()];
            own.copy_from_slice(bytes);
            Self::from_le_bytes(own)
        }
    })* };
}

element!(f64 => "<f8", u64 => "<u8", u32 => "<u4", u8 => "|u1");

/// The file's bytes for numbers in an array of this shape.
fn encode<T: Element>(shape: &[usize], numbers: &[T]) -> Vec<u8> {
    debug_assert_eq!(shape.iter().product::<usize>(), numbers.len());
    let sizes: String = shape.iter().map(|size| format!("{size},")).collect();
    let mut header = format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({sizes}), }}", T::DESCR);
    // Magic, two bytes of length, header, newline.
    let unpadded = MAGIC.len() + 2 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(ALIGNMENT) - unpadded));
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    numbers.iter().for_each(|number| number.put(&mut bytes));
    bytes
}

/// Writes numbers, row by row, as an array of this shape.
///
/// # Errors
/// When the file cannot be written.
pub fn write<T: Element>(path: &Path, shape: &[usize], numbers: &[T]) -> Result<(), RecordError> {
    write_bytes(path, &encode(shape, numbers))
}

/// Reads an array whose second and further dimensions are `row`, row by row.
///
/// # Errors
/// When the file cannot be read, or holds numbers of another type, order or shape.
pub fn read<T: Element>(path: &Path, row: &[usize]) -> Result<Vec<T>, NpyError> {
    let bytes = rs274::file::bytes(path, LARGEST_FILE).map_err(RecordError::io("read", path))?;
    decode(&bytes, row).map_err(|message| NpyError::Format { path: path.to_owned(), message })
}

fn decode<T: Element>(bytes: &[u8], row: &[usize]) -> Result<Vec<T>, String> {
    let rest = bytes.strip_prefix(MAGIC).ok_or("not an NPY file of version 1.0")?;
    let (length, rest) = rest.split_at_checked(2).ok_or("the file ends within its header")?;
    let length = usize::from(u16::from_le_bytes([length[0], length[1]]));
    let (header, data) = rest.split_at_checked(length).ok_or("the file ends within its header")?;
    let header = str::from_utf8(header).map_err(|_| "the header is not text")?;
    let value = |key: &str| {
        let after = header.split_once(&format!("'{key}':")).map(|(_, after)| after.trim_start());
        after.ok_or_else(|| format!("the header does not tell `{key}`"))
    };
    if !value("descr")?.starts_with(&format!("'{}'", T::DESCR)) {
        return Err(format!("the numbers are not of type `{}`: {}", T::DESCR, header.trim_end()));
    }
    if !value("fortran_order")?.starts_with("False") {
        return Err("the array is in Fortran order".to_owned());
    }
    let shape = value("shape")?.strip_prefix('(').and_then(|after| after.split_once(')'));
    let (shape, _) = shape.ok_or("the shape is not in parentheses")?;
    let sizes = shape.split(',').map(str::trim).filter(|size| !size.is_empty());
    let sizes: Vec<usize> =
        sizes.map(str::parse).collect::<Result<_, _>>().map_err(|_| format!("`({shape})` is not a shape"))?;
    if sizes.get(1..) != Some(row) {
        return Err(format!("the shape is ({shape}), not (n, {row:?})"));
    }
    let count = sizes.iter().try_fold(size_of::<T>(), |product, &size| product.checked_mul(size));
    if count != Some(data.len()) {
        return Err(format!("shape ({shape}) of `{}` does not fit {} bytes", T::DESCR, data.len()));
    }
    Ok(data.chunks_exact(size_of::<T>()).map(T::get).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As NumPy 2 writes `np.array([[1, 2, 258]], dtype='<u4')`: the header fills 128 bytes less the ten before it.
    #[test]
    fn the_bytes_are_numpys() {
        let bytes = encode(&[1, 3], &[1_u32, 2, 258]);
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00"); // 0x76 = 118 = 128 - 10
        assert!(bytes[10..].starts_with(b"{'descr': '<u4', 'fortran_order': False, 'shape': (1,3,), }  "));
        assert_eq!(bytes[127], b'\n');
        assert_eq!(&bytes[128..], [1, 0, 0, 0, 2, 0, 0, 0, 2, 1, 0, 0]);
    }

    #[test]
    fn what_is_written_is_read() {
        let numbers = [0.1, -0.0, f64::INFINITY, 5e-324, 1.0, 2.0];
        assert_eq!(decode::<f64>(&encode(&[2, 3], &numbers), &[3]), Ok(numbers.to_vec()));
        assert_eq!(decode::<u8>(&encode(&[3], &[0_u8, 1, 255]), &[]), Ok(vec![0, 1, 255]));
        assert_eq!(decode::<u64>(&encode::<u64>(&[0], &[]), &[]), Ok(vec![]));
    }

    #[test]
    fn other_arrays_are_refused_with_the_reason() {
        let bytes = encode(&[2, 3], &[1.0; 6]);
        let fails = |bytes: &[u8], row: &[usize], reason: &str| {
            let message = decode::<f64>(bytes, row).unwrap_err();
            assert!(message.contains(reason), "{message}");
        };
        fails(b"PK", &[3], "not an NPY file");
        fails(&bytes[..9], &[3], "within its header");
        fails(&bytes[..60], &[3], "within its header");
        fails(&bytes[..bytes.len() - 1], &[3], "does not fit 47 bytes");
        fails(&bytes, &[4], "the shape is (2,3,)");
        fails(&encode(&[6], &[1_u32; 6]), &[], "not of type `<f8`");
        let text = String::from_utf8_lossy(&bytes[10..70]).replace("False", "True ");
        fails(&[&bytes[..10], text.as_bytes(), &bytes[70..]].concat(), &[3], "Fortran");
        let text = String::from_utf8_lossy(&bytes[10..80]).replace("(2,3,)", "(x,3,)");
        fails(&[&bytes[..10], text.as_bytes(), &bytes[80..]].concat(), &[3], "not a shape");
    }
}

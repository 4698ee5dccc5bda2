//! Reading and writing whole files: under a temporary name, flushed to disk, then renamed. A killed run leaves a file
//! whole or not at all. A table is `NAME.csv`, or `NAME.csv.gz` where it is compressed; readers take whichever is there.

use super::rows::Row;
use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a record could not be read or written.
#[derive(Debug, Error)]
pub enum RecordError {
    /// The file system refused.
    #[error("cannot {verb} {path}: {source}", path = path.display())]
    Io {
        /// `read`, `write`, `create`, ...
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// Another process works in the folder.
    #[error("{folder} is in use by another bvbench{holder}; wait for it, or name another folder with --out", folder = folder.display())]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// ` (process ID)`; empty when unknown.
        holder: String,
    },
    /// A manifest is of a layout that this program does not read.
    #[error("{path}: schema {found}, but this bvbench reads schema {known}; make the run again, or read it with the bvbench that made it", path = path.display())]
    Schema {
        /// The manifest.
        path: PathBuf,
        /// What it says: a version, or `none`.
        found: String,
        /// The version read here.
        known: u32,
    },
    /// A row is not of its type. The message of `source` holds line and column.
    #[error("{path}: {source}", path = path.display())]
    Csv {
        /// The file.
        path: PathBuf,
        /// The cause, with the line.
        source: csv::Error,
    },
    /// A value that cannot be.
    #[error("{path}:{line}: {message}", path = path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: u64,
        /// What is wrong.
        message: &'static str,
    },
    /// Raw rows are not those that were measured.
    #[error(
        "{folder}: {files} changed or missing since the run wrote them; make the run again in another folder, or take what is there with --accept-changed-rows (of `stage analyze`, `stage report` and `stage compare`)",
        folder = folder.display()
    )]
    Changed {
        /// The run.
        folder: PathBuf,
        /// The files.
        files: String,
    },
    /// A JSON file is not what it should be.
    #[error("{path}: {source}", path = path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// The cause, with line and column.
        source: serde_json::Error,
    },
}

impl RecordError {
    /// Wraps an I/O error with what was attempted on which file.
    pub fn io(verb: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { verb, path, source }
    }
}

/// Writes `bytes` to `path` all at once.
///
/// # Errors
/// When the folder cannot be created or the file cannot be written.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), RecordError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(RecordError::io("create", folder))?;
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".partial");
    let temporary = path.with_file_name(name);
    let written = File::create(&temporary).and_then(|file| {
        let mut writer = BufWriter::new(file);
        writer.write_all(bytes)?;
        writer.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()
    });
    written.map_err(RecordError::io("write", &temporary))?;
    fs::rename(&temporary, path).map_err(RecordError::io("write", path))
}

/// Writes a text file all at once.
///
/// # Errors
/// As [`write_bytes`].
pub fn write_text(path: &Path, text: &str) -> Result<(), RecordError> {
    write_bytes(path, text.as_bytes())
}

/// Writes a value as a JSON file, all at once.
///
/// # Errors
/// As [`write_bytes`]; [`RecordError::Json`] when the value has no JSON form.
pub fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), RecordError> {
    let text =
        serde_json::to_string_pretty(value).map_err(|source| RecordError::Json { path: path.to_owned(), source })?;
    write_text(path, &(text + "\n"))
}

/// Reads a value from a JSON file.
///
/// # Errors
/// When the file cannot be read or is of another type.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, RecordError> {
    serde_json::from_str(&read_text(path)?).map_err(|source| RecordError::Json { path: path.to_owned(), source })
}

/// What is added to the name of a compressed table.
const GZIP: &str = ".gz";

/// A table's name where it is compressed.
pub fn compressed(file: &str) -> String {
    format!("{file}{GZIP}")
}

/// The place of a table in `folder`: plain, or compressed where only that is there.
pub fn located(folder: &Path, file: &str) -> PathBuf {
    let (plain, packed) = (folder.join(file), folder.join(compressed(file)));
    if !plain.exists() && packed.exists() { packed } else { plain }
}

/// Opens a table in `folder` for reading, plain or compressed.
///
/// # Errors
/// When it is missing or no regular file.
pub fn open_table(folder: &Path, file: &str) -> Result<Box<dyn Read>, RecordError> {
    let path = located(folder, file);
    let opened = BufReader::new(open(&path)?);
    let is_packed = path.extension().is_some_and(|extension| extension == GZIP.trim_start_matches('.'));
    Ok(if is_packed { Box::new(MultiGzDecoder::new(opened)) } else { Box::new(opened) })
}

/// The bytes of a table's text, compressed or not; `None` when they are more than `most`, and no more than these are read.
///
/// # Errors
/// When the table cannot be read.
pub fn table_bytes(folder: &Path, file: &str, most: u64) -> Result<Option<u64>, RecordError> {
    let mut text = open_table(folder, file)?.take(most.saturating_add(1));
    let bytes = std::io::copy(&mut text, &mut std::io::sink());
    let bytes = bytes.map_err(RecordError::io("read", &located(folder, file)))?;
    Ok((bytes <= most).then_some(bytes))
}

/// Writes all rows to the row type's file in `folder`.
///
/// # Errors
/// As [`write_bytes`].
pub fn write_rows<R: Row>(folder: &Path, rows: &[R]) -> Result<(), RecordError> {
    let path = folder.join(R::FILE);
    write_bytes(&path, &row_bytes(&path, rows)?)?;
    remove_file(&folder.join(compressed(R::FILE)))
}

/// Writes rows together with those of the folder's file, if there is one, that `stays` keeps; those come first.
///
/// # Errors
/// When the file cannot be read or written.
pub fn merge_rows<R: Row + Clone>(folder: &Path, new: &[R], stays: impl Fn(&R) -> bool) -> Result<(), RecordError> {
    let mut rows: Vec<R> = read_rows_if_there(folder)?;
    rows.retain(stays);
    rows.extend_from_slice(new);
    write_rows(folder, &rows)
}

/// As [`write_rows`], compressed: equal rows make equal bytes.
///
/// # Errors
/// As [`write_bytes`].
pub fn write_rows_compressed<R: Row>(folder: &Path, rows: &[R]) -> Result<(), RecordError> {
    let path = folder.join(compressed(R::FILE));
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let packed = encoder.write_all(&row_bytes(&folder.join(R::FILE), rows)?).and_then(|()| encoder.finish());
    write_bytes(&path, &packed.map_err(RecordError::io("write", &path))?)?;
    remove_file(&folder.join(R::FILE))
}

/// Name and columns of a table without a row type, which no code here reads row by row.
#[derive(Clone, Copy, Debug)]
pub struct Head {
    /// The file's name in the run's folder.
    pub file: &'static str,
    /// The first line of the file.
    pub columns: &'static str,
}

/// Writes the lines of a table that has no row type, a tuple each.
///
/// # Errors
/// As [`write_bytes`], and when a line has not one value for each column.
pub fn write_lines<T: Serialize>(folder: &Path, head: Head, lines: &[T]) -> Result<(), RecordError> {
    let path = folder.join(head.file);
    let columns: Vec<&str> = head.columns.split(',').collect();
    write_bytes(&path, &csv_bytes(&path, &columns, lines)?)
}

/// Removes a file; one that is not there is fine.
fn remove_file(path: &Path) -> Result<(), RecordError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(RecordError::io("remove", path)(error)),
        _ => Ok(()),
    }
}

/// The text of rows. The first row brings the columns; where there is none, they are written here.
fn row_bytes<R: Row>(path: &Path, rows: &[R]) -> Result<Vec<u8>, RecordError> {
    csv_bytes(path, if rows.is_empty() { columns::<R>() } else { &[] }, rows)
}

fn csv_bytes<T: Serialize>(path: &Path, columns: &[&str], rows: &[T]) -> Result<Vec<u8>, RecordError> {
    let csv_error = |source| RecordError::Csv { path: path.to_owned(), source };
    let mut writer = csv::Writer::from_writer(Vec::new());
    if !columns.is_empty() {
        writer.write_record(columns).map_err(csv_error)?;
    }
    for row in rows {
        writer.serialize(row).map_err(csv_error)?;
    }
    writer.into_inner().map_err(|e| RecordError::io("write", path)(e.into_error()))
}

/// The columns of a row type, by what it asks a deserializer for.
fn columns<R: Row>() -> &'static [&'static str] {
    struct Fields<'a>(&'a mut &'static [&'static str]);

    impl<'de> serde::Deserializer<'de> for Fields<'_> {
        type Error = serde::de::value::Error;

        fn deserialize_struct<V: serde::de::Visitor<'de>>(
            self,
            _: &'static str,
            fields: &'static [&'static str],
            visitor: V,
        ) -> Result<V::Value, Self::Error> {
            *self.0 = fields;
            self.deserialize_any(visitor)
        }

        fn deserialize_any<V: serde::de::Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
            Err(serde::de::Error::custom("there is no row"))
        }

        serde::forward_to_deserialize_any! {
            bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct seq
            tuple tuple_struct map enum identifier ignored_any
        }
    }

    let mut fields: &[&str] = &[];
    // Only its question is wanted: there is no row to give.
    let _ = R::deserialize(Fields(&mut fields));
    fields
}

/// Opens a file for reading, if it is one: a pipe would be waited for, a device has no end.
///
/// # Errors
/// When it cannot be read or is no regular file.
pub fn open(path: &Path) -> Result<File, RecordError> {
    let kind = fs::metadata(path).map_err(RecordError::io("read", path))?;
    if !kind.is_file() {
        let cause = std::io::Error::new(std::io::ErrorKind::InvalidInput, "it is not a regular file");
        return Err(RecordError::io("read", path)(cause));
    }
    File::open(path).map_err(RecordError::io("read", path))
}

/// The text of a regular file.
///
/// # Errors
/// As [`open`], and when the text is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, RecordError> {
    std::io::read_to_string(open(path)?).map_err(RecordError::io("read", path))
}

/// Hands the rows of the row type's file in `folder` to `visit` one at a time: for files too large to hold. `visit` may refuse a row.
///
/// # Errors
/// When the file is missing or a row is not of its type, or with the line of the row that is refused.
pub fn for_each_row<R: Row>(
    folder: &Path,
    mut visit: impl FnMut(R) -> Result<(), &'static str>,
) -> Result<(), RecordError> {
    let path = located(folder, R::FILE);
    let bad = |source| RecordError::Csv { path: path.clone(), source };
    let mut reader = csv::Reader::from_reader(open_table(folder, R::FILE)?);
    let headers = reader.headers().map_err(bad)?.clone();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(bad)? {
        let row: R = record.deserialize(Some(&headers)).map_err(bad)?;
        row.check().and_then(|()| visit(row)).map_err(|message| {
            let line = record.position().map_or(0, csv::Position::line);
            RecordError::Value { path: path.clone(), line, message }
        })?;
    }
    Ok(())
}

/// Reads all rows of the row type's file in `folder`.
///
/// # Errors
/// When the file is missing or a row is not of its type.
pub fn read_rows<R: Row>(folder: &Path) -> Result<Vec<R>, RecordError> {
    let mut rows = Vec::new();
    for_each_row(folder, |row| {
        rows.push(row);
        Ok(())
    })?;
    Ok(rows)
}

/// The rows of a file that a folder need not have: none when it is not there.
///
/// # Errors
/// When a row is not of its type.
pub fn read_rows_if_there<R: Row>(folder: &Path) -> Result<Vec<R>, RecordError> {
    if has_rows::<R>(folder) { read_rows(folder) } else { Ok(Vec::new()) }
}

/// Whether the row type's file is in `folder`, plain or compressed.
pub fn has_rows<R: Row>(folder: &Path) -> bool {
    located(folder, R::FILE).exists()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Cache, SingleRow};

    fn rows() -> Vec<SingleRow> {
        let row = |pose| SingleRow {
            scene: "s".into(),
            case: "c".into(),
            cache: Cache::Warm,
            binary: 0,
            launch: 0,
            pose,
            ns: 100,
        };
        (0..1000).map(row).collect()
    }

    /// A compressed table is read like a plain one, its bytes are the same each time, and of the two forms the folder has one.
    #[test]
    fn a_compressed_table_reads_as_a_plain_one() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let (plain, packed) = (folder.join("singles.csv"), folder.join("singles.csv.gz"));
        write_rows(folder, &rows()).unwrap();
        let long = fs::metadata(&plain).unwrap().len();
        write_rows_compressed(folder, &rows()).unwrap();
        let bytes = fs::read(&packed).unwrap();
        assert!(!plain.exists() && (bytes.len() as u64) * 4 < long);
        assert_eq!(read_rows::<SingleRow>(folder).unwrap(), rows());
        assert_eq!(table_bytes(folder, SingleRow::FILE, long).unwrap(), Some(long));
        assert_eq!(table_bytes(folder, SingleRow::FILE, long - 1).unwrap(), None);
        assert_eq!(read_rows_if_there::<SingleRow>(folder).unwrap().len(), 1000);
        write_rows_compressed(folder, &rows()).unwrap();
        assert_eq!(fs::read(&packed).unwrap(), bytes);
        write_rows(folder, &rows()[..1]).unwrap();
        assert!(!packed.exists());
        assert_eq!(read_rows::<SingleRow>(folder).unwrap().len(), 1);
    }

    /// Half a file is no table.
    #[test]
    fn a_truncated_table_is_an_error_that_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        write_rows_compressed(folder.path(), &rows()).unwrap();
        let path = folder.path().join("singles.csv.gz");
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let error = read_rows::<SingleRow>(folder.path()).unwrap_err().to_string();
        assert!(error.contains("singles.csv.gz"), "{error}");
    }
}

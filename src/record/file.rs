//! Reading and writing whole files: under a temporary name, flushed to disk, then renamed. A killed run leaves a file
//! whole or not at all.

use super::rows::Row;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Write};
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
        "{folder}: {files} changed since the run wrote them; make the run again, or pass --accept-changed-rows",
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

/// Writes all rows to the row type's file in `folder`.
///
/// # Errors
/// As [`write_bytes`].
pub fn write_rows<R: Row>(folder: &Path, rows: &[R]) -> Result<(), RecordError> {
    let path = folder.join(R::FILE);
    let csv_error = |source| RecordError::Csv { path: path.clone(), source };
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(csv_error)?;
    }
    let bytes = writer.into_inner().map_err(|e| RecordError::io("write", &path)(e.into_error()))?;
    write_bytes(&path, &bytes)
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

/// Hands the rows of the row type's file in `folder` to `visit` one at a time: for files too large to hold.
///
/// # Errors
/// When the file is missing or a row is not of its type.
pub fn for_each_row<R: Row>(folder: &Path, mut visit: impl FnMut(R)) -> Result<(), RecordError> {
    let path = folder.join(R::FILE);
    let file = open(&path)?;
    let bad = |source| RecordError::Csv { path: path.clone(), source };
    let mut reader = csv::Reader::from_reader(BufReader::new(file));
    let headers = reader.headers().map_err(bad)?.clone();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(bad)? {
        let row: R = record.deserialize(Some(&headers)).map_err(bad)?;
        row.check().map_err(|message| {
            let line = record.position().map_or(0, csv::Position::line);
            RecordError::Value { path: path.clone(), line, message }
        })?;
        visit(row);
    }
    Ok(())
}

/// Reads all rows of the row type's file in `folder`.
///
/// # Errors
/// When the file is missing or a row is not of its type.
pub fn read_rows<R: Row>(folder: &Path) -> Result<Vec<R>, RecordError> {
    let mut rows = Vec::new();
    for_each_row(folder, |row| rows.push(row))?;
    Ok(rows)
}

/// The rows of a file that a folder need not have: none when it is not there.
///
/// # Errors
/// When a row is not of its type.
pub fn read_rows_if_there<R: Row>(folder: &Path) -> Result<Vec<R>, RecordError> {
    if folder.join(R::FILE).exists() { read_rows(folder) } else { Ok(Vec::new()) }
}

//! The log of a watch: a CSV row per sample, and per fault without one. A watch that is started again writes behind what is there. Times are nanoseconds since the epoch of Unix.

use crate::monitor::{Fault, Outcome};
use crate::opc;
use bvbench::scene::Scene;
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;

/// A row of the log.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Row {
    /// Source time of the sample, by the control's clock; 0 without a sample.
    pub source_ns: i64,
    /// When the server took the sample, by its clock; 0 where it does not say.
    pub published_ns: i64,
    /// When it was received.
    pub received_ns: i64,
    /// When it was judged.
    pub judged_ns: i64,
    /// When the control had confirmed the verdict; 0 when it did not.
    pub written_ns: i64,
    /// `clear`, `near`, `collision` or `unknown`.
    pub verdict: &'static str,
    /// Clearance guaranteed over the look-ahead, mm, at most the near distance.
    pub clearance_mm: f64,
    /// The pair with that clearance, as `a:b`; empty when none was near.
    pub pair: String,
    /// Length of the look-ahead, ns.
    pub horizon_ns: u64,
    /// Distances that were found.
    pub queries: u32,
    /// Whether the machine is held.
    pub holds: bool,
    /// Kind of the fault; empty without one.
    pub fault: &'static str,
    /// What happened.
    pub message: String,
    /// Line of the program; 0 when nobody says it.
    pub line: u32,
    /// Older samples that came with this one and were not judged.
    pub superseded: u32,
}

impl Row {
    /// A row without times.
    pub fn new(scene: &Scene, outcome: &Outcome) -> Self {
        let fault = outcome.fault.as_ref();
        Self {
            source_ns: opc::unix_ns(outcome.source_ticks),
            verdict: outcome.verdict.name(),
            clearance_mm: outcome.clearance_mm,
            pair: outcome.pair.map(|pair| scene.pair_name(pair)).unwrap_or_default(),
            horizon_ns: (outcome.horizon_s * 1e9) as u64,
            queries: outcome.queries,
            holds: outcome.holds,
            fault: fault.map_or("", Fault::name),
            message: fault.map(ToString::to_string).unwrap_or_default(),
            line: outcome.line,
            superseded: outcome.superseded,
            ..Self::default()
        }
    }
}

/// Where rows go.
pub struct Log {
    file: Option<File>,
    /// Whether the last row may be torn, so that the next one begins on a new line.
    torn: bool,
}

impl Log {
    /// Opens a log behind the rows that it has; without a path rows go nowhere.
    ///
    /// # Errors
    /// When the file cannot be opened, or is not the log of a watch.
    pub fn open(path: Option<&Path>) -> std::io::Result<Self> {
        let Some(path) = path else { return Ok(Self { file: None, torn: false }) };
        let header = encode(None).map_err(std::io::Error::other)?;
        let mut file = OpenOptions::new().create(true).read(true).append(true).open(path)?;
        let length = file.metadata()?.len();
        if length == 0 {
            let mut log = Self { file: Some(file), torn: false };
            log.write_all(&header).ok();
            return Ok(log);
        }
        let mut first = Vec::new();
        (&mut file).take(header.len() as u64).read_to_end(&mut first)?;
        if first != header {
            return Err(std::io::Error::new(ErrorKind::InvalidData, "it has other columns: name another file"));
        }
        let mut last = [0];
        file.seek(SeekFrom::Start(length - 1))?;
        file.read_exact(&mut last)?;
        Ok(Self { file: Some(file), torn: last != *b"\n" })
    }

    /// Writes a row at once.
    ///
    /// # Errors
    /// When the row is not wholly in the file.
    pub fn write(&mut self, row: &Row) -> std::io::Result<()> {
        let mut bytes = if self.torn { b"\n".to_vec() } else { Vec::new() };
        bytes.extend(encode(Some(row)).map_err(std::io::Error::other)?);
        self.write_all(&bytes)
    }

    fn write_all(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        let Some(file) = &mut self.file else { return Ok(()) };
        let written = file.write_all(bytes);
        self.torn = written.is_err();
        written
    }
}

/// A row as CSV, or the header.
fn encode(row: Option<&Row>) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::WriterBuilder::new().has_headers(row.is_none()).from_writer(Vec::new());
    writer.serialize(row.unwrap_or(&Row::default()))?;
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    let end = bytes.iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |at| at + 1);
    Ok(if row.is_none() { bytes[..end].to_vec() } else { bytes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_is_a_header_and_a_row_per_sample() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let mut log = Log::open(Some(&path)).unwrap();
        log.write(&Row { line: 7, message: "a, \"b\"".into(), ..Row::default() }).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("source_ns,published_ns,received_ns,judged_ns,written_ns,verdict,"), "{text}");
        assert!(lines[1].ends_with("\"a, \"\"b\"\"\",7,0") && lines.len() == 2, "{text}");
    }

    #[test]
    fn a_log_that_is_opened_again_keeps_its_rows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        for line in [1, 2] {
            Log::open(Some(&path)).unwrap().write(&Row { line, ..Row::default() }).unwrap();
        }
        // A kill may cut the last row short.
        let mut text = std::fs::read_to_string(&path).unwrap();
        text.truncate(text.len() - 1);
        std::fs::write(&path, &text).unwrap();
        Log::open(Some(&path)).unwrap().write(&Row { line: 3, ..Row::default() }).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let ends: Vec<&str> = text.lines().map(|line| &line[line.len() - 4..]).collect();
        assert_eq!(ends, ["eded", ",1,0", ",2,0", ",3,0"]);
        std::fs::write(&path, "time,verdict\n").unwrap();
        assert_eq!(Log::open(Some(&path)).err().unwrap().kind(), ErrorKind::InvalidData);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "time,verdict\n");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_an_error_of_the_row() {
        let mut log = Log::open(Some(Path::new("/dev/full"))).unwrap();
        let error = log.write(&Row::default()).unwrap_err();
        assert_eq!(error.raw_os_error(), Some(28), "no space left on device");
        assert!(log.torn);
    }
}

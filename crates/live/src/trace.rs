//! What a simulated control did: a CSV row per cycle, by which a run is judged afterwards.

use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::Write as _;
use std::path::Path;

/// A cycle of a simulated control.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Cycle {
    /// The control's clock: the source time of the sample, ns since the epoch of Unix.
    pub source_ns: i64,
    /// Source time of the sample that the newest verdict is about; 0 before the first.
    pub verdict_ns: i64,
    /// Whether the machine was allowed to move in this cycle.
    pub permitted: bool,
    /// The program's own clock, s.
    pub time_s: f64,
    /// The program's own clock where the machine stands when it is held a deadline after this cycle, s.
    pub reach_s: f64,
}

/// Where cycles go.
pub struct Trace(File);

impl Trace {
    /// Creates a trace.
    ///
    /// # Errors
    /// When the file cannot be created or written.
    pub fn create(path: &Path) -> std::io::Result<Self> {
        let mut file = File::create(path)?;
        file.write_all(b"source_ns,verdict_ns,permitted,time_s,reach_s\n")?;
        Ok(Self(file))
    }

    /// Writes a cycle at once, so that it is there when the control is killed.
    ///
    /// # Errors
    /// When the row cannot be written.
    pub fn write(&mut self, cycle: &Cycle) -> std::io::Result<()> {
        let Cycle { source_ns, verdict_ns, permitted, time_s, reach_s } = cycle;
        self.0.write_all(format!("{source_ns},{verdict_ns},{permitted},{time_s},{reach_s}\n").as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cycle_is_read_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.csv");
        let cycle = Cycle { source_ns: 5, verdict_ns: 0, permitted: true, time_s: 0.004, reach_s: 1.0 / 3.0 };
        Trace::create(&path).unwrap().write(&cycle).unwrap();
        let rows: Vec<Cycle> = csv::Reader::from_path(&path).unwrap().deserialize().map(Result::unwrap).collect();
        assert_eq!(rows, [cycle]);
    }
}

//! The manifest: everything one must know to make the run again, and to judge its timings.

use super::file::{RecordError, compressed, located, open, read_text, write_json};
use super::vocabulary::Kind;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::Path;

/// Version of the records' layout; a change of a column's meaning raises it.
pub const SCHEMA: u32 = 2;

/// Version of the protocol that decides what is measured and how it is judged: `docs/protocol.md`.
pub const PROTOCOL: &str = "2.3";

/// What was run, with what, where.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`SCHEMA`] of the writer.
    pub schema: u32,
    /// [`PROTOCOL`] of the writer.
    pub protocol: String,
    /// What was asked for.
    pub request: Request,
    /// What it was made of: path or name to content hash, for every scene, program, mesh and claims file.
    pub inputs: BTreeMap<String, String>,
    /// The variants measured, with what they promise.
    pub variants: Vec<VariantEntry>,
    /// The scenes measured.
    pub scenes: Vec<SceneEntry>,
    /// The program that ran.
    pub program: Program,
    /// The binaries that timed, in the order of their numbers; empty in records from before protocol 2.1.
    #[serde(default)]
    pub binaries: Vec<BinaryEntry>,
    /// The machine it ran on.
    pub machine: MachineFacts,
    /// The clock that timed it; `None` before it was measured.
    pub clock: Option<ClockEntry>,
    /// How the caches were emptied before cold queries; `None` without cold queries.
    pub cold: Option<ColdEntry>,
    /// The variant whose default case the `null` method duplicates; empty without one.
    pub null_of: String,
    /// The triangle tests against their integer twin, once verified.
    pub cross_check: Option<CrossCheckEntry>,
    /// Stages finished so far, in order.
    pub finished: Vec<Stage>,
    /// What disturbed the timings; empty when nothing is known to have.
    pub noise: Vec<String>,
    /// Files of raw rows to the BLAKE3 hash of their bytes, from the stages that are finished; empty in older manifests.
    #[serde(default)]
    pub rows: BTreeMap<String, String>,
    /// Which part of the plan the folder holds; `None` for a whole run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shard: Option<ShardEntry>,
}

/// A part of a plan, carried out in a folder of its own.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShardEntry {
    /// Its number, from 1.
    pub number: u32,
    /// Shards of the plan.
    pub of: u32,
    /// [`Manifest::plan_hash`] of the whole.
    pub plan: String,
}

/// A stage of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Verdicts against the truth.
    Verify,
    /// Times and counters.
    Measure,
    /// Summary, ratios, claims.
    Analyze,
    /// Figures.
    Plot,
    /// The report.
    Report,
}

/// What decides the result, apart from the inputs: two runs of equal request and inputs have equal deterministic files.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// `smoke`, `quick` or `full`.
    pub profile: String,
    /// Seed of all randomness.
    pub seed: u64,
    /// Scenes as given on the command line; empty for those of a run by default.
    pub scenes: Vec<String>,
    /// Variant ids.
    pub variants: Vec<String>,
    /// Tree policies asked for; empty for each volume's default and the shared control.
    pub policies: Vec<String>,
    /// Workload names; empty for all.
    pub workloads: Vec<String>,
    /// Poses per scene in the verification.
    pub verify_poses: u64,
    /// Poses per scene that are timed.
    pub measure_poses: u64,
    /// Steps that each program is sampled in, about, when it is timed as a whole.
    pub program_steps: u64,
    /// Timed blocks per launch, without warm-up.
    pub blocks: u32,
    /// Process launches, of all binaries together.
    pub launches: u32,
    /// Binaries that take turns, launch by launch.
    #[serde(default = "one")]
    pub binaries: u32,
    /// Poses of each program that are asked with cold caches.
    #[serde(default)]
    pub cold_poses: u64,
}

const fn one() -> u32 {
    1
}

/// A binary that timed. Binaries of one source differ in the order of their sections alone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BinaryEntry {
    /// Name of its file.
    pub file: String,
    /// BLAKE3 hash of its bytes.
    pub hash: String,
    /// Seed of the order of its sections, from the end of its name, `-shuffled-SEED`; `None` for the linker's own order.
    pub seed: Option<u64>,
}

/// What the clock adds to the time of a single query.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClockEntry {
    /// Median time of no work at all, ns: the part of every single reading that is the clock's own.
    pub empty_ns: u64,
    /// 99th percentile of the same, ns.
    pub empty_p99_ns: u64,
    /// Smallest difference of two readings that is not zero, ns.
    pub tick_ns: u64,
}

/// How the caches are emptied: a buffer is read, one word of every 64 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ColdEntry {
    /// Size of the buffer, bytes.
    pub buffer_bytes: u64,
    /// Size of the machine's largest cache, bytes; 0 where the system does not tell.
    pub largest_cache_bytes: u64,
}

/// A variant as measured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct VariantEntry {
    /// Id.
    pub id: String,
    /// Name in tables and plots.
    pub label: String,
    /// Source.
    pub reference: String,
    /// Whether it promises to miss nothing.
    pub safe: bool,
    /// What kind of thing it is.
    pub kind: Kind,
    /// The policies measured, the default one first; empty without a tree of ours.
    pub policies: Vec<String>,
}

/// The comparison of the leaves' triangle test and the exact one with their integer twin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CrossCheckEntry {
    /// Pairs of triangles.
    pub pairs: u64,
    /// Pairs that touch.
    pub touching: u64,
    /// Pairs with a triangle that is a segment or a point.
    pub degenerate: u64,
    /// Pairs on which either disagrees with the twin.
    pub disagreements: u64,
}

/// A scene as measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneEntry {
    /// Name.
    pub name: String,
    /// One line on what it shows.
    pub title: String,
    /// Part name to triangle count.
    pub triangles: BTreeMap<String, u64>,
    /// The pairs examined, `a:b`.
    pub pairs: Vec<String>,
}

/// The program.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Program {
    /// bvbench's version.
    pub version: String,
    /// Fingerprint of the source it was built from; empty when unknown, and in older manifests.
    #[serde(default)]
    pub source: String,
    /// BLAKE3 hash of its executable; empty when unknown or when several took part, and in older manifests.
    #[serde(default)]
    pub hash: String,
    /// Git revision of the source when the program began; empty when unknown.
    pub git_revision: String,
    /// Whether that checkout had changes; `None` when unknown.
    pub git_dirty: Option<bool>,
    /// Compiler.
    pub rustc: String,
    /// Optimisation and target flags.
    pub flags: String,
    /// The command line, quoted for a POSIX shell.
    pub command: String,
}

impl Program {
    /// Version, source, compiler and flags: what builds on several machines have in common. The revision counts only where the source is
    /// unknown, because a commit changes no program.
    fn built_from(&self) -> [&str; 4] {
        let source = if self.source.is_empty() { &self.git_revision } else { &self.source };
        [&self.version, source, &self.rustc, &self.flags].map(String::as_str)
    }

    /// Whether rows of both may stand in one record: they were built from the same, and are one executable where both executables are known.
    pub fn is_same(&self, other: &Self) -> bool {
        let is_one = self.hash == other.hash || self.hash.is_empty() || other.hash.is_empty();
        is_one && self.built_from() == other.built_from()
    }
}

/// The machine, as far as it can be known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MachineFacts {
    /// CPU model.
    pub cpu: String,
    /// Instruction set that wide variants used: `avx512`, `avx2` or `portable`; empty in older manifests.
    #[serde(default)]
    pub simd: String,
    /// Logical cores.
    pub cores: usize,
    /// Memory, bytes.
    pub memory_bytes: u64,
    /// Operating system and kernel.
    pub os: String,
    /// Load average over a minute when the run began; `None` where the system does not say.
    pub load: Option<f64>,
}

impl MachineFacts {
    /// Whether times of both machines may stand in one record: processor, instruction set and cores are the same.
    pub fn is_alike(&self, other: &Self) -> bool {
        (&self.cpu, &self.simd, self.cores) == (&other.cpu, &other.simd, other.cores)
    }
}

impl Manifest {
    /// Its file in a run's folder.
    pub const FILE: &'static str = "manifest.json";

    /// Reads the manifest of a run.
    ///
    /// # Errors
    /// When it is missing, of another [`SCHEMA`], or not a manifest.
    pub fn read(folder: &Path) -> Result<Self, RecordError> {
        let path = folder.join(Self::FILE);
        let text = read_text(&path)?;
        let json = |source| RecordError::Json { path: path.clone(), source };
        // The version first: the other fields of another version may not be those below.
        let version: serde_json::Value = serde_json::from_str(&text).map_err(json)?;
        let found = version.get("schema").map_or_else(|| "none".to_owned(), ToString::to_string);
        if found != SCHEMA.to_string() {
            return Err(RecordError::Schema { path, found, known: SCHEMA });
        }
        serde_json::from_str(&text).map_err(json)
    }

    /// BLAKE3 hash of everything that decides the rows of a plan: request, inputs, variants, versions, what the program was built from, and binaries.
    pub fn plan_hash(&self) -> String {
        let binaries: Vec<&str> = self.binaries.iter().map(|binary| binary.hash.as_str()).collect();
        let layout = (self.schema, &self.protocol);
        let plan =
            serde_json::json!([layout, self.request, self.inputs, self.variants, self.program.built_from(), binaries]);
        blake3::hash(plan.to_string().as_bytes()).to_hex().to_string()
    }

    /// Notes the hash of every file below a folder in the run's folder, by its path there.
    ///
    /// # Errors
    /// When one cannot be read.
    pub fn seal_below(&mut self, folder: &Path, below: &Path) -> Result<(), RecordError> {
        for file in files_below(folder, below)? {
            let hash = hash(&folder.join(&file))?;
            self.rows.insert(file, hash);
        }
        Ok(())
    }

    /// Whether the hash of every file below a folder in the run's folder was noted.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn is_sealed_below(&self, folder: &Path, below: &Path) -> Result<bool, RecordError> {
        Ok(files_below(folder, below)?.iter().all(|file| self.rows.contains_key(file)))
    }

    /// Notes the hashes of files of raw rows in the run's folder.
    ///
    /// # Errors
    /// When one cannot be read.
    pub fn seal(&mut self, folder: &Path, files: &[&str]) -> Result<(), RecordError> {
        for file in files {
            self.unseal(file);
            let path = located(folder, file);
            let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            self.rows.insert(name, hash(&path)?);
        }
        Ok(())
    }

    /// Forgets the hash of a file of raw rows, plain or compressed.
    pub fn unseal(&mut self, file: &str) {
        self.rows.remove(file);
        self.rows.remove(&compressed(file));
    }

    /// Compares the files of raw rows with the hashes that were noted when they were written.
    ///
    /// # Errors
    /// [`RecordError::Changed`] with the files that are others, or gone.
    pub fn check_rows(&self, folder: &Path) -> Result<(), RecordError> {
        let is_other = |(file, noted): &(&String, &String)| hash(&folder.join(file)).ok().as_ref() != Some(noted);
        let files: Vec<&str> = self.rows.iter().filter(is_other).map(|(file, _)| file.as_str()).collect();
        if files.is_empty() {
            return Ok(());
        }
        Err(RecordError::Changed { folder: folder.to_owned(), files: files.join(", ") })
    }

    /// Writes it.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), RecordError> {
        write_json(&folder.join(Self::FILE), self)
    }
}

/// Every file below a folder in the run's folder, by its path there; none where there is no such folder.
fn files_below(folder: &Path, below: &Path) -> Result<Vec<String>, RecordError> {
    let mut files = Vec::new();
    if !below.exists() {
        return Ok(files);
    }
    for entry in fs::read_dir(below).map_err(RecordError::io("read", below))? {
        let path = entry.map_err(RecordError::io("read", below))?.path();
        if path.is_dir() {
            files.extend(files_below(folder, &path)?);
        } else {
            let names = path.strip_prefix(folder).unwrap_or(&path).components();
            let names: Vec<_> = names.map(|name| name.as_os_str().to_string_lossy()).collect();
            files.push(names.join("/"));
        }
    }
    Ok(files)
}

fn hash(path: &Path) -> Result<String, RecordError> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes).map_err(RecordError::io("read", path))?;
    Ok(blake3::hash(&bytes).to_hex().to_string())
}

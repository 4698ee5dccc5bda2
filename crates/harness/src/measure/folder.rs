//! A study's folder: opened once and locked, filled unit by unit, sealed with the hashes of its rows.
//!
//! Every study (a run, an audit, a sweep, an ablation) works in such a folder. It is made of units, such as the counts of one scene. A unit's files
//! are written into a folder of their own that is renamed when it is whole; the last step joins all units into the study's CSV files. A
//! study that was killed goes on with the units it lacks, and what it had is as if it had never stopped.

use super::MeasureError;
use super::environment;
use crate::record::file::{compressed, located};
use crate::record::manifest::{PROTOCOL, Program, Request, SCHEMA, Stage, VariantEntry};
use crate::record::{
    self, BuildRow, FolderLock, Manifest, RecordError, Row, TimingRow, read_rows, read_rows_if_there, rows, write_rows,
    write_rows_compressed,
};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Folder of the units inside a study's folder.
const UNITS: &str = "units";

/// The unit of the comparison of triangle tests, which says nothing of a scene or a variant.
pub(super) const CROSS_CHECK: &str = "cross-check";

/// What a study leaves in its folder beside the manifest, the units and [`DERIVED`].
const FILES: [&[&str]; 6] = [
    rows::MEASURED,
    &[TimingRow::FILE, BuildRow::FILE],
    record::study::FILES,
    record::audit::FILES,
    record::sweep::FILES,
    &OTHER_FILES,
];

/// The report of an audit, and tables of older layouts, so that `--fresh` leaves nothing behind.
const OTHER_FILES: [&str; 13] = [
    "audit.md",
    "audit.csv",
    "audit_trees.csv",
    "audit_axes.csv",
    "audit_timings.csv",
    "audit_builds.csv",
    "sweep.csv",
    "sweep_timings.csv",
    "sweep_builds.csv",
    "ablation.csv",
    "ablation_kinds.csv",
    "ablation_times.csv",
    "queries.csv",
];

/// What analysis, plots and report make of the raw rows of a run.
const DERIVED: [&[&str]; 3] =
    [rows::DERIVED, record::cost::FILES, &["claims.toml", "report.md", "report.html", "plots"]];

/// A study's folder.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// What is known of the study so far.
    pub manifest: Manifest,
    /// Whether tables joined from units are compressed.
    pub compresses: bool,
    /// `None` in a launch: its parent holds the lock.
    _lock: Option<FolderLock>,
}

/// A table of raw rows, of which every unit holds a part.
#[derive(Clone, Copy, Debug)]
pub struct RawTable {
    /// Its file.
    pub file: &'static str,
    join: fn(&Path, &[PathBuf], bool) -> Result<(), RecordError>,
}

impl RawTable {
    /// The table of a row type.
    pub const fn of<R: Row>() -> Self {
        Self { file: R::FILE, join: join::<R> }
    }

    /// The table of a row type that not every unit has; without any row there is no file. A row that several units have is written once.
    pub const fn of_some<R: Row>() -> Self {
        Self { file: R::FILE, join: join_some::<R> }
    }
}

fn join<R: Row>(folder: &Path, units: &[PathBuf], compresses: bool) -> Result<(), RecordError> {
    let mut rows: Vec<R> = Vec::new();
    for unit in units {
        rows.extend(read_rows::<R>(unit)?);
    }
    write(compresses)(folder, &rows)
}

/// How rows are written.
fn write<R: Row>(compresses: bool) -> fn(&Path, &[R]) -> Result<(), RecordError> {
    if compresses { write_rows_compressed } else { write_rows }
}

fn join_some<R: Row>(folder: &Path, units: &[PathBuf], compresses: bool) -> Result<(), RecordError> {
    let (mut rows, mut seen): (Vec<R>, _) = (Vec::new(), BTreeSet::new());
    for unit in units {
        rows.extend(read_rows_if_there::<R>(unit)?);
    }
    rows.retain(|row| seen.insert(serde_json::to_string(row).unwrap_or_default()));
    if rows.is_empty() { remove(&located(folder, R::FILE)) } else { write(compresses)(folder, &rows) }
}

impl Folder {
    /// Opens a folder for what `new` says: a new one, one to go on with, whose own manifest is kept, or a finished one. `fresh`
    /// allows what another request left to be replaced; only files that a study writes are removed then. What has no results yet, as after a
    /// failed start, is replaced without it.
    ///
    /// # Errors
    /// When the folder holds something else, another process works in it, or it cannot be written.
    pub fn open(path: &Path, new: Manifest, fresh: bool) -> Result<Self, MeasureError> {
        let has_manifest = path.join(Manifest::FILE).exists();
        let left = left_behind(path);
        if left.foreign {
            return Err(MeasureError::NotARun(path.to_owned()));
        }
        let lock = FolderLock::take(path)?;
        let old = has_manifest.then(|| Manifest::read(path));
        let manifest = match old.map(|old| old.map(|old| (difference(&old, &new), old))) {
            None if !left.ours => new,
            Some(Ok((None, old))) => old,
            None if !fresh => return Err(another(path, "the layout")),
            Some(Err(error)) if !fresh => return Err(error.into()),
            Some(Ok((Some(difference), _))) if !fresh && has_results(path) => return Err(another(path, difference)),
            _ => {
                FILES.iter().chain(&DERIVED).copied().flatten().chain(&[UNITS]).try_for_each(|name| {
                    remove(&path.join(name))?;
                    remove(&path.join(compressed(name)))
                })?;
                new
            }
        };
        manifest.write(path)?;
        Ok(Self { path: path.to_owned(), manifest, compresses: false, _lock: Some(lock) })
    }

    /// The folder of a study that another process has opened and holds the lock of.
    ///
    /// # Errors
    /// When the folder holds no study of what `new` says.
    pub fn join_parent(path: &Path, new: &Manifest) -> Result<Self, MeasureError> {
        let manifest = Manifest::read(path)?;
        // The parent's binary, or its binaries, may be others than this one, which `Run::check_binary` compares; what the parent does of the
        // plan is its affair.
        let program = Program { hash: manifest.program.hash.clone(), ..new.program.clone() };
        let (binaries, shard) = (manifest.binaries.clone(), manifest.shard.clone());
        let new = Manifest { program, binaries, shard, ..new.clone() };
        match difference(&manifest, &new) {
            None => Ok(Self { path: path.to_owned(), manifest, compresses: false, _lock: None }),
            Some(difference) => Err(another(path, difference)),
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder of a unit, or of several: `names` from the outermost in.
    pub fn unit(&self, names: &[&str]) -> PathBuf {
        units(&self.path, names)
    }

    /// Joins what all `units` hold of each table into one file, and notes its hash.
    ///
    /// # Errors
    /// When a unit is missing or malformed, or a file cannot be written.
    pub fn join(&mut self, tables: &[RawTable], units: &[PathBuf]) -> Result<(), RecordError> {
        for table in tables {
            (table.join)(&self.path, units, self.compresses)?;
            if located(&self.path, table.file).exists() {
                self.manifest.seal(&self.path, &[table.file])?;
            } else {
                self.manifest.unseal(table.file);
            }
        }
        Ok(())
    }

    /// Writes a table of its own, and notes its hash.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn put<R: Row>(&mut self, rows: &[R]) -> Result<(), RecordError> {
        write_rows(&self.path, rows)?;
        self.manifest.seal(&self.path, &[R::FILE])
    }

    /// Notes the hashes of what is in a folder of units, which stay where they are: the units of a shard.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn seal_units(&mut self, names: &[&str]) -> Result<(), RecordError> {
        let units = self.unit(names);
        self.manifest.seal_below(&self.path, &units)
    }

    /// Takes the units of another folder as its own.
    ///
    /// # Errors
    /// When a file cannot be copied, or is there already.
    pub fn take_units(&self, other: &Path, names: &[&str]) -> Result<(), RecordError> {
        let of_other = units(other, names);
        if of_other.exists() { copy_below(&of_other, &self.unit(names)) } else { Ok(()) }
    }

    /// Whether a stage is finished.
    pub fn has_finished(&self, stage: Stage) -> bool {
        self.manifest.finished.contains(&stage)
    }

    /// Begins a stage that is finished once more, from nothing: `raw` are the files that it and all later stages write, `units` the folders
    /// of their units. Later stages are no longer finished, and what was derived from them is removed; so are their rows when another program
    /// made them, so that no record mixes two programs.
    ///
    /// # Errors
    /// When another program made the stages before it, or a file cannot be written or removed.
    pub fn begin_again(&mut self, stage: Stage, raw: &[&str], units: &[&str]) -> Result<(), MeasureError> {
        let is_own = self.is_of(&environment::program());
        self.manifest.finished.retain(|&finished| finished < stage);
        if !is_own && !self.manifest.finished.is_empty() {
            return Err(another(&self.path, "the program of an earlier stage"));
        }
        for file in raw {
            self.manifest.unseal(file);
        }
        if self.manifest.finished.is_empty() {
            self.manifest.protocol = PROTOCOL.to_owned();
            self.manifest.program = environment::program();
            self.manifest.machine = environment::machine();
        }
        self.save()?;
        DERIVED.iter().copied().flatten().try_for_each(|file| remove(&located(&self.path, file)))?;
        if !is_own {
            raw.iter().try_for_each(|file| remove(&located(&self.path, file)))?;
        }
        Ok(units.iter().try_for_each(|units| remove(&self.unit(&[units])))?)
    }

    /// Begins a stage that is not finished, or goes on with it.
    ///
    /// # Errors
    /// When another program made a stage that is finished.
    pub fn begin(&self, stage: Stage) -> Result<(), MeasureError> {
        let has_others = self.manifest.finished.iter().any(|&finished| finished != stage && finished <= Stage::Measure);
        if has_others && !self.is_of(&environment::program()) {
            return Err(another(&self.path, "the program of another stage"));
        }
        Ok(())
    }

    /// Whether `program`, with the protocol of this one, made what the folder holds.
    pub(super) fn is_of(&self, program: &Program) -> bool {
        self.manifest.program.is_same(program) && self.manifest.protocol == PROTOCOL
    }

    /// Notes that a stage is finished.
    ///
    /// # Errors
    /// When the manifest cannot be written.
    pub fn finish(&mut self, stage: Stage) -> Result<(), RecordError> {
        if !self.has_finished(stage) {
            self.manifest.finished.push(stage);
        }
        self.save()
    }

    /// Writes the manifest.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save(&self) -> Result<(), RecordError> {
        self.manifest.write(&self.path)
    }

    /// Removes the units below a folder of units.
    ///
    /// # Errors
    /// When they cannot be removed.
    pub fn drop_units(&self, names: &[&str]) -> Result<(), RecordError> {
        remove(&self.unit(names))?;
        // Stays while other units are in it.
        let _ = fs::remove_dir(self.path.join(UNITS));
        Ok(())
    }
}

/// A unit, or several, in the study's folder `study`: `names` from the outermost in.
pub(super) fn units(study: &Path, names: &[&str]) -> PathBuf {
    names.iter().fold(study.join(UNITS), |path, name| path.join(name))
}

/// The manifest of a study that begins now on this machine.
pub fn begun(request: Request, variants: Vec<VariantEntry>) -> Manifest {
    Manifest {
        schema: SCHEMA,
        protocol: PROTOCOL.to_owned(),
        request,
        variants,
        program: environment::program(),
        machine: environment::machine(),
        ..Manifest::default()
    }
}

/// Writes a unit's files into a folder beside its own and renames it when they are whole.
///
/// # Errors
/// When a file cannot be written.
pub fn write_unit(unit: &Path, write: impl FnOnce(&Path) -> Result<(), RecordError>) -> Result<(), RecordError> {
    let temporary = unit.with_extension("partial");
    remove(&temporary)?;
    fs::create_dir_all(&temporary).map_err(RecordError::io("create", &temporary))?;
    write(&temporary)?;
    fs::rename(&temporary, unit).map_err(RecordError::io("write", unit))
}

fn another(path: &Path, difference: &'static str) -> MeasureError {
    MeasureError::AnotherRun { folder: path.to_owned(), difference }
}

/// What a folder holds.
struct Left {
    /// Files that no study writes, and no manifest beside them.
    foreign: bool,
    /// Files that a study writes, but for what one leaves that is killed before it has a manifest.
    ours: bool,
}

fn left_behind(path: &Path) -> Left {
    let begun = [FolderLock::FILE.to_owned(), format!("{}.partial", Manifest::FILE)];
    let entries = fs::read_dir(path).map(|entries| entries.flatten().map(|entry| entry.file_name()).collect());
    let mut entries: Vec<_> = entries.unwrap_or_default();
    entries.retain(|name| !begun.iter().any(|begun| name == begun.as_str()));
    let ours = || FILES.iter().chain(&DERIVED).copied().flatten();
    let is_ours = |name: &std::ffi::OsString| name == UNITS || ours().any(|ours| name == ours);
    let foreign = !entries.iter().any(|name| name == Manifest::FILE) && !entries.iter().all(is_ours);
    Left { foreign, ours: !entries.is_empty() }
}

/// Whether a study's folder holds results: a table, or a unit other than [`CROSS_CHECK`].
fn has_results(path: &Path) -> bool {
    let inside = |folder: &Path| -> Vec<PathBuf> {
        fs::read_dir(folder).map(|entries| entries.flatten().map(|entry| entry.path()).collect()).unwrap_or_default()
    };
    let is_result = |unit: &PathBuf| unit.file_stem().is_none_or(|name| name != CROSS_CHECK);
    FILES.iter().chain(&DERIVED).copied().flatten().any(|file| located(path, file).exists())
        || inside(&path.join(UNITS)).iter().flat_map(|stage| inside(stage)).any(|unit| is_result(&unit))
}

/// Copies a folder into another, file by file; a file that is there already is an error.
fn copy_below(from: &Path, to: &Path) -> Result<(), RecordError> {
    fs::create_dir_all(to).map_err(RecordError::io("create", to))?;
    for entry in fs::read_dir(from).map_err(RecordError::io("read", from))? {
        let path = entry.map_err(RecordError::io("read", from))?.path();
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy_below(&path, &target)?;
        } else {
            let mut file = fs::File::create_new(&target).map_err(RecordError::io("create", &target))?;
            let mut source = fs::File::open(&path).map_err(RecordError::io("read", &path))?;
            std::io::copy(&mut source, &mut file).map_err(RecordError::io("write", &target))?;
        }
    }
    Ok(())
}

/// What keeps one study from being continued as the other; the command line, the load and such do not.
pub(super) fn difference(old: &Manifest, new: &Manifest) -> Option<&'static str> {
    let hashes = |manifest: &Manifest| manifest.binaries.iter().map(|b| b.hash.clone()).collect::<Vec<_>>();
    let finished = old.finished.contains(&Stage::Measure);
    match () {
        () if old.schema != new.schema => Some("the schema"),
        () if old.request != new.request => Some("the request"),
        () if old.inputs != new.inputs => Some("an input file"),
        () if old.variants != new.variants => Some("the list of variants"),
        () if old.shard != new.shard => Some("the shard, or its plan,"),
        // A finished study is not continued but made again, so another build of the program may do it.
        () if !finished && !old.program.is_same(&new.program) => Some("the program"),
        () if !finished && old.protocol != new.protocol => Some("the protocol"),
        () if !finished && hashes(old) != hashes(new) => Some("a binary"),
        () => None,
    }
}

/// Removes a file or a folder with all that is in it; one that is not there is fine.
pub(super) fn remove(path: &Path) -> Result<(), RecordError> {
    let result = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match result {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(RecordError::io("remove", path)(error)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{RatioRow, write_text};
    use crate::synthetic::{Plan, Run};
    use std::collections::BTreeMap;

    fn manifest(seed: u64) -> Manifest {
        let manifest = Run::generate(&Plan { seed, ..Plan::default() }).manifest;
        Manifest { finished: Vec::new(), rows: BTreeMap::new(), ..manifest }
    }

    #[test]
    fn a_folder_has_one_owner_and_goes_on_with_its_units() {
        let place = tempfile::tempdir().unwrap();
        let open = |seed, fresh| Folder::open(place.path(), manifest(seed), fresh);
        let mut folder = open(1, false).unwrap();
        assert!(open(1, false).unwrap_err().to_string().contains("in use"), "two processes in one folder");
        let unit = folder.unit(&["counts", "mill"]);
        let run = Run::generate(&Plan::default());
        write_unit(&unit, |folder| write_rows(folder, &run.timings)).unwrap();
        folder.join(&[RawTable::of::<TimingRow>()], &[unit.clone(), unit.clone()]).unwrap();
        assert_eq!(read_rows::<TimingRow>(place.path()).unwrap().len(), 2 * run.timings.len());
        folder.finish(Stage::Measure).unwrap();
        drop(folder);
        let mut again = open(1, false).unwrap();
        assert!(unit.exists() && again.has_finished(Stage::Measure));
        again.manifest.check_rows(place.path()).unwrap();
        write_text(&place.path().join(TimingRow::FILE), "changed").unwrap();
        assert!(again.manifest.check_rows(place.path()).unwrap_err().to_string().contains(TimingRow::FILE));
        again.begin_again(Stage::Measure, &[TimingRow::FILE], &["counts"]).unwrap();
        assert!(!unit.exists() && !again.has_finished(Stage::Measure) && again.manifest.rows.is_empty());
    }

    /// A folder with finished stages, made by this program or by another one.
    fn finished(place: &Path, stages: &[Stage], by_this_program: bool) -> Folder {
        let mut manifest = Manifest { protocol: PROTOCOL.to_owned(), ..manifest(1) };
        manifest.program = environment::program();
        if !by_this_program {
            manifest.program.hash = "another".to_owned();
        }
        let mut folder = Folder::open(place, manifest, true).unwrap();
        stages.iter().for_each(|&stage| folder.finish(stage).unwrap());
        folder
    }

    const STAGES: [Stage; 5] = [Stage::Verify, Stage::Measure, Stage::Analyze, Stage::Plot, Stage::Report];

    /// A run that is made again is no finished run until all of it is: killed in its measurement, it goes on there.
    #[test]
    fn a_stage_that_is_made_again_drops_the_later_ones() {
        let place = tempfile::tempdir().unwrap();
        let mut folder = finished(place.path(), &STAGES, true);
        folder.begin_again(Stage::Verify, &[], &[]).unwrap();
        assert!(folder.manifest.finished.is_empty());
        folder.finish(Stage::Verify).unwrap();
        folder.finish(Stage::Measure).unwrap();
        folder.begin_again(Stage::Measure, &[], &[]).unwrap();
        assert_eq!(folder.manifest.finished, [Stage::Verify]);
    }

    /// A commit makes no other program; another build does, and where executables are unknown another source.
    #[test]
    fn a_program_is_its_executable() {
        // The program tells its source, a test does not.
        let program = Program { source: "its source".to_owned(), ..environment::program() };
        let old = Manifest { program, ..manifest(1) };
        assert!(!old.program.hash.is_empty());
        let with = |program: Program| Manifest { program, ..old.clone() };
        let committed = with(Program { git_revision: "later".to_owned(), ..old.program.clone() });
        assert_eq!((difference(&old, &committed), old.plan_hash()), (None, committed.plan_hash()));
        let rebuilt = with(Program { hash: "another".to_owned(), ..old.program.clone() });
        assert_eq!((difference(&old, &rebuilt), old.plan_hash()), (Some("the program"), rebuilt.plan_hash()));
        // Shards of builds of several hosts: what they were built from decides.
        let merged = with(Program { hash: String::new(), ..old.program.clone() });
        assert_eq!(difference(&merged, &rebuilt), None);
        let changed = with(Program { source: "another".to_owned(), ..merged.program.clone() });
        assert_eq!(difference(&merged, &changed), Some("the program"));
        // Where the source is unknown, as in older records, the revision tells.
        let before = |revision: &str| Program {
            source: String::new(),
            git_revision: revision.to_owned(),
            ..merged.program.clone()
        };
        assert_eq!(difference(&with(before("a")), &with(before("b"))), Some("the program"));
    }

    /// What was derived from a stage that is made again is gone at once, whoever makes it: a report beside no times would be of old ones.
    #[test]
    fn nothing_derived_outlives_its_rows() {
        for by_this_program in [true, false] {
            let place = tempfile::tempdir().unwrap();
            let mut folder = finished(place.path(), &STAGES, by_this_program);
            write_text(&place.path().join(RatioRow::FILE), "old").unwrap();
            write_text(&place.path().join("plots/time-ratios.svg"), "old").unwrap();
            write_text(&place.path().join(TimingRow::FILE), "old").unwrap();
            folder.begin_again(Stage::Verify, &[TimingRow::FILE], &[]).unwrap();
            assert!(!place.path().join(RatioRow::FILE).exists() && !place.path().join("plots").exists());
            assert_eq!(place.path().join(TimingRow::FILE).exists(), by_this_program);
        }
    }

    /// Another program may make all of a finished run again, and leaves no rows of the old one; it may not make a part of it.
    #[test]
    fn no_record_mixes_two_programs() {
        let place = tempfile::tempdir().unwrap();
        let timings = place.path().join(TimingRow::FILE);
        let mut folder = finished(place.path(), &STAGES, false);
        write_text(&timings, "old").unwrap();
        let refused = folder.begin_again(Stage::Measure, &[TimingRow::FILE], &[]).unwrap_err();
        assert!(refused.to_string().contains("program of an earlier stage") && timings.exists(), "{refused}");
        drop(folder);
        let mut folder = finished(place.path(), &STAGES, false);
        write_text(&timings, "old").unwrap();
        folder.begin_again(Stage::Verify, &[TimingRow::FILE], &[]).unwrap();
        assert!(!timings.exists() && folder.manifest.finished.is_empty());
        assert_eq!(folder.manifest.program, environment::program());
        let places = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        assert!(finished(places[0].path(), &[Stage::Measure], false).begin(Stage::Verify).is_err());
        assert!(finished(places[1].path(), &[Stage::Measure], true).begin(Stage::Verify).is_ok());
    }

    /// A run that failed at its scene, after the comparison of triangle tests, is begun anew when the scene is mended.
    #[test]
    fn what_has_no_results_is_replaced() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(place.path(), manifest(1), false).unwrap();
        write_unit(&folder.unit(&["verify", CROSS_CHECK]), |_| Ok(())).unwrap();
        fs::create_dir_all(folder.unit(&["verify", "cross-check.partial"])).unwrap();
        drop(folder);
        let folder = Folder::open(place.path(), manifest(2), false).unwrap();
        assert!(folder.manifest.request == manifest(2).request && !folder.unit(&["verify"]).exists());
        write_unit(&folder.unit(&["verify", "mill"]), |_| Ok(())).unwrap();
        drop(folder);
        let refused = Folder::open(place.path(), manifest(3), false).unwrap_err();
        assert!(refused.to_string().contains("another request"), "{refused}");
    }

    #[test]
    fn another_request_needs_fresh_and_foreign_files_are_never_touched() {
        let place = tempfile::tempdir().unwrap();
        let open = |seed, fresh| Folder::open(place.path(), manifest(seed), fresh);
        drop(open(1, false).unwrap());
        write_text(&place.path().join(TimingRow::FILE), "old").unwrap();
        write_text(&place.path().join("notes.txt"), "mine").unwrap();
        assert!(open(2, false).unwrap_err().to_string().contains("another request"));
        drop(open(2, true).unwrap());
        assert!(!place.path().join(TimingRow::FILE).exists() && place.path().join("notes.txt").exists());
        // Rows of an older layout without a manifest are replaced when that is asked for; a foreign folder never.
        fs::remove_file(place.path().join(Manifest::FILE)).unwrap();
        assert!(matches!(open(2, true), Err(MeasureError::NotARun(_))));
        fs::remove_file(place.path().join("notes.txt")).unwrap();
        write_text(&place.path().join("ablation.csv"), "old").unwrap();
        assert!(open(2, false).unwrap_err().to_string().contains("--fresh"));
        drop(open(2, true).unwrap());
        assert!(!place.path().join("ablation.csv").exists());
    }
}

//! The folder of a run, an audit or a sweep: opening it, and the units in it that are written whole or not at all.

use super::MeasureError;
use crate::record::file::compressed;
use crate::record::manifest::Stage;
use crate::record::{FolderLock, Manifest, RecordError};
use std::fs;
use std::path::Path;

/// Folder of the unfinished units inside a run's folder.
pub(super) const UNITS: &str = "units";

/// Opens a folder for what `new` says: a new one, one to go on with, whose own manifest is kept, or a finished one. `fresh`
/// allows what another request left to be replaced; only the files and folders named `files`, the manifest and the units
/// are removed then.
///
/// # Errors
/// When the folder holds something else, another process works in it, or it cannot be written.
pub(super) fn open(
    folder: &Path,
    new: Manifest,
    fresh: bool,
    files: &[&str],
) -> Result<(Manifest, FolderLock), MeasureError> {
    if holds_something_else(folder) {
        return Err(MeasureError::NotARun(folder.to_owned()));
    }
    let lock = FolderLock::take(folder)?;
    let mut manifest = new;
    if folder.join(Manifest::FILE).exists() {
        match Manifest::read(folder).map(|old| (difference(&old, &manifest), old)) {
            Ok((None, old)) => manifest = old,
            _ if fresh => {
                [Manifest::FILE, UNITS].iter().chain(files).try_for_each(|name| {
                    remove(&folder.join(name))?;
                    remove(&folder.join(compressed(name)))
                })?;
            }
            Ok((Some(difference), _)) => {
                return Err(MeasureError::AnotherRun { folder: folder.to_owned(), difference });
            }
            Err(error) => return Err(error.into()),
        }
    }
    manifest.write(folder)?;
    Ok((manifest, lock))
}

/// The manifest of a run that another process has opened and holds the lock of.
///
/// # Errors
/// When the folder holds no run of what `new` says.
pub(super) fn join(folder: &Path, new: &Manifest) -> Result<Manifest, MeasureError> {
    let manifest = Manifest::read(folder)?;
    // The parent's binary, or its binaries, may be others than this one.
    let new = Manifest { binaries: manifest.binaries.clone(), ..new.clone() };
    match difference(&manifest, &new) {
        None => Ok(manifest),
        Some(difference) => Err(MeasureError::AnotherRun { folder: folder.to_owned(), difference }),
    }
}

/// Whether a folder without a manifest has anything in it but what a run leaves that was killed before it wrote one.
fn holds_something_else(folder: &Path) -> bool {
    let begun = [FolderLock::FILE.to_owned(), format!("{}.partial", Manifest::FILE)];
    let is_foreign = |entry: fs::DirEntry| !begun.iter().any(|name| entry.file_name() == name.as_str());
    !folder.join(Manifest::FILE).exists() && fs::read_dir(folder).is_ok_and(|entries| entries.flatten().any(is_foreign))
}

/// What keeps one run from being continued as the other; the command line, the load and such do not.
fn difference(old: &Manifest, new: &Manifest) -> Option<&'static str> {
    let program = |manifest: &Manifest| {
        let program = &manifest.program;
        (program.version.clone(), program.git_revision.clone(), program.rustc.clone(), program.flags.clone())
    };
    let hashes = |manifest: &Manifest| manifest.binaries.iter().map(|b| b.hash.clone()).collect::<Vec<_>>();
    let finished = old.finished.contains(&Stage::Measure);
    match () {
        () if old.schema != new.schema => Some("the schema"),
        () if old.request != new.request => Some("the request"),
        () if old.inputs != new.inputs => Some("an input file"),
        () if old.variants != new.variants => Some("the list of variants"),
        // A finished run is not continued but made again, so another build of the program may do it.
        () if !finished && program(old) != program(new) => Some("the program"),
        () if !finished && old.protocol != new.protocol => Some("the protocol"),
        () if !finished && hashes(old) != hashes(new) => Some("a binary"),
        () => None,
    }
}

/// Writes a unit's files into a folder beside its own and renames it when they are whole.
pub(super) fn write_unit(unit: &Path, write: impl FnOnce(&Path) -> Result<(), RecordError>) -> Result<(), RecordError> {
    let temporary = unit.with_extension("partial");
    remove(&temporary)?;
    fs::create_dir_all(&temporary).map_err(RecordError::io("create", &temporary))?;
    write(&temporary)?;
    fs::rename(&temporary, unit).map_err(RecordError::io("write", unit))
}

/// Removes a file or a folder with all that is in it; one that is not there is fine.
pub(super) fn remove(path: &Path) -> Result<(), RecordError> {
    let result = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match result {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(RecordError::io("remove", path)(error)),
        _ => Ok(()),
    }
}

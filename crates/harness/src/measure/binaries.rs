//! Binaries of one source that differ in layout: the linker shuffled their sections (`scripts/binaries`). The launches of a run take them in
//! turn, so that an interval holds what an accident of layout does to a method (Mytkowicz et al. 2009, ASPLOS; Curtsinger and Berger 2013,
//! ASPLOS). A binary of another source is refused.

use super::environment::{self, Identity};
use crate::record::manifest::BinaryEntry;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{OnceLock, mpsc};
use std::time::Duration;
use thiserror::Error;

/// What stands before the seed at the end of a binary's name.
const SEED_MARK: &str = "-shuffled-";
/// Longest answer to the question for an identity, bytes; a true one has some 300.
const LONGEST_ANSWER: u64 = 64 * 1024;
/// A binary answers in milliseconds; after this long it is none of ours.
const PATIENCE: Duration = Duration::from_secs(10);
/// Most binaries of a run.
const MOST: usize = 64;

/// A binary with its place on this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Binary {
    /// Its file.
    pub path: PathBuf,
    /// What the manifest says of it.
    pub entry: BinaryEntry,
}

/// Why a binary cannot time a run.
#[derive(Debug, Error)]
pub enum BinaryError {
    /// The file system refused.
    #[error("cannot read {path}: {cause}", path = path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// A folder holds none.
    #[error("{folder} holds no binary whose name ends in `{SEED_MARK}SEED`: make them with scripts/binaries", folder = .0.display())]
    None(PathBuf),
    /// Too many.
    #[error("{0} binaries: at most {MOST} take turns")]
    TooMany(usize),
    /// It does not say what it is.
    #[error("{path} does not say what it was built from ({cause}): it is no bvbench of protocol 2.1; make binaries with scripts/binaries", path = path.display())]
    Unknown {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: String,
    },
    /// It is of another source.
    #[error("{path} has another {difference} than this program ({there}, not {here}): make them again with scripts/binaries", path = path.display())]
    Another {
        /// The file.
        path: PathBuf,
        /// What differs.
        difference: &'static str,
        /// What the binary says.
        there: String,
        /// What this program is.
        here: String,
    },
    /// It is the same as another one.
    #[error("{first} and {second} are the same binary: nothing would be learnt from the second", first = first.display(), second = second.display())]
    Same {
        /// One.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
}

/// Number of the binary of a launch, of so many.
pub const fn binary_of(launch: u32, binaries: u32) -> u32 {
    if binaries == 0 { 0 } else { launch % binaries }
}

/// The binary that is running, as it was at the first call: its file may be built again since.
pub fn running() -> Option<BinaryEntry> {
    static RUNNING: OnceLock<Option<BinaryEntry>> = OnceLock::new();
    RUNNING.get_or_init(|| entry(&std::env::current_exe().ok()?).ok()).clone()
}

/// The binaries that `paths` name, files in their order and of folders all whose names end in a seed, by seed; each of the same source as
/// this program.
///
/// # Errors
/// When one cannot be read or run, is of another source, or is there twice.
pub fn gather(paths: &[PathBuf]) -> Result<Vec<Binary>, BinaryError> {
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            files.extend(in_folder(path)?);
        } else {
            files.push(path.clone());
        }
    }
    if files.len() > MOST {
        return Err(BinaryError::TooMany(files.len()));
    }
    let here = environment::identity();
    let mut binaries: Vec<Binary> = Vec::new();
    for file in files {
        let path = file.canonicalize().map_err(|cause| BinaryError::Read { path: file.clone(), cause })?;
        let entry = entry(&path)?;
        if let Some(same) = binaries.iter().find(|other| other.entry.hash == entry.hash) {
            return Err(BinaryError::Same { first: same.path.clone(), second: path });
        }
        let there = ask(&path)?;
        if let Some((difference, there, here)) = there.difference(&here) {
            return Err(BinaryError::Another { path, difference, there, here });
        }
        binaries.push(Binary { path, entry });
    }
    Ok(binaries)
}

/// The files of a folder whose names end in a seed, by seed.
fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, BinaryError> {
    let error = |cause| BinaryError::Read { path: folder.to_owned(), cause };
    let mut found = Vec::new();
    for file in folder.read_dir().map_err(error)? {
        let path = file.map_err(error)?.path();
        if let Some(seed) = seed_of(&path).filter(|_| path.is_file()) {
            found.push((seed, path));
        }
    }
    if found.is_empty() {
        return Err(BinaryError::None(folder.to_owned()));
    }
    found.sort();
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

fn seed_of(path: &Path) -> Option<u64> {
    let name = path.file_name()?.to_str()?;
    let name = name.strip_suffix(std::env::consts::EXE_SUFFIX)?;
    name.rsplit_once(SEED_MARK)?.1.parse().ok()
}

fn entry(path: &Path) -> Result<BinaryEntry, BinaryError> {
    let error = |cause| BinaryError::Read { path: path.to_owned(), cause };
    let hash = blake3::hash(&std::fs::read(path).map_err(error)?).to_hex().to_string();
    let file = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    Ok(BinaryEntry { file, hash, seed: seed_of(path) })
}

/// What a binary says it was built from.
fn ask(path: &Path) -> Result<Identity, BinaryError> {
    let unknown = |cause: String| BinaryError::Unknown { path: path.to_owned(), cause };
    let mut child = Command::new(path)
        .arg("identity")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|cause| unknown(cause.to_string()))?;
    let text = answer(&mut child);
    // Whatever it is, it has said what we wanted to know, or it never will.
    let _ = child.kill();
    let _ = child.wait();
    serde_json::from_str(&text.map_err(unknown)?).map_err(|_| unknown("its answer is no identity".to_owned()))
}

/// What a child prints, as far as it does so in time.
fn answer(child: &mut Child) -> Result<String, String> {
    let output = child.stdout.take().ok_or_else(|| "it has no output".to_owned())?;
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        let mut text = String::new();
        let read = output.take(LONGEST_ANSWER).read_to_string(&mut text).map(|_| text);
        // Nobody listens any more when it took too long.
        let _ = sender.send(read);
    });
    let read = receiver.recv_timeout(PATIENCE).map_err(|_| format!("no answer in {} s", PATIENCE.as_secs()))?;
    read.map_err(|cause| cause.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// Launches take the binaries in turn; one binary takes them all.
    #[test]
    fn launches_take_the_binaries_in_turn() {
        assert_eq!((0..7).map(|launch| binary_of(launch, 3)).collect::<Vec<_>>(), [0, 1, 2, 0, 1, 2, 0]);
        assert_eq!((binary_of(5, 1), binary_of(5, 0)), (0, 0));
    }

    #[test]
    fn a_name_tells_the_seed() {
        assert_eq!(seed_of(Path::new("x/bvbench-shuffled-17")), Some(17));
        assert_eq!(seed_of(Path::new("x/bvbench-shuffled-")), None);
        assert_eq!(seed_of(Path::new("x/bvbench")), None);
    }

    #[test]
    fn a_folder_without_binaries_and_a_file_that_is_none_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let error = gather(&[folder.path().to_owned()]).unwrap_err();
        assert!(matches!(&error, BinaryError::None(_)) && error.to_string().contains("scripts/binaries"), "{error}");
        let file = folder.path().join("bvbench-shuffled-1");
        fs::write(&file, "no program").unwrap();
        assert!(matches!(gather(&[folder.path().to_owned()]), Err(BinaryError::Unknown { .. })));
        assert!(matches!(gather(&[folder.path().join("gone")]), Err(BinaryError::Read { .. })));
    }

    /// A program that prints without end, or says nothing of itself, is not waited for.
    #[cfg(unix)]
    #[test]
    fn programs_that_are_none_of_ours_are_refused() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        for (name, script) in [("endless", "#!/bin/sh\nexec yes\n"), ("silent", "#!/bin/sh\nexit 0\n")] {
            let file = folder.path().join(name);
            fs::write(&file, script).unwrap();
            fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
            assert!(matches!(gather(&[file]), Err(BinaryError::Unknown { .. })), "{name}");
        }
        let other = folder.path().join("other");
        let identity = Identity { version: "9.9.9".into(), ..environment::identity() };
        let text = serde_json::to_string(&identity).unwrap();
        fs::write(&other, format!("#!/bin/sh\ncat <<'END'\n{text}\nEND\n")).unwrap();
        fs::set_permissions(&other, fs::Permissions::from_mode(0o755)).unwrap();
        let error = gather(std::slice::from_ref(&other)).unwrap_err().to_string();
        assert!(error.contains("another version") && error.contains("9.9.9"), "{error}");
        let text = serde_json::to_string(&environment::identity()).unwrap();
        fs::write(&other, format!("#!/bin/sh\ncat <<'END'\n{text}\nEND\n")).unwrap();
        assert_eq!(gather(std::slice::from_ref(&other)).unwrap().len(), 1);
        assert!(matches!(gather(&[other.clone(), other]), Err(BinaryError::Same { .. })));
    }
}

//! Bytes as files that a run or a peer leaves: an error, or what can be written and read again.

use bvbench::measure::peers::npy::{self, Element};
use bvbench::record::manifest::Manifest;
use std::fmt::Debug;
use std::fs;
use std::path::{Path, PathBuf};

/// A folder of this process and thread.
fn folder() -> PathBuf {
    let name = format!("bvbench-fuzz-{}-{:?}", std::process::id(), std::thread::current().id());
    let folder = std::env::temp_dir().join(name);
    fs::create_dir_all(&folder).expect("a folder for temporary files can be made");
    folder
}

/// Reads the bytes as arrays of every type and of several shapes.
pub fn npy(bytes: &[u8]) {
    let folder = folder();
    let path = folder.join("a.npy");
    fs::write(&path, bytes).expect("a temporary file can be written");
    for row in [&[][..], &[3], &[3, 4]] {
        read_again::<f64>(&path, row, f64::to_bits);
        read_again::<u64>(&path, row, u64::from);
        read_again::<u32>(&path, row, u64::from);
        read_again::<u8>(&path, row, u64::from);
    }
    let _ = fs::remove_dir_all(folder);
}

fn read_again<T: Element + Debug>(path: &Path, row: &[usize], bits: impl Fn(T) -> u64) {
    let Ok(numbers) = npy::read::<T>(path, row) else { return };
    let width: usize = row.iter().product();
    assert_eq!(numbers.len() % width, 0);
    let (again, shape) = (path.with_file_name("b.npy"), [&[numbers.len() / width], row].concat());
    npy::write(&again, &shape, &numbers).expect("a temporary file can be written");
    let read = npy::read::<T>(&again, row).expect("what was written is read");
    assert!(read.into_iter().map(&bits).eq(numbers.into_iter().map(&bits)));
}

/// Reads the bytes as the manifest of a run.
pub fn manifest(bytes: &[u8]) {
    let folder = folder();
    fs::write(folder.join(Manifest::FILE), bytes).expect("a temporary file can be written");
    if let Ok(manifest) = Manifest::read(&folder) {
        manifest.write(&folder).expect("a temporary file can be written");
        let again = Manifest::read(&folder).expect("what was written is read");
        assert_eq!((again.request, again.scenes, again.inputs), (manifest.request, manifest.scenes, manifest.inputs));
    }
    let _ = fs::remove_dir_all(folder);
}

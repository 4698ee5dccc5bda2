//! What a program is built from: a fingerprint of the source and the state of its git checkout. The build script asks, and so does a run, so
//! that a commit alone need not build anything again.

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Whatever the program is compiled from, below the root of the package: of `crates`, the packages that it depends on.
pub const SOURCES: [&str; 9] = [
    "Cargo.toml",
    "Cargo.lock",
    "build.rs",
    "crates/harness",
    "crates/obbtree",
    "crates/record",
    "crates/rs274",
    "crates/scene",
    "src",
];

/// A number that names the content of [`SOURCES`] below `root`; the same only for programs of one compiler. `None` when something cannot
/// be read.
pub fn fingerprint(root: &Path) -> Option<u64> {
    let mut files = Vec::new();
    for source in SOURCES {
        gather(&root.join(source), &mut files)?;
    }
    files.sort();
    let mut hasher = DefaultHasher::new();
    for file in files {
        let content = fs::read(&file).ok()?;
        hasher.write(file.strip_prefix(root).ok()?.as_os_str().as_encoded_bytes());
        hasher.write_usize(content.len());
        hasher.write(&content);
    }
    Some(hasher.finish())
}

fn gather(path: &Path, files: &mut Vec<PathBuf>) -> Option<()> {
    if path.is_dir() {
        for entry in fs::read_dir(path).ok()? {
            gather(&entry.ok()?.path(), files)?;
        }
    } else if path.exists() {
        files.push(path.to_owned());
    }
    Some(())
}

/// The revision that `root` has checked out, and whether there are local changes. `None` where `root` is not the top of a checkout: a
/// package in a registry's folder may lie below somebody else's repository.
pub fn checkout(root: &Path) -> Option<(String, bool)> {
    if !root.join(".git").exists() {
        return None;
    }
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let revision = git(&["rev-parse", "HEAD"])?;
    // New files count where programs are made of them: a volume that nobody has committed is a local change.
    let tracked = git(&["status", "--porcelain", "--untracked-files=no"])?;
    let sources = git(&["status", "--porcelain", "--", "src", "crates", "examples", "benches"])?;
    Some((revision, !(tracked.is_empty() && sources.is_empty())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fingerprint_changes_with_names_and_contents_of_what_is_compiled() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        for file in SOURCES.iter().take(3) {
            fs::write(root.join(file), "one").unwrap();
        }
        fs::create_dir_all(root.join("src/deep")).unwrap();
        fs::write(root.join("src/deep/a.rs"), "fn a() {}").unwrap();
        let first = fingerprint(root).unwrap();
        fs::write(root.join("README.md"), "not compiled").unwrap();
        assert_eq!(fingerprint(root), Some(first));
        fs::rename(root.join("src/deep/a.rs"), root.join("src/deep/b.rs")).unwrap();
        let renamed = fingerprint(root).unwrap();
        fs::write(root.join("src/deep/b.rs"), "fn b() {}").unwrap();
        assert!(renamed != first && fingerprint(root) != Some(renamed));
        assert_eq!(checkout(root), None, "no checkout of its own");
    }
}

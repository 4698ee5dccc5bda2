//! The source of a scene's files: a folder on disk, or the scenes compiled into the program. Every file is hashed when it is read.

use super::error::SceneError;
use super::{MeshFile, shipped};
use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};

/// A scene's folder, and the record of the files read from it.
pub struct Folder {
    source: Source,
    name: String,
    /// Hash of each file: its path as `scene/file`, with `..` resolved as far as the folder's parent, to the BLAKE3 hash of its bytes.
    inputs: BTreeMap<String, String>,
    /// Real path of each file that was read from disk.
    files: Vec<PathBuf>,
    /// Import reports of the mesh files.
    pub meshes: Vec<MeshFile>,
}

enum Source {
    Disk(PathBuf),
    Shipped,
    Memory(BTreeMap<String, Vec<u8>>),
}

impl Folder {
    /// A folder on disk.
    pub fn on_disk(path: &Path) -> Self {
        let name = path.canonicalize().ok().and_then(|full| Some(full.file_name()?.to_string_lossy().into_owned()));
        Self { source: Source::Disk(path.to_owned()), ..Self::shipped(name.as_deref().unwrap_or("scene")) }
    }

    /// A folder compiled into the program.
    pub fn shipped(name: &str) -> Self {
        let (inputs, files, meshes) = (BTreeMap::new(), Vec::new(), Vec::new());
        Self { source: Source::Shipped, name: name.to_owned(), inputs, files, meshes }
    }

    /// A folder in memory; files are given by their paths relative to the folder.
    pub fn in_memory(name: &str, files: BTreeMap<String, Vec<u8>>) -> Self {
        Self { source: Source::Memory(files), ..Self::shipped(name) }
    }

    /// The folder's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Name of a file in messages.
    pub fn path(&self, relative: &str) -> PathBuf {
        match &self.source {
            Source::Disk(folder) => folder.join(relative),
            Source::Shipped => Path::new("bench-scenes").join(normalised(&self.name, relative)),
            Source::Memory(_) => Path::new(&self.name).join(relative),
        }
    }

    /// Whether the folder has the file.
    #[cfg(feature = "urdf")]
    pub fn has(&self, relative: &str) -> bool {
        match &self.source {
            Source::Disk(folder) => folder.join(relative).is_file(),
            Source::Shipped => shipped::file(&normalised(&self.name, relative)).is_some(),
            Source::Memory(files) => files.contains_key(relative),
        }
    }

    /// The bytes of a file, by its path relative to the folder.
    pub fn bytes(&mut self, relative: &str) -> Result<Vec<u8>, SceneError> {
        let key = normalised(&self.name, relative);
        let bytes = match &self.source {
            Source::Disk(folder) => rs274::file::bytes(&folder.join(relative), LARGEST_FILE),
            Source::Shipped => shipped::file(&key)
                .map(|text| text.as_bytes().to_vec())
                .ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "no such file among the shipped scenes")),
            Source::Memory(files) => files
                .get(relative)
                .cloned()
                .ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "no such file in memory")),
        };
        let bytes = bytes.map_err(|cause| SceneError::Read { file: self.path(relative), cause })?;
        self.inputs.insert(key, blake3::hash(&bytes).to_hex().to_string());
        if let Source::Disk(folder) = &self.source {
            self.files.extend(folder.join(relative).canonicalize());
        }
        Ok(bytes)
    }

    /// The text of a file.
    pub fn text(&mut self, relative: &str) -> Result<String, SceneError> {
        let bytes = self.bytes(relative)?;
        let is_utf16 = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
        if let (false, Err(error)) = (is_utf16, str::from_utf8(&bytes)) {
            let cause = io::Error::new(io::ErrorKind::InvalidData, error);
            return Err(SceneError::Read { file: self.path(relative), cause });
        }
        Ok(rs274::file::decode(bytes))
    }

    /// The hash of a file that was read; empty for one that was not.
    pub fn hash(&self, relative: &str) -> String {
        self.inputs.get(&normalised(&self.name, relative)).cloned().unwrap_or_default()
    }

    /// The record of the files read: hashes by file, real paths, and import reports of mesh files.
    pub fn into_records(self) -> (BTreeMap<String, String>, Vec<PathBuf>, Vec<MeshFile>) {
        (self.inputs, self.files, self.meshes)
    }
}

/// Largest file of a scene, bytes: a binary STL of 20 million triangles.
pub const LARGEST_FILE: u64 = 1 << 30;

/// `folder/relative` with `/` between the parts and `..` resolved. `..` beyond the folder's parent stays, and an absolute path stays what it is,
/// so that two files never have one key.
fn normalised(folder: &str, relative: &str) -> String {
    let path = Path::new(relative);
    // An absolute path begins with an empty part.
    let mut parts = vec![if path.has_root() { String::new() } else { folder.to_owned() }];
    for component in path.components() {
        match component {
            // The root is its own parent.
            Component::ParentDir if parts.last().is_some_and(String::is_empty) => {}
            Component::ParentDir if parts.last().is_none_or(|last| last == "..") => parts.push("..".to_owned()),
            Component::ParentDir => drop(parts.pop()),
            Component::Normal(part) => parts.push(part.to_string_lossy().into_owned()),
            Component::Prefix(prefix) => parts.push(prefix.as_os_str().to_string_lossy().into_owned()),
            Component::CurDir | Component::RootDir => {}
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_do_not_depend_on_where_the_folder_is() {
        assert_eq!(normalised("lathe", "./scene.toml"), "lathe/scene.toml");
        assert_eq!(normalised("a", "../lathe/machine.toml"), "lathe/machine.toml");
        assert_eq!(normalised("a", "b/../c/./d.stl"), "a/c/d.stl");
    }

    #[test]
    fn files_in_different_folders_have_different_keys() {
        assert_eq!(normalised("a", "../machine.toml"), "machine.toml");
        assert_eq!(normalised("a", "../../machine.toml"), "../machine.toml");
        assert_eq!(normalised("a", "../../../b/machine.toml"), "../../b/machine.toml");
        assert_eq!(normalised("a", "/b/machine.toml"), "/b/machine.toml");
        assert_eq!(normalised("a", "/../b/machine.toml"), "/b/machine.toml");
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = Folder::shipped("nowhere").bytes("scene.toml").unwrap_err();
        assert!(error.to_string().contains("scene.toml: no such file"), "{error}");
        let error = Folder::on_disk(Path::new("no-such-folder")).text("scene.toml").unwrap_err();
        assert!(matches!(error, SceneError::Read { file, .. } if file == Path::new("no-such-folder/scene.toml")));
    }
}

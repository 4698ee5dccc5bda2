//! One process at a time in a run's folder. The operating system releases the lock when the process ends, however it ends.

use super::file::RecordError;
use std::fs::{self, File, TryLockError};
use std::io::{Read, Write};
use std::path::Path;

/// The lock of a folder, held until the value is dropped.
#[derive(Debug)]
pub struct FolderLock {
    _file: File,
}

impl FolderLock {
    /// The lock's file in the folder. It stays when the lock is released: removing it would let two processes hold two locks.
    pub const FILE: &'static str = ".lock";

    /// Locks `folder`, which is created when it is missing.
    ///
    /// # Errors
    /// [`RecordError::Locked`] when another process holds the lock; [`RecordError::Io`] when the file cannot be opened.
    pub fn take(folder: &Path) -> Result<Self, RecordError> {
        fs::create_dir_all(folder).map_err(RecordError::io("create", folder))?;
        let path = folder.join(Self::FILE);
        let mut options = File::options();
        options.read(true).write(true).create(true).truncate(false);
        let mut file = options.open(&path).map_err(RecordError::io("open", &path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut process = String::new();
                // Some systems let nobody read a locked file; the message then names no process.
                let _ = file.read_to_string(&mut process);
                let holder =
                    process.trim().parse::<u32>().map_or_else(|_| String::new(), |id| format!(" (process {id})"));
                return Err(RecordError::Locked { folder: folder.to_owned(), holder });
            }
            Err(TryLockError::Error(source)) => return Err(RecordError::io("lock", &path)(source)),
        }
        let written = file.set_len(0).and_then(|()| writeln!(file, "{}", std::process::id()));
        written.map_err(RecordError::io("write", &path))?;
        Ok(Self { _file: file })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_holder_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let held = FolderLock::take(folder.path()).unwrap();
        let message = FolderLock::take(folder.path()).unwrap_err().to_string();
        assert!(message.contains(&folder.path().display().to_string()), "{message}");
        assert!(cfg!(windows) || message.contains(&format!("process {}", std::process::id())), "{message}");
        drop(held);
        FolderLock::take(folder.path()).unwrap();
    }
}

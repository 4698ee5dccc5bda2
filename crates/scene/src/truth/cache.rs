//! Cache of the ground truth: a folder of files, each named by a hash of everything that its answers depend on.
//!
//! A file is either complete or absent, because it is written under a temporary name and renamed. It ends with a hash of its contents. A
//! file that is truncated, damaged or of another version is ignored, and its answers are computed again.

use super::{Judgement, PairOracle, Verdict};
use crate::geometry::{Isometry, content_hash};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Part of every key. Increase it whenever an answer may have changed.
const VERSION: u32 = 8;
/// The first bytes of every file.
const MAGIC: &[u8; 8] = b"bvtruth\0";
/// Bytes of one record: flags, the witness's faces, clearance, depth.
const RECORD: usize = 1 + 4 + 4 + 8 + 8;

/// Why answers could not be stored.
#[derive(Debug, Error)]
#[error("cannot {verb} {path}: {source}", path = path.display())]
pub struct CacheError {
    verb: &'static str,
    path: PathBuf,
    source: std::io::Error,
}

impl CacheError {
    fn new(verb: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self { verb, path, source }
    }
}

/// A folder of answers.
#[derive(Clone, Debug)]
pub struct TruthCache {
    folder: PathBuf,
}

/// The key of one set of answers: two meshes, the poses, and the request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TruthKey {
    hash: blake3::Hash,
    poses: usize,
}

impl TruthKey {
    /// The key of the answers at these poses. `request` states, in the caller's words, what else the answers depend on: the cut-off of the
    /// clearance, the method for depths, the bounds of clusters.
    pub fn new(oracle: &PairOracle, poses: &[Isometry], request: &str) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&VERSION.to_le_bytes());
        for mesh in [oracle.mesh_a(), oracle.mesh_b()] {
            hasher.update(content_hash(mesh).as_bytes());
        }
        hasher.update(&(request.len() as u64).to_le_bytes()).update(request.as_bytes());
        for pose in poses {
            for x in pose.translation.vector.iter().chain(pose.rotation.coords.iter()) {
                hasher.update(&x.to_le_bytes());
            }
        }
        Self { hash: hasher.finalize(), poses: poses.len() }
    }
}

impl TruthCache {
    /// The cache in a folder, which is created when it does not exist.
    ///
    /// # Errors
    /// When the folder cannot be created.
    pub fn at(folder: &Path) -> Result<Self, CacheError> {
        fs::create_dir_all(folder).map_err(CacheError::new("create", folder))?;
        Ok(Self { folder: folder.to_owned() })
    }

    fn path(&self, key: &TruthKey) -> PathBuf {
        self.folder.join(format!("{}.truth", key.hash.to_hex()))
    }

    /// The answers stored under the key, in the order of the poses; `None` when no valid file exists.
    pub fn load(&self, key: &TruthKey) -> Option<Vec<Judgement>> {
        decode(&fs::read(self.path(key)).ok()?, key)
    }

    /// Stores the answers.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn store(&self, key: &TruthKey, judgements: &[Judgement]) -> Result<(), CacheError> {
        let path = self.path(key);
        // Two processes may store the same answers at the same time.
        let temporary = path.with_extension(format!("{}.partial", std::process::id()));
        let written = File::create(&temporary).and_then(|mut file| {
            file.write_all(&encode(key, judgements))?;
            file.sync_all()
        });
        let renamed = written.and_then(|()| fs::rename(&temporary, &path));
        renamed.map_err(|source| {
            let _ = fs::remove_file(&temporary);
            CacheError::new("write", &path)(source)
        })
    }
}

/// Encodes magic bytes, key and records, followed by a hash of all of these.
fn encode(key: &TruthKey, judgements: &[Judgement]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(key.hash.as_bytes());
    for Judgement { verdict, clearance_mm, depth_mm } in judgements {
        let flags = [verdict.touches(), verdict.contained, depth_mm.is_some()];
        bytes.push(flags.iter().enumerate().map(|(i, &flag)| u8::from(flag) << i).sum());
        let (face_a, face_b) = verdict.witness.unwrap_or_default();
        bytes.extend(face_a.to_le_bytes());
        bytes.extend(face_b.to_le_bytes());
        bytes.extend(clearance_mm.to_le_bytes());
        bytes.extend(depth_mm.unwrap_or(0.0).to_le_bytes());
    }
    let hash = blake3::hash(&bytes);
    bytes.extend(hash.as_bytes());
    bytes
}

fn decode(bytes: &[u8], key: &TruthKey) -> Option<Vec<Judgement>> {
    let (contents, hash) = bytes.split_last_chunk::<32>()?;
    let contents_are_whole = blake3::hash(contents) == blake3::Hash::from_bytes(*hash);
    let records = contents.strip_prefix(MAGIC)?.strip_prefix(key.hash.as_bytes())?;
    if !contents_are_whole || records.len() != key.poses * RECORD {
        return None;
    }
    records.chunks_exact(RECORD).map(decode_record).collect()
}

fn decode_record(record: &[u8]) -> Option<Judgement> {
    let (&flags, numbers) = record.split_first()?;
    let (&face_a, numbers) = numbers.split_first_chunk::<4>()?;
    let (&face_b, numbers) = numbers.split_first_chunk::<4>()?;
    let (&clearance, depth) = numbers.split_first_chunk::<8>()?;
    let flag = |i: u8| flags >> i & 1 == 1;
    let witness = flag(0).then_some((u32::from_le_bytes(face_a), u32::from_le_bytes(face_b)));
    Some(Judgement {
        verdict: Verdict { witness, contained: flag(1) },
        clearance_mm: f64::from_le_bytes(clearance),
        depth_mm: flag(2).then_some(f64::from_le_bytes(depth.try_into().ok()?)),
    })
}

#[cfg(test)]
mod tests {
    use super::super::solids;
    use super::*;
    use std::sync::Arc;

    fn oracle() -> PairOracle {
        PairOracle::new(Arc::new(solids::block(4.0, 4.0, 4.0)), Arc::new(solids::block(2.0, 2.0, 2.0)))
    }

    fn poses() -> Vec<Isometry> {
        [0.0, 2.5, 9.0].map(|x| Isometry::translation(x, 0.0, 0.0)).to_vec()
    }

    fn answers() -> Vec<Judgement> {
        let mut judged = super::super::judge_all(
            &oracle(),
            &poses(),
            &super::super::Sought::Distance { beyond_mm: f64::INFINITY },
            &|_| (),
        );
        judged[1].depth_mm = Some(0.5);
        judged[2].clearance_mm = f64::INFINITY;
        judged
    }

    #[test]
    fn what_is_stored_is_loaded() {
        let folder = tempfile::tempdir().unwrap();
        let cache = TruthCache::at(&folder.path().join("new/cache")).unwrap();
        let key = TruthKey::new(&oracle(), &poses(), "10 mm");
        assert_eq!(cache.load(&key), None);
        cache.store(&key, &answers()).unwrap();
        assert_eq!(cache.load(&key), Some(answers()));
        assert_eq!(fs::read_dir(&cache.folder).unwrap().count(), 1); // no temporary file is left
    }

    #[test]
    fn any_other_question_has_another_key() {
        let key = TruthKey::new(&oracle(), &poses(), "10 mm");
        let swapped = PairOracle::new(oracle().mesh_b().clone(), oracle().mesh_a().clone());
        let mut nudged = poses();
        nudged[2].translation.x += 1e-12;
        assert_ne!(key, TruthKey::new(&oracle(), &poses(), "1 mm"));
        assert_ne!(key, TruthKey::new(&swapped, &poses(), "10 mm"));
        assert_ne!(key, TruthKey::new(&oracle(), &nudged, "10 mm"));
        assert_ne!(key, TruthKey::new(&oracle(), &poses()[..2], "10 mm"));
        assert_eq!(key, TruthKey::new(&oracle(), &poses(), "10 mm"));
    }

    #[test]
    fn a_damaged_file_is_not_trusted() {
        let folder = tempfile::tempdir().unwrap();
        let cache = TruthCache::at(folder.path()).unwrap();
        let key = TruthKey::new(&oracle(), &poses(), "");
        cache.store(&key, &answers()).unwrap();
        let good = fs::read(cache.path(&key)).unwrap();
        for i in 0..good.len() {
            let mut damaged = good.clone();
            damaged[i] ^= 4;
            fs::write(cache.path(&key), damaged).unwrap();
            assert_eq!(cache.load(&key), None, "byte {i}");
            fs::write(cache.path(&key), &good[..i]).unwrap();
            assert_eq!(cache.load(&key), None, "{i} bytes");
        }
        // A whole file with too few answers.
        cache.store(&key, &answers()[..2]).unwrap();
        assert_eq!(cache.load(&key), None);
    }

    #[test]
    fn a_folder_that_cannot_be_used_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = TruthCache::at(&file.join("cache")).unwrap_err();
        assert!(error.to_string().starts_with("cannot create"), "{error}");
        let cache = TruthCache::at(&folder.path().join("gone")).unwrap();
        fs::remove_dir(folder.path().join("gone")).unwrap();
        let key = TruthKey::new(&oracle(), &poses(), "");
        assert!(cache.store(&key, &answers()).unwrap_err().to_string().starts_with("cannot write"));
        assert_eq!(cache.load(&key), None);
    }
}

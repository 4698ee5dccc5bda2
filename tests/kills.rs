//! Runs that are killed at random moments, over and over, and then left to finish: nothing that was complete is lost, and the
//! deterministic tables are those of a run that nobody disturbed.
//!
//! `BVBENCH_KILLS=40 cargo test --release --test kills` kills more often. Messages name the kill and its moment; the seed is fixed.

#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};
use support::Folder;

/// Kills in the short form of the test.
const KILLS: u32 = 4;
const SEED: u64 = 2011;

/// A trial small enough to be repeated: two variants on one scene, with everything that `repro` does.
fn start(folder: &Folder, out: &str) -> Child {
    let arguments = [
        ["repro", "--profile", "smoke", "--scene", "scene"].as_slice(),
        &["--variant", "obb-vertex", "--variant", "obb-area", "--out", out, "--quiet"],
    ]
    .concat();
    folder.command(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

fn finish(folder: &Folder, out: &str) -> Duration {
    let begun = Instant::now();
    let output = start(folder, out).wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    begun.elapsed()
}

/// Every CSV below a folder, by its path there.
fn tables(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut rest = vec![folder.to_owned()];
    while let Some(next) = rest.pop() {
        for path in fs::read_dir(next).into_iter().flatten().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                rest.push(path);
            } else if path.extension().is_some_and(|end| end == "csv") {
                found.push(path);
            }
        }
    }
    found
}

/// The deterministic tables of a finished run, by name.
fn deterministic(folder: &Path) -> BTreeMap<PathBuf, String> {
    let names =
        ["cases", "poses", "answers", "lines", "misses", "verification", "trees", "tightness", "exits", "outlines"];
    let is_named = |path: &PathBuf| path.file_stem().is_some_and(|stem| names.iter().any(|name| stem == *name));
    let read = |path: PathBuf| (path.strip_prefix(folder).unwrap().to_owned(), fs::read_to_string(&path).unwrap());
    tables(folder).into_iter().filter(is_named).map(read).collect()
}

#[test]
fn a_run_killed_at_random_moments_ends_as_an_undisturbed_one() {
    let folder = Folder::with_scene();
    let whole = finish(&folder, "undisturbed");
    let kills = std::env::var("BVBENCH_KILLS").map_or(KILLS, |text| text.parse().unwrap());
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    for kill in 0..kills {
        let wait = whole.mul_f64(random.random::<f64>());
        let mut child = start(&folder, "killed");
        std::thread::sleep(wait);
        child.kill().unwrap();
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.is_empty(), "kill {kill} after {wait:?}: {said}");
        for path in tables(&folder.path("killed")).iter().filter(|path| !path.to_string_lossy().contains(".partial")) {
            let mut rows = csv::Reader::from_path(path).unwrap().into_records();
            assert!(rows.all(|row| row.is_ok()), "kill {kill} after {wait:?} left half a table: {}", path.display());
        }
    }
    finish(&folder, "killed");
    let (killed, undisturbed) = (deterministic(&folder.path("killed")), deterministic(&folder.path("undisturbed")));
    assert!(undisturbed.len() >= 10, "{:?}", undisturbed.keys());
    assert_eq!(killed.keys().collect::<Vec<_>>(), undisturbed.keys().collect::<Vec<_>>());
    for (name, text) in &undisturbed {
        assert_eq!(&killed[name], text, "{}", name.display());
    }
}

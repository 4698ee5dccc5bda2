//! A run over several binaries: what it records, what it refuses, and that it is taken up again.

#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::{BALL_AND_RING, Folder, words};

/// Copies of this bvbench that differ in a byte behind their last section, which changes the hash and nothing else.
fn binaries(folder: &Folder, seeds: &[u64]) -> PathBuf {
    let place = folder.path("binaries");
    fs::create_dir_all(&place).unwrap();
    for seed in seeds {
        let file = place.join(format!("bvbench-shuffled-{seed}"));
        fs::copy(env!("CARGO_BIN_EXE_bvbench"), &file).unwrap();
        fs::OpenOptions::new().append(true).open(&file).unwrap().write_all(&seed.to_le_bytes()).unwrap();
    }
    place
}

fn manifest(run: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(run.join("manifest.json")).unwrap()).unwrap()
}

/// The distinct pairs of two columns.
fn pairs(path: &Path, columns: [&str; 2]) -> BTreeSet<(String, String)> {
    let reader: Box<dyn std::io::Read> = Box::new(flate2::read::MultiGzDecoder::new(fs::File::open(path).unwrap()));
    let mut reader = csv::Reader::from_reader(reader);
    let headers = reader.headers().unwrap().clone();
    let place = columns.map(|column| headers.iter().position(|header| header == column).unwrap());
    let cells = |record: csv::StringRecord| (record[place[0]].to_owned(), record[place[1]].to_owned());
    reader.records().map(|record| cells(record.unwrap())).collect()
}

fn pair(a: &str, b: &str) -> (String, String) {
    (a.to_owned(), b.to_owned())
}

const CLAIMS: &str = "schema = 1\nsource = \"a test\"\n\n[comparison]\nbaselines = [\"obb-vertex\"]\n";

/// Two binaries of two launches: rows say which binary they come from, singles are of the first launch of each, raw rows are compressed, the analysis has
/// components of binary, launch and block, and another run is planned from them. What was interrupted goes on; with another binary it does not.
#[test]
fn launches_take_the_binaries_in_turn() {
    let scene = format!("{BALL_AND_RING}\n[program]\nfile = \"program.ngc\"\nstep_mm = 1\nstart = {{ x_mm = 100 }}\n");
    let folder =
        Folder::with(&[("scene/scene.toml", &scene), ("scene/program.ngc", "G21 G90 G94\nG1 X20 F1000\nM2\n")]);
    let place = binaries(&folder, &[7, 8]);
    let stage = |verb: &str, out: &str, more: &str| {
        format!(
            "stage {verb} --profile smoke --scene scene --workload program-time --variant obb-area --variant obb-vertex \
             --policy median/shared/8 --cold-poses 2 --quiet --out {out} {more}"
        )
    };
    let binary = format!("--binary {}", place.display());
    let two = format!("{binary} --launches 2 --blocks 2 --gzip");
    folder.done(&words(&stage("verify", "run", &two)));
    folder.done(&words(&stage("measure", "run", &two)));
    let run = folder.path("run");
    let manifest = manifest(&run);
    assert_eq!(manifest["protocol"], bvbench::record::manifest::PROTOCOL);
    assert_eq!((&manifest["request"]["launches"], &manifest["request"]["binaries"]), (&4.into(), &2.into()));
    let seeds: Vec<_> = manifest["binaries"].as_array().unwrap().iter().map(|binary| binary["seed"].as_u64()).collect();
    assert_eq!(seeds, [Some(7), Some(8)]);
    assert!(
        manifest["clock"]["empty_ns"].as_u64().is_some() && manifest["cold"]["buffer_bytes"].as_u64() >= Some(64 << 20)
    );
    assert!(manifest["rows"]["timings.csv.gz"].is_string() && !run.join("timings.csv").exists());
    let turns: BTreeSet<_> = [("0", "0"), ("1", "1"), ("0", "2"), ("1", "3")].map(|(a, b)| pair(a, b)).into();
    for file in ["timings.csv.gz", "builds.csv.gz"] {
        assert_eq!(pairs(&run.join(file), ["binary", "launch"]), turns, "{file}");
    }
    assert!(pairs(&run.join("singles.csv.gz"), ["binary", "launch"]).is_subset(&turns));
    let caches: BTreeSet<_> = pairs(&run.join("singles.csv.gz"), ["cache", "cache"]);
    assert_eq!(caches, [pair("cold", "cold")].into(), "there are no chunks but programs");

    fs::write(folder.path("claims.toml"), CLAIMS).unwrap();
    folder.done(&["stage", "analyze", "--out", "run", "--claims", "claims.toml"]);
    let ratios = fs::read_to_string(run.join("ratios.csv")).unwrap();
    assert!(ratios.contains("program-time-cold,all,program-time-cold,obb-area"), "{ratios}");
    let mut variance = csv::Reader::from_path(run.join("variance.csv")).unwrap();
    let headers = variance.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = variance.records().map(Result::unwrap).collect();
    let cell =
        |row: &csv::StringRecord, name: &str| row[headers.iter().position(|header| header == name).unwrap()].to_owned();
    assert!(rows.iter().all(|row| ["binaries", "launches", "blocks"].map(|name| cell(row, name)) == ["2", "2", "2"]));
    assert!(
        rows.iter().all(|row| ["binary_sd", "launch_sd", "block_sd"].iter().all(|name| !cell(row, name).is_empty()))
    );

    // Finished: made again only as a whole. Another request is another run.
    let message = folder.refused(&words(&stage("measure", "run", &binary)));
    assert!(message.contains("request"), "{message}");
    // A pilot of one binary plans nothing.
    folder.done(&words(&stage("verify", "pilot", "")));
    folder.done(&words(&stage("measure", "pilot", "")));
    folder.done(&["stage", "analyze", "--out", "pilot", "--claims", "claims.toml"]);
    let message = folder.refused(&words(&stage("measure", "next", "--plan-from pilot")));
    assert!(message.contains("plans nothing") && message.contains("two binaries"), "{message}");
}

/// A record is of one executable: another one makes all of it again, and what is not made again is not told as its own.
#[test]
fn a_record_is_of_one_executable() {
    let folder = Folder::with_scene();
    let place = binaries(&folder, &[1, 2]);
    let run = |binary: u64, verb: &str| {
        let program = place.join(format!("bvbench-shuffled-{binary}"));
        let line = format!(
            "stage {verb} --profile smoke --scene scene --workload random --variant obb-vertex --variant aabb \
             --policy median/shared/8 --out run --quiet"
        );
        let output = Command::new(program).current_dir(folder.root()).args(words(&line)).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        if output.status.success() { Ok(()) } else { Err(said) }
    };
    let refused = |verb: &str| folder.refused(&["stage", verb, "--out", "run"]);
    run(1, "verify").unwrap();
    let message = refused("analyze");
    assert!(message.contains("not finished") && message.contains("bvbench stage measure"), "{message}");
    // Another executable does not go on with it.
    assert!(run(2, "measure").unwrap_err().contains("the program"));
    run(1, "measure").unwrap();
    fs::write(folder.path("claims.toml"), CLAIMS).unwrap();
    assert!(refused("report").contains("bvbench stage analyze"));
    folder.done(&["stage", "analyze", "--out", "run", "--claims", "claims.toml"]);
    // Nor does it make a part of it again.
    assert!(run(2, "measure").unwrap_err().contains("the program of an earlier stage"));
    assert!(folder.path("run/ratios.csv").exists());
    // What it verifies again has no times, neither those of the first nor what was derived from them.
    run(2, "verify").unwrap();
    assert!(!folder.path("run/ratios.csv").exists() && !folder.path("run/timings.csv").exists());
    for verb in ["analyze", "plot", "report"] {
        assert!(refused(verb).contains("bvbench stage measure"), "{verb}");
    }
    assert!(folder.refused(&["stage", "compare", "run", "run"]).contains("bvbench stage measure"));
    assert!(run(1, "measure").unwrap_err().contains("the program"));
    run(2, "measure").unwrap();
    folder.done(&["stage", "analyze", "--out", "run", "--claims", "claims.toml"]);
}

#[test]
fn what_is_no_binary_of_this_source_is_refused() {
    let folder = Folder::with_scene();
    let refused = |binary: &str| {
        let line = format!("stage measure --profile smoke --scene scene --binary {binary} --out run --quiet");
        folder.refused(&words(&line))
    };
    assert!(refused("gone").contains("cannot read"));
    fs::create_dir(folder.path("empty")).unwrap();
    assert!(refused("empty").contains("scripts/binaries"));
    assert!(refused("/bin/true").contains("is no bvbench"));
    let message = folder.refused(&["stage", "measure", "--launches", "0", "--out", "run", "--quiet"]);
    assert!(message.contains("--launches: from 1"), "{message}");
}

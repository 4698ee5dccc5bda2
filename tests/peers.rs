//! Engines side by side, from outside: our own variants as runners, and runners that fail.

#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use std::fs;
use std::path::Path;
use support::{BALL_AND_RING, Folder, words};

/// The rows of a CSV, each as (column, cell) pairs.
fn rows(path: &Path) -> Vec<Vec<(String, String)>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let cells =
        |row: csv::StringRecord| header.iter().zip(row.iter()).map(|(h, c)| (h.to_owned(), c.to_owned())).collect();
    reader.records().map(|row| cells(row.unwrap())).collect()
}

fn cell<'a>(row: &'a [(String, String)], column: &str) -> &'a str {
    &row.iter().find(|(name, _)| name == column).unwrap().1
}

#[test]
fn engines_are_compared_and_those_that_fail_are_named() {
    let folder = Folder::with_scene();
    folder.write("empty.sh", "echo ready; while read -r line; do echo done 5; done\n");
    folder.write("rude.sh", "echo ready; while read -r line; do echo what; done\n");
    let arguments = "peers run --scene scene --out out --poses 256 --rounds 2 --quiet --variant obb-area --variant aabb@median \
                     --runner dead=false --runner missing=no-such-program --against obb-area";
    let mut arguments = words(arguments);
    arguments.extend(["--runner", "empty=sh empty.sh", "--runner", "rude=sh rude.sh"]);
    // Right answers whose times are none: a chunk in 0 ns, a construction in 600 years, and poses that were never timed.
    let times = [("frozen", "chunk*", "0"), ("eternal", "build", "18446744073709551615")];
    for (name, command, number) in times {
        let answer = format!("case $line in {command}) echo done {number};; *) echo done 5;; esac");
        folder.write(&format!("{name}.sh"), &format!("echo ready; while read -r line; do {answer}; done\n"));
    }
    let own = format!("'{}' peers runner --variant obb-area \"$@\"\n", env!("CARGO_BIN_EXE_bvbench"));
    let zeros = "size=$(wc -c < \"$3/ns.npy\"); head -c 128 \"$3/ns.npy\" > head.npy; head -c $((size - 128)) /dev/zero | cat head.npy - > \"$3/ns.npy\"\n";
    folder.write("timeless.sh", &(own + zeros));
    arguments.extend(["--runner", "frozen=sh frozen.sh", "--runner", "eternal=sh eternal.sh"]);
    arguments.extend(["--runner", "timeless=sh timeless.sh"]);
    let (code, said, noted) = folder.told(&arguments);
    assert_eq!(code, Some(1), "{noted}");
    for (engine, reason) in [
        ("dead", "ended with exit status: 1"),
        ("missing", "no-such-program cannot be started"),
        ("empty", "verdicts.npy"),
        ("rude", "it said `what` to `build`"),
        ("frozen", "it said `done 0` to `chunk "),
        ("eternal", "it said `done 18446744073709551615` to `build`: a time is from 0 to 600000000000 ns"),
        ("timeless", "ns.npy holds 0 ns for pose "),
    ] {
        let line = noted.lines().find(|line| line.starts_with(&format!("SKIPPED: {engine} on scene ring:ball")));
        assert!(line.is_some_and(|line| line.contains(reason)), "{engine}: {noted}");
        assert!(!said.contains(engine));
    }
    let peers = rows(&folder.path("out/peers.csv"));
    let all: Vec<_> = peers.iter().filter(|row| cell(row, "stratum") == "all").collect();
    assert_eq!(all.iter().map(|row| cell(row, "engine")).collect::<Vec<_>>(), ["aabb@median", "obb-area"]);
    for row in all {
        assert_eq!((cell(row, "false_negatives"), cell(row, "mode"), cell(row, "largest_error")), ("0", "first", ""));
        assert!(cell(row, "poses").parse::<u64>().unwrap() >= 192, "{row:?}");
        for column in ["mean_ns", "median_ns", "p99_ns", "build_ns", "bytes"] {
            assert!(cell(row, column).parse::<f64>().unwrap() > 0.0, "{column} of {row:?}");
        }
    }
    let ratios = rows(&folder.path("out/peer-ratios.csv"));
    let own = ratios.iter().find(|row| cell(row, "engine") == "obb-area" && cell(row, "stratum") == "all").unwrap();
    // All chunks share lines: one cluster has no interval.
    assert_eq!(["ratio", "low", "high"].map(|column| cell(own, column)), ["1.0", "NaN", "NaN"]);

    // Our own program goes by its name: where it lies says nothing on another machine.
    let setting = fs::read_to_string(folder.path("out/peers-first.json")).unwrap();
    assert!(setting.contains("\"bvbench\"") && !setting.contains(env!("CARGO_BIN_EXE_bvbench")), "{setting}");

    // Another mode is added to what is there, even where no raw rows are, as in a clone of a published record.
    let first = |file: &str| {
        let rows = rows(&folder.path(&format!("out/{file}")));
        rows.into_iter().filter(|row| cell(row, "mode") == "first").collect::<Vec<_>>()
    };
    let derived = ["peers.csv", "peer-ratios.csv"];
    let before = derived.map(first);
    for file in ["peer-builds.csv", "peer-timings.csv", "peer-answers.csv"] {
        fs::remove_file(folder.path(&format!("out/{file}"))).unwrap();
    }
    let arguments = "peers run --scene scene --out out --poses 64 --rounds 1 --quiet --variant obb-area --variant aabb \
                     --mode distance --against aabb";
    let said = folder.done(&words("peers table --out out --against obb-area"));
    assert!(said.contains("scene, mode first, ") && said.contains("times faster than obb-area"), "{said}");
    let refused = folder.refused(&words("peers table --out out --against aabb"));
    assert!(refused.contains("--against aabb: out has no raw rows, and its ratios are those to obb-area"), "{refused}");
    folder.done(&words(arguments));
    assert_eq!(derived.map(first), before);
    folder.done(&words("peers table --out out --against obb-area"));
    assert_eq!(derived.map(first), before);
    let peers = rows(&folder.path("out/peers.csv"));
    let distance = peers.iter().find(|row| cell(row, "mode") == "distance" && cell(row, "stratum") == "all").unwrap();
    assert!(cell(distance, "largest_error").parse::<f64>().unwrap() < 1e-6, "{distance:?}");
}

#[test]
fn motions_are_answered_and_compared_with_the_truth() {
    let folder = Folder::with_scene();
    let asked = "--scene scene --out out --poses 24 --quiet --mode motion --variant obb-area";
    let said = folder.done(&words(&format!("peers verify {asked}")));
    assert!(said.contains("thin-walls, mode motion"), "{said}");
    folder.done(&words(&format!("peers run {asked} --rounds 1")));
    let answers = rows(&folder.path("out/peer-answers.csv"));
    let planted: Vec<_> = answers.iter().filter(|row| cell(row, "scene") == "thin-walls").collect();
    assert_eq!(planted.len(), 24);
    // Three of four go through a wall; only their contacts have a time.
    assert_eq!(planted.iter().filter(|row| cell(row, "exact") == "1").count(), 18);
    for row in planted {
        assert_eq!([cell(row, "value"), cell(row, "true_value")].map(str::is_empty), [cell(row, "exact") == "0"; 2]);
    }
    for row in rows(&folder.path("out/peers.csv")) {
        assert_eq!([cell(&row, "false_negatives"), cell(&row, "false_positives")], ["0", "0"], "{row:?}");
    }
}

#[test]
fn a_scene_is_exported_as_arrays() {
    let folder = Folder::with_scene();
    folder.done(&["peers", "export", "--scene", "scene", "--out", "out", "--poses", "64", "--mode", "all"]);
    for file in
        ["a_vertices", "a_faces", "b_vertices", "b_faces", "poses", "chunks", "exact", "grazing", "stratum", "truth"]
    {
        let bytes = fs::read(folder.path(&format!("out/scene/ring-ball/{file}.npy"))).unwrap();
        assert!(bytes.starts_with(b"\x93NUMPY\x01\x00") && bytes.len() > 128, "{file}");
    }
}

#[test]
fn pairs_that_would_share_a_folder_are_refused() {
    let folder = Folder::with_scene();
    let ball = BALL_AND_RING.lines().find(|line| line.contains("name = \"ball\"")).unwrap();
    let both = ["ba/ll", "ba-ll"].map(|name| ball.replacen("ball", name, 1)).join("\n");
    let pairs = BALL_AND_RING.replacen("[[\"ring\", \"ball\"]]", "[[\"ring\", \"ba/ll\"], [\"ring\", \"ba-ll\"]]", 1);
    folder.write("scene/scene.toml", &pairs.replacen(ball, &both, 1));
    let refused = folder.refused(&["peers", "export", "--scene", "scene", "--out", "out", "--poses", "64"]);
    assert!(refused.contains("two pairs of parts would have one folder"), "{refused}");
}

#[test]
fn bad_usage_is_refused() {
    let folder = Folder::with_scene();
    for (arguments, reason) in [
        ("peers run --scene scene --out out --variant nobody", "there is no variant `nobody`"),
        ("peers run --scene scene --out out --variant obb-area@nothing", "`nothing` is not a tree policy"),
        ("peers run --scene scene --out out --variant obb-area --variant obb-area", "two of the engines"),
        ("peers run --scene scene --out out --runner nameless", "is not NAME=COMMAND"),
        ("peers run --scene scene --out out --rounds 0", "at least one round"),
        ("peers run --scene scene --out out --mode path --poses 64", "no workload `program`"),
        ("peers run --scene scene --out out --mode fast", "is not a mode"),
        ("peers table --out nowhere --against obb-area", "peers.csv"),
    ] {
        let noted = folder.refused(&words(arguments));
        assert!(noted.contains(reason), "{arguments}: {noted}");
    }
}

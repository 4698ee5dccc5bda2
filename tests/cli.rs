//! The command line from outside: what it writes, what it refuses, and what is left of a run that was killed.

#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use bvbench::record::FolderLock;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;
use support::{BALL_AND_RING, Folder, words};

fn smoke<'a>(verb: &'a str, out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let mut arguments = if verb == "repro" { vec![verb] } else { vec!["stage", verb] };
    arguments.extend(["--profile", "smoke", "--scene", "scene", "--out", out, "--quiet"]);
    arguments.extend(more);
    arguments
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The distinct values of a column.
fn column(path: &Path, name: &str) -> BTreeSet<String> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let index = reader.headers().unwrap().iter().position(|header| header == name).unwrap();
    reader.records().map(|record| record.unwrap()[index].to_owned()).collect()
}

#[test]
fn repro_leaves_every_record_every_figure_and_a_report() {
    let folder = Folder::with_scene();
    let said = folder.done(&smoke("repro", "run", &[]));
    assert!(said.contains("No safe variant misses a contact above grazing."), "{said}");
    let run = folder.path("run");
    let listed: serde_json::Value = serde_json::from_str(&folder.done(&["list", "--json"])).unwrap();
    let listed = listed.as_array().unwrap();
    let standard = listed.iter().filter(|v| v["standard"] == true);
    let ids: BTreeSet<String> = standard.map(|v| v["id"].as_str().unwrap().to_owned()).collect();
    assert!(ids.len() >= 11 && ids.len() < listed.len());
    let measured = column(&run.join("cases.csv"), "variant");
    let ids: BTreeSet<String> = ids.into_iter().chain(["null-duplicate".to_owned()]).collect();
    assert_eq!(measured, ids, "every standard variant is measured, and no other");
    let tables =
        "cases poses answers lines misses trees tightness builds timings summary ratios claims verification outlines";
    for file in words(tables) {
        let rows = csv::Reader::from_path(run.join(format!("{file}.csv"))).unwrap().into_records().count();
        assert!(rows > 0, "{file}.csv is empty");
    }
    // Every table names cases and poses that the dictionaries of the run know, and no id reads as a missing value.
    let (cases, poses) = (column(&run.join("cases.csv"), "case"), column(&run.join("poses.csv"), "pose"));
    for file in ["timings.csv", "answers.csv", "misses.csv"] {
        assert!(column(&run.join(file), "case").is_subset(&cases), "{file}");
    }
    assert!(column(&run.join("timings.csv"), "case").iter().any(|case| case.starts_with("null-duplicate@")));
    assert!(column(&run.join("answers.csv"), "pose").is_subset(&poses));
    assert!(column(&run.join("timings.csv"), "chunk").is_subset(&column(&run.join("poses.csv"), "chunk")));
    let manifest: serde_json::Value = serde_json::from_str(&read(&run.join("manifest.json"))).unwrap();
    assert_eq!(manifest["request"]["profile"], "smoke");
    assert_eq!(manifest["cross_check"]["disagreements"], 0);
    let pictures: Vec<PathBuf> = fs::read_dir(run.join("plots")).unwrap().map(|entry| entry.unwrap().path()).collect();
    let ending = |end: &str| pictures.iter().filter(|path| path.extension().is_some_and(|e| e == end)).count();
    assert!(ending("svg") >= 8 && ending("svg") == ending("png"), "{pictures:?}");
    assert!(read(&run.join("report.md")).contains("plots/"));
    let page = read(&run.join("report.html"));
    assert!(page.contains("<!doctype html>") && page.contains("\"summary.csv\"") && page.len() < 8_000_000);
    // What a pipe gets is not coloured. The run ends with its answer, a ranking and the verdicts, and with what to look at next.
    let (from, to) = (said.find('?').unwrap(), said.find("Look next at").unwrap());
    let conclusion: Vec<&str> = said[from..to].lines().collect();
    assert!(conclusion.len() > 20 && conclusion.iter().all(|line| line.chars().count() <= 80), "{said}");
    for part in ["SAFE VARIANT", "SENTENCE", "hierarchy-pays"] {
        assert!(said[from..to].contains(part), "no {part}: {said}");
    }
    assert!(said[to..].contains("report.html"), "{said}");
    assert!(!said.contains('\x1b'), "{said}");
    let compare = |variable: &str, value: &str| {
        folder.command(&["stage", "compare", "run", "run", "--all"]).env(variable, value).output().unwrap()
    };
    let same = compare("NO_COLOR", "1");
    let text = String::from_utf8(same.stdout).unwrap();
    assert!(same.status.success() && text.contains("Contacts missed: the same") && !text.contains('\x1b'), "{text}");
    assert!(String::from_utf8(compare("CLICOLOR_FORCE", "1").stdout).unwrap().contains('\x1b'));
    assert!(folder.refused(&["stage", "compare", "run", "nowhere"]).contains("manifest.json"));
    let left = fs::read_dir(&run).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    assert!(left.filter(|name| name.ends_with(".partial")).count() == 0);
}

#[test]
fn deterministic_records_are_the_same_bytes_on_one_thread_and_two() {
    let folder = Folder::with_scene();
    let variants = ["--variant", "sphere-ritter", "--variant", "obb-area", "--variant", "obb-vertex-centroid"];
    for (out, threads) in [("one", "1"), ("two", "2")] {
        let mut more = variants.to_vec();
        let cache = format!("cache-{out}");
        more.extend(["--threads", threads, "--cache", &cache]);
        folder.done(&smoke("verify", out, &more));
        folder.done(&smoke("measure", out, &more));
    }
    for file in words("poses answers lines misses verification trees tightness outlines") {
        let file = format!("{file}.csv");
        assert_eq!(read(&folder.path("one").join(&file)), read(&folder.path("two").join(&file)), "{file}");
    }
    // And the comparison can fail: another seed gives other poses.
    let mut more = variants.to_vec();
    more.extend(["--seed", "7"]);
    folder.done(&smoke("verify", "other", &more));
    assert_ne!(read(&folder.path("one/verification.csv")), read(&folder.path("other/verification.csv")));
}

#[test]
fn a_killed_run_leaves_whole_files_and_goes_on() {
    let folder = Folder::with_scene();
    let more = ["--variant", "aabb", "--variant", "obb-area"];
    for wait_ms in [50, 150, 400, 800] {
        let mut child = folder.command(&smoke("measure", "killed", &more)).spawn().unwrap();
        sleep(Duration::from_millis(wait_ms));
        child.kill().unwrap();
        child.wait().unwrap();
        for entry in fs::read_dir(folder.path("killed")).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|end| end == "csv") {
                assert!(csv::Reader::from_path(&path).unwrap().into_records().all(|record| record.is_ok()), "{path:?}");
            }
        }
    }
    folder.done(&smoke("measure", "killed", &more));
    folder.done(&smoke("measure", "undisturbed", &more));
    for file in ["poses.csv", "answers.csv", "trees.csv", "tightness.csv"] {
        assert_eq!(read(&folder.path("killed").join(file)), read(&folder.path("undisturbed").join(file)), "{file}");
    }
}

#[test]
fn what_cannot_be_done_is_refused_with_its_cause() {
    let folder = Folder::with_scene();
    let missing = folder.refused(&["stage", "verify", "--scene", "no-such-scene", "--out", "x"]);
    assert!(missing.contains("no-such-scene") && missing.contains("lathe-toolpost"), "{missing}");
    let unknown = folder.refused(&["stage", "measure", "--variant", "dop-7", "--scene", "scene", "--out", "x"]);
    assert!(unknown.contains("dop-7") && unknown.contains("dop-8"), "{unknown}");
    assert!(folder.refused(&["repro", "--profile", "huge"]).contains("smoke"));
    assert!(folder.refused(&["stage", "measure", "--policy", "median/own/9"]).contains("median/own/9"));
    assert!(folder.refused(&["frobnicate"]).contains("frobnicate"));
    assert!(folder.refused(&["stage", "analyze", "--out", "nowhere"]).contains("manifest.json"));
    for of_a_scene in [smoke("verify", "x", &[]), vec!["try", "scene", "--out", "x"]] {
        let unknown = folder.refused(&[&of_a_scene[..], &["--workload", "dance"]].concat());
        assert!(unknown.contains("has no workload `dance`; it has "), "{unknown}");
        assert!(!folder.path("x").exists(), "a run was begun, which would refuse the corrected request");
    }

    folder.write("malformed/scene.toml", "title = \"x\"\nparts = [\n");
    let malformed = folder.refused(&["stage", "verify", "--scene", "malformed", "--out", "x"]);
    assert!(malformed.contains("scene.toml:"), "{malformed}");
    folder.write("typo/scene.toml", &BALL_AND_RING.replace("radius_mm = 20", "radus_mm = 20"));
    assert!(folder.refused(&["stage", "verify", "--scene", "typo", "--out", "x"]).contains("radus_mm"));
    folder.write("nan/scene.toml", &BALL_AND_RING.replace("radius_mm = 20", "radius_mm = nan"));
    assert!(folder.refused(&["stage", "verify", "--scene", "nan", "--out", "x"]).contains("scene.toml"));
    folder.write("part/scene.toml", &BALL_AND_RING.replace("[\"ring\", \"ball\"]", "[\"ring\", \"bell\"]"));
    assert!(folder.refused(&["stage", "verify", "--scene", "part", "--out", "x"]).contains("bell"));

    folder.write("blocked", "a file where the folder should be");
    assert!(folder.refused(&smoke("verify", "blocked/run", &[])).contains("blocked"));
    folder.write("mine/thesis.txt", "precious");
    assert!(folder.refused(&smoke("verify", "mine", &[])).contains("--out"));
    assert_eq!(read(&folder.path("mine/thesis.txt")), "precious");
}

#[test]
fn a_run_of_another_request_is_not_replaced_unasked() {
    let folder = Folder::with_scene();
    folder.done(&smoke("verify", "run", &["--variant", "aabb"]));
    let message = folder.refused(&smoke("verify", "run", &["--variant", "dop-8"]));
    assert!(message.contains("--fresh"), "{message}");
    folder.done(&smoke("verify", "run", &["--variant", "dop-8", "--fresh"]));
    assert!(folder.run(&smoke("verify", "run", &["--variant", "dop-8"])).status.success(), "the same again is welcome");
}

#[test]
fn an_audit_goes_on_with_the_cells_it_lacks() {
    let folder = Folder::with_scene();
    let audit = words("study audit --profile smoke --scene scene --orientation vertex --out audit --quiet");
    folder.done(&audit);
    let files = ["cases.csv", "factors.csv", "poses.csv", "counts.csv", "trees.csv", "exits.csv"];
    let read = || files.map(|file| fs::read(folder.path("audit").join(file)).unwrap());
    let whole = read();
    // One orientation, four centres, five splits, four leaf sizes.
    assert_eq!(fs::read_dir(folder.path("audit/units/counts/scene")).unwrap().count(), 80);
    let report = fs::read_to_string(folder.path("audit/audit.md")).unwrap();
    assert!(report.contains("| centre × split |") && report.contains("## What the centre leaves out"), "{report}");
    for figure in ["audit-factors", "audit-best-centre", "audit-containment", "audit-exit-axes"] {
        assert!(folder.path("audit/plots").join(figure).with_extension("png").exists(), "{figure}");
    }
    fs::remove_dir_all(folder.path("audit/units/counts/scene/vertex-mid-extent-sah16-2")).unwrap();
    files.iter().for_each(|file| fs::remove_file(folder.path("audit").join(file)).unwrap());
    folder.done(&audit);
    assert_eq!(read(), whole);
    let other = words("study audit --profile smoke --scene scene --orientation area --out audit");
    assert!(folder.refused(&other).contains("another request"));
    let unknown = folder.refused(&words("study audit --scene scene --orientation sideways --out none"));
    assert!(unknown.contains("no orientation `sideways`"), "{unknown}");
    let leaves = "--counts-only --quiet --leaf 1 --leaf 8 --out leaves";
    folder.done(&words(&format!("study audit --profile smoke --scene scene --orientation area {leaves}")));
    assert_eq!(column(&folder.path("leaves/trees.csv"), "leaf"), ["1", "8"].map(str::to_owned).into());
    let odd = folder.refused(&words("study audit --scene scene --leaf 3 --out none"));
    assert!(odd.contains("no leaves of 3 triangles; it has 1, 2, 4, 8"), "{odd}");
}

#[test]
fn a_sweep_is_the_same_every_time_and_tells_its_names() {
    let folder = Folder::with_scene();
    let run = |out: &str| {
        folder.done(&words(&format!("study sweep leaf --profile smoke --counts-only --out {out} --quiet")));
        ["cases.csv", "factors.csv", "counts.csv", "sweep_summary.csv", "plots/sweep.svg"]
            .map(|f| fs::read(folder.path(out).join("leaf").join(f)).unwrap())
    };
    assert_eq!(run("one"), run("two"));
    let names = folder.done(&["study", "sweep"]);
    for name in words("grading flips size offset rotation aspect step leaf") {
        assert!(names.contains(name), "{names}");
    }
    let unknown = folder.refused(&["study", "sweep", "colour"]);
    assert!(unknown.contains("no sweep `colour`"), "{unknown}");
}

#[test]
fn a_scene_of_ones_own_is_tried_without_the_paper() {
    let folder = Folder::with_scene();
    let command = ["try", "scene", "--profile", "smoke", "--variant", "aabb", "--variant", "obb-vertex", "--quiet"];
    let said = folder.done(&command);
    assert!(
        said.contains("a ball against a ring") && said.contains("plain OBB") && !said.contains("supported"),
        "{said}"
    );
    let run = folder.path("results/try-scene");
    for file in ["report.md", "report.html"] {
        let text = read(&run.join(file));
        assert!(text.contains("a ball against a ring"), "{file}");
        for of_the_paper in ["Xu and Zhang, Tongji", "replication", "Do the claims hold"] {
            assert!(!text.contains(of_the_paper), "{file} has `{of_the_paper}`");
        }
    }
    // The records stay, and the stages can be made again, by the claims that the run was judged by.
    let (report, judged_by) = (read(&run.join("report.md")), read(&run.join("claims.toml")));
    assert!(report.contains("stage analyze --claims FILE --out DIR"), "{report}");
    for stage in [&["analyze"][..], &["plot"], &["report", "--quiet"]] {
        folder.done(&[&["stage"][..], stage, &["--out", "results/try-scene"]].concat());
    }
    assert_eq!((read(&run.join("report.md")), read(&run.join("claims.toml"))), (report, judged_by));
    // A finished run is shown as it is, and made again where another program made it.
    let manifest = read(&run.join("manifest.json"));
    let made: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    let hash = made["program"]["hash"].as_str().unwrap();
    for text in [manifest.clone(), manifest.replace(hash, "another")] {
        let is_anothers = text != manifest;
        folder.write("results/try-scene/manifest.json", &text);
        folder.done(&command);
        let now: serde_json::Value = serde_json::from_str(&read(&run.join("manifest.json"))).unwrap();
        assert_eq!(now["program"]["hash"], made["program"]["hash"]);
        assert_eq!(now["rows"]["timings.csv"] != made["rows"]["timings.csv"], is_anothers);
    }
}

/// Variants that promise nothing have none to be compared with, which is said before anything is measured.
#[test]
fn a_trial_of_unsafe_variants_alone_is_refused_at_once() {
    let folder = Folder::with_scene();
    let message =
        folder.refused(&["try", "scene", "--profile", "smoke", "--variant", "obb-vertex-centroid", "--quiet"]);
    assert!(message.contains("none of the variants is safe"), "{message}");
    assert!(!folder.path("results/try-scene/units").exists(), "something was measured");
}

#[test]
fn meshes_and_poses_are_tried_as_a_scene() {
    let folder = Folder::with_scene();
    let tetrahedron = "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    folder.write("a piece.obj", tetrahedron);
    folder.write("tool.obj", tetrahedron);
    let rows: String = (0..60).map(|i| format!("a piece,1,0,0,0,{},-0.5,0\n", 0.2 * f64::from(i) - 12.0)).collect();
    folder.write("poses.csv", &format!("part,qw,qx,qy,qz,tx,ty,tz\n{rows}"));
    let quick =
        ["--profile", "smoke", "--workload", "recorded", "--variant", "obb-area", "--out", "run", "--quiet", "--json"];
    let result = folder.done(&[&["try", "a piece.obj", "tool.obj", "poses.csv"][..], &quick].concat());
    let result: serde_json::Value = serde_json::from_str(&result).unwrap();
    let case = &result["verification"]["cases"][0];
    // 60 poses under two policies; those nearer than 9 mm touch, less what the slant keeps apart.
    assert!(case["poses"] == 60 && case["colliding"].as_u64().unwrap() > 30 && case["missed"] == 0, "{case}");
    assert!(read(&folder.path("run/report.html")).contains("a piece against tool at the poses of poses"));
    // The manifest's command and the report's steps are such as a shell takes.
    #[cfg(unix)]
    {
        let manifest: serde_json::Value = serde_json::from_str(&read(&folder.path("run/manifest.json"))).unwrap();
        let script = format!("printf '%s\\n' {}", manifest["program"]["command"].as_str().unwrap());
        let words = std::process::Command::new("sh").args(["-c", &script]).output().unwrap().stdout;
        let words = String::from_utf8(words).unwrap();
        let words: Vec<&str> = words.lines().skip(1).collect();
        assert_eq!(words, [&["try", "a piece.obj", "tool.obj", "poses.csv"][..], &quick].concat());
    }
    // Neither the copies in the scene's folder, nor other poses, replace what the run was made of.
    let copies = ["a_piece.obj", "tool.obj", "poses.csv", "scene.toml"].map(|name| folder.path("run-scene").join(name));
    let before = copies.clone().map(|file| read(&file));
    folder.write("other.csv", "part,qw,qx,qy,qz,tx,ty,tz\ntool,1,0,0,0,0,0,0\n");
    for (files, told) in [
        (&["run-scene/a_piece.obj", "run-scene/tool.obj", "run-scene/poses.csv"], "no part named `a piece`"),
        (&["a piece.obj", "tool.obj", "other.csv"], "--fresh"),
    ] {
        let message = folder.refused(&[&["try"][..], &files[..], &quick].concat());
        assert!(message.contains(told), "{message}");
        assert_eq!(copies.clone().map(|file| read(&file)), before);
    }
    // Nor does what is refused with --fresh: a scene that is none, a variant that is none, a run at which another process works.
    folder.write("nobody.csv", "part,qw,qx,qy,qz,tx,ty,tz\nnobody,1,0,0,0,0,0,0\n");
    let manifest = read(&folder.path("run/manifest.json"));
    let held = FolderLock::take(&folder.path("run")).unwrap();
    for (poses, more, told) in [
        ("other.csv", &["--variant", "none"][..], "no variant `none`"),
        ("nobody.csv", &[], "no part named `nobody`; there are a piece, tool"),
        ("other.csv", &[], "is in use by another bvbench"),
    ] {
        let message =
            folder.refused(&[&["try", "a piece.obj", "tool.obj", poses, "--fresh"][..], more, &quick].concat());
        assert!(message.contains(told), "{message}");
        assert_eq!(copies.clone().map(|file| read(&file)), before, "{told}");
        assert_eq!(read(&folder.path("run/manifest.json")), manifest, "{told}");
    }
    drop(held);
    folder.write("a_piece.obj", tetrahedron);
    let twice = folder.refused(&["try", "a piece.obj", "a_piece.obj", "poses.csv", "--out", "twice"]);
    assert!(twice.contains("a_piece.obj, too"), "{twice}");
    // However few poses there are, all strata are timed: apart by more than 1 mm, and the last by less.
    let first: String = rows.split_inclusive('\n').take(12).collect();
    folder.write("few.csv", &format!("part,qw,qx,qy,qz,tx,ty,tz\n{first}"));
    let more = ["--profile", "smoke", "--variant", "aabb", "--variant", "obb-area", "--out", "few", "--quiet"];
    let said = folder.done(&[&["try", "a piece.obj", "tool.obj", "few.csv"][..], &more].concat());
    let said = words(&said).join(" ");
    let undecided = "Undecided (too few poses) on few-scene, by query time in `recorded`.";
    assert!(said.contains(undecided) && !said.contains(" of the 12 poses in"), "{said}");
    assert!(column(&folder.path("few/summary.csv"), "workload").contains("recorded"));
    assert!(
        said.contains("Nothing is shown where there was no contact to ask about: in `recorded` of few-scene."),
        "{said}"
    );
    // What is lacking or wrong is named.
    assert!(folder.refused(&["try", "tool.obj"]).contains("one pose file (.csv), and 0 of the paths are"));
    assert!(folder.refused(&["try", "scene", "scene"]).contains("`bvbench repro --scene A --scene B`"));
    assert!(folder.refused(&["try", "tool.obj", "poses.csv"]).contains("two meshes at least"));
    assert!(folder.refused(&["try", "tool.obj", "none.stl", "poses.csv"]).contains("none.stl"));
    // Links have the names by which they are given, not those of the file behind them.
    #[cfg(unix)]
    {
        for link in ["left.obj", "right.obj"] {
            std::os::unix::fs::symlink(folder.path("tool.obj"), folder.path(link)).unwrap();
        }
        let links = folder.refused(&["try", "left.obj", "right.obj", "nobody.csv", "--out", "links"]);
        assert!(links.contains("there are left, right") && !folder.path("links-scene").exists(), "{links}");
    }
    // A run that was killed while it copied goes on; its tables have headers whether they have rows or not.
    folder.write("begun-scene/tool.obj.partial", "v 0 0");
    folder.write("begun-scene/poses.csv", "part");
    let begun = ["try", "a piece.obj", "tool.obj", "poses.csv", "--profile", "smoke", "--workload", "recorded"];
    // A policy that is asked for twice counts once.
    let twice = ["--variant", "obb-area", "--policy", "median", "--policy", "median", "--out", "begun", "--quiet"];
    folder.done(&[&begun[..], &twice].concat());
    for table in ["claims.csv", "program_times.csv"] {
        assert!(read(&folder.path("begun").join(table)).starts_with(if table == "claims.csv" {
            "claim,"
        } else {
            "scene,"
        }));
    }
    folder.write("other-scene/notes.txt", "somebody's own");
    let other = folder.refused(&["try", "a piece.obj", "tool.obj", "poses.csv", "--out", "other"]);
    assert!(other.contains("other-scene") && folder.path("other-scene/notes.txt").exists(), "{other}");
}

#[cfg(unix)]
#[test]
fn arguments_that_are_no_text_are_taken() {
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::with_scene();
    let out = std::ffi::OsStr::from_bytes(b"out\xff");
    let words = ["stage", "verify", "--profile", "smoke", "--scene", "scene", "--variant", "aabb", "--quiet", "--out"];
    let output = folder.command(&words).arg(out).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.path("").join(out).join("manifest.json").exists());
}

#[test]
fn the_old_spelling_of_a_verb_answers_with_the_new_one() {
    let folder = Folder::with_scene();
    folder.write("p.ngc", "G0 X1\nM2\n");
    let output = folder.run(&["gcode", "p.ngc"]);
    let noted = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && noted.contains("`bvbench gcode` is now `bvbench program gcode`"), "{noted}");
    assert_eq!(output.stdout, folder.run(&["program", "gcode", "p.ngc"]).stdout);
}

/// The record of a run says what the program was built from; the harness learns it from the program.
#[test]
fn the_program_knows_what_it_was_built_from() {
    let told = Folder::with_scene().done(&["identity"]);
    let told: serde_json::Value = serde_json::from_str(&told).unwrap();
    for (fact, part) in [("source", ""), ("rustc", "rustc "), ("flags", "opt-level "), ("version", ".")] {
        let text = told[fact].as_str().unwrap();
        assert!(!text.is_empty() && text.contains(part), "{fact}: {told}");
    }
    assert!(!told["flags"].as_str().unwrap().contains("target ,"), "{told}");
}

#[test]
fn shells_and_manual_readers_get_every_verb() {
    let folder = Folder::with_scene();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.done(&["completions", shell]);
        assert!(script.contains("compare") && script.contains("clearance"), "{shell}: {script}");
    }
    assert!(folder.refused(&["completions", "dash"]).contains("dash"));
    folder.done(&["man", "--out", "man"]);
    let page = read(&folder.path("man/bvbench-check.1"));
    assert!(page.contains("bvbench") && page.contains("tolerance") && page.contains("Examples"), "{page}");
    let pages: BTreeSet<String> = fs::read_dir(folder.path("man"))
        .unwrap()
        .map(|page| page.unwrap().file_name().into_string().unwrap())
        .collect();
    assert!(pages.contains("bvbench.1") && pages.contains("bvbench-scene-pairs.1"), "{pages:?}");
    assert!(!pages.iter().any(|page| page.contains("launch")), "hidden verbs have no page: {pages:?}");
    folder.write("blocked", "a file where the folder should be");
    assert!(folder.refused(&["man", "--out", "blocked/man"]).contains("blocked"));
}

#[test]
#[cfg(target_os = "linux")]
fn output_that_cannot_be_written_is_an_error_and_a_reader_that_left_is_none() {
    let folder = Folder::with_scene();
    folder.write("p.ngc", "G21 G0 X1\nM2\n");
    for arguments in [
        &["list"][..],
        &["list", "--json"],
        &["program", "gcode", "p.ngc", "--json"],
        &["scene", "info", "scene"],
        &["check", "scene", "p.ngc", "--quiet", "--json"],
        &["completions", "bash"],
        &["--help"],
    ] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = folder.command(arguments).stdout(full).output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains("standard output: No space left on device"), "{arguments:?}: {message}");
        let mut left = folder.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(left.stdout.take());
        let output = left.wait_with_output().unwrap();
        assert!(output.status.success() && output.stderr.is_empty(), "{arguments:?}: {output:?}");
    }
}

#[test]
fn more_threads_than_any_machine_can_use_are_refused() {
    let folder = Folder::with_scene();
    let most = (4 * std::thread::available_parallelism().map_or(1, usize::from)).max(256);
    let too_many = (most + 1).to_string();
    for verb in [
        &["check", "scene"][..],
        &["view", "scene"],
        &["stage", "verify", "--scene", "scene"],
        &["study", "sweep", "leaf"],
        &["study", "audit", "--scene", "scene"],
        &["peers", "run", "--scene", "scene", "--out", "x"],
    ] {
        let message = folder.refused(&[verb, &["--threads", &too_many]].concat());
        assert!(message.contains(&format!("--threads {too_many}: at most {most}")), "{verb:?}: {message}");
    }
    assert!(folder.refused(&["check", "scene", "--threads", "0"]).contains("at least one"));
}

#[test]
fn a_run_killed_before_its_manifest_was_whole_is_taken_up() {
    let folder = Folder::with_scene();
    folder.write("run/manifest.json.partial", "{ \"schema\": 1, \"requ");
    folder.done(&smoke("verify", "run", &["--variant", "aabb"]));
    assert!(!folder.path("run/manifest.json.partial").exists());
}

#[test]
fn a_folder_in_use_is_refused() {
    let folder = Folder::with_scene();
    let file = folder.write("run/.lock", "4711\n");
    let held = fs::File::options().write(true).open(file).unwrap();
    held.lock().unwrap();
    let message = folder.refused(&smoke("verify", "run", &["--variant", "aabb"]));
    assert!(message.contains("run is in use") && (cfg!(windows) || message.contains("process 4711")), "{message}");
}

#[test]
fn a_manifest_of_another_schema_is_refused_with_both_versions() {
    let folder = Folder::with_scene();
    for (text, found) in [("{\"schema\": 99}", "schema 99"), ("{}", "schema none")] {
        folder.write("run/manifest.json", text);
        for verb in ["analyze", "plot", "report"] {
            let message = folder.refused(&["stage", verb, "--out", "run"]);
            assert!(message.contains(found) && message.contains("reads schema 2"), "{verb}: {message}");
        }
    }
}

#[test]
fn control_characters_of_a_name_do_not_reach_the_terminal() {
    let message = Folder::with_scene().refused(&["stage", "verify", "--scene", "no\x1b]0;owned\x07", "--out", "x"]);
    assert!(!message.contains('\x1b') && message.contains("u{1b}"), "{message}");
}

/// Replaces a file of a run by what `edit` makes of it while `asked` is called, and puts it back.
fn edited(folder: &Folder, file: &str, edit: impl Fn(&str) -> String, asked: impl Fn()) {
    let path = folder.path(file);
    let good = fs::read_to_string(&path).unwrap();
    fs::write(&path, edit(&good)).unwrap();
    asked();
    fs::write(&path, good).unwrap();
}

#[test]
fn rows_that_changed_since_they_were_measured_are_refused() {
    let folder = Folder::with_scene();
    let title = "title = \"<script>alert(1)</script>\"";
    folder.write("scene/scene.toml", &BALL_AND_RING.replace("title = \"a ball against a ring\"", title));
    for verb in ["verify", "measure"] {
        folder.done(&smoke(verb, "run", &["--variant", "obb-area", "--variant", "aabb"]));
    }
    let analyze = || folder.done(&["stage", "analyze", "--out", "run"]);
    analyze();
    // A lost row, in the timings and in the verification.
    for file in ["timings.csv", "verification.csv"] {
        let lost = |good: &str| good.lines().take(good.lines().count() - 1).map(|line| format!("{line}\n")).collect();
        edited(&folder, &format!("run/{file}"), lost, || {
            for verb in ["analyze", "plot", "report"] {
                let message = folder.refused(&["stage", verb, "--out", "run"]);
                assert!(message.contains(file) && message.contains("--accept-changed-rows"), "{verb}: {message}");
            }
            assert!(folder.refused(&["stage", "compare", "run", "run"]).contains(file));
        });
    }
    // A time of zero is none, whoever accepts it; the message names file and line.
    let zero = |good: &str| {
        let (head, last) = good.trim_end().rsplit_once('\n').unwrap();
        let (cells, _) = last.rsplit_once(',').unwrap();
        format!("{head}\n{cells},0\n")
    };
    edited(&folder, "run/timings.csv", zero, || {
        let message = folder.refused(&["stage", "analyze", "--out", "run", "--accept-changed-rows"]);
        assert!(message.contains("timings.csv:") && message.contains("must be above 0"), "{message}");
    });
    analyze();
    folder.done(&["stage", "report", "--out", "run", "--quiet"]);
    let report = fs::read_to_string(folder.path("run/report.md")).unwrap();
    assert!(!report.contains("<script>") && report.contains("&lt;script"), "the title is markup in report.md");
    let page = fs::read_to_string(folder.path("run/report.html")).unwrap();
    assert!(!page.contains("<script>alert(1)"), "the title is a script in report.html");
}

#[test]
fn names_that_are_formulas_or_have_control_characters_are_refused() {
    for name in ["=1+1", "@x", "-y", "", "a\\u001Bb"] {
        let folder = Folder::with_scene();
        let scene = BALL_AND_RING.replace("name = \"ring\"", &format!("name = \"{name}\""));
        folder.write("scene/scene.toml", &scene);
        let message = folder.refused(&["scene", "info", "scene"]);
        assert!(message.contains("scene.toml:") && message.contains("the name `"), "{name}: {message}");
    }
}

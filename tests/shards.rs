//! A plan in seven shards, merged, has the deterministic tables of the run that was never parted; what does not belong together is refused.

#![expect(clippy::unwrap_used, reason = "a test may fail by panicking")]

mod support;

use std::fs;
use std::path::Path;
use support::Folder;

/// Verdicts, counts and one launch of two variants on a scene of seconds.
const PLAN: [&str; 9] =
    ["--profile", "smoke", "--scene", "scene", "--variant", "obb-vertex", "--variant", "obb-area", "--quiet"];

const DETERMINISTIC: [&str; 9] =
    ["cases", "poses", "answers", "lines", "misses", "verification", "trees", "tightness", "exits"];

fn run(folder: &Folder, verbs: &[&str], more: &[&str]) {
    folder.done(&[verbs, &PLAN, more].concat());
}

fn shard(folder: &Folder, number: u32, of: u32, out: &str) {
    run(folder, &["repro"], &["--shard", &format!("{number}/{of}"), "--out", out]);
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}

#[test]
fn seven_merged_shards_are_the_run_byte_for_byte() {
    let folder = Folder::with_scene();
    run(&folder, &["stage", "verify"], &["--out", "whole"]);
    run(&folder, &["stage", "measure"], &["--out", "whole"]);
    let names: Vec<String> = (1..=7).map(|number| format!("shard-{number}")).collect();
    for (number, name) in (1..).zip(&names) {
        shard(&folder, number, 7, name);
    }
    let launches = |name: &String| folder.path(name).join("units/measure/launch-0").exists();
    assert_eq!(names.iter().filter(|name| launches(name)).count(), 1, "a launch is whole");
    let cases =
        |name: &String| fs::read_dir(folder.path(name).join("units/verify/scenes/scene")).map_or(0, Iterator::count);
    assert!(names.iter().all(|name| cases(name) < 3) && names.iter().map(cases).sum::<usize>() == 5);

    let refused = |shards: &[&str]| folder.refused(&[&["stage", "merge"], shards, &["--out", "refused"]].concat());
    let all: Vec<&str> = names.iter().map(String::as_str).collect();
    assert!(refused(&all[1..6]).contains("these are lacking: 1, 7"));
    assert!(refused(&[&all[..], &all[2..3]].concat()).contains("is named twice"), "one folder named twice");
    copy(&folder.path("shard-3"), &folder.path("copy-of-3"));
    assert!(refused(&[&all[..], &["copy-of-3"]].concat()).contains("both hold shard 3"));
    assert!(refused(&["whole"]).contains("holds no shard"));
    run(&folder, &["repro"], &["--shard", "2/7", "--seed", "5", "--out", "other-seed"]);
    let foreign = refused(&[&all[..1], &["other-seed"], &all[2..]].concat());
    assert!(foreign.contains("another plan") && foreign.contains("the request differs"), "{foreign}");

    // A shard of another version, one that was changed, and one that is not whole.
    let manifest = folder.path("copy-of-3/manifest.json");
    let text = fs::read_to_string(&manifest).unwrap();
    let with_copy = [&all[..2], &["copy-of-3"], &all[3..]].concat();
    let with = |changed: String| {
        fs::write(&manifest, changed).unwrap();
        refused(&with_copy)
    };
    let protocol = text.replacen("\"protocol\": \"", "\"protocol\": \"9", 1);
    assert!(with(protocol).contains("protocol 9"));
    let edited = with(text.replace("\"seed\": 2011", "\"seed\": 2012"));
    assert!(edited.contains("the manifest of copy-of-3 was changed"), "{edited}");
    assert!(with(text.replace("\"measure\"", "\"plot\"")).contains("unfinished"));
    // Units without their hashes: all of them, or one.
    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let rows = value["rows"].as_object().unwrap().clone();
    for left in [0, rows.len() - 1] {
        value["rows"] = rows.clone().into_iter().take(left).collect::<serde_json::Map<_, _>>().into();
        let refused = with(value.to_string());
        assert!(refused.contains("copy-of-3 is unfinished"), "{left}: {refused}");
    }
    fs::write(&manifest, &text).unwrap();
    let unit = folder.path("copy-of-3/units/verify/scenes/scene");
    let file = fs::read_dir(unit).unwrap().next().unwrap().unwrap().path().join("verification.csv");
    fs::write(&file, "changed").unwrap();
    assert!(refused(&with_copy).contains("verification.csv"));

    // In any order.
    let mut shuffled = all.clone();
    shuffled.reverse();
    folder.done(&[&["stage", "merge"], &shuffled[..], &["--out", "merged"]].concat());
    for name in DETERMINISTIC {
        let read = |run: &str| fs::read_to_string(folder.path(run).join(format!("{name}.csv"))).unwrap();
        assert_eq!(read("merged"), read("whole"), "{name}");
    }
    let read = |run: &str| -> serde_json::Value {
        serde_json::from_str(&fs::read_to_string(folder.path(run).join("manifest.json")).unwrap()).unwrap()
    };
    let (merged, whole) = (read("merged"), read("whole"));
    for key in ["request", "inputs", "cross_check", "finished", "null_of"] {
        assert_eq!(merged[key], whole[key], "{key}");
    }
    assert!(merged.get("shard").is_none() && folder.path("merged/timings.csv").exists());
    folder.done(&["stage", "analyze", "--out", "merged"]);
}

#[test]
fn a_finished_shard_is_not_made_again_and_its_folder_is_its_own() {
    let folder = Folder::with_scene();
    shard(&folder, 1, 2, "shard");
    let unit = folder.path("shard/units/measure/launch-0/scene/timings.csv");
    let made = fs::metadata(&unit).unwrap().modified().unwrap();
    shard(&folder, 1, 2, "shard");
    assert_eq!(fs::metadata(&unit).unwrap().modified().unwrap(), made);
    let refused = |more: &[&str]| folder.refused(&[&["repro"], &PLAN[..], more, &["--out", "shard"]].concat());
    assert!(refused(&["--shard", "2/2"]).contains("the shard"));
    assert!(refused(&[]).contains("the shard"));
    assert!(refused(&["--shard", "3/2"]).contains("is no shard"));
}

/// A study in four shards and whole; `place` is its folder within the one that is named.
fn study_in_shards(folder: &Folder, plan: &[&str], place: &str, tables: &[&str]) {
    let study = |more: &[&str]| folder.done(&[&["study"], plan, &["--quiet"], more].concat());
    let name = plan[0];
    let [whole, merged] = ["whole", "merged"].map(|kind| format!("{name}-{kind}"));
    study(&["--out", &whole]);
    let shards: Vec<String> = (1..=4).map(|number| format!("{name}-{number}")).collect();
    for (number, shard) in (1..).zip(&shards) {
        study(&["--shard", &format!("{number}/4"), "--out", shard]);
        assert!(!folder.path(shard).join(place).join("counts.csv").exists(), "a shard joins nothing");
    }
    let shards: Vec<String> = shards.iter().map(|shard| format!("{shard}/{place}")).collect();
    let shards: Vec<&str> = shards.iter().map(String::as_str).collect();
    let out = format!("{merged}/{place}");
    let refused = folder.refused(&[&["stage", "merge"], &shards[1..], &["--out", &out]].concat());
    assert!(refused.contains("these are lacking: 1"), "{refused}");
    folder.done(&[&["stage", "merge"], &shards[..], &["--out", &out]].concat());
    study(&["--out", &merged]);
    for table in tables {
        let read = |of: &str| fs::read_to_string(folder.path(of).join(place).join(format!("{table}.csv"))).unwrap();
        assert_eq!(read(&merged), read(&whole), "{name}: {table}");
    }
    // Times are whole too: in a shard each, and in what is merged as many as there were.
    let inside = |path: &Path| fs::read_dir(path).into_iter().flatten().map(|entry| entry.unwrap().path());
    let times =
        |of: &str| inside(&folder.path(of).join("units/times")).map(|scene| inside(&scene).count()).sum::<usize>();
    let of_shards: usize = shards.iter().map(|shard| times(shard)).sum();
    assert_eq!((of_shards, times(&out)), (times(&format!("{whole}/{place}")), of_shards));
    // Half a shard is refused.
    let manifest = folder.path(shards[3]).join("manifest.json");
    let mut value: serde_json::Value = serde_json::from_str(&fs::read_to_string(&manifest).unwrap()).unwrap();
    value["rows"] = serde_json::json!({});
    fs::write(&manifest, value.to_string()).unwrap();
    let refused = folder.refused(&[&["stage", "merge"], &shards[..], &["--out", "half"]].concat());
    assert!(refused.contains("unfinished"), "{refused}");
}

#[test]
fn merged_shards_of_a_study_are_the_study_byte_for_byte() {
    let folder = Folder::with_scene();
    let audit = ["audit", "--profile", "smoke", "--scene", "scene", "--orientation", "vertex", "--leaf", "1"];
    study_in_shards(&folder, &audit, "", &["cases", "factors", "poses", "counts", "exits", "trees"]);
    let sweep = ["sweep", "leaf", "--profile", "smoke", "--variant", "obb-area", "--counts-only"];
    study_in_shards(&folder, &sweep, "leaf", &["cases", "factors", "counts"]);
}

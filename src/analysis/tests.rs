//! The whole analysis on a made-up run with planted effects.

use super::judge::{Verdict, ratio_verdict};
use super::stats::Interval;
use super::*;
use crate::record::ExitRow;
use crate::record::Stratum;
use crate::record::synthetic::{Plan, Run, SCENES};
use tempfile::TempDir;

fn analyse(run: &Run) -> (TempDir, Outcome) {
    let folder = TempDir::new().unwrap();
    run.write(folder.path());
    let outcome = analyze(folder.path(), &ClaimSet::standard()).unwrap();
    (folder, outcome)
}

fn ratio<'a>(outcome: &'a Outcome, metric: &str, variant: &str, policy: &str, baseline: &str) -> &'a RatioRow {
    let matches = |r: &&RatioRow| {
        (r.scene.as_str(), r.metric.as_str(), r.variant.as_str()) == (SCENES[0], metric, variant)
            && r.policy == policy
            && r.baseline == baseline
            && (r.stratum == ALL || r.stratum == "-")
    };
    outcome.ratios.iter().find(matches).unwrap_or_else(|| panic!("{metric} {variant} {policy} / {baseline}"))
}

fn verdicts<'a>(outcome: &'a Outcome, claim: &str, reading: &str) -> Vec<&'a str> {
    let of_it = outcome.claims.iter().filter(|row| row.claim == claim && row.reading == reading);
    of_it.map(|row| row.verdict.as_str()).collect()
}

#[test]
fn planted_effects_are_found() {
    let (_folder, outcome) = analyse(&Run::generate(&Plan::default()));
    let time = ratio(&outcome, "time", "obb-area", "area-mean/own/1", "obb-vertex");
    assert!((time.ratio - 0.8).abs() < 0.005 && time.low < 0.8 && time.high > 0.8, "{time:?}");
    assert!(time.high - time.low < 0.02, "{time:?}");
    let counts = ratio(&outcome, "volume-tests", "aabb", "vertex-mean/own/1", "obb-vertex");
    assert!((counts.ratio - 1.6).abs() < 0.05, "{counts:?}");
    let build = ratio(&outcome, "build", "aabb", "vertex-mean/own/1", "obb-vertex");
    assert!((build.ratio - 0.3).abs() < 0.01, "{build:?}");
    // Two scenes, `all` and four strata each.
    assert_eq!(verdicts(&outcome, "faster", "R1"), ["reproduces"; 10]);
    assert_eq!(verdicts(&outcome, "considerably-faster", "R1"), ["inconclusive"; 10]);
    assert_eq!(verdicts(&outcome, "faster", "R3"), ["equivalent"; 10]);
    assert_eq!(verdicts(&outcome, "contacts-missed", "R1"), ["reversed"; 2]);
    assert_eq!(verdicts(&outcome, "contacts-missed", "R2"), ["reproduces"; 2]);
    assert_eq!(verdicts(&outcome, "repairs-misses", "R2"), ["reversed"; 2]);
    assert_eq!(verdicts(&outcome, "drift", "R2"), ["reproduces"; 2]);
    assert_eq!(verdicts(&outcome, "drift", "R1"), ["equivalent"; 2]);
    assert_eq!(verdicts(&outcome, "overhang", "R2"), ["reproduces"; 2]);
    assert_eq!(verdicts(&outcome, "equal-gap", "R2"), ["reproduces"; 2]);
    assert_eq!(verdicts(&outcome, "equal-gap", "R1"), ["reversed"; 2]);
    assert_eq!(verdicts(&outcome, "unbalanced-tree", "R1"), ["reproduces"; 2]);
    assert_eq!(verdicts(&outcome, "looser-box", "R1"), ["reproduces"; 2]);
    assert_eq!(verdicts(&outcome, "obb-costly-to-build", "obb-aabb"), ["reproduces"; 2]);
    assert_eq!(verdicts(&outcome, "hierarchy-pays", "obb-brute"), ["reproduces"; 10]);
    assert_eq!(verdicts(&outcome, "real-time-on-controller", "-"), ["not-judged"]);
    assert!(outcome.noise.is_empty(), "{:?}", outcome.noise);
}

/// Three tests end with the first axis and one with none, of 26 and 189 operations: (3·26 + 189)/4 = 66.75. Of the aligned box's
/// ten tests two end with a product of edges.
#[test]
fn ends_of_tests_are_judged_by_their_means() {
    let folder = TempDir::new().unwrap();
    Run::generate(&Plan::default()).write(folder.path());
    let row = |variant: &str, split: &str, axis, tests, operations| ExitRow {
        scene: SCENES[0].to_owned(),
        stratum: Stratum::Far,
        variant: variant.to_owned(),
        split: split.to_owned(),
        axes: "own".to_owned(),
        leaf: 1,
        axis,
        tests,
        operations,
    };
    let rows = [
        row("obb-area", "area-mean", 1, 3, 26),
        row("obb-area", "area-mean", 0, 1, 189),
        row("aabb", "vertex-mean", 0, 6, 189),
        row("aabb", "vertex-mean", 6, 2, 81),
        row("aabb", "vertex-mean", 7, 2, 93),
    ];
    record::write_rows(folder.path(), &rows).unwrap();
    let outcome = analyze(folder.path(), &ClaimSet::standard()).unwrap();
    let found = |claim: &str| outcome.claims.iter().find(|row| row.claim == claim && row.scene == SCENES[0]).unwrap();
    let operations = found("few-operations");
    assert_eq!((operations.verdict.as_str(), operations.value), ("reproduces", Some(66.75)));
    let edges = found("edges-rarely-decide");
    assert_eq!((edges.verdict.as_str(), edges.value), ("reversed", Some(0.2)));
    assert!(edges.note.contains("50.0 % of the tests that some axis ends"), "{}", edges.note);
}

#[test]
fn unsafe_variants_are_noted_and_never_ranked() {
    let (_folder, outcome) = analyse(&Run::generate(&Plan::default()));
    let speed = outcome.claims.iter().find(|row| row.claim == "faster" && row.reading == "R2").unwrap();
    assert!(speed.note.contains("obb-area-centroid is unsafe"), "{}", speed.note);
    assert!(speed.missed.unwrap() > 0 && speed.baseline_missed.unwrap() > speed.missed.unwrap());
    let ranking: Vec<&str> = outcome.ranking.iter().map(|place| place.variant.as_str()).collect();
    assert_eq!(ranking[..2], ["obb-area", "obb-vertex"]);
    assert_eq!(ranking[ranking.len() - 2..], ["parry-trimesh", "brute"]);
    assert!(!ranking.iter().any(|id| id.contains("centroid") || *id == NULL_VARIANT));
    assert!(ranking.contains(&"ellipsoid"));
}

#[test]
fn who_promises_to_be_safe_and_misses_is_not_ranked() {
    let mut run = Run::generate(&Plan::default());
    let row = run.verification.iter_mut().find(|row| row.variant == "obb-area" && row.band.is_above_grazing()).unwrap();
    row.missed += 1;
    let (_folder, outcome) = analyse(&run);
    assert!(!outcome.ranking.iter().any(|place| place.variant == "obb-area"));
    assert!(outcome.ranking.iter().any(|place| place.variant == "obb-vertex"));
}

#[test]
fn the_order_of_rows_does_not_matter() {
    let mut run = Run::generate(&Plan::default());
    let (straight, _) = analyse(&run);
    run.timings.reverse();
    run.queries.sort_by_key(|row| (row.pose.wrapping_mul(2_654_435_761), row.variant.clone()));
    run.builds.reverse();
    let (shuffled, _) = analyse(&run);
    for file in ["summary.csv", "ratios.csv", "claims.csv"] {
        let read = |folder: &TempDir| std::fs::read(folder.path().join(file)).unwrap();
        assert!(read(&straight) == read(&shuffled), "{file} depends on the order of rows");
    }
}

/// The chunks differ by far more than the variants. Were a chunk of one variant compared with another chunk of the other,
/// the planted ratio would drown: shifting the chunk numbers of one variant shows it.
#[test]
fn pairing_is_what_makes_the_interval_narrow() {
    let mut run = Run::generate(&Plan::default());
    let chunks = Plan::default().chunks;
    for row in run.timings.iter_mut().filter(|row| row.variant == "obb-area") {
        row.chunk = row.chunk / chunks * chunks + (row.chunk + 1) % chunks;
    }
    let (_folder, outcome) = analyse(&run);
    let time = ratio(&outcome, "time", "obb-area", "area-mean/own/1", "obb-vertex");
    assert!(time.high / time.low > 1.2, "{time:?}");
    assert_ne!(verdicts(&outcome, "faster", "R1"), ["reproduces"; 10]);
}

#[test]
fn a_loud_null_flags_the_run() {
    let mut run = Run::generate(&Plan::default());
    run.timings.iter_mut().filter(|row| row.variant == NULL_VARIANT).for_each(|row| row.ns += row.ns / 25);
    let (_folder, outcome) = analyse(&run);
    assert_eq!(outcome.noise.len(), SCENES.len(), "{:?}", outcome.noise);
    let speed = outcome.claims.iter().find(|row| row.claim == "faster").unwrap();
    assert!(speed.note.contains("noisy run"), "{}", speed.note);
}

#[test]
fn contradictory_records_are_refused() {
    let refusal = |spoil: &dyn Fn(&mut Run)| {
        let mut run = Run::generate(&Plan::default());
        spoil(&mut run);
        let folder = TempDir::new().unwrap();
        run.write(folder.path());
        analyze(folder.path(), &ClaimSet::standard()).unwrap_err().to_string()
    };
    assert!(refusal(&|run| run.timings.push(run.timings[0].clone())).contains("twice"));
    assert!(refusal(&|run| run.timings[0].poses += 1).contains("chunk 0"));
    assert!(refusal(&|run| run.timings[0].poses = 0).contains("timings.csv:2: ns, passes and poses must be above 0"));
    assert!(refusal(&|run| run.builds[0].ns = 0).contains("builds.csv:2: ns must be above 0"));
    assert!(refusal(&|run| run.manifest.variants[0].policies = vec!["best".into()]).contains("SPLIT/AXES/LEAF"));
    let empty = TempDir::new().unwrap();
    assert!(analyze(empty.path(), &ClaimSet::standard()).unwrap_err().to_string().contains("manifest.json"));
}

#[test]
fn few_clusters_decide_nothing() {
    let (_folder, outcome) = analyse(&Run::generate(&Plan { chunks: 2, ..Plan::default() }));
    let row = outcome.claims.iter().find(|row| row.claim == "faster" && row.stratum == "far").unwrap();
    assert_eq!(row.verdict, "inconclusive");
    assert!(row.note.contains("only 2 clusters"), "{}", row.note);
}

#[test]
fn verdicts_at_their_thresholds() {
    let verdict = |low, high| ratio_verdict(Interval { value: f64::midpoint(low, high), low, high }, 0.95).0;
    assert_eq!(verdict(0.90, 0.949), Verdict::Reproduces);
    assert_eq!(verdict(0.90, 0.95), Verdict::Inconclusive);
    assert_eq!(verdict(0.95, 1.05), Verdict::Equivalent);
    assert_eq!(verdict(1.04, 1.06), Verdict::Inconclusive);
    assert_eq!(verdict(1.051, 1.06), Verdict::Reversed);
    let short = ratio_verdict(Interval { value: 0.85, low: 0.8, high: 0.9 }, 0.75);
    assert!(short.0 == Verdict::Inconclusive && short.1.is_some());
}

/// A publication run's size: the analysis of 1.2 million timings takes about two seconds, most of it reading.
#[test]
#[ignore = "takes several seconds; run it after a change of the tables or the bootstrap"]
fn a_million_timings_are_analysed() {
    let run = Run::generate(&Plan { launches: 5, blocks: 20, chunks: 100, ..Plan::default() });
    assert!(run.timings.len() > 1_000_000, "{}", run.timings.len());
    let folder = TempDir::new().unwrap();
    run.write(folder.path());
    drop(run);
    let outcome = analyze(folder.path(), &ClaimSet::standard()).unwrap();
    assert_eq!(verdicts(&outcome, "faster", "R1"), ["reproduces"; 10]);
}

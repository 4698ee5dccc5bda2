//! Two made-up runs, the second with planted changes.

use super::*;
use crate::analysis::analyze;
use crate::analysis::claims::ClaimSet;
use crate::analysis::table::{Chunk, Sample};
use crate::analysis::tests::normal;
use crate::record::synthetic::{PLANTED, Plan, Run, SCENES};
use crate::record::{MissRow, PoseRow, Stratum};
use tempfile::TempDir;

fn folder_of(run: &Run) -> TempDir {
    let folder = TempDir::new().unwrap();
    run.write(folder.path());
    analyze(folder.path(), &ClaimSet::standard()).unwrap();
    folder
}

/// Makes a second run on the same poses, with noise of its own.
fn again(change: &dyn Fn(&mut Run)) -> TempDir {
    let mut run = Run::generate(&Plan { seed: 2, ..Plan::default() });
    run.manifest.request.seed = Plan::default().seed;
    change(&mut run);
    folder_of(&run)
}

fn compared(change: &dyn Fn(&mut Run)) -> Comparison {
    let before = folder_of(&Run::generate(&Plan::default()));
    compare_runs(before.path(), again(change).path()).unwrap()
}

fn case<'a>(comparison: &'a Comparison, metric: &str, variant: &str) -> Vec<&'a TimeChange> {
    let is_meant = |row: &&TimeChange| (&*row.scene, &*row.metric, &*row.variant) == (SCENES[0], metric, variant);
    comparison.times.iter().filter(is_meant).collect()
}

/// The timings of both runs are drawn about the same means with an error of one percent, so nothing changes but noise.
#[test]
fn two_runs_of_the_same_differ_by_noise_only() {
    let comparison = compared(&|_| {});
    assert_eq!(comparison.scenes.len(), SCENES.len());
    assert!(comparison.scenes.iter().all(|scene| scene.same_poses && (scene.drift.unwrap() - 1.0).abs() < 0.01));
    let changed: Vec<_> = comparison.times.iter().filter(|row| row.change != "noise").collect();
    assert!(changed.is_empty(), "{changed:?}");
    // Of each case the time of all strata, of each of four and of the programs, and the construction.
    let cases: usize = PLANTED.iter().map(|planted| planted.policies.len().max(1)).sum();
    // The control runs at far poses alone, and no programs.
    assert_eq!(comparison.times.len(), SCENES.len() * (cases * 7 - 4));
    assert!(comparison.counts.is_empty() && comparison.trees.is_empty() && comparison.misses.is_empty());
    let Compared { times, counts, trees, misses, verdicts } = comparison.compared;
    assert!(times == comparison.times.len() && [counts, trees, misses, verdicts].iter().all(|pairs| *pairs > 0));
    assert!(comparison.failed().is_empty());
}

/// Another version of the program may number the chunks differently.
/// A time of one cluster has no interval, and decides nothing.
#[test]
fn a_single_cluster_has_no_interval() {
    let mut run = Run::generate(&Plan { chunks: 1, ..Plan::default() });
    run.poses.retain(|row| row.workload == "approach");
    let (chunks, poses): (BTreeSet<u32>, BTreeSet<u32>) = run.poses.iter().map(|row| (row.chunk, row.pose)).unzip();
    run.timings.retain(|row| chunks.contains(&row.chunk));
    run.answers.retain(|row| poses.contains(&row.pose));
    let folder = TempDir::new().unwrap();
    run.write(folder.path());
    let comparison = compare_runs(folder.path(), folder.path()).unwrap();
    let of_stratum = comparison.times.iter().find(|row| row.metric == "time" && row.stratum != ALL).unwrap();
    assert!(of_stratum.low.is_nan() && of_stratum.high.is_nan() && of_stratum.change == "undecided", "{of_stratum:?}");
}

#[test]
fn chunks_are_paired_by_what_they_hold() {
    let comparison = compared(&|run| {
        run.timings.iter_mut().for_each(|row| row.chunk = 3 * row.chunk + 1);
        run.poses.iter_mut().for_each(|row| row.chunk = 3 * row.chunk + 1);
    });
    let changed: Vec<_> = comparison.times.iter().filter(|row| row.change != "noise").collect();
    assert!(changed.is_empty() && comparison.times.iter().any(|row| row.metric == "time"), "{changed:?}");
}

#[test]
fn planted_times_counts_and_trees_are_found_and_nothing_else() {
    let comparison = compared(&|run| {
        let is = |variant: &str, scene: &str| variant == "aabb" && scene == SCENES[0];
        run.timings.iter_mut().filter(|row| is(row.variant(), &row.scene)).for_each(|row| row.ns = row.ns * 6 / 5);
        run.builds.iter_mut().filter(|row| is(&row.variant, &row.scene)).for_each(|row| row.ns /= 2);
        run.answers.iter_mut().find(|row| is(row.case.split('@').next().unwrap(), &row.scene)).unwrap().volume_tests +=
            7;
        run.tightness.iter_mut().find(|row| is(&row.variant, &row.scene)).unwrap().hulled_volume_mm3 *= 1.5;
    });
    let changed: Vec<_> = comparison.times.iter().filter(|row| row.change != "noise").collect();
    assert!(changed.iter().all(|row| row.variant == "aabb" && row.scene == SCENES[0]), "{changed:?}");
    // All strata and each of four.
    let slower = case(&comparison, "time", "aabb").into_iter().filter(|row| row.change == "slower").count();
    assert_eq!(slower, 5);
    let time = case(&comparison, "time", "aabb")[0];
    assert!((time.ratio - 1.2).abs() < 0.01 && time.low < 1.2 && 1.2 < time.high, "{time:?}");
    let programs = case(&comparison, "program-time", "aabb")[0];
    assert!((programs.ratio - 1.2).abs() < 0.01 && programs.change == "slower", "{programs:?}");
    let build = case(&comparison, "build", "aabb")[0];
    assert!((build.ratio - 0.5).abs() < 0.01 && build.change == "faster", "{build:?}");
    let counts: Vec<_> = comparison.counts.iter().map(|row| (row.stratum == ALL, row.differing)).collect();
    assert_eq!(counts, [(true, 1), (false, 1)]);
    assert_eq!(comparison.counts[0].volume_tests.1 - comparison.counts[0].volume_tests.0, 7);
    assert_eq!(comparison.trees.len(), 1);
    assert_eq!(comparison.failed(), [Gate::Counts, Gate::Slower]);
    assert!(comparison.trees[0].looseness.1 > comparison.trees[0].looseness.0);
}

/// Whole programs are compared apart from single queries, and by their own null duplicate: a change within its noise is none.
#[test]
fn slower_programs_are_found_where_queries_are_the_same() {
    let cases: [(u64, u64, &[Gate]); 3] = [(200, 100, &[Gate::Slower]), (105, 100, &[Gate::Slower]), (105, 110, &[])];
    for (percent, of_null, failed) in cases {
        let comparison = compared(&|run| {
            let is_program = |row: &&PoseRow| row.workload == PROGRAM_TIME;
            let programs: BTreeSet<u32> = run.poses.iter().filter(is_program).map(|row| row.chunk).collect();
            for row in run.timings.iter_mut().filter(|row| programs.contains(&row.chunk)) {
                let of_case = if row.variant() == NULL_VARIANT { of_null } else { 100 };
                row.ns = row.ns * percent * of_case / 10_000;
            }
        });
        assert_eq!(comparison.failed(), failed, "{percent} {of_null}");
        let changed = comparison.times.iter().filter(|row| row.change != "noise");
        let metrics: BTreeSet<&str> = changed.map(|row| row.metric.as_str()).collect();
        assert_eq!(metrics, failed.iter().map(|_| PROGRAM_TIME).collect::<BTreeSet<_>>());
    }
}

/// A run of one scene and case in which launches alone differ, by 2 %: eight chunks of equal poses and a part, in blocks that agree.
fn of_launches(launches: u32, normal: &mut impl FnMut() -> f64) -> Scene {
    let chunk = |number: u32| Chunk {
        workload: "approach".into(),
        program: String::new(),
        pair: "tool:obstacle".into(),
        stratum: Stratum::Far,
        first_step: number,
        poses: 8,
        judged: None,
        ends_in_contact: false,
        cluster: number,
        spans_strata: false,
    };
    let case = CaseKey { variant: "ball".into(), split: "median".into(), split_axes: "own".into(), leaf: 1 };
    let mut scene = Scene::default();
    scene.chunks = (0..8).map(|number| (number, chunk(number))).collect();
    for launch in 0..launches {
        assert!(scene.binaries.note(launch, 0));
        let ns = 1000.0 * (0.02 * normal()).exp();
        let times = scene.timings.entry(case.clone()).or_default();
        times.extend((0..8).map(|item| Sample { launch, block: 0, item, ns: f64::from(item + 1) * ns }));
        let builds = scene.builds.entry(case.clone()).or_default();
        builds.extend((0..4).map(|block| Sample { launch, block, item: 0, ns }));
    }
    scene
}

/// Two runs of the same program differ by what differs between launches. Of 200 pairs of runs about 10 are beyond the noise of 1 % at two
/// launches, and 5 at three. As many draws as launches, with the clusters' degrees of freedom alone, find about 44 and 13; blocks taken as
/// independent find 123 and 108 other constructions. A single launch decides nothing.
#[test]
fn equal_runs_are_seldom_called_slower_or_faster() {
    let mut normal = normal(8);
    let manifest = Run::generate(&Plan::default()).manifest;
    let side = |scene: Scene| Side {
        manifest: manifest.clone(),
        scenes: BTreeMap::from([("mill".to_owned(), scene)]),
        misses: Misses::default(),
        trees: Vec::new(),
        tightness: Vec::new(),
        ratios: Vec::new(),
        claims: Vec::new(),
    };
    for (launches, pairs, most) in [(1, 10, 0), (2, 200, 20), (3, 200, 20)] {
        let mut changed = BTreeMap::from([("time", 0), ("build", 0)]);
        for _ in 0..pairs {
            let (before, after) = (side(of_launches(launches, &mut normal)), side(of_launches(launches, &mut normal)));
            let mut scene = SceneMatch {
                scene: "mill".to_owned(),
                not_compared: None,
                same_poses: true,
                noise: EQUAL.1,
                program_noise: None,
                drift: None,
            };
            let mut comparison = Comparison::default();
            changes::of_scene(&mut scene, &before, &after, &mut comparison);
            let whole = comparison.times.iter().filter(|row| row.stratum == ALL || row.stratum == "-");
            for row in whole {
                assert_eq!(row.change == "undecided", launches == 1, "{row:?}");
                *changed.get_mut(row.metric.as_str()).unwrap() +=
                    u32::from(["slower", "faster"].contains(&&*row.change));
            }
        }
        assert!(changed.values().all(|changed| *changed <= most), "{launches} launches: {changed:?} of {pairs}");
    }
}

#[test]
fn one_more_miss_is_a_regression_and_one_fewer_is_none() {
    let miss = |by: u64, variant: &'static str| {
        move |run: &mut Run| {
            let stray = run.misses[0].clone();
            let row = run.misses.iter_mut().find(|row| row.case.starts_with(&format!("{variant}@")));
            match row {
                Some(row) => row.missed = row.missed.wrapping_add(by),
                None => run.misses.push(MissRow { case: format!("{variant}@vertex-mean/own/1"), missed: by, ..stray }),
            }
        }
    };
    let worse = compared(&miss(1, "aabb"));
    assert_eq!(worse.failed(), [Gate::Misses]);
    assert_eq!((worse.misses.len(), worse.misses[0].missed), (1, (0, 1)));
    let better = compared(&miss(u64::MAX, "obb-vertex-centroid"));
    assert!(better.failed().is_empty());
    let missed = better.misses[0].missed;
    assert_eq!(missed.0 - missed.1, 1);
    // Other poses, and one miss more of an unsafe variant: within the intervals.
    let other = compared(&|run| {
        run.manifest.request.verify_poses += 1;
        miss(1, "obb-vertex-centroid")(run);
    });
    assert!(other.failed().is_empty() && other.misses.len() == 1);
    let broken = compared(&|run| {
        run.manifest.request.verify_poses += 1;
        miss(1, "aabb")(run);
    });
    assert_eq!(broken.failed(), [Gate::Misses], "a safe variant misses none on any poses");
}

/// Fewer misses in one workload do not make up for more in another, and no contact before excuses no miss now. Lines of odd numbers are taken
/// for those of another workload.
#[test]
fn misses_are_compared_by_workload() {
    fn parted(run: &mut Run) {
        run.lines.iter_mut().filter(|row| row.line % 2 == 1).for_each(|row| row.workload = "program".to_owned());
        run.misses.iter_mut().filter(|row| row.line % 2 == 1).for_each(|row| row.workload = "program".to_owned());
    }
    fn missed<'a>(run: &'a mut Run, workload: &str) -> &'a mut u64 {
        let is = |row: &&mut MissRow| row.case.starts_with("obb-vertex-centroid@") && row.workload == workload;
        &mut run.misses.iter_mut().find(is).unwrap().missed
    }
    let mut run = Run::generate(&Plan::default());
    parted(&mut run);
    let before = folder_of(&run);
    let after = again(&|run| {
        parted(run);
        *missed(run, "approach") -= 5;
        *missed(run, "program") += 2;
    });
    let comparison = compare_runs(before.path(), after.path()).unwrap();
    assert_eq!(comparison.failed(), [Gate::Misses]);
    let changes: Vec<_> = comparison.misses.iter().map(|row| (row.workload.as_str(), row.is_regression)).collect();
    assert_eq!(changes, [("approach", false), ("program", true)]);
    run.lines.clear();
    run.misses.clear();
    let without = folder_of(&run);
    let after = again(&|run| {
        let stray = run.misses[0].clone();
        run.misses.push(MissRow { case: "aabb@vertex-mean/own/1".to_owned(), missed: 1, ..stray });
    });
    let comparison = compare_runs(without.path(), after.path()).unwrap();
    assert_eq!(comparison.failed(), [Gate::Misses]);
    let worse: Vec<_> = comparison.misses.iter().filter(|row| row.is_regression).collect();
    assert!(worse.len() == 1 && worse[0].variant == "aabb" && worse[0].missed == (0, 1), "{worse:?}");
}

#[test]
fn a_scene_of_other_inputs_or_poses_is_not_paired() {
    let comparison = compared(&|run| {
        run.manifest.inputs.insert(format!("{}/scene.toml", SCENES[0]), "11".into());
        run.manifest.machine.cpu = "another".into();
    });
    let [other, same] = &comparison.scenes[..] else { panic!("two scenes") };
    // Scenes come by name: the tailstock first.
    let (other, same) = if other.scene == SCENES[0] { (other, same) } else { (same, other) };
    let reason = NotCompared::Inputs(vec![format!("{}/scene.toml", SCENES[0])]);
    assert_eq!(other.not_compared, Some(reason));
    assert!(same.same_poses && comparison.times.iter().all(|row| row.scene == same.scene));
    assert!(comparison.notes.iter().any(|note| note.starts_with("processor: made-up CPU before")));
    assert_eq!(comparison.failed(), [Gate::Uncompared]);
    let shared = compared(&|run| drop(run.manifest.inputs.insert("scenes/made-up/scene.toml".into(), "11".into())));
    assert!(shared.times.is_empty() && shared.scenes.iter().all(|scene| !scene.same_poses));
    // Neither times, counts nor trees are compared where every scene has other inputs; what was verified is.
    let Compared { times, counts, trees, misses, .. } = shared.compared;
    assert!((times, counts, trees) == (0, 0, 0) && misses > 0 && !shared.is_of_nothing());
    let fewer = compared(&|run| run.manifest.scenes.retain(|scene| scene.name == SCENES[0]));
    let reasons: Vec<_> = fewer.scenes.iter().filter_map(|scene| scene.not_compared.clone()).collect();
    assert_eq!(reasons, [NotCompared::OnlyBefore]);
    let more = compared(&|run| drop(run.manifest.inputs.insert("another/machine.toml".into(), "22".into())));
    assert!(more.scenes.iter().all(|scene| scene.same_poses), "what only one run has is of another scene");
    let seed = compared(&|run| run.manifest.request.seed = 9);
    assert!(seed.times.iter().all(|row| row.metric == "build") && !seed.times.is_empty());
}

/// The null comparison of one run deviates by 10 %, so a change of 5 % is within the noise.
#[test]
fn a_noisy_run_hides_small_changes() {
    let slower = |run: &mut Run| {
        run.timings.iter_mut().filter(|row| row.variant() == "aabb").for_each(|row| row.ns = row.ns * 21 / 20);
    };
    let quiet = compared(&slower);
    assert!(case(&quiet, "time", "aabb").iter().filter(|row| row.stratum == ALL).all(|row| row.change == "slower"));
    let noisy = compared(&|run| {
        slower(run);
        run.timings.iter_mut().filter(|row| row.variant() == NULL_VARIANT).for_each(|row| row.ns = row.ns * 11 / 10);
    });
    assert!(case(&noisy, "time", "aabb").iter().all(|row| row.change == "noise"), "{:?}", noisy.scenes);
}

#[test]
fn what_cannot_be_read_is_an_error_and_derived_files_may_be_missing() {
    let (before, empty) = (folder_of(&Run::generate(&Plan::default())), TempDir::new().unwrap());
    assert!(compare_runs(before.path(), empty.path()).unwrap_err().to_string().contains("manifest.json"));
    let raw = TempDir::new().unwrap();
    Run::generate(&Plan::default()).write(raw.path());
    let comparison = compare_runs(before.path(), raw.path()).unwrap();
    assert!(comparison.verdicts.is_empty());
    assert!(comparison.times.iter().all(|row| row.change == "noise"), "{:?}", comparison.times);
}

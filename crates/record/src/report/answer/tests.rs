//! Made-up tables for each answer that a run can have.

use super::*;
use crate::analysis::{analyze, ranking};
use crate::record::synthetic::{Plan, Run, SCENES};
use crate::record::{Band, LineRow, MissRow, PROGRAM_TIME, VerificationRow, write_rows};
use tempfile::TempDir;

/// An analysed run whose tables the tests then change.
fn contents() -> (TempDir, Contents) {
    of(&Run::generate(&Plan::default()), &ClaimSet::standard())
}

fn of(run: &Run, claims: &ClaimSet) -> (TempDir, Contents) {
    let folder = TempDir::new().unwrap();
    run.write(folder.path());
    analyze(folder.path(), claims).unwrap();
    let contents = Contents::read(folder.path()).unwrap();
    (folder, contents)
}

/// Sets the ratio of the proposal in one scene.
fn set(contents: &mut Contents, scene: &str, (ratio, low, high): (f64, f64, f64), effect: &str, noisy: u8) {
    let reading = proposed(&contents.claims).unwrap().clone();
    let rows = contents.ratios.iter_mut().filter(|row| row.metric == PROGRAM_TIME && row.stratum == ALL);
    let of = (&reading.subject.variant, &reading.baseline.variant);
    for row in rows.filter(|row| row.scene == scene && (&row.variant, &row.baseline) == of) {
        (row.ratio, row.low, row.high, row.noisy) = (ratio, low, high, noisy);
        effect.clone_into(&mut row.effect);
    }
}

fn first(contents: &Contents) -> String {
    answer(contents)[0].answer.clone()
}

const LESS: ((f64, f64, f64), &str) = ((0.8, 0.75, 0.85), "less");
const MORE: ((f64, f64, f64), &str) = ((1.5, 1.4, 1.6), "more");
const SAME: ((f64, f64, f64), &str) = ((1.0, 0.98, 1.02), "same");
const UNCLEAR: ((f64, f64, f64), &str) = ((0.9, 0.7, 1.2), "unclear");

#[test]
fn each_pair_of_outcomes_has_its_verdict() {
    let (_folder, mut contents) = contents();
    let [a, b] = SCENES;
    let cases = [
        (LESS, LESS, "Yes, in all 2 scenes."),
        (MORE, MORE, "No: slower in all 2 scenes."),
        (SAME, SAME, "No: the same within 5 % in all 2 scenes."),
        (UNCLEAR, UNCLEAR, "Undecided in all 2 scenes."),
        (MORE, SAME, &*format!("No, in none of 2 scenes: slower on {a}; the same within 5 % on {b}.")),
        (LESS, MORE, &*format!("In 1 of 2 scenes: faster on {a}; slower on {b}.")),
        (UNCLEAR, LESS, &*format!("In 1 of 2 scenes: faster on {b}; undecided on {a}.")),
        (MORE, UNCLEAR, &*format!("Not shown in any of 2 scenes: slower on {a}; undecided on {b}.")),
    ];
    for ((of_a, effect_a), (of_b, effect_b), expected) in
        cases.iter().map(|(a, b, expected)| (*a, *b, *expected)).collect::<Vec<_>>()
    {
        set(&mut contents, a, of_a, effect_a, 0);
        set(&mut contents, b, of_b, effect_b, 0);
        let text = first(&contents);
        assert!(text.starts_with(expected), "{text}, not {expected}");
        assert!(!text.contains("noisy"), "{text}");
    }
    assert!(
        first(&contents).contains("1.500 [1.400, 1.600] on lathe-toolpost, 0.900 [0.700, 1.200] on lathe-tailstock")
    );
}

/// A cell with a noisy null duplicate decides nothing, however clear its ratio looks, and the answer gives the reason.
#[test]
fn noise_leaves_a_scene_undecided() {
    let (_folder, mut contents) = contents();
    set(&mut contents, SCENES[0], LESS.0, LESS.1, 1);
    set(&mut contents, SCENES[1], LESS.0, LESS.1, 0);
    let text = first(&contents);
    assert!(text.starts_with("In 1 of 2 scenes: faster on lathe-tailstock; undecided on lathe-toolpost."), "{text}");
    assert!(text.ends_with("The timings of lathe-toolpost were too noisy to decide on speed."), "{text}");
}

#[test]
fn one_scene_and_a_foreign_one_are_named() {
    let (_folder, mut contents) = contents();
    contents.manifest.scenes.truncate(1);
    contents.manifest.scenes[0].name = "a-press-brake".to_owned();
    contents.ratios.iter_mut().for_each(|row| {
        if row.scene == SCENES[0] {
            "a-press-brake".clone_into(&mut row.scene);
        }
    });
    set(&mut contents, "a-press-brake", LESS.0, LESS.1, 0);
    assert!(first(&contents).starts_with("Yes, on a-press-brake."), "{}", first(&contents));
    set(&mut contents, "a-press-brake", MORE.0, MORE.1, 0);
    assert!(first(&contents).starts_with("No: slower on a-press-brake."));
    set(&mut contents, "a-press-brake", UNCLEAR.0, UNCLEAR.1, 0);
    assert!(first(&contents).starts_with("Undecided on a-press-brake."));
}

#[test]
fn a_run_without_one_of_the_variants_says_so() {
    let (_folder, mut contents) = contents();
    let reading = proposed(&contents.claims).unwrap().clone();
    contents.ratios.retain(|row| row.variant != reading.subject.variant);
    assert!(first(&contents).starts_with("This run cannot say"), "{}", first(&contents));
    contents.ratios.clear();
    contents.ranking.clear();
    assert!(answer(&contents)[2].answer.starts_with("This run cannot say"));
}

/// A ratio from a single launch has no interval: the number is shown alone, and nothing is decided.
#[test]
fn a_ratio_without_an_interval_is_a_number() {
    let (_folder, mut contents) = contents();
    SCENES.into_iter().for_each(|scene| set(&mut contents, scene, (0.8, f64::NAN, f64::NAN), "unclear", 0));
    let text = first(&contents);
    assert!(text.starts_with("Undecided in all 2 scenes.") && text.contains("0.800 on lathe-toolpost,"), "{text}");
}

/// The spread of a single cluster is unknown: its interval of no width is not shown, and a single launch names no fastest volume.
#[test]
fn a_single_cluster_has_no_interval() {
    let (_folder, mut contents) = contents();
    let [a, b] = SCENES;
    for (scene, ratio) in [(a, 0.97), (b, 0.8)] {
        set(&mut contents, scene, (ratio, ratio, ratio), "unclear", 0);
    }
    contents.ratios.iter_mut().for_each(|row| row.clusters = 1);
    let text = first(&contents);
    assert!(text.contains("0.970 on lathe-toolpost, 0.800 on lathe-tailstock.") && !text.contains('['), "{text}");
    assert_eq!(answer(&contents)[2].answer, format!("Undecided (one launch) on {a} and {b}."));
}

/// A scene without programs is ranked by the first workload that it has, and says so.
#[test]
fn each_scene_is_ranked_by_its_own_workload() {
    let (_folder, mut contents) = contents();
    let [a, b] = SCENES;
    contents.ratios.retain(|row| row.scene != b || row.metric != PROGRAM_TIME);
    let sampled = contents.ratios.iter_mut().filter(|row| row.scene == b && row.workload == "program");
    sampled.for_each(|row| row.workload = "recorded".to_owned());
    contents.ranking = ranking(&contents.manifest, &contents.ratios, &contents.misses, &contents.claims);
    assert!(contents.ranking.iter().all(|entry| entry.scenes == 2), "{:?}", contents.ranking);
    let text = first(&contents);
    assert!(text.starts_with("Yes, in all 2 scenes."), "{text}");
    assert!(text.contains(&format!("Program time on {a} and query time in `recorded` on {b} relative to")), "{text}");
    let text = &answer(&contents)[2].answer;
    assert_eq!(
        *text,
        format!("The area-weighted OBB on {a}; the area-weighted OBB on {b}, by query time in `recorded`.")
    );
}

/// Verified poses of which none or a part is timed are told, with how those of a recording were chosen.
#[test]
fn untimed_poses_are_told() {
    let mut run = Run::generate(&Plan::default());
    let of_approach = run.verification.iter().filter(|row| row.workload == "approach" && row.scene == SCENES[0]);
    let extra: Vec<VerificationRow> =
        of_approach.map(|row| VerificationRow { workload: "random".to_owned(), ..row.clone() }).collect();
    run.verification.extend(extra);
    let (_folder, mut contents) = of(&run, &ClaimSet::standard());
    let poses = contents.misses.poses()[&(SCENES[0], "random")];
    let none = format!(" None of the {poses} poses in `random` of {} were timed", SCENES[0]);
    assert_eq!(untimed(&contents), format!("{none}."));
    contents.summary.push(SummaryRow {
        scene: SCENES[0].to_owned(),
        workload: RECORDED.to_owned(),
        stratum: ALL.to_owned(),
        poses: 70,
        ..contents.summary[0].clone()
    });
    run.verification
        .iter_mut()
        .filter(|row| row.workload == "random")
        .for_each(|row| RECORDED.clone_into(&mut row.workload));
    let (_folder, recorded) = of(&run, &ClaimSet::standard());
    contents.misses = recorded.misses;
    let how = ", those of a recording chosen by stratum and weighted by each stratum's share.";
    assert_eq!(untimed(&contents), format!(" 70 of the {poses} poses in `recorded` of {} were timed{how}", SCENES[0]));
}

/// Query times of fewer than four clusters of poses decide nothing, however clear their ratio looks.
#[test]
fn too_few_poses_leave_the_fastest_undecided() {
    let (_folder, mut contents) = contents();
    let [a, b] = SCENES;
    contents.ratios.retain(|row| row.scene != b || row.metric != PROGRAM_TIME);
    let undecided = "undecided (too few poses)";
    for (clusters, expected) in [(1, undecided), (3, undecided), (4, "the area-weighted OBB")] {
        contents.ratios.iter_mut().filter(|row| row.metric == "time").for_each(|row| row.clusters = clusters);
        let text = &answer(&contents)[2].answer;
        assert_eq!(*text, format!("The area-weighted OBB on {a}; {expected} on {b}, by query time in `program`."));
    }
}

/// The workload that the claim names decides on the proposal, whatever the scenes are ranked by.
#[test]
fn a_claim_names_the_workload_of_the_answer() {
    let (_folder, mut contents) = contents();
    let proposed = |claim: &&mut Claim| {
        claim.primary.is_some() && claim.test.as_ref().is_some_and(|test| test.kind == TestKind::TimeRatio)
    };
    let claim = contents.claims.claims.iter_mut().find(proposed).unwrap();
    claim.test.as_mut().unwrap().workload = Some("approach".to_owned());
    assert!(first(&contents).contains("Query time in `approach` relative to"), "{}", first(&contents));
    assert!(!answer(&contents)[2].answer.contains("approach"));
}

#[test]
fn misses_are_those_of_the_printed_boxes_and_of_the_safe_ones() {
    let (_folder, contents) = contents();
    let statement = &answer(&contents)[1];
    assert_eq!(statement.question, "What do the boxes as printed miss?");
    let expected = "Of the contacts of each workload, the plain OBB, centred on the mean misses ";
    assert!(statement.answer.starts_with(expected), "{}", statement.answer);
    assert!(statement.answer.contains("; the area-weighted OBB, centred on the mean misses "));
    assert!(statement.answer.contains("The safe variants miss none of at least "), "{}", statement.answer);
}

/// Rates of two workloads are told apart, and the bound on a safe variant counts lines by what they hold: ten lines of one contact and one
/// of ninety are 100² / (10 + 90²) = 1.23 lines, which bound nothing, whatever other workloads hold.
#[test]
fn rates_are_told_by_workload() {
    let tally = |lines: &[(u64, u64)]| Tally { lines: lines.to_vec(), ..Tally::default() };
    let (many, none, few) = (tally(&[(1, 10), (0, 10)]), tally(&[(0, 7); 3]), tally(&[(2, 10)]));
    let empty = tally(&[]);
    let of = Tallies::from([
        ("approach", vec![("a", &many), ("b", &few), ("c", &empty)]),
        ("program", vec![("a", &none)]),
        ("random", vec![("a", &empty)]),
    ]);
    assert_eq!(rates(&of).unwrap(), "misses 5.0 to 20 % in `approach` and none of 21 in `program`");
    assert_eq!(rates(&Tallies::new()), None);
    // Where none was missed no rate is told, least of all one of zero.
    let rare = tally(&[(1, 5000)]);
    for (scenes, expected) in [
        (vec![("a", &none), ("b", &few)], "misses 20 % in `program` (none of 21 on a)"),
        (
            vec![("a", &none), ("b", &few), ("c", &none), ("d", &many)],
            "misses 5.0 to 20 % in `program` (none of 42 in 2 scenes)",
        ),
        (vec![("a", &rare), ("b", &few)], "misses 0.0200 to 20 % in `program`"),
    ] {
        assert_eq!(rates(&Tallies::from([("program", scenes)])).unwrap(), expected);
    }
    let (_folder, contents) = contents();
    let (even, uneven) = (tally(&[(0, 1); 1000]), tally(&[vec![(0, 1); 10], vec![(0, 90)]].concat()));
    let safe = Tallies::from([("approach", vec![("a", &even)]), ("random", vec![("a", &uneven), ("b", &empty)])]);
    let text = safe_ones(&contents, &[safe]);
    assert!(text.contains("none of at least 1100 contacts each"), "{text}");
    assert!(text.contains("a rate of at most 0.300 % in `approach` and 100 % in `random` (95 %)."), "{text}");
    assert!(text.ends_with("Nothing is shown where there was no contact to ask about: in `random` of b."), "{text}");
}

/// The rates are of the scenes with contacts of a workload, and the others are named: `lines.csv` has no rows of them.
#[test]
fn scenes_without_a_contact_are_not_counted_and_are_told() {
    let (b, none): (&str, &[(&str, &str)]) = (SCENES[1], &[]);
    for (lacking, range, told) in [
        (none, " (ranges over 2 scenes).", None),
        (&[(b, "approach")], "", Some("in `approach` of lathe-tailstock.")),
        (
            &[(b, "random")],
            " (ranges over 2 scenes in `approach` and 1 scene in `random`).",
            Some("in `random` of lathe-tailstock."),
        ),
    ] {
        let mut run = Run::generate(&Plan::default());
        // In `random` what is in `approach`.
        if lacking.contains(&(b, "random")) {
            let random = "random".to_owned();
            run.lines.extend(run.lines.clone().into_iter().map(|row| LineRow { workload: random.clone(), ..row }));
            run.misses.extend(run.misses.clone().into_iter().map(|row| MissRow { workload: random.clone(), ..row }));
            let rows = run.verification.clone().into_iter();
            run.verification.extend(rows.map(|row| VerificationRow { workload: random.clone(), ..row }));
        }
        let is_lacking = |scene: &str, workload: &str| lacking.contains(&(scene, workload));
        run.lines.retain(|row| !is_lacking(&row.scene, &row.workload));
        run.misses.retain(|row| !is_lacking(&row.scene, &row.workload));
        run.verification.retain(|row| !is_lacking(&row.scene, &row.workload) || row.band == Band::Clear);
        let (_folder, contents) = of(&run, &ClaimSet::standard());
        let text = &answer(&contents)[1].answer;
        let (rates, safe) = text.split_once(" The safe variants").unwrap();
        assert!(rates.ends_with(range) && rates.contains("ranges") != range.is_empty(), "{text}");
        assert_eq!(safe.split_once("no contact to ask about: ").map(|(_, places)| places), told, "{text}");
    }
}

/// Boxes that the run does not have were asked about nothing, for another reason than that there was no contact.
#[test]
fn boxes_that_the_run_does_not_have_are_not_there() {
    let (mut run, claims) = (Run::generate(&Plan::default()), ClaimSet::standard());
    let printed = printed(&claims);
    let is_there = |variant: &str| printed.iter().all(|case| case.variant != variant);
    let of_case = |case: &str| is_there(case.split('@').next().unwrap());
    run.manifest.variants.retain(|entry| is_there(&entry.id));
    run.cases.retain(|row| is_there(&row.variant));
    run.timings.retain(|row| of_case(&row.case));
    run.answers.retain(|row| of_case(&row.case));
    run.misses.retain(|row| of_case(&row.case));
    let (_folder, contents) = of(&run, &claims);
    let text = &answer(&contents)[1].answer;
    assert!(text.starts_with("This run does not have them."), "{text}");
}

/// A variant that is declared safe and missed a contact is named first.
#[test]
fn a_broken_promise_is_told() {
    let mut run = Run::generate(&Plan::default());
    let missing = run.misses.iter().find(|row| row.case.contains("obb-vertex-centroid")).unwrap().clone();
    let safe = run.cases.iter().find(|case| case.variant == "aabb").unwrap().case.clone();
    run.misses.push(MissRow { case: safe, missed: 1, missed_asked: 0, ..missing });
    let (_folder, contents) = of(&run, &ClaimSet::standard());
    let text = &answer(&contents)[1].answer;
    assert!(text.contains("The AABB is called safe and missed a contact."), "{text}");
    assert!(!text.contains("miss none"), "{text}");
}

#[test]
fn without_claims_there_are_two_questions() {
    let (_folder, contents) = of(&Run::generate(&Plan::default()), &ClaimSet::none("my machine", "obb-vertex"));
    let questions: Vec<String> = answer(&contents).into_iter().map(|statement| statement.question).collect();
    assert_eq!(questions, ["Which contacts are missed?", "Which safe volume is fastest?"]);
}

/// Sets the ratio of two variants in a scene, or adds it.
fn place(contents: &mut Contents, [variant, baseline]: [&str; 2], scene: &str, (ratio, low, high): (f64, f64, f64)) {
    let cases = Cases::new(&contents.manifest);
    let is_it = |row: &RatioRow| {
        (&*row.scene, &*row.metric, &*row.stratum) == (scene, PROGRAM_TIME, ALL)
            && (&*row.variant, &*row.baseline) == (variant, baseline)
            && cases.is_default(variant, &row.policy)
    };
    let entry = |id: &str| contents.manifest.variants.iter().find(|entry| entry.id == id).unwrap().policies[0].clone();
    let (policy, baseline_policy) = (entry(variant), entry(baseline));
    if !contents.ratios.iter().any(is_it) {
        let like = contents.ratios.iter().find(|row| row.metric == PROGRAM_TIME && row.stratum == ALL).unwrap().clone();
        let [scene, variant, baseline] = [scene, variant, baseline].map(str::to_owned);
        contents.ratios.push(RatioRow { scene, variant, policy, baseline, baseline_policy, ..like });
    }
    for row in contents.ratios.iter_mut().filter(|row| is_it(row)) {
        (row.ratio, row.low, row.high) = (ratio, low, high);
    }
}

/// A volume is told apart from the fastest one by their direct ratio, whatever the spread of the baseline.
#[test]
fn a_volatile_baseline_ties_nothing_but_itself() {
    let mut run = Run::generate(&Plan::default());
    for row in run.timings.iter_mut().filter(|row| row.case.starts_with("obb-vertex@")) {
        row.ns = row.ns * [10, 13, 8][row.launch as usize] / 10;
    }
    let (_folder, contents) = of(&run, &ClaimSet::none("my machine", "obb-vertex"));
    let [a, b] = SCENES;
    let cases = Cases::new(&contents.manifest);
    let [area, aabb] =
        ["obb-area", "aabb"].map(|id| ranking_ratio(&contents.ratios, &cases, a, id, "obb-vertex").unwrap());
    assert!(area.high > aabb.low, "{area:?} {aabb:?}");
    let expected = format!("The area-weighted OBB and the plain OBB, not told apart, on {a} and {b}.");
    assert_eq!(answer(&contents)[1].answer, expected);
}

#[test]
fn the_fastest_differs_by_scene_ties_and_noise() {
    let (folder, mut contents) = contents();
    let [a, b] = SCENES;
    // Planted: the area-weighted box takes 0.8 everywhere.
    assert_eq!(answer(&contents)[2].answer, format!("The area-weighted OBB on {a} and {b}."));
    let subject = proposed(&contents.claims).unwrap().subject.variant.clone();
    let [plain, area] = ["obb-vertex", "obb-area"];
    assert_eq!(subject, area);
    place(&mut contents, [area, plain], b, (0.8, 0.79, 0.81));
    place(&mut contents, ["aabb", plain], a, (0.1, 0.09, 0.11));
    place(&mut contents, ["aabb", plain], b, (200.0, 190.0, 210.0));
    place(&mut contents, ["aabb", area], b, (250.0, 240.0, 260.0));
    let volumes = contents.ranking.iter().filter(|entry| entry.kind == Kind::Volume && entry.variant != "aabb");
    let volumes: Vec<String> = volumes.map(|entry| entry.variant.clone()).collect();
    volumes.iter().for_each(|id| place(&mut contents, [id, "aabb"], a, (9.0, 8.0, 10.0)));
    let text = &answer(&contents)[2].answer;
    let expected = format!(
        "The AABB on {a}; the area-weighted OBB on {b}. None is fastest everywhere: on {b} the AABB takes 250 times the time of the fastest."
    );
    assert_eq!(*text, expected);
    place(&mut contents, ["aabb", plain], b, (0.81, 0.80, 0.82));
    place(&mut contents, ["aabb", area], b, (1.01, 0.98, 1.04));
    assert!(
        answer(&contents)[2].answer.contains("not told apart, on lathe-tailstock"),
        "{}",
        answer(&contents)[2].answer
    );
    // Where the null duplicate is noisy nothing is decided, by whatever factor one leads.
    place(&mut contents, ["aabb", plain], b, (0.32, 0.31, 0.33));
    volumes.iter().for_each(|id| place(&mut contents, [id, "aabb"], b, (9.0, 8.0, 10.0)));
    assert!(answer(&contents)[2].answer.starts_with("The AABB on lathe-toolpost and lathe-tailstock"));
    let nulls = contents.ratios.iter_mut().filter(|row| row.variant == NULL_VARIANT && row.scene == b);
    nulls.for_each(|row| (row.ratio, row.low, row.high, row.noisy) = (1.2, 0.9, 1.7, 1));
    assert_eq!(answer(&contents)[2].answer, format!("The AABB on {a}; undecided (noisy) on {b}."));
    contents.ratios.iter_mut().for_each(|row| row.noisy = 1);
    assert_eq!(answer(&contents)[2].answer, format!("Undecided (noisy) on {a} and {b}."));
    // The records themselves are untouched.
    write_rows(folder.path(), &contents.ratios).unwrap();
}

//! Audits made up with known effects.

use super::*;
use crate::analysis::tests::normal;
use crate::record::Band;
use crate::record::synthetic::{Plan, Run};
use tempfile::TempDir;

const ORIENTATIONS: [(&str, f64); 2] = [("turned", 1.0), ("level", 2.0)];
const CENTRES: [(&str, f64); 3] = [("tight", 1.0), ("loose", 3.0), ("drifted", 0.5)];
const SPLITS: [(&str, f64); 2] = [("halves", 1.0), ("thirds", 1.0)];
const LEAVES: [(&str, f64); 2] = [("1", 1.0), ("8", 0.25)];

/// All cells with the product of their levels' planted effects.
fn cells() -> Vec<([String; 4], f64)> {
    let mut cells = Vec::new();
    for (o, x) in ORIENTATIONS {
        for (c, y) in CENTRES {
            for (s, z) in SPLITS {
                cells.extend(LEAVES.map(|(l, w)| ([o, c, s, l].map(str::to_owned), x * y * z * w)));
            }
        }
    }
    cells
}

/// Two scenes with three chunks each, on lines of their own. Volume tests per pose are 1200 × scene × chunk × planted effect. Boxes with the drifted centre rule
/// are unsafe and miss a tenth of the contacts.
fn write(folder: &Path) {
    Run::generate(&Plan::default()).manifest.write(folder).unwrap();
    let (mut rows, mut trees, mut factors) = (Vec::new(), Vec::new(), Vec::new());
    for (scene, scale) in [("mill", 1), ("lathe", 7)] {
        for (levels, effect) in cells() {
            let [orientation, centre, split, leaf] = levels.clone();
            let tree = TreeRow {
                scene: scene.into(),
                part: "a".into(),
                variant: format!("{orientation}-{centre}"),
                split,
                split_axes: "own".into(),
                leaf: leaf.parse().unwrap(),
                ..TreeRow::default()
            };
            let (case, drifted) = (tree.case().name(), centre == "drifted");
            if scene == "mill" {
                factors
                    .extend(FACTORS.iter().zip(levels).map(|(factor, level)| FactorRow::of_case(&case, factor, level)));
            }
            for chunk in 0..3 {
                let stratum = if chunk == 0 { Stratum::Colliding } else { Stratum::Far };
                rows.push(CountRow {
                    poses: 10,
                    queries: 10,
                    volume_tests: (12_000.0 * f64::from(scale * (chunk + 1)) * effect) as u64,
                    touching: if chunk == 0 { 10 } else { 0 },
                    missed: u64::from(chunk == 0 && drifted),
                    ..CountRow::new(scene, &case, chunk, Some(stratum))
                });
            }
            trees.push(TreeRow {
                volumes_area_mm2: Some(240.0),
                part_area_mm2: Some(24.0),
                outside_nodes: Some(u64::from(drifted)),
                outside_corners_pct: Some(if drifted { 5.0 } else { 0.0 }),
                overhang_mm: Some(if drifted { 1.5 } else { 0.0 }),
                ..tree
            });
        }
    }
    write_poses(folder, [0, 1, 2]);
    write_rows(folder, &factors).unwrap();
    write_rows(folder, &rows).unwrap();
    write_rows(folder, &trees).unwrap();
}

/// A pose of each chunk on the given line.
fn write_poses(folder: &Path, lines: [u32; 3]) {
    let pose = |scene: &str, chunk: u32, line: u32| PoseRow {
        scene: scene.into(),
        pose: chunk,
        pair: "a:b".into(),
        workload: "random".into(),
        program: String::new(),
        line,
        step: chunk,
        chunk,
        stratum: if chunk == 0 { Stratum::Colliding } else { Stratum::Far },
        band: if chunk == 0 { Band::Millimetre } else { Band::Clear },
        clearance_mm: None,
        exact: u8::from(chunk == 0),
        contained: 0,
        judged: None,
    };
    let of_scene = |scene| (0..).zip(lines).map(move |(chunk, line)| pose(scene, chunk, line));
    write_rows(folder, &["mill", "lathe"].into_iter().flat_map(of_scene).collect::<Vec<_>>()).unwrap();
}

fn near(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-9
}

#[test]
fn planted_effects_are_found_and_what_was_not_planted_is_not() {
    let folder = TempDir::new().unwrap();
    write(folder.path());
    let outcome = analyze_audit(folder.path()).unwrap();
    let effect = |cells: &str, term: &str, level: &str| {
        let mut rows = outcome.effects.iter().filter(|row| row.scene == ALL && row.response == "volume-tests");
        rows.find(|row| row.cells == cells && row.term == term && row.level == level).unwrap()
    };
    // Levels 1 and 2 lie a factor √2 below and above their geometric mean; 1 and 3 a factor √3; 1 and 1/4 a factor 2.
    for (term, level, expected) in [
        ("orientation", "turned", 0.5_f64.sqrt()),
        ("orientation", "level", 2.0_f64.sqrt()),
        ("centre", "loose", 3.0_f64.sqrt()),
        ("split", "thirds", 1.0),
        ("leaf", "8", 0.5),
        ("orientation:leaf", "level:8", 1.0),
    ] {
        let row = effect(SAFE, term, level);
        assert!(near(row.effect, expected), "{row:?}");
        // The planted effects are the same in every chunk, so that resampling changes nothing.
        assert!(near(row.low, row.effect) && near(row.high, row.effect), "{row:?}");
    }
    // With the drifted centre the three are 1, 3 and 1/2, whose geometric mean is ∛1.5.
    assert!(near(effect(ALL, "centre", "drifted").effect, 0.5 / 1.5_f64.cbrt()));
    assert!(near(effect("tight", "leaf", "1").effect, 2.0));
}

/// The colliding stratum has one chunk, in which the orientation counts twice: its effect differs among three chunks, and is no certainty.
/// That chunk alone has no interval.
#[test]
fn a_stratum_of_one_chunk_is_no_certainty() {
    for (chunks, has_interval) in [(3, true), (1, false)] {
        let folder = TempDir::new().unwrap();
        write(folder.path());
        let mut rows: Vec<CountRow> = read_rows(folder.path()).unwrap();
        rows.retain(|row| row.chunk < chunks);
        let is_counted_twice = |row: &&mut CountRow| row.chunk == 0 && row.case.starts_with("level-");
        rows.iter_mut().filter(is_counted_twice).for_each(|row| row.volume_tests *= 2);
        write_rows(folder.path(), &rows).unwrap();
        let outcome = analyze_audit(folder.path()).unwrap();
        let is_it =
            |scene: &str, cells: &str, response: &str| (scene, cells, response) == ("mill", SAFE, "volume-tests");
        let mut effects = outcome.effects.iter().filter(|row| is_it(&row.scene, &row.cells, &row.response));
        let effect = effects.find(|row| row.level == "level").unwrap();
        let mut shares = outcome.shares.iter().filter(|row| is_it(&row.scene, &row.cells, &row.response));
        let share = shares.find(|row| row.term == "orientation").unwrap();
        // In the colliding chunk the levels are a factor 4 apart, in the others 2: the strata count the same.
        assert!(near(effect.effect, if has_interval { 2.0_f64.powf(0.75) } else { 2.0 }), "{effect:?}");
        for [value, low, high] in [[effect.effect, effect.low, effect.high], [share.share, share.low, share.high]] {
            let is_within = low < value && value < high;
            assert_eq!((is_within, low.is_nan(), high.is_nan()), (has_interval, !has_interval, !has_interval));
        }
    }
}

/// Chunks that share a line are drawn as one. The colliding chunk (a factor 4 between the levels of orientation, where the far ones have 2) and one far
/// chunk on one line are one of two clusters; three chunks on one line are one cluster, which has no interval. Values stay.
#[test]
fn chunks_that_share_a_line_are_one_cluster() {
    let effect = |lines: [u32; 3]| {
        let folder = TempDir::new().unwrap();
        write(folder.path());
        write_poses(folder.path(), lines);
        let mut rows: Vec<CountRow> = read_rows(folder.path()).unwrap();
        let is_counted_twice = |row: &&mut CountRow| row.chunk == 0 && row.case.starts_with("level-");
        rows.iter_mut().filter(is_counted_twice).for_each(|row| row.volume_tests *= 2);
        write_rows(folder.path(), &rows).unwrap();
        let effects = analyze_audit(folder.path()).unwrap().effects;
        let is_it = |row: &&AuditEffectRow| {
            (&*row.scene, &*row.cells, &*row.response, &*row.level) == ("mill", SAFE, "volume-tests", "level")
        };
        let row = effects.iter().find(is_it).unwrap();
        assert!(near(row.effect, 2.0_f64.powf(0.75)), "{row:?}");
        [row.low, row.high]
    };
    let (apart, two, one) = (effect([0, 1, 2]), effect([0, 0, 1]), effect([7, 7, 7]));
    assert!(two[0] < two[1] && two != apart, "{two:?} {apart:?}");
    assert!(one.iter().all(|end| end.is_nan()), "{one:?}");
}

/// One scene with four strata of two chunks and no effect: the intervals of at most about 15 of 300 samples must miss it. With a factor by
/// the degrees of freedom of all strata together, some 32 do.
#[test]
fn strata_of_two_chunks_hold_what_they_promise() {
    let mut normal = normal(5);
    let level = |name: &str| vec![name.to_owned()];
    let levels = Levels([[level("turned"), level("level")].concat(), level("tight"), level("halves"), level("1")]);
    let mut missed = 0;
    for sample in 0..300 {
        let chunk = |number: u32| Observed {
            group: (number / 2).to_string(),
            unit: number.to_string(),
            values: vec![normal(), 0.0],
        };
        let chunks: Vec<Observed> = (0..8).map(chunk).collect();
        let mut outcome = AuditOutcome::default();
        tell(&mut outcome, SAFE, "time", &levels, &("mill".to_owned(), vec![chunks.as_slice()]), sample);
        let effect = &outcome.effects[0];
        missed += u32::from(effect.low > 1.0 || effect.high < 1.0);
    }
    assert!(missed <= 24, "{missed} of 300");
}

#[test]
fn shares_are_those_of_the_squared_logarithms() {
    let folder = TempDir::new().unwrap();
    write(folder.path());
    let outcome = analyze_audit(folder.path()).unwrap();
    let share = |term: &str| {
        let mut rows = outcome.shares.iter().filter(|row| row.scene == "lathe" && row.response == "volume-tests");
        rows.find(|row| row.cells == SAFE && row.term == term).unwrap().share
    };
    // Each factor has two levels, so the squares are (ln √2)², (ln √3)², 0, (ln 2)².
    let squares = [2.0_f64.ln() / 2.0, 3.0_f64.ln() / 2.0, 0.0, 2.0_f64.ln()].map(|x| x * x);
    let total: f64 = squares.iter().sum();
    for (factor, square) in FACTORS.iter().zip(squares) {
        assert!((share(factor) - square / total).abs() < 1e-9, "{factor}");
    }
    assert!(share(REST) < 1e-9 && share("orientation:centre") < 1e-9);
}

#[test]
fn cells_carry_their_means_misses_and_containment() {
    let folder = TempDir::new().unwrap();
    write(folder.path());
    let outcome = analyze_audit(folder.path()).unwrap();
    let row = |scene: &str, centre: &str| {
        let mut rows = outcome.cells.iter().filter(|row| row.scene == scene && row.orientation == "turned");
        rows.find(|row| row.centre == centre && row.split == "halves" && row.leaf == 1).unwrap()
    };
    // One colliding chunk of 1200 tests a pose, and two far ones of 2400 and 3600: strata count the same.
    let tight = row("mill", "tight");
    assert!(near(tight.volume_tests, (1200.0 * (2400.0_f64 * 3600.0).sqrt()).sqrt()));
    assert_eq!((tight.safe, tight.touching, tight.missed, tight.time_ratio), (1, 10, 0, None));
    assert!(near(row(ALL, "tight").volume_tests, tight.volume_tests * 7.0_f64.sqrt()));
    let drifted = row(ALL, "drifted");
    assert_eq!((drifted.safe, drifted.touching, drifted.missed), (0, 20, 2));
    assert_eq!((drifted.outside_corners_pct, drifted.overhang_mm, drifted.box_area_ratio.round()), (5.0, 1.5, 10.0));
}

#[test]
fn an_audit_that_lacks_a_cell_is_refused() {
    let folder = TempDir::new().unwrap();
    write(folder.path());
    let mut rows: Vec<CountRow> = read_rows(folder.path()).unwrap();
    rows.remove(30);
    write_rows(folder.path(), &rows).unwrap();
    let error = analyze_audit(folder.path()).unwrap_err();
    assert_eq!(error.to_string(), "counts.csv: scene `mill` lacks cells of the audit; let it finish first");
}

#[test]
fn the_same_records_give_the_same_bytes() {
    let folder = TempDir::new().unwrap();
    write(folder.path());
    let written = || {
        analyze_audit(folder.path()).unwrap();
        [AuditCellRow::FILE, AuditEffectRow::FILE, AuditShareRow::FILE]
            .map(|file| std::fs::read(folder.path().join(file)).unwrap())
    };
    assert_eq!(written(), written());
}

/// A cell is compared only with the copy of the reference that was timed in the same launch.
#[test]
fn times_are_compared_within_a_launch() {
    let folder = TempDir::new().unwrap();
    write(folder.path());
    let (mut timings, mut builds) = (Vec::new(), Vec::new());
    let trees: Vec<TreeRow> = read_rows(folder.path()).unwrap();
    for (launch, tree) in (0..).zip(&trees) {
        // Every launch is on a machine of another speed; leaves of eight take twice the time to ask and half to build.
        let (speed, of_eight) = (1000 * (u64::from(launch) + 1), tree.leaf == 8);
        let null = TreeRow { variant: NULL_VARIANT.into(), ..tree.clone() };
        for (of, query, build) in [(tree, if of_eight { 6 } else { 3 }, if of_eight { 2 } else { 4 }), (&null, 3, 4)] {
            let (scene, case) = (tree.scene.clone(), of.case());
            timings.extend((0..3).map(|chunk| TimingRow {
                scene: scene.clone(),
                case: case.name(),
                binary: 0,
                launch,
                block: 0,
                chunk,
                passes: 2,
                ns: query * speed,
            }));
            builds.push(BuildRow {
                scene,
                part: tree.part.clone(),
                variant: case.variant,
                split: case.split,
                split_axes: case.split_axes,
                leaf: case.leaf,
                triangles: 12,
                binary: 0,
                launch,
                block: 0,
                ns: build * speed,
            });
        }
    }
    write_rows(folder.path(), &timings).unwrap();
    write_rows(folder.path(), &builds).unwrap();
    for row in analyze_audit(folder.path()).unwrap().cells {
        let (time, build) = if row.leaf == 8 { (2.0, 0.5) } else { (1.0, 1.0) };
        assert!(near(row.time_ratio.unwrap(), time) && near(row.build_ratio.unwrap(), build), "{row:?}");
    }
}

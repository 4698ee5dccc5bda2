//! The kinds of change between two runs, by kind of record.

use super::{Comparison, SceneMatch, Side, case_name};
use crate::analysis::ALL;
use crate::analysis::judge::CLUSTERS_MIN;
use crate::analysis::stats::{self, Interval};
use crate::analysis::table::Scene;
use crate::analysis::totals::{Estimate, Totals};
use crate::record::rows::CaseKey;
use crate::record::{ClaimRow, NULL_VARIANT, PROGRAM_TIME, Stratum};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A time in the later run divided by the same time in the earlier run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimeChange {
    /// Scene.
    pub scene: String,
    /// Variant id.
    pub variant: String,
    /// `split/axes/leaf`.
    pub policy: String,
    /// `time`, `program-time` or `build`.
    pub metric: String,
    /// Stratum, `all`, or `-` for `build`.
    pub stratum: String,
    /// Total time in the later run over that in the earlier one; above 1, the later run takes longer.
    pub ratio: f64,
    /// Lower end of the 95 % interval; no number of a single cluster or launch, whose spread is unknown.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// `slower`, `faster`, `noise`, or `undecided` when there are too few clusters or launches.
    pub change: String,
}

/// A case with queries whose counts differ between the runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CountChange {
    /// Scene.
    pub scene: String,
    /// Variant id.
    pub variant: String,
    /// `split/axes/leaf`.
    pub policy: String,
    /// Stratum, or `all`.
    pub stratum: String,
    /// Queries that both runs counted.
    pub queries: u64,
    /// Number of those queries whose counts differ.
    pub differing: u64,
    /// Volume tests over all queries that both runs counted, before and after.
    pub volume_tests: (u64, u64),
    /// Triangle tests over the same queries, before and after.
    pub triangle_tests: (u64, u64),
}

/// A tree that differs between the runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TreeChange {
    /// Scene.
    pub scene: String,
    /// Part.
    pub part: String,
    /// Variant id.
    pub variant: String,
    /// `split/axes/leaf`.
    pub policy: String,
    /// Nodes, before and after.
    pub nodes: (u64, u64),
    /// Memory, bytes, before and after.
    pub bytes: (u64, u64),
    /// Looseness over all levels, before and after: volume of the bounding volumes over volume of the convex hulls.
    pub looseness: (f64, f64),
    /// Largest overhang of a level, mm, before and after.
    pub overhang_mm: (f64, f64),
}

/// A case that misses more or fewer contacts of a workload than before.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MissChange {
    /// Scene.
    pub scene: String,
    /// Workload.
    pub workload: String,
    /// Variant id.
    pub variant: String,
    /// `split/axes/leaf`.
    pub policy: String,
    /// Contacts missed above grazing, before and after.
    pub missed: (u64, u64),
    /// Colliding poses, before and after.
    pub colliding: (u64, u64),
    /// Whether the later run misses more. With the same poses, any additional miss counts: fewer in
    /// another workload do not make up for it. With other poses, the rate must lie beyond both intervals, or a safe variant that missed none
    /// must miss at least one.
    pub is_regression: bool,
}

/// A verdict that differs between the runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VerdictChange {
    /// Claim id.
    pub claim: String,
    /// Reading.
    pub reading: String,
    /// Scene.
    pub scene: String,
    /// Workload.
    pub workload: String,
    /// Stratum.
    pub stratum: String,
    /// The earlier verdict.
    pub before: String,
    /// The later one.
    pub after: String,
}

/// Times, counts and trees of a scene with equal inputs.
pub(super) fn of_scene(scene: &mut SceneMatch, before: &Side, after: &Side, comparison: &mut Comparison) {
    if let (Some(old), Some(new)) = (before.scenes.get(&scene.scene), after.scenes.get(&scene.scene)) {
        let (olds, news) = (cases(old), cases(new));
        comparison.only_before.extend(olds.difference(&news).map(|case| case_name(&scene.scene, case)));
        comparison.only_after.extend(news.difference(&olds).map(|case| case_name(&scene.scene, case)));
        let mut logs = Vec::new();
        for &case in olds.intersection(&news) {
            let of_launches = |place, found: Option<Estimate>| {
                found.map(|found| time_change(scene, case, place, found, found.clusters > 1))
            };
            if scene.same_poses {
                let times = of_times(scene, case, new.time_changes(old, case), after);
                logs.extend(times.first().map(|all| all.ratio.ln()));
                comparison.times.extend(times);
                comparison.times.extend(of_launches((PROGRAM_TIME, ALL), new.program_change(old, case)));
                let counts = of_counts(scene, case, old, new);
                comparison.compared.counts += counts.len();
                comparison.counts.extend(counts.into_iter().filter(|row| row.differing > 0));
            }
            comparison.times.extend(of_launches(("build", "-"), new.build_change(old, case)));
        }
        scene.drift = (!logs.is_empty()).then(|| stats::mean(&logs).exp());
    }
    of_trees(&scene.scene, before, after, comparison);
}

/// All cases of a scene except the null duplicate.
fn cases(scene: &Scene) -> BTreeSet<&CaseKey> {
    let cases = scene.timings.keys().chain(scene.queries.keys()).chain(scene.builds.keys());
    cases.filter(|case| case.variant != NULL_VARIANT).collect()
}

/// The change over all strata first, then the change in each stratum.
fn of_times(
    scene: &SceneMatch,
    case: &CaseKey,
    strata: Vec<(Option<Stratum>, Totals)>,
    after: &Side,
) -> Vec<TimeChange> {
    let (seed, purpose) = (after.manifest.request.seed, format!("compare time {}", scene.scene));
    let row = |(stratum, totals): (Option<Stratum>, Totals)| {
        let decides = totals.repeats() > 1 && totals.clusters() >= CLUSTERS_MIN;
        let place = ("time", stratum.map_or(ALL, Stratum::id));
        time_change(scene, case, place, totals.estimate(seed, &purpose), decides)
    };
    strata.into_iter().map(row).collect()
}

/// A ratio of times by metric and stratum, compared with the noise of the scene. What does not decide has too few clusters or launches.
fn time_change(
    scene: &SceneMatch,
    case: &CaseKey,
    (metric, stratum): (&str, &str),
    found: Estimate,
    decides: bool,
) -> TimeChange {
    let Interval { value: ratio, low, high } = found.interval;
    let (low, high) = if found.clusters < 2 { (f64::NAN, f64::NAN) } else { (low, high) };
    let noise = scene.program_noise.filter(|_| metric == PROGRAM_TIME).unwrap_or(scene.noise);
    let change = match () {
        () if !decides => "undecided",
        () if low > noise => "slower",
        () if high < 1.0 / noise => "faster",
        () => "noise",
    };
    TimeChange {
        scene: scene.scene.clone(),
        variant: case.variant.clone(),
        policy: case.policy(),
        metric: metric.to_owned(),
        stratum: stratum.to_owned(),
        ratio,
        low,
        high,
        change: change.to_owned(),
    }
}

/// The sums over all strata and over each stratum, of the queries that both runs counted.
fn of_counts(scene: &SceneMatch, case: &CaseKey, old: &Scene, new: &Scene) -> Vec<CountChange> {
    let mut rows: BTreeMap<Option<Stratum>, CountChange> = BTreeMap::new();
    for (after, before) in new.both_queries(old, case) {
        for stratum in [None, Some(after.stratum)] {
            let row = rows.entry(stratum).or_insert_with(|| CountChange {
                scene: scene.scene.clone(),
                variant: case.variant.clone(),
                policy: case.policy(),
                stratum: stratum.map_or(ALL, Stratum::id).to_owned(),
                queries: 0,
                differing: 0,
                volume_tests: (0, 0),
                triangle_tests: (0, 0),
            });
            let counts = |query: &crate::analysis::table::Query| (query.volume_tests, query.triangle_tests);
            row.queries += 1;
            row.differing += u64::from(counts(before) != counts(after));
            row.volume_tests.0 += before.volume_tests;
            row.volume_tests.1 += after.volume_tests;
            row.triangle_tests.0 += before.triangle_tests;
            row.triangle_tests.1 += after.triangle_tests;
        }
    }
    rows.into_values().collect()
}

/// The properties of a tree that are compared.
#[derive(Clone, Copy, Default)]
struct Shape {
    nodes: u64,
    bytes: u64,
    volume_mm3: f64,
    hull_mm3: f64,
    overhang_mm: f64,
}

impl Shape {
    fn looseness(&self) -> f64 {
        self.volume_mm3 / self.hull_mm3
    }

    /// Exact equality, with NaN equal to NaN: trees without hulls have NaN looseness.
    fn is_as(&self, other: &Self) -> bool {
        let floats = |shape: &Self| [shape.volume_mm3, shape.hull_mm3, shape.overhang_mm].map(f64::to_bits);
        (self.nodes, self.bytes) == (other.nodes, other.bytes) && floats(self) == floats(other)
    }
}

fn shapes(side: &Side, scene: &str) -> BTreeMap<(String, CaseKey), Shape> {
    let mut shapes: BTreeMap<_, Shape> = BTreeMap::new();
    for row in side.trees.iter().filter(|row| row.scene == scene) {
        let shape = shapes.entry((row.part.clone(), row.case())).or_default();
        (shape.nodes, shape.bytes) = (row.nodes, row.bytes);
    }
    for row in side.tightness.iter().filter(|row| row.scene == scene && row.frame == 0) {
        let shape = shapes.entry((row.part.clone(), row.case())).or_default();
        shape.volume_mm3 += row.hulled_volume_mm3;
        shape.hull_mm3 += row.hull_mm3;
        shape.overhang_mm = shape.overhang_mm.max(row.overhang_mm);
    }
    shapes
}

fn of_trees(scene: &str, before: &Side, after: &Side, comparison: &mut Comparison) {
    let (old, new) = (shapes(before, scene), shapes(after, scene));
    let both: Vec<_> = new.iter().filter_map(|(key, new)| Some((key, old.get(key)?, new))).collect();
    comparison.compared.trees += both.len();
    let change = |((part, case), old, new): (&(String, CaseKey), &Shape, &Shape)| TreeChange {
        scene: scene.to_owned(),
        part: part.clone(),
        variant: case.variant.clone(),
        policy: case.policy(),
        nodes: (old.nodes, new.nodes),
        bytes: (old.bytes, new.bytes),
        looseness: (old.looseness(), new.looseness()),
        overhang_mm: (old.overhang_mm, new.overhang_mm),
    };
    comparison.trees.extend(both.into_iter().filter(|(_, old, new)| !old.is_as(new)).map(change));
}

/// Compares misses in a scene, workload by workload, even when its inputs differ, because a safe variant must never miss. A workload in which
/// the earlier run met no contact counts as one without misses.
pub(super) fn of_misses(scene: &SceneMatch, before: &Side, after: &Side, comparison: &mut Comparison) {
    let request = |side: &Side| (side.manifest.request.seed, side.manifest.request.verify_poses);
    let same_poses = scene.not_compared.is_none() && request(before) == request(after);
    let verified = before.misses.verified().filter(|(name, ..)| *name == scene.scene);
    let known: BTreeSet<&CaseKey> = verified.map(|(_, case, ..)| case).collect();
    let of_both = after.misses.iter().filter(|(name, case, ..)| *name == scene.scene && known.contains(case));
    let mut compared = BTreeSet::new();
    for (_, case, workload, new) in of_both {
        compared.insert(case);
        let old = before.misses.in_workload(&scene.scene, case, workload);
        let missed = (old.missed_in_all, new.missed_in_all);
        let colliding = (old.contacts_in_all, new.contacts_in_all);
        let is_safe = after.manifest.variants.iter().any(|variant| variant.id == case.variant && variant.safe);
        let is_regression = if same_poses && colliding.0 == colliding.1 {
            missed.1 > missed.0
        } else {
            (is_safe && missed.0 == 0 && missed.1 > 0) || (new.contacts() > 0 && new.interval().0 > old.interval().1)
        };
        if missed.0 != missed.1 || is_regression {
            comparison.misses.push(MissChange {
                scene: scene.scene.clone(),
                workload: workload.to_owned(),
                variant: case.variant.clone(),
                policy: case.policy(),
                missed,
                colliding,
                is_regression,
            });
        }
    }
    comparison.compared.misses += compared.len();
}

/// Compares verdicts on the same claim, reading, scene and stratum.
pub(super) fn of_verdicts(before: &Side, after: &Side, comparison: &mut Comparison) {
    fn key(row: &ClaimRow) -> [&str; 6] {
        [&row.claim, &row.role, &row.reading, &row.scene, &row.workload, &row.stratum]
    }
    let old: BTreeMap<_, &str> = before.claims.iter().map(|row| (key(row), row.verdict.as_str())).collect();
    for row in &after.claims {
        let Some(&verdict) = old.get(&key(row)) else { continue };
        comparison.compared.verdicts += 1;
        if verdict != row.verdict {
            comparison.verdicts.push(VerdictChange {
                claim: row.claim.clone(),
                reading: row.reading.clone(),
                scene: row.scene.clone(),
                workload: row.workload.clone(),
                stratum: row.stratum.clone(),
                before: verdict.to_owned(),
                after: row.verdict.clone(),
            });
        }
    }
}

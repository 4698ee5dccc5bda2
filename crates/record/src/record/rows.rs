//! The rows. Column names are field names; `results/README.md` is their dictionary for readers.

use super::repeats::{SingleRow, VarianceRow};
use super::sweep::SweepGrowthRow;
use super::vocabulary::{Band, Kind, Stratum};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A row type and the file it lives in.
pub trait Row: Serialize + DeserializeOwned {
    /// The file's name in the run's folder.
    const FILE: &'static str;

    /// Whether the values can be.
    ///
    /// # Errors
    /// What is wrong with the first that cannot.
    fn check(&self) -> Result<(), &'static str> {
        Ok(())
    }
}

impl Row for TimingRow {
    const FILE: &'static str = "timings.csv";

    fn check(&self) -> Result<(), &'static str> {
        if self.ns == 0 || self.passes == 0 {
            return Err("ns and passes must be above 0");
        }
        Ok(())
    }
}

impl Row for BuildRow {
    const FILE: &'static str = "builds.csv";

    fn check(&self) -> Result<(), &'static str> {
        if self.ns == 0 { Err("ns must be above 0") } else { Ok(()) }
    }
}

/// Says which file each row type lives in, and gives the list of the files a name.
macro_rules! row_file {
    ($list:ident: $($row:ty => $file:literal),* $(,)?) => {
        /// The files of these rows.
        pub const $list: &[&str] = &[$($file),*];
        row_file! { $($row => $file),* }
    };
    ($($row:ty => $file:literal),* $(,)?) => { $(impl Row for $row { const FILE: &'static str = $file; })* };
}
pub(super) use row_file;

row_file! { MEASURED:
    CaseRow => "cases.csv",
    PoseRow => "poses.csv",
    AnswerRow => "answers.csv",
    LineRow => "lines.csv",
    MissRow => "misses.csv",
    VerificationRow => "verification.csv",
    TreeRow => "trees.csv",
    TightnessRow => "tightness.csv",
    ExitRow => "exits.csv",
    OutlineRow => "outlines.csv",
    SingleRow => "singles.csv",
}

row_file! { DERIVED:
    ProgramTimeRow => "program_times.csv",
    SummaryRow => "summary.csv",
    RatioRow => "ratios.csv",
    ClaimRow => "claims.csv",
    VarianceRow => "variance.csv",
}

/// What identifies a method and how its trees were built; part of most rows. `split` and `split_axes` are `none` and `leaf` is 0
/// for methods without a tree of ours.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CaseKey {
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// `own` or `shared`.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
}

/// One case: a variant with a tree policy. Every other table names it by `case` or by variant and policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseRow {
    /// Name, unique in the run: `variant@split/axes/leaf`, or the variant's id without a tree of ours.
    pub case: String,
    /// Variant id.
    pub variant: String,
    /// Its name in tables and plots.
    pub label: String,
    /// What kind of thing it is.
    pub kind: Kind,
    /// 1 when the variant promises to miss nothing.
    pub safe: u8,
    /// Split rule; `none` without a tree of ours.
    pub split: String,
    /// `own` or `shared`; `none` without a tree of ours.
    pub split_axes: String,
    /// Leaf size; 0 without a tree of ours.
    pub leaf: u8,
    /// 1 for the variant's default policy.
    pub default: u8,
    /// 1 when the verification asks the case's own query at every pose; 0 when it asks at a sample of them.
    pub asked_everywhere: u8,
    /// The case that this one is a second copy of; empty for all but the null duplicate.
    pub duplicate_of: String,
}

/// One posed pair that is counted or timed. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseRow {
    /// Scene name.
    pub scene: String,
    /// Number within the scene, from 0, in the order of the chunks.
    pub pose: u32,
    /// `a:b`, the two parts.
    pub pair: String,
    /// Workload name within the scene.
    pub workload: String,
    /// File of the program that the pose is a step of, for poses of a whole program (workload `program-time`); else empty.
    pub program: String,
    /// The approach, ray or stretch of a path that the pose lies on, within workload and pair: poses of one line depend on one another.
    pub line: u32,
    /// Number of the pose among the pair's poses of the workload, from 0.
    pub step: u32,
    /// The chunk it is counted and timed in.
    pub chunk: u32,
    /// Distance stratum.
    pub stratum: Stratum,
    /// Depth band.
    pub band: Band,
    /// Distance of the surfaces, mm, or more, but on the same side of the strata's borders; 0 when they touch, empty when it was not sought.
    pub clearance_mm: Option<f64>,
    /// Exact verdict, 0 or 1.
    pub exact: u8,
    /// 1 when the surfaces do not touch but one solid lies inside the other.
    pub contained: u8,
    /// Number of poses of the workload that were judged, of this pair and stratum; empty for whole programs, and in older records.
    pub judged: Option<u32>,
}

/// One answer: one case's own query at one pose. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AnswerRow {
    /// Scene name.
    pub scene: String,
    /// Case, by its name in `cases.csv`.
    pub case: String,
    /// Pose, by its number in `poses.csv`.
    pub pose: u32,
    /// The case's verdict, 0 or 1.
    pub verdict: u8,
    /// Volume overlap tests in mode `first`.
    pub volume_tests: u64,
    /// Triangle tests in mode `first`.
    pub triangle_tests: u64,
}

/// One line of poses of the verification that touches somewhere above grazing. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LineRow {
    /// Scene name.
    pub scene: String,
    /// Workload name.
    pub workload: String,
    /// `a:b`, the two parts.
    pub pair: String,
    /// The line, within workload and pair.
    pub line: u32,
    /// Its contacts above grazing.
    pub contacts: u64,
    /// How many of them are in the sample of poses at which every case is asked.
    pub sampled: u64,
}

/// The contacts above grazing that one case missed on one line; lines without a miss have no row. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissRow {
    /// Scene name.
    pub scene: String,
    /// Case, by its name in `cases.csv`.
    pub case: String,
    /// Workload name.
    pub workload: String,
    /// `a:b`, the two parts.
    pub pair: String,
    /// The line, within workload and pair.
    pub line: u32,
    /// Contacts missed, however the verdict was obtained.
    pub missed: u64,
    /// Contacts missed by the case's own query.
    pub missed_asked: u64,
}

/// How many volume tests of one case end with one axis of the separating-axis test, over all counted queries of one stratum;
/// for variants whose volumes are boxes. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExitRow {
    /// Scene name.
    pub scene: String,
    /// Stratum of the poses.
    pub stratum: Stratum,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// The axis that separates, in the order of the test: 1 to 3 the first box's normals, 4 to 6 the second's, 7 to 15 products
    /// of edges; 0 when none does. A variant that tries fewer axes is told as if it tried all.
    pub axis: u8,
    /// Volume tests that end with it.
    pub tests: u64,
    /// Arithmetic operations of one such test, both boxes given in one frame.
    pub operations: u64,
}

/// Verdicts of one variant over all poses of one band, counted. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerificationRow {
    /// Scene name.
    pub scene: String,
    /// Workload name.
    pub workload: String,
    /// `a:b`, the two parts.
    pub pair: String,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// 1 when the variant promises to miss nothing.
    pub safe: u8,
    /// Depth band.
    pub band: Band,
    /// Posed pairs in the band.
    pub poses: u64,
    /// How many of them the variant's own query answered; the witness argument answered the others.
    pub asked: u64,
    /// How many of those asked touch by the exact test.
    pub asked_exact: u64,
    /// How many of those the variant's own query missed.
    pub asked_missed: u64,
    /// How many touch by the exact test.
    pub exact: u64,
    /// How many touch by the leaves' triangle test; equal to `exact` since that test is exact.
    pub brute: u64,
    /// How many touch by the variant.
    pub tree: u64,
    /// `brute` and not `tree`: the volume's false negatives.
    pub missed_by_volume: u64,
    /// `exact` and not `brute`: the triangle test's; 0 since that test is exact.
    pub missed_by_leaf: u64,
    /// `exact` and not `tree`: all of the variant's false negatives, whoever is to blame.
    pub missed: u64,
    /// `tree` and not `exact`.
    pub false_positives: u64,
}

/// One tree. Deterministic.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TreeRow {
    /// Scene name.
    pub scene: String,
    /// Part the tree is over.
    pub part: String,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Triangles of the part.
    pub triangles: u64,
    /// Nodes of the tree.
    pub nodes: u64,
    /// Leaves among them.
    pub leaves: u64,
    /// Depth of the deepest leaf; the root has depth 0.
    pub depth_max: u32,
    /// Mean depth of a leaf, weighted by its triangles.
    pub depth_mean: f64,
    /// Mean over inner nodes of smaller child count / larger child count, weighted by the node's count; 1 is balanced.
    pub child_ratio: f64,
    /// Sum over nodes of volume area / root area: the expected number of nodes a random line visits.
    pub sah_cost: f64,
    /// Memory, bytes.
    pub bytes: u64,
    /// Shift of the root volume's centre from the middle of the part's extent, mm, along the direction from the
    /// area centroid to the mean of the corners: positive is toward the finely triangulated side.
    pub drift_mm: f64,
    /// Volume of the root, mm³; this and what follows is empty in older records and for what is no binary tree of volumes.
    pub root_volume_mm3: Option<f64>,
    /// Volume of the part's convex hull, mm³; empty when it is flat.
    pub hull_mm3: Option<f64>,
    /// Sum of the surface areas of all volumes, mm².
    pub volumes_area_mm2: Option<f64>,
    /// Area of the part, mm².
    pub part_area_mm2: Option<f64>,
    /// Nodes with a corner outside their volume.
    pub outside_nodes: Option<u64>,
    /// Corners outside their node's volume, counted once for each node that holds them, percent.
    pub outside_corners_pct: Option<f64>,
    /// Largest distance of a corner from its node's volume, mm.
    pub overhang_mm: Option<f64>,
}

/// One level of one tree. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TightnessRow {
    /// Scene name.
    pub scene: String,
    /// Part the tree is over.
    pub part: String,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Frame of the part: 0 its own, others turned at random, the same for all variants.
    #[serde(default)]
    pub frame: u32,
    /// Level; the root is 0.
    pub level: u32,
    /// Nodes on the level.
    pub nodes: u64,
    /// Triangles under them.
    pub triangles: u64,
    /// Sum of the nodes' volumes, mm³.
    pub volume_mm3: f64,
    /// Sum of the nodes' surface areas, mm².
    pub area_mm2: f64,
    /// Sum of the volumes of the convex hulls of the nodes' contents, mm³; over the nodes whose hull has a volume.
    pub hull_mm3: f64,
    /// Sum of the volumes of those same nodes, mm³: `hulled_volume_mm3 / hull_mm3` is the level's looseness.
    pub hulled_volume_mm3: f64,
    /// Corners that lie outside their node's volume, percent.
    pub outside_corners_pct: f64,
    /// Area of triangles with a corner outside their node's volume, percent.
    pub outside_area_pct: f64,
    /// Largest distance of a corner from its node's volume, mm (0 when all are inside).
    pub overhang_mm: f64,
    /// Largest directed Hausdorff distance from a node's volume to the convex hull of its contents, mm; upper levels only.
    pub hausdorff_mm: Option<f64>,
    /// Sum of the volumes that lie in both of two siblings, mm³, by sampling; upper levels only, and not at the root.
    pub sibling_overlap_mm3: Option<f64>,
}

/// A line segment of a drawing: a root volume of a variant on a part, or an edge of the part itself (variant `mesh`).
/// Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutlineRow {
    /// Scene name.
    pub scene: String,
    /// Part drawn.
    pub part: String,
    /// Variant id, or `mesh`.
    pub variant: String,
    /// Coordinate axis along which alone the segment is seen, as part of the silhouette: `x`, `y` or `z`; empty for all.
    pub view: String,
    /// Start, mm, part frame.
    pub x1_mm: f64,
    /// Start, mm, part frame.
    pub y1_mm: f64,
    /// Start, mm, part frame.
    pub z1_mm: f64,
    /// End, mm, part frame.
    pub x2_mm: f64,
    /// End, mm, part frame.
    pub y2_mm: f64,
    /// End, mm, part frame.
    pub z2_mm: f64,
}

/// One timed construction. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BuildRow {
    /// Scene name.
    pub scene: String,
    /// Part the tree is over.
    pub part: String,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Triangles of the part.
    pub triangles: u64,
    /// Binary that ran, by its number in the manifest; 0 in records from before protocol 2.1.
    #[serde(default)]
    pub binary: u32,
    /// Process launch, from 0.
    pub launch: u32,
    /// Block within the launch, from 0.
    pub block: u32,
    /// Wall time, ns.
    pub ns: u64,
}

/// One timed chunk of queries. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimingRow {
    /// Scene name.
    pub scene: String,
    /// Case, by its name in `cases.csv`.
    pub case: String,
    /// Binary that ran, by its number in the manifest; 0 in records from before protocol 2.1.
    #[serde(default)]
    pub binary: u32,
    /// Process launch, from 0.
    pub launch: u32,
    /// Block within the launch, from 0.
    pub block: u32,
    /// Chunk within the scene, from 0; `poses.csv` names its poses, the same for every case, block and launch.
    pub chunk: u32,
    /// How often the chunk was run through to fill the sample.
    pub passes: u32,
    /// Wall time of all passes over the whole chunk, ns.
    pub ns: u64,
}

/// Mean, quantiles and counts of one case in one workload. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SummaryRow {
    /// Scene name.
    pub scene: String,
    /// Workload name.
    pub workload: String,
    /// Stratum, or `all`: every pose of the workload alike; in `recorded`, each pair and stratum with its share of the recording.
    pub stratum: String,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Timed poses.
    pub poses: u64,
    /// Independent groups of lines among them: what intervals are made of.
    pub clusters: u64,
    /// Arithmetic mean time of a query, ns; NaN, like all times of the row, where the case was counted but not timed.
    pub mean_ns: f64,
    /// Lower end of the 95 % interval of the mean, ns.
    pub mean_low_ns: f64,
    /// Upper end, ns.
    pub mean_high_ns: f64,
    /// Poses of which single queries were timed; 0 where none were.
    #[serde(default)]
    pub single_poses: u64,
    /// Median over poses of the time of a single query, warm, with one reading of the clock in it, ns; of each pose the median reading.
    pub query_p50_ns: Option<f64>,
    /// 95th percentile of the same, ns.
    pub query_p95_ns: Option<f64>,
    /// 99th percentile, ns.
    pub query_p99_ns: Option<f64>,
    /// Largest, ns.
    pub query_max_ns: Option<f64>,
    /// Median over chunks of the chunk's mean query time, ns.
    #[serde(alias = "median_ns")]
    pub chunk_median_ns: f64,
    /// 95th percentile of the same, ns.
    #[serde(alias = "p95_ns")]
    pub chunk_p95_ns: f64,
    /// Largest, ns.
    #[serde(alias = "max_ns")]
    pub chunk_max_ns: f64,
    /// Mean volume tests of a query; NaN where nothing was counted.
    pub volume_tests: f64,
    /// Mean triangle tests of a query.
    pub triangle_tests: f64,
    /// Contacts above grazing of the verification that the case's own query was asked about (of scene and workload; repeated on every
    /// stratum's row).
    pub contacts: u64,
    /// How many of them it missed.
    pub missed: u64,
    /// Lower end of the 95 % interval of the miss rate, by line.
    pub miss_rate_low: f64,
    /// Upper end; 3/m when nothing was missed on m lines.
    pub miss_rate_high: f64,
}

impl SummaryRow {
    /// The ends of the interval of the mean, ns; `None` without one, and of a single cluster, whose spread is unknown.
    pub fn interval(&self) -> Option<(f64, f64)> {
        ends(self.clusters, self.mean_low_ns, self.mean_high_ns)
    }
}

/// The ends of an interval; `None` without one, and of a single cluster, whose spread is unknown.
fn ends(clusters: u64, low: f64, high: f64) -> Option<(f64, f64)> {
    (clusters != 1 && low.is_finite() && high.is_finite()).then_some((low, high))
}

/// The time that one case needs for a whole program, up to its first collision: the paper's quantity. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProgramTimeRow {
    /// Scene name.
    pub scene: String,
    /// File of the program, or `all`: the programs of the scene together.
    pub program: String,
    /// `collision` or `end`: where the program ends; `-` for `all`.
    pub ends_at: String,
    /// Queries up to there.
    pub queries: u64,
    /// Variant id.
    pub variant: String,
    /// Split rule.
    pub split: String,
    /// Split axes.
    pub split_axes: String,
    /// Leaf size.
    pub leaf: u8,
    /// Sum of the query times, ns.
    pub total_ns: f64,
    /// Lower end of its 95 % interval over binaries, or over the launches of a single one, ns.
    pub total_low_ns: f64,
    /// Upper end, ns.
    pub total_high_ns: f64,
    /// Case that it is compared with: the first baseline under its default policy.
    pub baseline: String,
    /// Total over the baseline's total; empty without a baseline.
    pub ratio: Option<f64>,
    /// Lower end of its 95 % interval.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

/// A ratio of two cases: of totals, paired. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RatioRow {
    /// Scene name.
    pub scene: String,
    /// Workload name; `program-time` and `program-time-cold` for the metrics of these names; `-` for `build`.
    pub workload: String,
    /// Stratum, or `all`; for whole programs the program's file, or `all`; `-` for `build`.
    pub stratum: String,
    /// `program-time`, `program-time-cold`, `time`, `volume-tests`, `triangle-tests` or `build`.
    pub metric: String,
    /// Variant on top.
    pub variant: String,
    /// Its policy, `split/axes/leaf`.
    pub policy: String,
    /// Variant below.
    pub baseline: String,
    /// Its policy.
    pub baseline_policy: String,
    /// Ratio of the totals; below 1 means that `variant` needs less.
    pub ratio: f64,
    /// Lower end of the 95 % bootstrap interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Independent clusters that were resampled: groups of lines, launches or binaries, blocks or binaries.
    pub clusters: u64,
    /// `less`, `same` (the interval lies within 5 % of 1), `more` or `unclear`.
    pub effect: String,
    /// 1 when the null duplicate is not within 1 % of its original in this scene, workload and stratum: nothing is decided here.
    pub noisy: u8,
}

impl RatioRow {
    /// The ends of the interval; `None` without one, and of a single cluster, whose spread is unknown.
    pub fn interval(&self) -> Option<(f64, f64)> {
        ends(self.clusters, self.low, self.high)
    }
}

/// The verdict on one claim, for one reading, scene, workload and stratum. Derived.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClaimRow {
    /// Claim id in `claims.toml`.
    pub claim: String,
    /// `primary`: the one row that answers the sentence; `exploratory`: all others.
    pub role: String,
    /// Reading: R1, R2, R3, or `-`.
    pub reading: String,
    /// Scene name; in a primary row all of its scenes, with `+` between them.
    pub scene: String,
    /// Workload name, `program-time`, or `-` where the claim is not about queries.
    pub workload: String,
    /// Stratum, `all`, a program's file, or `-` where the claim is not about queries.
    pub stratum: String,
    /// `supported`, `refuted`, `undecided`, `not-applicable`, `not-judged`.
    pub verdict: String,
    /// `less`, `same`, `more`, `unclear`; `-` where nothing is compared.
    pub effect: String,
    /// What was measured, in words: `time obb-area / obb-vertex`.
    pub measure: String,
    /// Its value.
    pub value: Option<f64>,
    /// Lower end of its interval.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// In primary rows: probability of data at least as far beyond the threshold if the truth were on it, after Holm's correction.
    pub p_holm: Option<f64>,
    /// Misses of the claim's variant above grazing, by its own queries.
    pub missed: Option<u64>,
    /// Misses of its baseline.
    pub baseline_missed: Option<u64>,
    /// What a reader should know beside the verdict.
    pub note: String,
}

impl ClaimRow {
    /// An exploratory row without reading, place, effect, measure or numbers.
    pub fn blank(claim: &str, verdict: &str) -> Self {
        let none = || "-".to_owned();
        Self {
            claim: claim.to_owned(),
            role: "exploratory".to_owned(),
            reading: none(),
            scene: none(),
            workload: none(),
            stratum: none(),
            verdict: verdict.to_owned(),
            effect: none(),
            measure: none(),
            ..Self::default()
        }
    }
}

macro_rules! case_key {
    ($($row:ty),* $(,)?) => { $(impl $row {
        /// The method and tree policy of the row.
        pub fn case(&self) -> CaseKey {
            CaseKey { variant: self.variant.clone(), split: self.split.clone(), split_axes: self.split_axes.clone(), leaf: self.leaf }
        }
    })* };
}

case_key!(
    CaseRow,
    ExitRow,
    VerificationRow,
    TreeRow,
    TightnessRow,
    BuildRow,
    SummaryRow,
    ProgramTimeRow,
    VarianceRow,
    SweepGrowthRow
);

impl CaseRow {
    /// The row of a case that is the only one of its variant and is asked everywhere.
    pub fn new(key: CaseKey, label: impl Into<String>, kind: Kind, safe: bool) -> Self {
        Self {
            case: key.name(),
            variant: key.variant,
            label: label.into(),
            kind,
            safe: u8::from(safe),
            split: key.split,
            split_axes: key.split_axes,
            leaf: key.leaf,
            default: 1,
            asked_everywhere: 1,
            duplicate_of: String::new(),
        }
    }
}

impl TimingRow {
    /// Id of the variant of its case.
    pub fn variant(&self) -> &str {
        self.case.split('@').next().unwrap_or(&self.case)
    }
}

impl CaseKey {
    /// A method without a tree of ours.
    pub fn without_tree(variant: &str) -> Self {
        let none = || "none".to_owned();
        Self { variant: variant.to_owned(), split: none(), split_axes: none(), leaf: 0 }
    }

    /// Name in `cases.csv`: `variant@split/axes/leaf`, or the variant's id without a tree of ours.
    pub fn name(&self) -> String {
        if self.split == "none" { self.variant.clone() } else { format!("{}@{}", self.variant, self.policy()) }
    }

    /// `split/axes/leaf`.
    pub fn policy(&self) -> String {
        format!("{}/{}/{}", self.split, self.split_axes, self.leaf)
    }
}

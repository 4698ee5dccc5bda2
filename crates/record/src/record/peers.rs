//! The rows of a comparison of engines: other libraries' and our own variants, each in a process of its own.

use super::rows::{Row, row_file};
use super::vocabulary::Stratum;
use serde::{Deserialize, Serialize};

row_file! {
    PeerBuildRow => "peer-builds.csv",
    PeerTimingRow => "peer-timings.csv",
    PeerAnswerRow => "peer-answers.csv",
    PeerRow => "peers.csv",
    PeerRatioRow => "peer-ratios.csv",
}

/// Stratum column of the rows that stand for all strata together.
pub const ALL_STRATA: &str = "all";

/// Constructions of an engine's structures over both meshes of a pair, the median of a round. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PeerBuildRow {
    /// Engine.
    pub engine: String,
    /// Scene name.
    pub scene: String,
    /// `a:b`, the two parts.
    pub pair: String,
    /// Mode.
    pub mode: String,
    /// Round.
    pub round: u32,
    /// Wall time of both, ns.
    pub ns: u64,
    /// Memory held by both, bytes, by the engine's own account; 0 when it gives none.
    pub bytes: u64,
    /// Triangles of both.
    pub triangles: u64,
}

/// One pass of an engine over a chunk. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PeerTimingRow {
    /// Engine.
    pub engine: String,
    /// Scene name.
    pub scene: String,
    /// `a:b`, the two parts.
    pub pair: String,
    /// Mode.
    pub mode: String,
    /// Distance stratum; in mode `path` that of the first pose.
    pub stratum: Stratum,
    /// Number of the chunk within the pair.
    pub chunk: u32,
    /// Poses in the chunk.
    pub poses: u32,
    /// Round, from 0; the warm-up round is not recorded.
    pub round: u32,
    /// Wall time of one pass over all poses, ns.
    pub ns: u64,
}

/// An engine's answer to one pose. The answer is deterministic where the engine is, the time is noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PeerAnswerRow {
    /// Engine.
    pub engine: String,
    /// Scene name.
    pub scene: String,
    /// `a:b`, the two parts.
    pub pair: String,
    /// Mode.
    pub mode: String,
    /// Number of the pose within the pair, from 0.
    pub pose: u32,
    /// The approach, ray or stretch of a path that the pose lies on, numbered within the pair; in mode `path` that of the chunk's first pose, in mode `motion`
    /// each motion is one. Absent from older records, where each pair is taken for one line.
    #[serde(default)]
    pub line: u32,
    /// Number of its chunk within the pair.
    pub chunk: u32,
    /// Distance stratum of the chunk.
    pub stratum: Stratum,
    /// 1 when the surfaces touch, exactly; in mode `motion` at some time of it.
    pub exact: u8,
    /// 1 when they are within 1e-6 mm of first contact, so that either answer is right; in mode `motion` when they come within some 1e-3 mm without a sure contact.
    pub grazing: u8,
    /// 1 when they touch by the engine.
    pub touching: u8,
    /// What the engine says in modes `all` (touching pairs of triangles), `distance` (mm) and `motion` (time of first contact, 0 to 1; empty without).
    pub value: Option<f64>,
    /// What is true in these modes.
    pub true_value: Option<f64>,
    /// Median over the rounds of the time for this pose alone, one reading of the clock included, ns.
    pub ns: u64,
}

/// An engine on a scene and stratum. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PeerRow {
    /// Engine.
    pub engine: String,
    /// Scene name.
    pub scene: String,
    /// Distance stratum, or [`ALL_STRATA`].
    pub stratum: String,
    /// Poses.
    pub poses: u64,
    /// Mean time of a pose in a pass over its chunk, ns.
    pub mean_ns: f64,
    /// Median of the times of single poses, ns.
    pub median_ns: f64,
    /// 99 % quantile of the times of single poses, ns.
    pub p99_ns: f64,
    /// Poses whose surfaces touch, not grazing, of which the engine says they do not.
    pub false_negatives: u64,
    /// Poses whose surfaces do not touch, not grazing, of which the engine says they do.
    pub false_positives: u64,
    /// Median time of a construction, over all pairs of the scene, ns.
    pub build_ns: u64,
    /// Memory held for all pairs of the scene, bytes; 0 when unknown.
    pub bytes: u64,
    /// Triangles of the parts that `build_ns` and `bytes` are about.
    pub triangles: u64,
    /// Mode.
    pub mode: String,
    /// In mode `distance` the largest error of a distance, mm; in mode `all` the largest error of a number of touching pairs; in mode `motion` of a time of first contact;
    /// empty in the other modes. Grazing poses are left out.
    pub largest_error: Option<f64>,
}

/// How many times faster an engine is than the one it is held against. Derived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PeerRatioRow {
    /// Engine.
    pub engine: String,
    /// The engine it is held against.
    pub reference: String,
    /// Scene name.
    pub scene: String,
    /// Distance stratum, or [`ALL_STRATA`].
    pub stratum: String,
    /// Mode.
    pub mode: String,
    /// Mean time of the reference over that of the engine, on the same poses: above 1 the engine is faster.
    pub ratio: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// The reference's 99 % quantile over that of the engine.
    pub p99_ratio: f64,
}

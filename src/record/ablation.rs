//! Rows of the experiment on the octree method: what each part of it saves.

use super::rows::{Row, row_file};
use serde::{Deserialize, Serialize};

row_file! {
    AblationRow => "ablation.csv",
    AblationKindRow => "ablation_kinds.csv",
    AblationTimeRow => "ablation_times.csv",
}

/// Counts of one form of the method over one surface, of the poses that hit or of those that do not. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AblationRow {
    /// What is varied: `parts`, `cap`, `depth`, `spacing`, `step` or `size`.
    pub sweep: String,
    /// The surface.
    pub surface: String,
    /// Spacing of the samples, mm.
    pub spacing_mm: f64,
    /// Their covering radius, mm.
    pub covering_mm: f64,
    /// Samples; of a variant the triangles of the surface.
    pub points: u64,
    /// Most points of a leaf.
    pub cap: u32,
    /// Greatest depth.
    pub depth: u8,
    /// Gray octants.
    pub octants: u64,
    /// Memory of the octree with its points, bytes.
    pub bytes: u64,
    /// `points`, `leaves` or `octree`; or the id of the variant whose trees over both meshes answer.
    pub search: String,
    /// `none`, `profile4`, `axial4` or `quad4`.
    pub second_level: String,
    /// Whether the tool is widened by the covering radius, 0 or 1.
    pub safe: u8,
    /// Whether the last colliding leaf is asked first, 0 or 1.
    pub coherence: u8,
    /// Mean distance of the tool's tip from pose to pose, mm.
    pub step_mm: f64,
    /// Whether these poses are those that the method calls interfering, 0 or 1.
    pub hit: u8,
    /// Poses.
    pub poses: u64,
    /// Separating-axis tests of level 1, in total; of a variant its volume tests.
    pub first_level: u64,
    /// Of level 2.
    pub second_level_tests: u64,
    /// Points held against a body's profile; of a variant its triangle tests.
    pub point_tests: u64,
    /// Queries that coherence answered.
    pub recalled: u64,
    /// Poses at which the meshes of tool and surface touch, exactly.
    pub touching: u64,
    /// Of those, the ones the method does not call interfering.
    pub missed: u64,
}

/// Local interference (of the cutter) or global (of shank and holder) over one surface. Deterministic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AblationKindRow {
    /// The surface.
    pub surface: String,
    /// `local` or `global`.
    pub kind: String,
    /// As in [`AblationRow`].
    pub safe: u8,
    /// Poses.
    pub poses: u64,
    /// Poses at which the meshes of these parts of the tool and of the surface touch, exactly.
    pub touching: u64,
    /// Poses at which the method says so.
    pub found: u64,
    /// Poses at which they touch and it does not.
    pub missed: u64,
}

/// Time of one form over one surface. Noisy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AblationTimeRow {
    /// As in [`AblationRow`].
    pub sweep: String,
    /// The surface.
    pub surface: String,
    /// Spacing of the samples, mm.
    pub spacing_mm: f64,
    /// As in [`AblationRow`].
    pub points: u64,
    /// Most points of a leaf.
    pub cap: u32,
    /// Greatest depth.
    pub depth: u8,
    /// As in [`AblationRow`].
    pub search: String,
    /// As in [`AblationRow`].
    pub second_level: String,
    /// As in [`AblationRow`].
    pub safe: u8,
    /// As in [`AblationRow`].
    pub coherence: u8,
    /// As in [`AblationRow`].
    pub step_mm: f64,
    /// Which round: within one every form runs once over all poses, in a fresh order.
    pub round: u32,
    /// Poses.
    pub poses: u64,
    /// Time of all poses, ns.
    pub ns: u64,
    /// Time to sample the surface and build the octree, ns.
    pub build_ns: u64,
}

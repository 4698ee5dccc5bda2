//! Workloads: pairs and the relative poses they are examined at.

use crate::geometry::Isometry;
use crate::scene::Pair;

/// Where a workload's poses come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The scene's G-code program.
    Program,
    /// Approaches along given directions, stopped at prescribed offsets from first contact.
    Approach,
    /// Random orientations and directions, at random offsets from first contact.
    Random,
    /// A CSV of recorded poses.
    Recorded,
}

/// One relative pose of a pair.
#[derive(Clone, Debug)]
pub struct PosedPair {
    /// Part `b` in the frame of part `a`.
    pub a_from_b: Isometry,
    /// Poses of one cluster depend on one another (one run of the tool path, one approach): the unit of resampling.
    pub cluster: u32,
    /// Line of the program, where there is one.
    pub line: Option<u32>,
    /// Travel past first contact, mm, negative before it, where the workload prescribed it. Poses along a path have none;
    /// there it is found by [`crate::truth`].
    pub depth_mm: Option<f64>,
}

/// The poses of one pair, in order.
#[derive(Clone, Debug)]
pub struct PairPoses {
    /// The pair.
    pub pair: Pair,
    /// Its poses; consecutive ones of a path lie side by side.
    pub poses: Vec<PosedPair>,
}

/// Named poses of one or more pairs.
#[derive(Clone, Debug)]
pub struct Workload {
    /// Name, unique in the scene.
    pub name: String,
    /// Where the poses come from.
    pub source: Source,
    /// Poses, pair by pair.
    pub pairs: Vec<PairPoses>,
}

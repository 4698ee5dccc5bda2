//! The trait of volumes that have lanes, of which trees are made.
//!
//! To add one, write a file beside `oriented`, `aligned` and `ball` with a type that implements [`WideVolume`] and name it in a `mod` line of
//! the engine's `mod.rs`. Building, traversal, distance, coherence and checks come with the tree.
//!
//! What a volume promises. In real numbers it contains the corners it was fitted to. Where a gap that its relation computes is more than
//! u(`PER_DISTANCE`·D + `PER_REACH`·(A + B)), the contents are apart, with u = 2⁻²⁴, D = |s| + |c| the distances of both centres from the node's origin, A
//! and B the reaches; the proof stands in its file. The slack that the tree takes off (`slack_of`) is that, and what the pose
//! needs ([`super::pose`]). Nothing here is an absolute length: scaled data give scaled slacks.

use super::lanes::{FOUR, Lanes};
use super::node::WIDTH;
use super::plain::Plain;
use super::pose::Motion;
use super::visit::Visits;
use crate::engine::geometry::Point;
use nalgebra::Matrix3;
use std::fmt::Debug;

/// Unit roundoff of `f32`: 2⁻²⁴.
pub const U: f32 = 1.0 / 16_777_216.0;
/// Per mm of distance, in units of [`U`].
const PER_DISTANCE: f32 = 43.0;
/// Per mm of reach, in units of [`U`].
const PER_REACH: f32 = 54.0;

/// A volume of which eight stand side by side, in `f32`, mm, relative to the origin of the node that holds them.
pub trait WideVolume: Copy + Debug + Send + Sync + 'static {
    /// Whether it may be turned: whether [`WideVolume::fit`] wants other axes than the mesh's.
    const TURNS: bool;
    /// Eight of them: a row for each of their numbers.
    type Eight: AsRef<[[f32; WIDTH]]> + Clone + Debug + Default + Send + Sync;
    /// What there is of one for each visit but its centre, once it has been moved into the other mesh's frame.
    type Moved<L: Lanes>: Copy;
    /// One of them and eight of the other mesh, in lanes.
    type Relation<L: Lanes>: Relation<L>;

    /// One that contains all `corners` (of patches, mm, mesh frame), along `axes` (columns of a rotation) if it is turned.
    fn fit(axes: &Matrix3<f64>, origin: [f32; 3], corners: impl Iterator<Item = [Point; 4]> + Clone) -> Self;

    /// Its middle, mm.
    fn centre(&self) -> [f32; 3];

    /// The sum of the lengths that enter a reach, mm: half-lengths, a radius.
    fn reach(&self) -> f32;

    /// What tells which of two is the larger and is opened: any measure that grows with the extent.
    fn size(&self) -> f32;

    /// Puts it into a place of eight.
    fn put(&self, eight: &mut Self::Eight, place: usize);

    /// The one in a place.
    fn get(eight: &Self::Eight, place: usize) -> Self;

    /// What there is of each visit's one volume but its centre, moved; and their reaches, mm.
    fn moved<'a, L: Lanes>(one: &impl Fn(usize) -> Self, motion: &impl Fn(usize) -> &'a Motion) -> (Self::Moved<L>, L);

    /// The relation of each visit's one volume to the eight of its node, or to a part of them.
    fn relation<L: Lanes>(part: usize, visits: &Visits<Self, L>) -> Self::Relation<L>;

    /// The same volume in `f64`; `origin` is that of the node that holds it.
    fn plain(&self, origin: [f32; 3]) -> Plain;
}

/// One volume and some others, lane by lane. A gap is the distance of two volumes along some axis less the reach of both along it, mm: less
/// than 0 where they overlap on it.
pub trait Relation<L> {
    /// Gaps that are quickly found, of which each is a lower bound of [`Relation::gap`].
    fn quick_gaps(&self) -> [L; 3];

    /// The largest gap; `quick_gaps` are those of [`Relation::quick_gaps`].
    fn gap(&self, quick_gaps: [L; 3]) -> L;

    /// A bit for each of the others that is larger than the one volume, as [`WideVolume::size`] measures.
    fn larger(&self) -> u32;

    /// A lower bound of the distance of the contents, mm, at least 0. No gap may count for more than it is without `slack`, and all rounding after
    /// that is paid for. Where the square of a quick bound is `enough`, no better one is looked for.
    fn least_mm(&self, slack: L, enough: impl Fn(L) -> bool) -> L;
}

/// The point `centre` from a node's origin, mm, mesh frame.
pub(super) fn point(origin: [f32; 3], centre: [f32; 3]) -> Point {
    let from = |x: [f32; 3]| Point::from(x.map(f64::from));
    from(origin) + from(centre).coords
}

/// Three numbers in a row; the last is nothing.
#[inline(always)]
pub(super) const fn row([x, y, z]: [f32; 3]) -> [f32; FOUR] {
    [x, y, z, 0.0]
}

/// What a volume contributes to the slack, mm, by the distance of its centre from the node's origin (or the sum of its coordinates, which is
/// more) and by its reach, mm.
#[inline(always)]
pub(super) fn slack_of(distance: f32, reach: f32) -> f32 {
    U * (PER_DISTANCE * distance + PER_REACH * reach)
}

/// The same in lanes, and what else there is.
#[inline(always)]
pub(super) fn slacks_of<L: Lanes>(distance: L, reach: L, else_mm: L) -> L {
    distance.mul_add(L::all(U * PER_DISTANCE), reach.mul_add(L::all(U * PER_REACH), else_mm))
}

//! The k-DOP: slabs along fixed directions, posed by cone duality; generic over the directions.
//!
//! J. T. Klosowski, M. Held, J. S. B. Mitchell, H. Sowizral, K. Zikan, "Efficient Collision Detection Using Bounding
//! Volume Hierarchies of k-DOPs", IEEE TVCG 4(1), 1998. Deviations: directions are unit vectors; each tree stays in its
//! mesh's frame, and instead of refitting a node in the other frame its extent along a foreign direction is bounded from
//! above ([`Posed`]). All directions of both meshes are tried, so the test is symmetric.
//!
//! The bound: write the foreign direction as e = Σ wⱼ uⱼ over three of the volume's own directions. Every point x of
//! the volume has |uⱼ·x - mⱼ| ≤ hⱼ, therefore e·x lies within Σ |wⱼ| hⱼ of Σ wⱼ mⱼ. That holds for any such three; the
//! tightest have Σ |wⱼ| small, which are those whose cone contains e ([`cones`]). It is weak linear-programming duality:
//! one choice per direction and pose serves every node, and per pair of nodes a direction costs a few multiply-adds.

pub mod cones;
pub mod dop_8;
mod facets;

use super::{BoundingVolume, Info, Segment, coordinate_axes_by_extent, rounding_pad};
use crate::geometry::{Isometry, Point, Triangle, Vector, triangle};
use cones::Cones;
use nalgebra::Unit;
use std::fmt::Debug;
use std::marker::PhantomData;

/// `N` directions, none parallel to another, that make a k-DOP of k = 2 `N`.
///
/// The sum of u uᵀ over the directions must be a multiple of the identity, as it is for every set that is symmetric
/// under permutations and sign changes of the coordinates.
pub trait Directions<const N: usize>: Clone + Debug + Send + Sync + 'static {
    /// Name, reference and promise of the variant.
    const INFO: Info;
    /// The unit directions and what depends on them alone; computed once per program.
    fn cones() -> &'static Cones<N>;
}

/// A slab along each of `N` directions: middle and half-width, mm, mesh frame.
#[derive(Clone, Debug)]
pub struct Dop<D, const N: usize> {
    middle: [f64; N],
    half: [f64; N],
    directions: PhantomData<D>,
}

/// A direction of one mesh, as seen by the volumes of the other.
#[derive(Clone, Copy, Debug)]
struct Posed {
    /// The three of the other mesh's directions that it is a combination of.
    slabs: [usize; 3],
    /// With these factors.
    weights: [f64; 3],
    /// What the translation adds, mm.
    shift: f64,
}

/// Both meshes' directions, each as seen by the other mesh.
#[derive(Clone, Debug)]
pub struct DopPose<const N: usize> {
    /// Directions of the left mesh, combined from those of the right one.
    of_left: [Posed; N],
    /// Directions of the right mesh, combined from those of the left one.
    of_right: [Posed; N],
}

impl Posed {
    /// Middle and half-width of a volume along this direction, mm, before the shift.
    #[inline(always)]
    fn extent<D, const N: usize>(&self, dop: &Dop<D, N>) -> (f64, f64) {
        let ([i, j, k], [u, v, w]) = (self.slabs, self.weights);
        (
            u * dop.middle[i] + v * dop.middle[j] + w * dop.middle[k],
            u.abs() * dop.half[i] + v.abs() * dop.half[j] + w.abs() * dop.half[k],
        )
    }
}

impl<D: Directions<N>, const N: usize> BoundingVolume for Dop<D, N> {
    const INFO: Info = D::INFO;

    type Pose = DopPose<N>;

    fn fit(triangles: &[Triangle]) -> Self {
        let directions = D::cones().directions();
        let (mut low, mut high) = ([f64::INFINITY; N], [f64::NEG_INFINITY; N]);
        for corner in triangle::corners(triangles) {
            for (i, direction) in directions.iter().enumerate() {
                let along = direction.dot(&corner.coords);
                low[i] = low[i].min(along);
                high[i] = high[i].max(along);
            }
        }
        let middle: [f64; N] = std::array::from_fn(|i| f64::midpoint(low[i], high[i]));
        let half: [f64; N] = std::array::from_fn(|i| 0.5 * (high[i] - low[i]));
        let farthest = middle.iter().fold(0.0, |most: f64, m| most.max(m.abs()));
        let pad = rounding_pad(farthest + half.iter().sum::<f64>());
        Self { middle, half: half.map(|h| h + pad), directions: PhantomData }
    }

    fn pose(a_from_b: &Isometry) -> DopPose<N> {
        let cones = D::cones();
        let directions = cones.directions();
        let rotation = a_from_b.rotation.to_rotation_matrix().into_inner();
        let translation = a_from_b.translation.vector;
        let posed = |e: &Vector, shift: f64| {
            let (slabs, weights) = cones.combination(e);
            Posed { slabs, weights, shift }
        };
        DopPose {
            of_left: std::array::from_fn(|i| posed(&rotation.tr_mul(&directions[i]), directions[i].dot(&translation))),
            of_right: std::array::from_fn(|i| {
                let in_left = rotation * directions[i];
                posed(&in_left, in_left.dot(&translation))
            }),
        }
    }

    #[inline]
    fn overlaps(&self, other: &Self, pose: &DopPose<N>) -> bool {
        for (i, posed) in pose.of_left.iter().enumerate() {
            let (middle, half) = posed.extent(other);
            if (middle + posed.shift - self.middle[i]).abs() > self.half[i] + half {
                return false;
            }
        }
        for (i, posed) in pose.of_right.iter().enumerate() {
            let (middle, half) = posed.extent(self);
            if (other.middle[i] + posed.shift - middle).abs() > other.half[i] + half {
                return false;
            }
        }
        true
    }

    /// Slack is taken per slab: a point within it of every slab counts as within it of the volume, which near a sharp
    /// corner it may not quite be.
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        let slabs = self.middle.iter().zip(&self.half);
        D::cones()
            .directions()
            .iter()
            .zip(slabs)
            .all(|(direction, (m, h))| (direction.dot(&point.coords) - m).abs() <= h + slack_mm)
    }

    /// The point with the smallest sum of squared distances from the middle planes of the slabs. With unit directions
    /// and Σ u uᵀ = (N/3) I that is (3/N) Σ m u.
    fn centre(&self) -> Point {
        let sum: Vector = D::cones().directions().iter().zip(&self.middle).map(|(direction, m)| direction * *m).sum();
        Point::from(sum * (3.0 / N as f64))
    }

    /// The sum of the pyramids over the facets: area times distance of the facet's plane over three.
    fn volume(&self) -> f64 {
        let (centre, directions) = (self.centre(), D::cones().directions());
        let mut volume = 0.0;
        self.for_each_facet(|slab, side, corners| {
            let distance = side * (self.middle[slab] - directions[slab].dot(&centre.coords)) + self.half[slab];
            volume += facets::area(corners) * distance / 3.0;
        });
        volume
    }

    fn surface_area(&self) -> f64 {
        let mut area = 0.0;
        self.for_each_facet(|_, _, corners| area += facets::area(corners));
        area
    }

    /// The directions of a k-DOP are not orthogonal, so it has no frame to offer: the coordinate axes, by the extent of
    /// the contents.
    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        let extents = triangle::bounds(triangles).map_or_else(Vector::zeros, |(low, high)| high - low);
        coordinate_axes_by_extent(&extents)
    }

    /// The edges of all facets, each edge once from either side.
    fn outline(&self) -> Vec<Segment> {
        let mut segments = Vec::new();
        self.for_each_facet(|_, _, corners| {
            for (i, corner) in corners.iter().enumerate() {
                segments.push([*corner, corners[(i + 1) % corners.len()]]);
            }
        });
        segments
    }
}

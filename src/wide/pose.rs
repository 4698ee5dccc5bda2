//! The constants of one relative pose, and a box of one mesh seen from a node of the other.

use super::code::Code;
use super::node::Node;
use super::turn;
use crate::geometry::{Isometry, Vector, grid};
use nalgebra::Matrix3;

/// Unit roundoff of `f32`: 2⁻²⁴.
pub(super) const U: f32 = 1.0 / 16_777_216.0;
/// Per mm of distance, in units of [`U`]: see [`super::boxes`].
pub(super) const PER_DISTANCE: f32 = 29.0;
/// Per mm of half-length, in units of [`U`]: see [`super::boxes`].
pub(super) const PER_HALF: f32 = 18.0;

/// Rounding in `f64` of a moved point or box, relative to the distances involved: 2⁻⁴⁴, five hundred times 2⁻⁵³; the
/// products and sums of a motion and its inverse are fewer than a hundred.
const MOTION_PAD: f64 = 1.0 / 17_592_186_044_416.0;
/// How much of a rotation matrix's defect counts: it enters the fifteen axes at most 28 times ([`super::boxes`]), and the points themselves
/// three times.
const DEFECT_FACTOR: f64 = 64.0;

/// A motion from one mesh's frame to the other's.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    rotation: Matrix3<f64>,
    translation: Vector,
}

/// Both motions, and the slack that they and the snapping of moved corners need.
#[derive(Clone, Debug)]
pub(super) struct Pose {
    pub a_from_b: Motion,
    pub b_from_a: Motion,
    /// How far, mm, a corner that the leaves see may be from where an exact motion of its box would have it.
    pub slack: f32,
}

impl Pose {
    /// `reach` is the sum of both meshes' largest distances from their origins, mm.
    ///
    /// The truth moves a corner of `b` by the matrix R as it stands in `f64`, adds, rounds and snaps it to the grid, which moves it by up to
    /// [`grid::SNAP_RADIUS_MM`]. R is orthogonal up to a defect max|RᵀR - I|, measured here; seen from `b`, by Rᵀ, points
    /// of `a` are misplaced in proportion to it.
    pub fn new(a_from_b: &Isometry, reach: f64) -> Self {
        let rotation = a_from_b.rotation.to_rotation_matrix().into_inner();
        let translation = a_from_b.translation.vector;
        let back = rotation.transpose();
        let defect = (back * rotation - Matrix3::identity()).amax();
        let slack = Self::slack(&translation, reach, defect);
        Self {
            b_from_a: Motion { translation: -(back * translation), rotation: back },
            a_from_b: Motion { rotation, translation },
            slack: slack as f32 * (1.0 + 4.0 * U),
        }
    }

    /// The slack for balls moved by the unit quaternion itself, whose defect is that of its length squared, mm.
    #[inline]
    pub fn ball_slack(a_from_b: &Isometry, reach: f64) -> f64 {
        let defect = (a_from_b.rotation.coords.norm_squared() - 1.0).abs();
        Self::slack(&a_from_b.translation.vector, reach, 4.0 * defect)
    }

    fn slack(translation: &Vector, reach: f64, defect: f64) -> f64 {
        grid::SNAP_RADIUS_MM + (DEFECT_FACTOR * defect + MOTION_PAD) * (reach + translation.abs().sum())
    }
}

/// A box of the other mesh in the frame of a node, relative to the node's origin: centre, axes, half-lengths and slack, mm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    pub centre: [f32; 3],
    pub axes: [[f32; 3]; 3],
    pub half: [f32; 3],
    pub slack: f32,
}

impl Seen {
    /// The box `code`, relative to `origin`, moved by `motion` and seen from `node`.
    #[inline(always)]
    pub fn new(motion: &Motion, code: &Code, origin: &[f32; 3], node: &Node, pose_slack: f32) -> Self {
        let own = turn::decode(code.turn);
        let r = &motion.rotation;
        let p: [f64; 3] = std::array::from_fn(|k| f64::from(origin[k]) + f64::from(code.centre[k]));
        let mut seen = Self { half: code.half, ..Self::default() };
        let mut distance = 0.0;
        for k in 0..3 {
            let centre = (r[(k, 0)] * p[0] + r[(k, 1)] * p[1])
                + (r[(k, 2)] * p[2] + (motion.translation[k] - f64::from(node.origin[k])));
            seen.centre[k] = centre as f32;
            distance += seen.centre[k].abs();
            for i in 0..3 {
                seen.axes[i][k] = (r[(k, 0)] * own[(0, i)] + r[(k, 1)] * own[(1, i)] + r[(k, 2)] * own[(2, i)]) as f32;
            }
        }
        let half = code.half[0] + code.half[1] + code.half[2];
        seen.slack = U * (PER_DISTANCE * distance + PER_HALF * half) + pose_slack;
        seen
    }
}

//! The constants of one relative pose, and a box of one mesh seen from a node of the other.

use super::code::Code;
use super::lanes::{DOUBLES, DoubleLanes, three};
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
    /// The columns of the rotation, each in as many lanes as there are.
    rotation: [[f64; DOUBLES]; 3],
    translation: [f64; DOUBLES],
}

impl Motion {
    fn new(rotation: &Matrix3<f64>, translation: &Vector) -> Self {
        let lanes = |v: [f64; 3]| [v[0], v[1], v[2], 0.0];
        Self {
            rotation: [0, 1, 2].map(|j| lanes(rotation.column(j).into_owned().into())),
            translation: lanes((*translation).into()),
        }
    }

    /// The columns of the rotation, each times its coordinate of `v`: the sum is where it turns `v` to.
    #[inline(always)]
    fn turn<D: DoubleLanes>(&self, v: [f64; 3]) -> [D; 3] {
        three!(j => D::load(&self.rotation[j]) * D::all(v[j]))
    }
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
            b_from_a: Motion::new(&back, &-(back * translation)),
            a_from_b: Motion::new(&rotation, &translation),
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

/// A box of the other mesh in the frame of a node, relative to the node's origin: centre, axes, half-lengths and slack, mm. What is
/// found in lanes stays in lanes; the fourth is nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    pub centre: [f32; DOUBLES],
    pub axes: [[f32; DOUBLES]; 3],
    pub half: [f32; 3],
    pub slack: f32,
}

impl Seen {
    /// The box `code`, relative to `origin`, moved by `motion` and seen from `node`.
    #[inline(always)]
    pub fn new<D: DoubleLanes>(motion: &Motion, code: &Code, origin: &[f32; 3], node: &Node, pose_slack: f32) -> Self {
        let own = turn::decode(code.turn);
        let p = three!(k => f64::from(origin[k]) + f64::from(code.centre[k]));
        let from = node.origin.map(f64::from);
        let [x, y, z] = motion.turn::<D>(p);
        let way = D::load(&motion.translation) - D::load(&[from[0], from[1], from[2], 0.0]);
        let centre = ((x + y) + (z + way)).narrow();
        let axes = three!(i => {
            let [x, y, z] = motion.turn::<D>([own[(0, i)], own[(1, i)], own[(2, i)]]);
            (x + y + z).narrow()
        });
        let distance = centre[0].abs() + centre[1].abs() + centre[2].abs();
        let half = code.half[0] + code.half[1] + code.half[2];
        let slack = U * (PER_DISTANCE * distance + PER_HALF * half) + pose_slack;
        Self { centre, axes, half: code.half, slack }
    }
}

//! The constants of one relative pose.

use super::boxes::Diagonals;
use super::lanes::{DOUBLES, DoubleLanes, three};
use super::volume::U;
use crate::geometry::{Isometry, Vector, grid};
use nalgebra::Matrix3;

/// Rounding in `f64` of a moved point or box, relative to the distances involved: 2⁻⁴⁴, five hundred times 2⁻⁵³; the
/// products and sums of a motion and its inverse are fewer than a hundred.
const MOTION_PAD: f64 = 1.0 / 17_592_186_044_416.0;
/// How much of a rotation matrix's defect counts: it enters the fifteen axes at most 28 times ([`super::boxes`]), half as often again because
/// boxes are turned by the quaternion ([`Motion::turned`]), and the points themselves three times.
const DEFECT_FACTOR: f64 = 64.0;

/// A motion from one mesh's frame to the other's.
#[derive(Clone, Debug)]
pub struct Motion {
    /// The columns of the rotation, each in as many lanes as there are.
    rotation: [[f64; DOUBLES]; 3],
    translation: [f64; DOUBLES],
    /// What the components x, y, z, w of a quaternion are multiplied by in the product of the rotation's own with it.
    product: [[f64; DOUBLES]; 4],
    /// Where the axes of the mesh's own frame are turned to.
    pub(super) axes: Diagonals,
}

impl Motion {
    /// By a rotation, as a matrix and as a quaternion (x, y, z, w), and a translation, mm.
    fn new(rotation: &Matrix3<f64>, [x, y, z, w]: [f64; 4], translation: &Vector) -> Self {
        let lanes = |v: [f64; 3]| [v[0], v[1], v[2], 0.0];
        let diagonal = |row: usize, column: usize| {
            let entry = |k: usize| rotation[((row + k) % 3, (column + k) % 3)] as f32;
            [entry(0), entry(1), entry(2), 0.0]
        };
        Self {
            rotation: [0, 1, 2].map(|j| lanes(rotation.column(j).into_owned().into())),
            translation: lanes((*translation).into()),
            product: [[w, z, -y, -x], [-z, w, x, -y], [y, -x, w, -z], [x, y, z, w]],
            axes: [diagonal(0, 0), diagonal(1, 0), diagonal(0, 1)],
        }
    }

    /// Where the axes of a box are turned to, whose rotation is given as in [`super::turn`].
    ///
    /// The product of the quaternions first, its matrix then: a third of the operations that turning three axes takes. With N(q) = (w² - |v|²) I +
    /// 2vvᵀ + 2w\[v\]× the motion's own matrix is R = N(r), and N(r) N(s) = N(rs). What is made here of p = rs is N(p) - (|p|² - 1) I; the box's s has
    /// length 1, so that this differs from turned axes by | |r|² - 1 |, half of what R lacks to being orthogonal (`DEFECT_FACTOR`), and by rounding in
    /// `f64` (`MOTION_PAD`).
    #[inline(always)]
    pub(super) fn turned<D: DoubleLanes>(&self, turn: [f32; 3]) -> Diagonals {
        let [x, y, z] = three!(k => f64::from(turn[k]));
        let w = (1.0 - (x * x + y * y + z * z)).sqrt();
        let [by_x, by_y, by_z, by_w] = &self.product;
        let vector = D::load(by_x) * D::all(x) + D::load(by_y) * D::all(y) + D::load(by_z) * D::all(z);
        let p = vector + D::load(by_w) * D::all(w);
        let twice = p + p;
        let squares = p * twice;
        let own = D::all(1.0) - squares.next() - squares.previous();
        let (mixed, scalar) = (p * twice.next(), p.last() * twice.previous());
        [own.narrow(), (mixed + scalar).narrow(), (mixed - scalar).narrow()]
    }

    /// The point `origin` + `centre` moved, relative to `from`, mm.
    #[inline(always)]
    pub(super) fn point<D: DoubleLanes>(
        &self,
        origin: &[f32; 3],
        centre: &[f32; 3],
        from: &[f32; 3],
    ) -> [f32; DOUBLES] {
        let p = three!(k => f64::from(origin[k]) + f64::from(centre[k]));
        let from = from.map(f64::from);
        let [x, y, z] = three!(j => D::load(&self.rotation[j]) * D::all(p[j]));
        let way = D::load(&self.translation) - D::load(&[from[0], from[1], from[2], 0.0]);
        ((x + y) + (z + way)).narrow()
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
        let [x, y, z, w]: [f64; 4] = a_from_b.rotation.coords.into();
        let defect = (back * rotation - Matrix3::identity()).amax();
        let slack = Self::slack(&translation, reach, defect);
        Self {
            b_from_a: Motion::new(&back, [-x, -y, -z, w], &-(back * translation)),
            a_from_b: Motion::new(&rotation, [x, y, z, w], &translation),
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

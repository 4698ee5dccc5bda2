//! Posed pairs, and what the exhaustive control says about them.
//!
//! A volume that is too small misses contacts just after they begin, so most poses lie around first contact: an approach
//! along a random direction at a random orientation, stopped at prescribed parts of the pair's size before and after.

use super::draw::Draw;
use super::meshes::{self, Subject};
use crate::engine::geometry::grid::Placement;
use crate::engine::geometry::{GridMesh, Isometry, Triangle, certified, triangle};
use nalgebra::UnitQuaternion;

/// Approaches per pair of meshes.
const APPROACHES: u64 = 6;
/// Equal steps in which an approach looks for contact.
const STEPS: u32 = 24;
/// Halvings of the step that made contact.
const HALVINGS: u32 = 26;
/// Travel past first contact, in parts of the pair's size.
const OFFSETS: [f64; 7] = [-0.1, -1e-3, -1e-6, 1e-7, 1e-4, 0.01, 0.2];

/// One pair of meshes at one pose, with the control's answer.
#[derive(Clone, Debug)]
pub struct Case {
    /// Index of the left mesh in [`Cases::subjects`].
    pub a: usize,
    /// Index of the right one.
    pub b: usize,
    /// The pose.
    pub a_from_b: Isometry,
    /// Pairs of faces that touch, sorted.
    pub contacts: Vec<(u32, u32)>,
}

/// The meshes and the posed pairs of them.
#[derive(Clone, Debug)]
pub struct Cases {
    /// The meshes.
    pub subjects: Vec<Subject>,
    /// The posed pairs.
    pub cases: Vec<Case>,
}

impl Cases {
    /// All posed pairs of the suite; the same on every machine.
    #[must_use]
    pub fn new() -> Self {
        let subjects = meshes::subjects();
        let triangles: Vec<Vec<Triangle>> = subjects.iter().map(|subject| subject.mesh.triangles()).collect();
        let mut cases = Vec::new();
        for a in 0..subjects.len() {
            // Every mesh meets itself and three others.
            for b in [a, (a + 1) % subjects.len(), (a + 4) % subjects.len(), (a + 9) % subjects.len()] {
                let pair = Approach { a: &triangles[a], b: &triangles[b] };
                for pose in pair.poses(&[subjects[a].name, subjects[b].name]) {
                    let contacts = contacts(&triangles[a], &triangles[b], &pose);
                    cases.push(Case { a, b, a_from_b: pose, contacts });
                }
            }
        }
        Self { subjects, cases }
    }

    /// The two meshes of a case.
    #[must_use]
    pub fn meshes(&self, case: &Case) -> (&GridMesh, &GridMesh) {
        (&self.subjects[case.a].mesh, &self.subjects[case.b].mesh)
    }
}

impl Default for Cases {
    fn default() -> Self {
        Self::new()
    }
}

/// Every pair of faces that touch, sorted: the control's answer, with the triangle test and the placement that all methods
/// share.
#[must_use]
pub fn contacts(a: &[Triangle], b: &[Triangle], a_from_b: &Isometry) -> Vec<(u32, u32)> {
    let placement = Placement::new(a_from_b);
    let moved: Vec<Triangle> = b.iter().map(|t| placement.triangle(t)).collect();
    let mut contacts = Vec::new();
    for (left, face_a) in a.iter().zip(0..) {
        contacts
            .extend(moved.iter().zip(0..).filter(|(right, _)| certified::touch(left, right)).map(|(_, f)| (face_a, f)));
    }
    contacts
}

/// Two meshes on their way to each other.
struct Approach<'a> {
    a: &'a [Triangle],
    b: &'a [Triangle],
}

impl Approach<'_> {
    fn touching(&self, a_from_b: &Isometry) -> bool {
        let placement = Placement::new(a_from_b);
        self.b.iter().any(|t| {
            let moved = placement.triangle(t);
            self.a.iter().any(|left| certified::touch(left, &moved))
        })
    }

    /// Poses around first contact. The first two approaches keep the meshes' axes parallel, exactly and within 1e-12 rad: that
    /// is where tests of edge against edge break down.
    fn poses(&self, names: &[&str]) -> Vec<Isometry> {
        let [(low_a, high_a), (low_b, high_b)] =
            [self.a, self.b].map(|triangles| triangle::bounds(triangles).expect("a mesh has a triangle"));
        let (middle_a, middle_b) = (nalgebra::center(&low_a, &high_a), nalgebra::center(&low_b, &high_b));
        let size = 0.5 * ((high_a - low_a).norm() + (high_b - low_b).norm());
        // Two points have no size; any distance will do for them.
        let reach = if size > 0.0 { size } else { 1.0 };
        let mut poses = Vec::new();
        for approach in 0..APPROACHES {
            let mut draw = Draw::new(0, names, approach);
            let direction = draw.direction();
            let rotation = match approach {
                0 => UnitQuaternion::identity(),
                1 => UnitQuaternion::from_scaled_axis(draw.in_ball() * 1e-12),
                _ => draw.rotation(),
            };
            let at = |distance: f64| {
                let middle = middle_a + direction.into_inner() * distance;
                Isometry::from_parts((middle - rotation * middle_b).into(), rotation)
            };
            let step = 1.1 * reach / f64::from(STEPS);
            let contact = (0..=STEPS).rev().map(|i| step * f64::from(i)).find(|&distance| self.touching(&at(distance)));
            let Some(mut touching) = contact else {
                poses.push(at(0.0));
                continue;
            };
            let mut apart = touching + step;
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(touching, apart);
                if self.touching(&at(middle)) { touching = middle } else { apart = middle }
            }
            poses.extend(OFFSETS.map(|offset| at(touching - offset * reach)));
        }
        poses
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_lie_on_both_sides_of_contact() {
        let cases = Cases::new().cases;
        let touching = cases.iter().filter(|case| !case.contacts.is_empty()).count();
        assert!(cases.len() > 1000, "{}", cases.len());
        assert!(touching * 3 > cases.len() && touching * 3 < 2 * cases.len(), "{touching} of {}", cases.len());
    }

    #[test]
    fn two_unit_cubes_touch_in_the_faces_that_meet() {
        let cube = meshes::cuboid(2.0, 2.0, 2.0).triangles();
        assert!(contacts(&cube, &cube, &Isometry::translation(2.1, 0.0, 0.0)).is_empty());
        let touching = contacts(&cube, &cube, &Isometry::translation(2.0, 0.0, 0.0));
        // Two triangles on either face, and all that share an edge or a corner with them; never the opposite faces.
        let on = |triangle: &Triangle, x: f64| triangle.corners.iter().all(|p| p.x == x);
        assert!(touching.iter().any(|&(f, g)| on(&cube[f as usize], 1.0) && on(&cube[g as usize], -1.0)));
        assert!(touching.iter().all(|&(f, g)| !on(&cube[f as usize], -1.0) && !on(&cube[g as usize], 1.0)));
    }
}

//! The method of the thesis between any two meshes: the rounder mesh is the tool, the other the surface ([`crate::interference`]).
//!
//! The tool is represented by the body of revolution around its mesh, the surface by samples in an octree. The verdicts therefore differ
//! from those of the exact triangle test that all trees share. The safe form reports contacts that do not exist, near contact and in the
//! hollows of a tool that is not round. The sampling form misses contacts between samples.

use super::{Model, same};
use crate::geometry::rigid::{self, rigid};
use crate::geometry::{Isometry, Mesh};
use crate::interference::detect::Allowance;
use crate::interference::{
    Body, BodyKind, BoxedTool, Counts, Detector, Division, Revolved, Samples, Search, SecondLevel, SurfaceOctree, Tool,
};
use crate::tree::distance::Proximity;
use crate::tree::traverse;
use crate::volume::Info;

/// Name and reference of the safe form, which widens the tool by the samples' covering radius.
pub const INFO: Info = Info {
    id: "octree-obb",
    label: "tool OBBs against surface octree",
    reference: "Wang 2006; Ding, Mannan and Poo 2004; the tool widened by the covering radius of the samples",
    safe: true,
};

/// Name and reference of the sampling form, in which only the samples count.
pub const SAMPLED: Info = Info {
    id: "octree-obb-sampled",
    label: "tool OBBs against surface octree, samples only",
    reference: "Wang 2006; Ding, Mannan and Poo 2004; what lies between samples is not seen",
    safe: false,
};

/// Approximate number of samples of a surface.
const SAMPLES: f64 = (1 << 18) as f64;
/// Smallest spacing of samples, mm. A quarter of a millimetre brings the covering radius below the repeatability of fixtures and holders.
const LEAST_SPACING_MM: f64 = 0.25;

/// A mesh as the surface: its samples in an octree.
fn surface(mesh: &Mesh) -> SurfaceOctree {
    let area: f64 = mesh.triangles().iter().map(crate::geometry::Triangle::area).sum();
    let spacing = (area / SAMPLES).sqrt().max(LEAST_SPACING_MM);
    // Black and white octants say what lies inside, which this method does not ask.
    SurfaceOctree::new(Samples::of(mesh, spacing), Division::default(), &|_| false)
}

/// A mesh as the tool: one body of revolution with its boxes.
#[derive(Clone, Debug)]
struct ToolSide {
    revolved: Revolved,
    boxes: BoxedTool,
}

impl ToolSide {
    fn new(mesh: &Mesh) -> Self {
        let revolved = Revolved::around(mesh);
        let bodies = vec![Body { kind: BodyKind::Holder, profile: revolved.profile.clone() }];
        Self { boxes: BoxedTool::new(Tool { bodies }, SecondLevel::Profile4), revolved }
    }
}

/// Allowance of zero: touching counts as interference.
const CONTACT: Allowance = Allowance { gouge_mm: 0.0, clearance_mm: 0.0 };

/// A mesh that can be either tool or surface.
#[derive(Clone, Debug)]
pub struct OctreeObb {
    surface: SurfaceOctree,
    tool: ToolSide,
    is_safe: bool,
}

impl OctreeObb {
    /// Prepares a mesh.
    pub fn new(mesh: &Mesh, is_safe: bool) -> Self {
        Self { surface: surface(mesh), tool: ToolSide::new(mesh), is_safe }
    }

    /// A detector for this mesh and another, and the function from a pose to the surface's pose in the tool's frame.
    fn pairing<'a>(&'a self, other: &'a Self) -> (Detector<'a>, impl Fn(&Isometry) -> Isometry + use<>) {
        let is_tool = self.tool.revolved.is_tool_against(&other.tool.revolved);
        let (tool, surface) = if is_tool { (&self.tool, &other.surface) } else { (&other.tool, &self.surface) };
        let tool_from_mesh = tool.revolved.tool_from_mesh;
        let tool_from_surface = move |a_from_b: &Isometry| {
            tool_from_mesh * if is_tool { rigid(a_from_b) } else { rigid::inverse(a_from_b) }
        };
        (Detector::new(surface, &tool.boxes, CONTACT, self.is_safe, Search::Octree), tool_from_surface)
    }
}

impl Model for OctreeObb {
    fn first(&self, other: &dyn Model, a_from_b: &[Isometry], verdicts: &mut Vec<bool>) {
        let (detector, tool_from_surface) = self.pairing(same(other));
        let touches = |pose| detector.first(&tool_from_surface(pose), None, &mut Counts::default()).is_some();
        verdicts.extend(a_from_b.iter().map(touches));
    }

    /// Volume tests are tests of octants against boxes; points compared with the profile are counted as triangle tests.
    fn first_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (bool, traverse::Counts) {
        let (detector, tool_from_surface) = self.pairing(same(other));
        let mut counts = Counts::default();
        let verdict = detector.first(&tool_from_surface(a_from_b), None, &mut counts).is_some();
        (verdict, traverse::Counts { volume_tests: counts.box_tests(), triangle_tests: counts.points })
    }

    /// Samples do not identify touching triangles, so the list is empty.
    fn all_counted(&self, _: &dyn Model, _: &Isometry) -> (Vec<(u32, u32)>, traverse::Counts) {
        (Vec::new(), traverse::Counts::default())
    }

    /// The distance from the body around the tool. The safe form subtracts the covering radius, so the result is never above the distance
    /// of the meshes.
    fn distance_mm(&self, other: &dyn Model, a_from_b: &Isometry, below_mm: f64, _: &mut Proximity) -> f64 {
        let (detector, tool_from_surface) = self.pairing(same(other));
        let least = detector.least_mm(&tool_from_surface(a_from_b), below_mm, &mut Counts::default());
        if least < below_mm { least.max(0.0) } else { f64::INFINITY }
    }

    fn bytes(&self) -> usize {
        self.surface.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::geometry::shapes::outline::OutlinePoint;
    use crate::geometry::shapes::{Revolve, Shape, Tessellation};
    use crate::truth::PairOracle;
    use obbtree::cases::meshes;
    use std::sync::Arc;

    fn tool() -> Mesh {
        let profile_mm = [[0.0, 0.0], [2.0, 0.0], [2.0, 10.0], [5.0, 10.0], [5.0, 20.0], [0.0, 20.0]];
        Shape::Revolve(Revolve { profile_mm: profile_mm.map(OutlinePoint::Sharp).to_vec() })
            .mesh(&Tessellation::default())
            .unwrap()
    }

    #[test]
    fn whichever_mesh_is_named_first_the_round_one_is_the_tool() {
        let (ring, tool) = (meshes::torus(12.0, 4.0, 40, 20), tool());
        let [a, b] = [&ring, &tool].map(|mesh| OctreeObb::new(mesh, false));
        // The tip down, 3 mm above the ring's highest circle, then 1 mm inside.
        for (height, expected) in [(7.0, 3.0), (3.0, 0.0)] {
            let pose = Isometry::translation(12.0, 0.0, height);
            let there = a.distance_mm(&b, &pose, 50.0, &mut Proximity::default());
            let back = b.distance_mm(&a, &pose.inverse(), 50.0, &mut Proximity::default());
            assert!((there - expected).abs() < 1e-6 && (back - there).abs() < 1e-9, "{there} {back}");
            assert_eq!(a.first_counted(&b, &pose).0, expected == 0.0);
        }
        let far = Isometry::translation(0.0, 0.0, 500.0);
        assert_eq!(a.distance_mm(&b, &far, 50.0, &mut Proximity::default()), f64::INFINITY);
    }

    #[test]
    fn the_safe_form_misses_nothing_and_its_distances_are_no_longer_than_the_truth() {
        let (ring, tool) = (Arc::new(meshes::torus(12.0, 4.0, 40, 20)), Arc::new(tool()));
        let [a, b] = [&ring, &tool].map(|mesh| OctreeObb::new(mesh, true));
        let oracle = PairOracle::new(ring, tool);
        let (mut touching, mut apart) = (0, 0);
        for k in 0..300 {
            let k = f64::from(k);
            let turn = Vector::new(1.3 * (0.37 * k).sin(), 1.1 * (0.53 * k).cos(), 0.2 * k);
            let at = Vector::new(12.0 * (0.05 * k).cos(), 12.0 * (0.05 * k).sin(), 5.0 + 2.0 * (0.29 * k).sin());
            let pose = Isometry::new(at, turn);
            let distance = a.distance_mm(&b, &pose, 100.0, &mut Proximity::default());
            let verdict = a.first_counted(&b, &pose).0;
            assert_eq!(verdict, distance <= 0.0);
            if oracle.touches(&pose) {
                touching += 1;
                assert!(verdict);
            } else if !verdict {
                apart += 1;
                assert!(distance <= oracle.clearance_mm(&pose, 100.0) + 1e-9);
            }
        }
        assert!(touching > 50 && apart > 50, "{touching} {apart}");
    }
}

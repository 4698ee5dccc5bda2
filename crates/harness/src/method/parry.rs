//! parry's `TriMesh` query as an in-process peer: its own tree, its own traversal, its own triangle test.
//!
//! parry is a whole system, not a bounding volume, and differs from the variants in every respect. It sees the unsnapped pose, and its
//! triangle test is not exact, so it counts as unsafe here.

use super::motion::Motion;
use super::{Model, same};
use crate::geometry::{Isometry, Mesh};
use crate::tree::distance::Proximity;
use crate::tree::traverse::Counts;
use crate::volume::Info;
use parry3d_f64::math::Pose;
use parry3d_f64::query::{NonlinearRigidMotion, cast_shapes_nonlinear, distance, intersection_test};
use parry3d_f64::shape::TriMesh;

/// Name and reference of the peer.
pub const INFO: Info = Info {
    id: "parry-trimesh",
    label: "parry TriMesh (whole system)",
    reference: "parry3d-f64, query::intersection_test on two TriMesh",
    safe: false,
};

/// A mesh as parry holds it.
pub struct ParryMesh(TriMesh);

impl ParryMesh {
    /// Builds parry's own tree over the mesh.
    ///
    /// # Panics
    /// Never for a [`Mesh`], which is not empty and has valid indices.
    pub fn new(mesh: &Mesh) -> Self {
        let vertices = mesh.vertices().iter().map(|p| p.coords.into()).collect();
        Self(TriMesh::new(vertices, mesh.faces().to_vec()).expect("a mesh has at least one face"))
    }
}

impl Model for ParryMesh {
    fn first(&self, other: &dyn Model, a_from_b: &[Isometry], verdicts: &mut Vec<bool>) {
        let (identity, other) = (Pose::IDENTITY, same::<Self>(other));
        verdicts.extend(a_from_b.iter().map(|pose| {
            intersection_test(&identity, &self.0, &(*pose).into(), &other.0)
                .expect("parry supports two triangle meshes")
                .intersecting
        }));
    }

    fn first_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (bool, Counts) {
        let mut verdict = Vec::with_capacity(1);
        self.first(other, std::slice::from_ref(a_from_b), &mut verdict);
        (verdict[0], Counts::default())
    }

    /// parry answers only whether two meshes touch; the list is empty.
    fn all_counted(&self, _: &dyn Model, _: &Isometry) -> (Vec<(u32, u32)>, Counts) {
        (Vec::new(), Counts::default())
    }

    fn distance_mm(&self, other: &dyn Model, a_from_b: &Isometry, below_mm: f64, _: &mut Proximity) -> f64 {
        let found = distance(&Pose::IDENTITY, &self.0, &(*a_from_b).into(), &same::<Self>(other).0)
            .expect("parry supports two triangle meshes")
            .distance;
        if found < below_mm { found } else { f64::INFINITY }
    }

    /// parry's own search, which knows the same motion: a centre that goes straight, and a constant turn about it.
    fn first_contact(&self, other: &dyn Model, motion: &Motion, _: f64) -> Option<f64> {
        let still = NonlinearRigidMotion::identity();
        let (start, centre) = (motion.start.into(), Default::default());
        let moved = NonlinearRigidMotion::new(start, centre, motion.way.into(), motion.turn.into());
        let found = cast_shapes_nonlinear(&still, &self.0, &moved, &same::<Self>(other).0, 0.0, 1.0, true);
        found.expect("parry supports two triangle meshes").map(|hit| hit.time_of_impact)
    }

    fn bytes(&self) -> usize {
        0
    }
}

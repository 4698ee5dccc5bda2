//! The exhaustive control: tests every pair of triangles, without volumes.

use super::{Model, same};
use crate::geometry::grid::Placement;
use crate::geometry::{Isometry, Triangle, certified, triangle_distance};
use crate::tree::distance::Proximity;
use crate::tree::traverse::Counts;
use crate::volume::Info;

/// Name and reference of the control.
pub const INFO: Info = Info {
    id: "brute",
    label: "brute force",
    reference: "every pair of triangles, no volume; the control",
    safe: true,
};

/// The triangles of one mesh, mm, in its own frame.
pub struct AllPairs(pub Vec<Triangle>);

impl Model for AllPairs {
    fn first(&self, other: &dyn Model, a_from_b: &[Isometry], verdicts: &mut Vec<bool>) {
        verdicts.extend(a_from_b.iter().map(|pose| self.first_counted(other, pose).0));
    }

    fn first_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (bool, Counts) {
        let placement = Placement::new(a_from_b);
        let mut tests = 0;
        let touching = same::<Self>(other).0.iter().any(|t| {
            let moved = placement.triangle(t);
            self.0.iter().any(|mine| {
                tests += 1;
                certified::touch(mine, &moved)
            })
        });
        (touching, Counts { volume_tests: 0, triangle_tests: tests })
    }

    fn all_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (Vec<(u32, u32)>, Counts) {
        let placement = Placement::new(a_from_b);
        let other = &same::<Self>(other).0;
        let mut contacts = Vec::new();
        for (t, face_b) in other.iter().zip(0..) {
            let moved = placement.triangle(t);
            let touching = self.0.iter().zip(0..).filter(|(mine, _)| certified::touch(mine, &moved));
            contacts.extend(touching.map(|(_, face_a)| (face_a, face_b)));
        }
        contacts.sort_unstable();
        (contacts, Counts { volume_tests: 0, triangle_tests: (self.0.len() * other.len()) as u64 })
    }

    fn distance_mm(&self, other: &dyn Model, a_from_b: &Isometry, below_mm: f64, _: &mut Proximity) -> f64 {
        let placement = Placement::new(a_from_b);
        let mut least = below_mm;
        for moved in same::<Self>(other).0.iter().map(|t| placement.triangle(t)) {
            for mine in &self.0 {
                if certified::touch(mine, &moved) {
                    return 0.0;
                }
                least = least.min(triangle_distance::squared(mine, &moved).sqrt());
            }
        }
        if least < below_mm { least } else { f64::INFINITY }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.0.as_slice())
    }
}

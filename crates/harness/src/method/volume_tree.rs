//! Every bounding volume as a method: a tree of it, and the one traversal.

use super::{Model, same};
use crate::geometry::Isometry;
use crate::tree::Tree;
use crate::tree::distance::{self, Proximity};
use crate::tree::levels::Drawn;
use crate::tree::tightness::TreeReport;
use crate::tree::traverse::{self, Counts, NoProbe, Scratch};
use crate::tree::validate::TreeFault;
use crate::tree::witness::{Places, reached};
use crate::volume::Shape;
use crate::volume::shape::obb::Obb;

impl<S: Shape> Model for Tree<S> {
    fn first(&self, other: &dyn Model, a_from_b: &[Isometry], verdicts: &mut Vec<bool>) {
        let other: &Self = same(other);
        let mut scratch = Scratch::default();
        verdicts.extend(a_from_b.iter().map(|pose| traverse::first(self, other, pose, &mut scratch, &mut NoProbe)));
    }

    /// A tree reports a contact only after the shared triangle test, so without a witness the answer is no. With a witness, the answer is
    /// yes if the query reaches it; otherwise the query itself decides.
    fn first_given(
        &self,
        other: &dyn Model,
        a_from_b: &[Isometry],
        witnesses: &[Option<(u32, u32)>],
        verdicts: &mut Vec<bool>,
    ) {
        let other: &Self = same(other);
        let (places, other_places) = (Places::of(self), Places::of(other));
        let mut scratch = Scratch::default();
        verdicts.extend(a_from_b.iter().zip(witnesses).map(|(pose, witness)| {
            witness.is_some_and(|witness| {
                reached((self, &places), (other, &other_places), pose, witness)
                    || traverse::first(self, other, pose, &mut scratch, &mut NoProbe)
            })
        }));
    }

    fn first_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (bool, Counts) {
        let mut counts = Counts::default();
        let verdict = traverse::first(self, same(other), a_from_b, &mut Scratch::default(), &mut counts);
        (verdict, counts)
    }

    fn all_counted(&self, other: &dyn Model, a_from_b: &Isometry) -> (Vec<(u32, u32)>, Counts) {
        let (mut counts, mut contacts) = (Counts::default(), Vec::new());
        traverse::all(self, same::<Self>(other), a_from_b, &mut Scratch::default(), &mut counts, &mut contacts);
        contacts.sort_unstable();
        (contacts, counts)
    }

    fn distance_mm(&self, other: &dyn Model, a_from_b: &Isometry, below_mm: f64, proximity: &mut Proximity) -> f64 {
        distance::distance_mm(self, same(other), a_from_b, below_mm, proximity)
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }

    fn tree_report(&self) -> Option<TreeReport> {
        Some(self.report())
    }

    fn order(&self) -> Option<&[u32]> {
        Some(self.faces())
    }

    fn drawn(&self, levels: u32) -> Vec<Drawn> {
        self.drawn(levels)
    }

    fn boxes(&self) -> Option<Tree<Obb>> {
        self.with_volumes(S::as_box)
    }

    fn check_structure(&self) -> Result<(), TreeFault> {
        self.check_structure()
    }

    fn check_containment(&self, slack_mm: f64) -> Result<(), TreeFault> {
        self.check_containment(slack_mm)
    }

    fn check_consistency(&self) -> Result<(), TreeFault> {
        self.check_consistency()
    }
}

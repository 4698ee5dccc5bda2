//! Two colliders in one frame of the engine, and the queries about them.

use crate::collider::{Collider, Contact, Nearest, Tree};
use crate::engine::Simd;
use crate::engine::distance::distance_mm;
use crate::engine::geometry::grid::Placement;
use crate::engine::geometry::witness;
use crate::engine::path::{Coherence, Memory};
use crate::engine::proximity::Proximity;
use crate::engine::traverse::{self, Scratch};
use crate::frame::{FARTHEST, exponent_for};
use crate::mesh::power_of_two;
use crate::pose::{self, PoseError};
use nalgebra::{Isometry3, Point3};
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Largest translation for which a distance is computed: up to it the distance of any two meshes is finite.
const LIMIT: f64 = power_of_two(1022);

thread_local! {
    /// Memory that the queries of a thread reuse.
    static WORK: RefCell<(Scratch, Proximity)> = RefCell::default();
}

/// Two colliders whose trees have the same unit.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    colliders: [Collider; 2],
    /// Their trees in the pair's unit, where that is not their own.
    coarser: [Option<Arc<Tree>>; 2],
    /// The engine's unit, as an exponent of two, in the unit of the meshes.
    exponent: i32,
}

impl Pair {
    pub fn new(a: &Collider, b: &Collider) -> Self {
        Self::in_unit([a, b], a.frame().exponent.max(b.frame().exponent))
    }

    fn in_unit(colliders: [&Collider; 2], exponent: i32) -> Self {
        let coarser = colliders.map(|collider| collider.coarser(exponent));
        Self { colliders: colliders.map(Collider::clone), coarser, exponent }
    }

    fn trees(&self) -> [&Tree; 2] {
        let tree = |i: usize| self.coarser[i].as_deref().unwrap_or_else(|| self.colliders[i].tree());
        [tree(0), tree(1)]
    }

    /// The pose between the origins of the engine's coordinates, in the unit of the meshes.
    fn between_origins(&self, a_from_b: &Isometry3<f64>) -> Result<Isometry3<f64>, PoseError> {
        let mut pose = pose::checked(a_from_b)?;
        let origins = self.colliders.each_ref().map(|collider| collider.frame().origin);
        if origins != [Point3::origin(); 2] {
            let [of_a, of_b] = origins;
            pose.translation.vector += pose.rotation * of_b.coords - of_a.coords;
        }
        Ok(pose)
    }

    /// The pose in the engine's unit and between its origins; `None` where it is too far for a contact.
    pub fn seen(&self, a_from_b: &Isometry3<f64>) -> Result<Option<Isometry3<f64>>, PoseError> {
        let mut seen = self.between_origins(a_from_b)?;
        seen.translation.vector *= power_of_two(-self.exponent);
        Ok((seen.translation.vector.amax() <= power_of_two(FARTHEST)).then_some(seen))
    }

    /// A point of the engine in the frame of `a`.
    fn shown(&self, point: &Point3<f64>) -> Point3<f64> {
        self.colliders[0].frame().origin + point.coords * power_of_two(self.exponent)
    }

    pub fn collides(&self, a_from_b: &Isometry3<f64>) -> Result<bool, PoseError> {
        let Some(seen) = self.seen(a_from_b)? else { return Ok(false) };
        let [a, b] = self.trees();
        Ok(WORK.with_borrow_mut(|(scratch, _)| traverse::first(a, b, &seen, Simd::in_use(), scratch)))
    }

    /// As [`Pair::collides`], with what earlier poses left behind.
    pub fn collides_along(&self, a_from_b: &Isometry3<f64>, memory: &mut Memory) -> Result<bool, PoseError> {
        let Some(seen) = self.seen(a_from_b)? else { return Ok(false) };
        let [a, b] = self.trees();
        Ok(memory.first(a, b, &seen, Simd::in_use(), Coherence::Evidence))
    }

    pub fn contacts(&self, a_from_b: &Isometry3<f64>, limit: usize) -> Result<Vec<Contact>, PoseError> {
        let Some(seen) = self.seen(a_from_b)? else { return Ok(Vec::new()) };
        let (mut places, [a, b]) = (Vec::new(), self.trees());
        if limit > 0 {
            WORK.with_borrow_mut(|(scratch, _)| {
                traverse::traverse((a, b), &seen, Simd::in_use(), scratch, &mut |pair| {
                    places.push(pair);
                    if places.len() < limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
                });
            });
        }
        let placement = Placement::new(&seen);
        let mut contacts: Vec<Contact> = places.into_iter().map(|places| self.contact(places, &placement)).collect();
        contacts.sort_unstable_by_key(|contact| contact.faces);
        Ok(contacts)
    }

    fn contact(&self, (i, j): (u32, u32), placement: &Placement) -> Contact {
        let [a, b] = self.trees();
        let [p, q] = witness::nearest(&a.triangle(i), &placement.triangle(&b.triangle(j)));
        Contact { faces: self.faces((i, j)), point: self.shown(&nalgebra::center(&p, &q)) }
    }

    fn faces(&self, (i, j): (u32, u32)) -> [u32; 2] {
        let [a, b] = self.trees();
        [a.faces[i as usize], b.faces[j as usize]]
    }

    pub fn distance_below(&self, a_from_b: &Isometry3<f64>, below: f64) -> Result<Option<Nearest>, PoseError> {
        let Some(seen) = self.seen(a_from_b)? else { return self.distance_far(a_from_b, below) };
        Ok(WORK.with_borrow_mut(|(_, proximity)| {
            proximity.nearest = None;
            self.distance_seen(&seen, below, proximity)
        }))
    }

    /// As [`Pair::distance_below`], with the pair of triangles that was nearest at an earlier pose.
    pub fn distance_along(
        &self,
        a_from_b: &Isometry3<f64>,
        below: f64,
        proximity: &mut Proximity,
    ) -> Result<Option<Nearest>, PoseError> {
        let Some(seen) = self.seen(a_from_b)? else { return self.distance_far(a_from_b, below) };
        Ok(self.distance_seen(&seen, below, proximity))
    }

    /// As [`Pair::distance_below`] for a translation that is too large for the pair's unit: in the finest unit that holds it.
    fn distance_far(&self, a_from_b: &Isometry3<f64>, below: f64) -> Result<Option<Nearest>, PoseError> {
        let farthest = self.between_origins(a_from_b)?.translation.vector.amax();
        if farthest > LIMIT {
            return Err(PoseError::TooFar { limit: LIMIT });
        }
        let [a, b] = &self.colliders;
        Self::in_unit([a, b], exponent_for(farthest, FARTHEST)).distance_below(a_from_b, below)
    }

    fn distance_seen(&self, seen: &Isometry3<f64>, below: f64, proximity: &mut Proximity) -> Option<Nearest> {
        let (unit, [a, b]) = (power_of_two(self.exponent), self.trees());
        // A limit above 0 stays above it: what touches is below any such limit.
        let below_mm = if below > 0.0 { (below / unit).max(f64::MIN_POSITIVE) } else { 0.0 };
        let found = distance_mm(a, b, seen, Simd::in_use(), below_mm, proximity);
        let places = proximity.nearest.filter(|_| found.is_finite())?;
        // 0 is said of contact alone.
        let distance = if found > 0.0 { (found * unit).max(f64::MIN_POSITIVE) } else { 0.0 };
        if distance >= below {
            return None;
        }
        let moved = Placement::new(seen).triangle(&b.triangle(places.1));
        let points = witness::nearest(&a.triangle(places.0), &moved).map(|p| self.shown(&p));
        Some(Nearest { distance, points, faces: self.faces(places) })
    }
}

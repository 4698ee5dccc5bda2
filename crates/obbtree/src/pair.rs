//! Two colliders in one frame of the engine, and the queries about them.

use crate::collider::{Collider, Contact, Nearest, Tree};
use crate::engine::Simd;
use crate::engine::distance::distance_mm;
use crate::engine::geometry::grid::Placement;
use crate::engine::path::{Coherence, Memory};
use crate::engine::proximity::Proximity;
use crate::engine::traverse::{self, Scratch};
use crate::mesh::power_of_two;
use crate::pose::{self, PoseError};
use crate::witness;
use nalgebra::{Isometry3, Point3};
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Largest translation that the engine's single precision can square, as an exponent of two in its units.
const FARTHEST: i32 = 60;

thread_local! {
    /// Memory that the queries of a thread reuse.
    static WORK: RefCell<(Scratch, Proximity)> = RefCell::default();
}

/// Two colliders whose trees have the same unit.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    a: Arc<Tree>,
    b: Arc<Tree>,
    /// The origins of the engine's coordinates in the frames of `a` and `b`.
    origins: [Point3<f64>; 2],
    /// The engine's unit, as an exponent of two, in the unit of the meshes.
    exponent: i32,
}

impl Pair {
    pub fn new(a: &Collider, b: &Collider) -> Self {
        let exponent = a.frame().exponent.max(b.frame().exponent);
        Self { a: a.tree(exponent), b: b.tree(exponent), origins: [a.frame().origin, b.frame().origin], exponent }
    }

    /// The pose in the engine's unit and between its origins; `None` where it is too far for a contact.
    pub fn seen(&self, a_from_b: &Isometry3<f64>) -> Result<Option<Isometry3<f64>>, PoseError> {
        let mut seen = pose::checked(a_from_b)?;
        let [of_a, of_b] = self.origins;
        if self.origins != [Point3::origin(); 2] {
            seen.translation.vector += seen.rotation * of_b.coords - of_a.coords;
        }
        seen.translation.vector *= power_of_two(-self.exponent);
        Ok((seen.translation.vector.amax() <= power_of_two(FARTHEST)).then_some(seen))
    }

    /// A point of the engine in the frame of `a`.
    fn shown(&self, point: &Point3<f64>) -> Point3<f64> {
        self.origins[0] + point.coords * power_of_two(self.exponent)
    }

    pub fn collides(&self, a_from_b: &Isometry3<f64>) -> Result<bool, PoseError> {
        let Some(seen) = self.seen(a_from_b)? else { return Ok(false) };
        Ok(WORK.with_borrow_mut(|(scratch, _)| traverse::first(&self.a, &self.b, &seen, Simd::in_use(), scratch)))
    }

    /// As [`Pair::collides`], with what earlier poses left behind.
    pub fn collides_along(&self, a_from_b: &Isometry3<f64>, memory: &mut Memory) -> Result<bool, PoseError> {
        let Some(seen) = self.seen(a_from_b)? else { return Ok(false) };
        Ok(memory.first(&self.a, &self.b, &seen, Simd::in_use(), Coherence::Evidence))
    }

    pub fn contacts(&self, a_from_b: &Isometry3<f64>, limit: usize) -> Result<Vec<Contact>, PoseError> {
        let Some(seen) = self.seen(a_from_b)? else { return Ok(Vec::new()) };
        let mut places = Vec::new();
        if limit > 0 {
            WORK.with_borrow_mut(|(scratch, _)| {
                traverse::traverse((&self.a, &self.b), &seen, Simd::in_use(), scratch, &mut |pair| {
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
        let [p, q] = witness::nearest(&self.a.triangle(i), &placement.triangle(&self.b.triangle(j)));
        Contact { faces: self.faces((i, j)), point: self.shown(&nalgebra::center(&p, &q)) }
    }

    fn faces(&self, (i, j): (u32, u32)) -> [u32; 2] {
        [self.a.faces[i as usize], self.b.faces[j as usize]]
    }

    pub fn distance_below(&self, a_from_b: &Isometry3<f64>, below: f64) -> Result<Option<Nearest>, PoseError> {
        WORK.with_borrow_mut(|(_, proximity)| {
            proximity.nearest = None;
            self.distance_along(a_from_b, below, proximity)
        })
    }

    /// As [`Pair::distance_below`], with the pair of triangles that was nearest at an earlier pose.
    pub fn distance_along(
        &self,
        a_from_b: &Isometry3<f64>,
        below: f64,
        proximity: &mut Proximity,
    ) -> Result<Option<Nearest>, PoseError> {
        let unit = power_of_two(self.exponent);
        let Some(seen) = self.seen(a_from_b)? else {
            return Err(PoseError::TooFar { limit: power_of_two(FARTHEST) * unit });
        };
        // A limit above 0 stays above it: what touches is below any such limit.
        let below_mm = if below > 0.0 { (below / unit).max(f64::MIN_POSITIVE) } else { 0.0 };
        let found = distance_mm(&self.a, &self.b, &seen, Simd::in_use(), below_mm, proximity);
        let Some(places) = proximity.nearest.filter(|_| found.is_finite()) else { return Ok(None) };
        // 0 is said of contact alone.
        let distance = if found > 0.0 { (found * unit).max(f64::MIN_POSITIVE) } else { 0.0 };
        if distance >= below {
            return Ok(None);
        }
        let moved = Placement::new(&seen).triangle(&self.b.triangle(places.1));
        let points = witness::nearest(&self.a.triangle(places.0), &moved).map(|p| self.shown(&p));
        Ok(Some(Nearest { distance, points, faces: self.faces(places) }))
    }
}

//! Bytes as a cutter's outline and as ways of it through a block: what a cut leaves is never deeper in the cutter where it has just been, and what is gone stays gone.

use super::engines::Choices;
use bvbench::geometry::shapes::outline::OutlinePoint;
use bvbench::geometry::shapes::{Revolve, RoundedBox, Shape, Tessellation};
use bvbench::geometry::{Isometry, Mesh, Point, Vector};
use bvbench::stock::{Body, Material, ROUNDING_MM, Step, Stock, Sweep};
use nalgebra::Translation3;
use std::sync::Arc;

/// Half the side of the block, mm; the ways are about as long.
const HALF_MM: f64 = 10.0;

const COARSE: Tessellation = Tessellation { density: 0.3, grading: 1.0 };

/// Cuts a block at a coarse resolution, so that what is slow is what has no bound.
pub fn run(bytes: &[u8]) {
    let mut choices = Choices::new(bytes, 0, 0);
    let Some(cutter) = cutter(&mut choices) else { return };
    let body = Body::turning(&cutter, choices.of(&[0.0, 0.0, 1.0]));
    let block = RoundedBox { size_mm: [2.0 * HALF_MM; 3], fillet_mm: 0.0, holes: Vec::new() };
    let block = Shape::RoundedBox(block).mesh(&COARSE).expect("a box has a mesh");
    let resolution_mm = choices.between(-2, 1);
    let mut stock = Stock::new(&Arc::new(block), resolution_mm).expect("a box is watertight");
    let points: Vec<Point> = (0..16).map(|_| (choices.vector() * HALF_MM).into()).collect();
    let mut known: Vec<Material> = points.iter().map(|point| stock.material_at(point)).collect();
    for _ in 0..=choices.below(6) {
        let sweep = way(&mut choices, &body);
        if choices.once_in(3) {
            let step = Step { examined: vec![sweep], cutting: Vec::new() };
            for contact in stock.run(&[step], 0.1) {
                assert!(contact.depth.low <= contact.depth.high && contact.from <= contact.to, "{contact:?}");
            }
            continue;
        }
        stock.run(&[Step { examined: Vec::new(), cutting: vec![sweep.clone()] }], 0.1);
        let again = stock.run(&[Step { examined: vec![sweep], cutting: Vec::new() }], 0.1);
        for contact in again {
            assert!(contact.depth.low <= ROUNDING_MM, "where it has cut, something is left for sure: {contact:?}");
        }
        for (point, before) in points.iter().zip(&mut known) {
            let now = stock.material_at(point);
            assert!(*before != Material::Gone || now == Material::Gone, "{point} is back");
            assert!(*before != Material::Unknown || now != Material::Solid, "{point} is solid again");
            *before = now;
        }
    }
}

/// A body of revolution with steps, grooves and perhaps a dish or a bore at its end; `None` where the outline is none.
fn cutter(choices: &mut Choices) -> Option<Arc<Mesh>> {
    let mut profile = vec![[0.0, choices.of(&[0.0, 0.0, 0.5, 3.0])], [choices.between(-2, 3), 0.0]];
    let mut z = 0.0;
    for _ in 0..=choices.below(5) {
        z += choices.of(&[0.0, 0.25, 1.0, 8.0]) + choices.unit();
        profile.push([choices.between(-2, 3), z]);
    }
    profile.push([0.0, z + choices.unit()]);
    let profile_mm = profile.into_iter().map(OutlinePoint::Sharp).collect();
    Shape::Revolve(Revolve { profile_mm }).mesh(&COARSE).ok().map(Arc::new)
}

fn way(choices: &mut Choices, body: &Body) -> Sweep {
    let turn = if choices.once_in(2) { choices.rotation() } else { choices.small_turn(-60, -40) };
    let from = Isometry::from_parts(Translation3::from(choices.vector() * (1.5 * HALF_MM)), turn);
    let travel = if choices.once_in(8) { Vector::zeros() } else { choices.direction() * choices.between(-10, 5) };
    let turn = if choices.once_in(2) { choices.small_turn(-20, -4) * from.rotation } else { from.rotation };
    let to = Isometry::from_parts((from.translation.vector + travel).into(), turn);
    body.sweep([&from, &to], choices.of(&[0.0, 0.0, 0.01]))
}

//! Meshes of every kind that has ever broken a volume: small, so that all pairs of triangles can be tested.

use super::choices::Choices;
use bvbench::geometry::{Mesh, Point, Triangle, Vector, grid};
use obbtree::cases::meshes;

/// Most triangles of most meshes.
const FEW: u64 = 24;
/// Most triangles of the others, which have trees deep enough for what paths keep.
const MANY: u64 = 96;

/// What the triangles are.
#[derive(Clone, Copy)]
enum Kind {
    Soup,
    Needles,
    Points,
    Segments,
    Duplicates,
    Coplanar,
    Lattice,
    Mixed,
    /// Corners in one point, from which the triangles spread.
    Fan,
    Solid,
}

/// How large the mesh is.
#[derive(Clone, Copy)]
enum Scale {
    /// Some steps of the grid.
    Grid,
    Ordinary,
    /// Up to the end of the range.
    Huge,
    Any,
}

const KINDS: [Kind; 10] = [
    Kind::Soup,
    Kind::Needles,
    Kind::Points,
    Kind::Segments,
    Kind::Duplicates,
    Kind::Coplanar,
    Kind::Lattice,
    Kind::Mixed,
    Kind::Fan,
    Kind::Solid,
];
const SCALES: [Scale; 8] = [
    Scale::Grid,
    Scale::Ordinary,
    Scale::Ordinary,
    Scale::Ordinary,
    Scale::Ordinary,
    Scale::Huge,
    Scale::Any,
    Scale::Any,
];

/// A mesh of any kind and scale, anywhere in its frame.
pub fn any(choices: &mut Choices) -> Mesh {
    let (kind, scale) = (choices.of(&KINDS), choices.of(&SCALES));
    made(choices, kind, scale)
}

/// A few points or triangles of some steps of the grid: such that only the snapping of their corners makes them touch.
pub fn of_the_grid(choices: &mut Choices) -> Mesh {
    let kind = choices.of(&[Kind::Points, Kind::Points, Kind::Soup, Kind::Lattice, Kind::Segments]);
    made(choices, kind, Scale::Grid)
}

/// Long triangles that meet in one point.
pub fn fan(choices: &mut Choices) -> Mesh {
    let scale = choices.of(&[Scale::Ordinary, Scale::Huge, Scale::Any]);
    made(choices, Kind::Fan, scale)
}

/// A mesh far from its origin, compared with its size.
pub fn far(choices: &mut Choices) -> Mesh {
    let triangles = shape(choices, Kind::Soup);
    let (scale, offset) = (choices.between(-26, 2), choices.direction() * choices.between(8, 11));
    placed(&triangles, scale, &offset)
}

fn made(choices: &mut Choices, kind: Kind, scale: Scale) -> Mesh {
    let triangles = shape(choices, kind);
    let scale = match scale {
        Scale::Grid => choices.between(-26, -16),
        Scale::Ordinary => choices.between(-1, 8),
        Scale::Huge => choices.between(10, 12),
        Scale::Any => choices.between(-26, 11),
    };
    // A lattice stays one: corners then coincide exactly.
    let scale = if matches!(kind, Kind::Lattice) { 2f64.powi(scale.log2() as i32).max(grid::STEP_MM) } else { scale };
    let offset = match choices.below(4) {
        0 => choices.vector() * choices.between(-20, 12),
        1 => choices.vector() * scale,
        _ => Vector::zeros(),
    };
    placed(&triangles, scale, &offset)
}

/// The triangles scaled and moved, and what is outside the range put on its border.
fn placed(triangles: &[Triangle], scale: f64, offset: &Vector) -> Mesh {
    let inside = |x: f64| x.clamp(-grid::LIMIT_MM, grid::LIMIT_MM);
    let place = |p: &Point| (p * scale + offset).map(inside);
    let placed: Vec<Triangle> = triangles.iter().map(|triangle| triangle.map(place)).collect();
    Mesh::from_triangles(&placed).expect("the corners are finite and in range")
}

/// Triangles of about size 1, about the origin.
fn shape(choices: &mut Choices, kind: Kind) -> Vec<Triangle> {
    let most = if choices.once_in(16) { MANY } else { FEW };
    let few = if choices.once_in(4) { 1 } else { 1 + choices.below(most) };
    let turned = choices.rotation();
    let triangle = Triangle::new;
    let point = |choices: &mut Choices| Point::from(choices.vector());
    let one = |choices: &mut Choices| {
        let p = point(choices);
        match kind {
            Kind::Points => triangle(p, p, p),
            Kind::Segments => triangle(p, point(choices), p),
            Kind::Coplanar => {
                let corners = [p, point(choices), point(choices)];
                Triangle { corners: corners.map(|p| turned * Point::new(p.x, p.y, 0.0)) }
            }
            Kind::Lattice => {
                let corners = [p, point(choices), point(choices)];
                Triangle { corners: corners.map(|p| p.map(|x| (2.4 * x).round())) }
            }
            Kind::Needles => {
                let tip = point(choices);
                triangle(p, tip, p + (tip - p) * choices.unit() + choices.vector() * choices.between(-36, -6))
            }
            Kind::Mixed => {
                let size = choices.between(-30, 0);
                triangle(p, p + choices.vector() * size, p + choices.vector() * size)
            }
            Kind::Fan => {
                let tip = point(choices);
                triangle(Point::origin(), tip, tip + choices.vector() * choices.between(-20, 0))
            }
            Kind::Soup | Kind::Duplicates | Kind::Solid => triangle(p, point(choices), point(choices)),
        }
    };
    match kind {
        Kind::Solid => solid(choices).into_iter().map(|triangle| triangle.map(|p| turned * p)).collect(),
        Kind::Duplicates => {
            let Triangle { corners: [p, q, r] } = one(choices);
            let orders = [triangle(p, q, r), triangle(q, r, p), triangle(r, q, p)];
            (0..few).map(|_| choices.of(&orders)).collect()
        }
        _ => (0..few).map(|_| one(choices)).collect(),
    }
}

fn solid(choices: &mut Choices) -> Vec<Triangle> {
    let [x, y, z] = [choices.between(-6, 1), choices.between(-6, 1), choices.between(-6, 1)];
    match choices.below(4) {
        0 => meshes::sphere(1.0, 5, 3),
        1 => meshes::torus(0.8, 0.2, 6, 3),
        _ => meshes::cuboid(x, y, z),
    }
    .triangles()
}

//! The set-up of each sweep at each value of its quantity: two meshes, and the lines along which they meet.
//!
//! The bodies are parametric: a stepped milling tool in its holder, and a fixture with large plane faces, fine holes, a clamping screw and
//! a hand wheel. Lines of approach are drawn once, on the bodies at the neutral value of the sweep, and used for every value. Nothing but
//! the swept quantity changes.

use super::super::MeasureError;
use super::flip::flip_diagonals;
use crate::geometry::shapes::{Shape, Tessellation};
use crate::geometry::{Isometry, Mesh, Point, Vector};
use crate::truth::PairOracle;
use crate::workload::ray::{Contact, Ray, Target};
use nalgebra::{Translation3, Unit, UnitQuaternion};
use obbtree::cases::Draw;
use rayon::prelude::*;
use std::sync::Arc;

/// A cutter of 12 mm in its collet chuck, finely tessellated at the tip and coarsely at the holder. It lies along z, with its tip at z = 0.
const TOOL: &str = "
kind = 'revolve'
profile_mm = [
    [0, 0], [6, 0, 1], [6, 26], [5.6, 26.5], [5.6, 45], [10, 48, 1], [10, 52], [16, 54, 1], [16, 76, 1], [25, 80, 2],
    [25, 118, 1], [31.5, 122, 0.5], [31.5, 127, 0.5], [28, 130.5, 0.5], [28, 133, 0.5], [31.5, 136.5, 0.5], [31.5, 142, 1],
    [0, 142],
]";

/// A drilled block on a base plate with a clamping screw and a hand wheel.
const FIXTURE: &str = "
kind = 'compound'
[[parts]]
shape = { kind = 'rounded-box', size_mm = [160, 120, 90], fillet_mm = 4, holes = [
    { face = '+z', at_mm = [40, 30], radius_mm = 6, depth_mm = 40 }, { face = '+z', at_mm = [-40, 30], radius_mm = 6, depth_mm = 40 },
    { face = '+z', at_mm = [40, -30], radius_mm = 6, depth_mm = 40 }, { face = '+z', at_mm = [-40, -30], radius_mm = 6, depth_mm = 40 },
] }
[[parts]]
shape = { kind = 'rounded-box', size_mm = [320, 240, 30] }
at = { xyz_mm = [0, 0, -60] }
[[parts]]
shape = { kind = 'thread', radius_mm = 8, pitch_mm = 2, length_mm = 40 }
at = { xyz_mm = [110, 70, -45] }
density = 0.5
[[parts]]
shape = { kind = 'torus', ring_radius_mm = 40, tube_radius_mm = 5 }
at = { xyz_mm = [0, -85, 0], rpy_deg = [90, 0, 0] }
density = 0.5
";

/// Travel past first contact of the poses of most sweeps, mm: one pose before contact and one in contact.
const DEPTHS_MM: [f64; 2] = [-1.0, 1.0];
/// Axis about which frames are rotated; no face or edge of the bodies lies along it.
const TURN_ABOUT: [f64; 3] = [1.0, 2.0, 3.0];
/// Volume of the boxes of the aspect sweep, mm³.
const BAR_MM3: f64 = 216_000.0;
/// Number of attempts to draw a line that touches.
const ATTEMPTS: usize = 16;

/// The quantity that a sweep varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// `Tessellation::grading` of both bodies.
    Grading,
    /// Share of the diagonals of plane quadrilaterals that are flipped.
    Flips,
    /// `Tessellation::density` of both bodies; records state the resulting number of triangles.
    Size,
    /// Distance, mm: the negative of the travel past first contact.
    Offset,
    /// Rotation of both bodies in their own frames, degrees.
    Rotation,
    /// Length over width of a bar.
    Aspect,
    /// Distance between samples on a path, mm.
    Step,
    /// Largest number of triangles in a leaf.
    Leaf,
    /// ε of the separating-axis test; needs no bodies.
    Precision,
}

/// Two meshes, and the lines and depths at which they are examined.
#[derive(Debug)]
pub struct Bodies {
    /// The mesh in whose frame poses are given.
    pub a: Arc<Mesh>,
    /// The mesh that poses move.
    pub b: Arc<Mesh>,
    /// The lines along which the bodies meet; the same at every value.
    pub lines: Vec<Line>,
    /// Travel past first contact of the poses of every line, mm.
    pub depths_mm: Vec<f64>,
    /// Leaf size, if the sweep varies it.
    pub leaf: Option<u8>,
    /// Distance between samples, mm, in the sweep of the path step.
    pub step_mm: Option<f64>,
}

/// A line of approach, given by its first contact.
#[derive(Clone, Debug)]
pub struct Line {
    /// Number of the line, which determines its group.
    pub number: u32,
    ray: Ray,
}

impl Line {
    /// The pose (a from b) at a travel past first contact, mm; negative before it.
    pub fn at_depth(&self, depth_mm: f64) -> Isometry {
        self.ray.at_depth(depth_mm)
    }
}

/// The course of a line, before its first contact is known.
struct Course {
    number: u32,
    through: Isometry,
    direction: Unit<Vector>,
}

/// Sets up the bodies of a sweep at the value `x`, with `lines` lines of approach.
pub fn stage(quantity: Quantity, x: f64, lines: usize, seed: u64) -> Result<Bodies, MeasureError> {
    let even = Tessellation { density: 0.5, grading: 1.0 };
    let with =
        |tessellation: Tessellation| Ok::<_, MeasureError>([mesh(FIXTURE, &tessellation)?, mesh(TOOL, &tessellation)?]);
    let neutral = match quantity {
        Quantity::Aspect => [mesh(FIXTURE, &even)?, bar(x)?],
        _ => with(even)?,
    };
    let meshes = match quantity {
        Quantity::Grading => with(Tessellation { grading: x, ..even })?,
        Quantity::Size => with(Tessellation { density: x, ..even })?,
        Quantity::Flips => {
            let [a, b] = &neutral;
            [flip_diagonals(a, x, seed), flip_diagonals(b, x, seed)]
        }
        _ => neutral.clone(),
    };
    // Aspect changes a body's shape, and with it where lines can aim.
    let courses = courses(quantity, &neutral, lines, seed);
    let [a, b] = meshes.map(Arc::new);
    let (target_a, target_b) = (Target::new(&a), Target::new(&b));
    let oracle = PairOracle::new(Arc::clone(&a), Arc::clone(&b));
    let contact = Contact { oracle: &oracle, a: &target_a, b: &target_b };
    let cast = |course: &Course| {
        Ray::cast(&contact, &course.through, course.direction).map(|ray| Line { number: course.number, ray })
    };
    let lines: Vec<Line> = courses.par_iter().filter_map(cast).collect();
    let depths_mm = if quantity == Quantity::Offset { vec![-x] } else { DEPTHS_MM.to_vec() };
    let mut stage = Bodies { a, b, lines, depths_mm, leaf: None, step_mm: None };
    match quantity {
        Quantity::Rotation => stage.turn_frames(x),
        Quantity::Step => stage.step_mm = Some(x),
        Quantity::Leaf => stage.leaf = Some(x as u8),
        _ => {}
    }
    Ok(stage)
}

impl Bodies {
    /// Rotates both bodies in their own frames, and the lines with them, so that nothing moves in the world frame.
    fn turn_frames(&mut self, degrees: f64) {
        let axis = Unit::new_normalize(Vector::from(TURN_ABOUT));
        let turn = UnitQuaternion::from_axis_angle(&axis, degrees.to_radians());
        let turned = |mesh: &Mesh| {
            let vertices = mesh.vertices().iter().map(|p| turn * p).collect();
            // A turned body reaches at most √3 times as far along an axis, and these reach a tenth of the limit.
            Arc::new(Mesh::new(vertices, mesh.faces().to_vec()).expect("a turned mesh stays finite and in range"))
        };
        (self.a, self.b) = (turned(&self.a), turned(&self.b));
        for line in &mut self.lines {
            line.ray = line.ray.in_frames(&turn, &turn);
        }
    }
}

fn mesh(shape: &str, tessellation: &Tessellation) -> Result<Mesh, MeasureError> {
    let shape: Shape = toml::from_str(shape).map_err(|error| MeasureError::Body(error.to_string()))?;
    shape.mesh(tessellation).map_err(|error| MeasureError::Body(error.to_string()))
}

/// A rounded bar along x of constant volume; `aspect` is the ratio of its length to its width and height.
fn bar(aspect: f64) -> Result<Mesh, MeasureError> {
    let width = (BAR_MM3 / aspect).cbrt();
    let shape =
        format!("kind = 'rounded-box'\nsize_mm = [{:?}, {width:?}, {width:?}]\nfillet_mm = 2.0", aspect * width);
    mesh(&shape, &Tessellation { density: 2.0, grading: 1.0 })
}

/// Random lines: each passes through a random point of either surface in a random direction, with the moving body in a random orientation.
fn courses(quantity: Quantity, [a, b]: &[Mesh; 2], lines: usize, seed: u64) -> Vec<Course> {
    let (target_a, target_b) = (Target::new(a), Target::new(b));
    let oracle = PairOracle::new(Arc::new(a.clone()), Arc::new(b.clone()));
    let contact = Contact { oracle: &oracle, a: &target_a, b: &target_b };
    let label = if quantity == Quantity::Aspect { "bar" } else { "tool" };
    let course = |number: usize| {
        let mut draw = Draw::new(seed, &["sweep", label], number as u64);
        (0..ATTEMPTS).find_map(|_| {
            let (rotation, direction) = (draw.rotation(), draw.direction());
            let (on_a, on_b): (Point, Point) = (target_a.point(&mut draw), target_b.point(&mut draw));
            let through = Isometry::from_parts(Translation3::from(on_a - rotation * on_b), rotation);
            let hits = Ray::cast(&contact, &through, direction).is_some();
            hits.then_some(Course { number: number as u32, through, direction })
        })
    };
    (0..lines).into_par_iter().filter_map(course).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_the_frames_moves_nothing_in_the_world() {
        let still = stage(Quantity::Rotation, 0.0, 12, 1).unwrap();
        let turned = stage(Quantity::Rotation, 37.0, 12, 1).unwrap();
        assert_eq!(still.lines.len(), turned.lines.len());
        let (one, other) = (PairOracle::new(still.a, still.b), PairOracle::new(turned.a, turned.b));
        for (line, same) in still.lines.iter().zip(&turned.lines) {
            for depth in [-1.0, 1.0] {
                assert_eq!(one.touches(&line.at_depth(depth)), other.touches(&same.at_depth(depth)), "{}", line.number);
            }
        }
    }

    #[test]
    fn poses_before_first_contact_are_free_and_the_lines_stay_the_same() {
        for (quantity, x) in [(Quantity::Grading, 4.0), (Quantity::Aspect, 20.0), (Quantity::Flips, 1.0)] {
            let stage = stage(quantity, x, 12, 1).unwrap();
            assert!(stage.lines.len() >= 11, "{quantity:?}");
            let oracle = PairOracle::new(Arc::clone(&stage.a), Arc::clone(&stage.b));
            for line in &stage.lines {
                assert!(!oracle.touches(&line.at_depth(-1e-3)) && oracle.touches(&line.at_depth(1e-4)), "{quantity:?}");
            }
        }
    }

    #[test]
    fn the_bar_keeps_its_volume() {
        let volume = |aspect: f64| bar(aspect).unwrap().signed_volume();
        // The rounding of the edges takes more off the slender bar: (4 - π) r² times the length of its edges, r = 2, is
        // 3.4 times 4·(60 + 60 + 60) = 2500 of 216 000 for the cube, 3.4·4·(814 + 2·16) = 11 600 for the bar.
        assert!((volume(1.0) / BAR_MM3 - 1.0).abs() < 0.02 && (volume(50.0) / BAR_MM3 - 1.0).abs() < 0.06);
    }
}

//! How far apart are two meshes? Branch and bound as in [`crate::tree::distance`], over pairs of slots, in `f64`.
//!
//! The boxes are decoded to `f64`, whose rounding is below the slack of the pose that every bound is lowered by.

use super::code::Code;
use super::node::{Contents, WIDTH, WideTree};
use super::pose::Pose;
use super::turn;
use crate::geometry::grid::Placement;
use crate::geometry::{Isometry, Vector, certified, triangle_distance};
use crate::tree::distance::Proximity;
use crate::volume::separating_axes::{gap_mm, widened_abs};
use nalgebra::Matrix3;

/// A box in its mesh's frame, mm.
struct Decoded {
    axes: Matrix3<f64>,
    centre: Vector,
    half: Vector,
}

impl Decoded {
    fn new(tree: &WideTree, slot: u32) -> Self {
        let (node, place) = tree.slot(slot);
        let Code { centre, turn, half } = node.code(place);
        let wide = |x: [f32; 3]| Vector::from(x.map(f64::from));
        Self { axes: turn::decode(turn), centre: wide(node.origin) + wide(centre), half: wide(half) }
    }
}

/// The distance of the meshes, mm, where it is below `below_mm`; infinity where it is not. 0 when triangles touch.
pub fn distance_mm(a: &WideTree, b: &WideTree, a_from_b: &Isometry, below_mm: f64, proximity: &mut Proximity) -> f64 {
    let rotation = a_from_b.rotation.to_rotation_matrix().into_inner();
    let translation = a_from_b.translation.vector;
    let slack = f64::from(Pose::new(a_from_b, a.reach + b.reach).slack);
    let placement = Placement::new(a_from_b);
    let Proximity { stack, nearest } = proximity;
    let between = |i: u32, j: u32| {
        let (still, moved) = (a.triangle(i), placement.triangle(&b.triangle(j)));
        if certified::touch(&still, &moved) { 0.0 } else { triangle_distance::squared(&still, &moved).sqrt() }
    };
    let gap = |x: &Decoded, y: &Decoded| {
        let t = x.axes.tr_mul(&(rotation * y.centre + translation - x.centre));
        let r = x.axes.tr_mul(&(rotation * y.axes));
        gap_mm(&t, &r, &widened_abs(&r), &x.half, &y.half) - slack
    };
    let mut least = below_mm;
    if let Some((i, j)) = *nearest {
        least = least.min(between(i, j));
    }
    stack.clear();
    stack.push((gap(&Decoded::new(a, 0), &Decoded::new(b, 0)), (0, 0)));
    while let Some((bound, (x, y))) = stack.pop() {
        if bound >= least {
            continue;
        }
        let area = |tree: &WideTree, slot: u32| tree.slot(slot).0.code(slot as usize % WIDTH).area();
        let (node, of_b) = match (a.contents(x), b.contents(y)) {
            (Contents::Triangle(i), Contents::Triangle(j)) => {
                let distance = between(i, j);
                if distance < least {
                    (least, *nearest) = (distance, Some((i, j)));
                }
                continue;
            }
            (Contents::Node(node), Contents::Triangle(_)) => (node, false),
            (Contents::Node(node), Contents::Node(_)) if area(a, x) > area(b, y) => (node, false),
            (_, Contents::Node(node)) => (node, true),
        };
        let from = stack.len();
        let (one_a, one_b) = (Decoded::new(a, x), Decoded::new(b, y));
        let count = if of_b { b.nodes[node as usize].count } else { a.nodes[node as usize].count };
        for place in 0..u32::from(count) {
            let slot = node * WIDTH as u32 + place;
            let (bound, pair) = if of_b {
                (gap(&one_a, &Decoded::new(b, slot)), (x, slot))
            } else {
                (gap(&Decoded::new(a, slot), &one_b), (slot, y))
            };
            if bound < least {
                stack.push((bound, pair));
            }
        }
        // The nearest is opened first: it brings the distance down that the others are held against.
        stack[from..].sort_by(|p, q| q.0.total_cmp(&p.0));
    }
    if least < below_mm { least } else { f64::INFINITY }
}

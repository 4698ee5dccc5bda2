//! What is hollow of a body of revolution around its axis: the dish of an end mill, the bore of an annular cutter.
//!
//! Two bounds again, as lines of (ρ, z). Of every face the plane's distance from the axis is linear in z, and its own distance is that at least; another bound is the
//! least distance of what is of it between the two heights. Nothing is nearer to the axis than the least of them.
//! Along an edge the distance is convex in z, so beyond its chord there is material. How far a point is in the hollow is least at an end of a straight way, as ρ is
//! convex along it.

use super::convex::{HalfPlane, rho};
use super::round::SAME_HEIGHT_MM;
use crate::geometry::{Point, Vector};
use crate::interference::revolved::{clipped, nearest_to_axis};

/// Distance from the wall of a hollow up to which it is known, mm: a fifth of the standard resolution.
const KNOWN_MM: f64 = 0.02;

/// The hollow between two heights: radii at both, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoreSlab {
    z: [f64; 2],
    /// Nothing of the surface is nearer to the axis.
    pub empty: [f64; 2],
    /// From here on outwards the body is there for sure; `None` where nobody knows.
    pub filled: Option<[f64; 2]>,
}

/// The hollow of a piece of a body of revolution.
#[derive(Clone, Debug)]
pub(super) struct Bore {
    /// The piece is outside each of these half planes,
    empty: Vec<HalfPlane>,
    /// and outside what all of these share.
    empty_together: Vec<HalfPlane>,
    /// What is outside one of these is in the body, as far as the piece goes,
    filled: Vec<HalfPlane>,
    /// and what is outside all of these.
    filled_together: Vec<HalfPlane>,
    /// A radius in the ring, mm.
    pub middle_mm: f64,
}

impl BoreSlab {
    pub fn new(z: [f64; 2], places: &[Point], faces: &[[u32; 3]]) -> Self {
        let [low, high] = z;
        let is_within = |p: &Point| p.z > low + SAME_HEIGHT_MM && p.z < high - SAME_HEIGHT_MM;
        if places.iter().any(is_within) {
            return Self::unknown(z);
        }
        let spanning = faces.iter().map(|face| face.map(|corner| places[corner as usize])).filter(|corners| {
            let (least, most) =
                corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.z), h.max(p.z)));
            least <= low + SAME_HEIGHT_MM && most >= high - SAME_HEIGHT_MM
        });
        let (mut empty, mut filled) = ([f64::INFINITY; 2], None);
        for corners in spanning {
            let of_plane = plane_distance(&corners, z);
            let nearest = nearest_to_axis(&clipped(&corners, low, high)).map_or(0.0, |p| p.x.hypot(p.y));
            let of_face = if 2.0 * nearest > of_plane[0] + of_plane[1] { [nearest; 2] } else { of_plane };
            empty = [0, 1].map(|k| f64::min(empty[k], of_face[k]));
            for side in 0..3 {
                let of_edge = chord(&corners[side], &corners[(side + 1) % 3], z);
                let is_nearer = |edge: &[f64; 2]| filled.is_none_or(|[a, b]: [f64; 2]| edge[0] + edge[1] < a + b);
                filled = of_edge.filter(is_nearer).or(filled);
            }
        }
        Self { z, empty: empty.map(|r| if r.is_finite() { r } else { 0.0 }), filled }
    }

    /// One of which nothing is known.
    pub const fn unknown(z: [f64; 2]) -> Self {
        Self { z, empty: [0.0; 2], filled: None }
    }

    /// Whether nothing is known to be filled.
    pub const fn is_vague(&self) -> bool {
        self.filled.is_none()
    }
}

/// How near the plane of a triangle comes to the axis at two heights, mm: linear between them, and below the triangle's own distance.
fn plane_distance([a, b, c]: &[Point; 3], z: [f64; 2]) -> [f64; 2] {
    let normal = (b - a).cross(&(c - a));
    let across = normal.x.hypot(normal.y);
    let offset = normal.dot(&a.coords);
    let signed = z.map(|z| (offset - normal.z * z) / across);
    let [below, above] = if signed[0] + signed[1] < 0.0 { signed.map(|s| -s) } else { signed };
    // The tip of a cone on the axis may be rounded to the other side.
    if below.min(above) > -SAME_HEIGHT_MM { [below.max(0.0), above.max(0.0)] } else { [0.0; 2] }
}

/// The distances from the axis at two heights of an edge that spans them, mm.
fn chord(p: &Point, q: &Point, z: [f64; 2]) -> Option<[f64; 2]> {
    let (p, q) = if p.z <= q.z { (p, q) } else { (q, p) };
    (p.z <= z[0] + SAME_HEIGHT_MM && q.z >= z[1] - SAME_HEIGHT_MM).then(|| {
        z.map(|z| {
            let at = p + (q - p) * ((z - p.z) / (q.z - p.z)).clamp(0.0, 1.0);
            at.x.hypot(at.y)
        })
    })
}

impl Bore {
    /// The hollow of slabs that lie one upon another, with the outer radii of each; `None` where nothing is hollow for sure or nothing filled.
    pub fn of(slabs: &[BoreSlab], outer: &[[f64; 2]]) -> Option<Self> {
        let filled: Vec<[f64; 2]> = slabs.iter().map(|slab| slab.filled).collect::<Option<_>>()?;
        if slabs.is_empty() {
            return None;
        }
        let corners = |radii: &dyn Fn(usize) -> [f64; 2]| -> Vec<[[f64; 2]; 2]> {
            (0..slabs.len()).map(|i| [0, 1].map(|k| [radii(i)[k], slabs[i].z[k]])).collect()
        };
        let line = |pair: &[[f64; 2]]| HalfPlane::below_line(pair[0], pair[1]);
        let inside = corners(&|i| slabs[i].empty);
        let outside = corners(&|i| filled[i]);
        let filled_together: Vec<HalfPlane> = outside.iter().filter_map(|pair| line(pair)).collect();
        let hull = upper_envelope(outside.as_flattened());
        let most = filled.iter().flatten().fold(0.0, |most: f64, &r| most.max(r));
        let least = outer.iter().flatten().fold(f64::INFINITY, |least: f64, &r| least.min(r));
        Some(Self {
            empty: envelope(inside.as_flattened()).windows(2).filter_map(line).collect(),
            empty_together: inside.iter().filter_map(|pair| line(pair)).collect(),
            filled: hull.windows(2).filter_map(line).collect(),
            filled_together,
            middle_mm: f64::midpoint(most, least),
        })
    }

    /// Whether the hollow of slabs that lie one upon another is known to within [`KNOWN_MM`]: a step between two radii is not.
    pub fn is_known(slabs: &[BoreSlab]) -> bool {
        let is_at_wall = |bore: &Self, slab: &BoreSlab, k: usize| {
            let wall = Vector::new(slab.empty[k], 0.0, slab.z[k]);
            bore.hollow(&wall, &wall) >= -KNOWN_MM
        };
        Self::of(slabs, &[])
            .is_none_or(|bore| slabs.iter().all(|slab| is_at_wall(&bore, slab, 0) && is_at_wall(&bore, slab, 1)))
    }

    /// How far a point is in the hollow at least, wherever it is on the way from `p` to `q`, mm; negative where it may be outside.
    pub fn hollow(&self, p: &Vector, q: &Vector) -> f64 {
        let ends = [p, q].map(|end| (rho(end), end.z));
        let of = |plane: &HalfPlane| ends.map(|(rho, z)| plane.depth(rho, z)).into_iter().fold(f64::INFINITY, f64::min);
        let together = self.empty_together.iter().map(of).fold(f64::INFINITY, f64::min);
        self.empty.iter().map(of).fold(together, f64::max)
    }

    /// How far a point is from what is filled for sure, mm; negative inside.
    pub fn short_of(&self, p: &Vector) -> f64 {
        let rho = rho(p);
        let of = |plane: &HalfPlane| plane.depth(rho, p.z);
        let together = self.filled_together.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        self.filled.iter().map(of).fold(together, f64::min)
    }
}

impl HalfPlane {
    /// How deep (ρ, z) is in it, mm.
    fn depth(&self, rho: f64, z: f64) -> f64 {
        self.c - self.a * rho - self.b * z
    }
}

/// The lower envelope, convex in z, of points (ρ, z) in the order of z.
fn envelope(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut hull: Vec<[f64; 2]> = Vec::new();
    for &[r, z] in points {
        if let Some(last) = hull.last_mut().filter(|last| z - last[1] <= SAME_HEIGHT_MM) {
            last[0] = last[0].min(r);
        } else {
            hull.push([r, z]);
        }
        while let [.., a, b, c] = hull[..]
            && (b[0] - a[0]) * (c[1] - b[1]) >= (c[0] - b[0]) * (b[1] - a[1])
        {
            let last = hull.len() - 1;
            hull.remove(last - 1);
        }
    }
    hull
}

/// The upper envelope, concave in z, of points (ρ, z) in the order of z.
pub(super) fn upper_envelope(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mirrored: Vec<[f64; 2]> = points.iter().map(|&[r, z]| [-r, z]).collect();
    envelope(&mirrored).into_iter().map(|[r, z]| [-r, z]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_envelope_is_below_all_points_and_convex() {
        let points = [[4.0, 0.0], [2.0, 0.4], [2.0, 0.4], [1.0, 0.5], [3.0, 0.7]];
        assert_eq!(envelope(&points), [[4.0, 0.0], [1.0, 0.5], [3.0, 0.7]]);
    }
}

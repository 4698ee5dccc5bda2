//! How deep what a cut leaves of a cube can come into a part.
//!
//! What slides along a surface that has just been cut is nowhere in the stock, and yet near it all along. Cells small enough to show that are as many as the surface
//! has squares of the resolution. Two convex bodies tell for a large cube at once. Throughout the cube the part's excess is at least a linear function f, as convex
//! functions are above their tangents. The cut's excess at one place of its way is a convex function g. A point that the cut leaves has g + s > 0 with
//! the slack s of the cut, so its depth in the part is at most -f < g + s - f. That is convex, so it is nowhere greater than at the corners of the cube. The pieces
//! of a part are asked one by one, as its depth is the greatest of theirs; of a cut one piece is enough.
//!
//! Of cutters that stand while the workpiece turns the same holds in (ρ, z).

use super::convex::{Convex, Cube, rho};
use super::sweep::{Form, Sweep, Way};
use crate::geometry::{Point, Vector};

/// Linear functions of the place beside a cube's centre; a part's excess is above the least of them.
pub(super) struct Tangents {
    /// Values at the centre, mm, and gradients: in the stock's frame, or in (ρ, 0, z).
    planes: Vec<(f64, Vector)>,
    is_turned: bool,
}

/// How far (ρ, z) in a cube may be from its centre's.
struct Ring {
    rho: f64,
    z: f64,
    /// Least and greatest of both beside the centre.
    beside: [[f64; 2]; 2],
}

impl Ring {
    fn new(at: &Point, [across, along]: [f64; 2]) -> Self {
        let rho = rho(&at.coords);
        Self { rho, z: at.z, beside: [[-across.min(rho), across], [-along, along]] }
    }

    /// The corners of the cube's (ρ, z) beside the centre's.
    fn corners(&self) -> impl Iterator<Item = Vector> {
        let [rho, z] = self.beside;
        (0..4).map(move |k| Vector::new(rho[k & 1], 0.0, z[k >> 1]))
    }
}

/// The corners of a cube beside its centre.
fn corners(half: f64) -> impl Iterator<Item = Vector> {
    let side = move |k: usize, axis: usize| if k >> axis & 1 == 0 { -half } else { half };
    (0..8).map(move |k| Vector::new(side(k, 0), side(k, 1), side(k, 2)))
}

impl Tangents {
    /// The greatest of `excess` less the least of the functions.
    fn below(&self, offset: &Vector, excess: f64) -> f64 {
        self.planes.iter().map(|(value, normal)| excess - value - normal.dot(offset)).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Sweep {
    /// Tangents of the excess over a cube of the stock, of all pieces that reach into it; `asked` as for [`Self::depth`].
    pub(super) fn tangents(&self, centre: &Point, half: f64, asked: &mut u64) -> Tangents {
        let radius = half * 3f64.sqrt();
        match &self.way {
            Way::Chords { form, course } => {
                let (q, travel) = course.at(centre);
                let bent = course.bend() * radius;
                let planes = match &**form {
                    Form::Round(round) => {
                        let axes = course.axes();
                        let cube = Cube { half, radius, axes, inside: f64::NEG_INFINITY, outside: self.pad + bent };
                        let in_stock = |normal: &Vector| Vector::from(axes.map(|axis| axis.dot(normal)));
                        let all = round.lowest(&q, &travel, &cube);
                        let reaching = all.filter(|(_, found)| found.least.deep - bent < self.pad);
                        reaching.map(|(_, found)| (found.value - bent - self.pad, in_stock(&found.normal))).collect()
                    }
                    Form::Rigid(_) => vec![(self.depth(centre, half, asked).deep, Vector::zeros())],
                };
                Tangents { planes, is_turned: false }
            }
            Way::Turned { section, shift, axis_from_stock, ring } => {
                let ring = Ring::new(&(axis_from_stock * centre), ring.map(|part| part * half));
                let planes = section.tangents(ring.rho, ring.z, shift);
                let planes = planes.map(|(value, normal)| (value - self.pad, normal));
                Tangents { planes: planes.filter(|(value, _)| *value < radius).collect(), is_turned: true }
            }
        }
    }

    /// How deep what this cut leaves of a cube can come into the part that has these tangents, mm: less than this. Infinite where it is not less than `than_mm`.
    pub(super) fn leaves(&self, centre: &Point, half: f64, tangents: &Tangents, than_mm: f64) -> f64 {
        let radius = half * 3f64.sqrt();
        match &self.way {
            Way::Chords { form, course } if !tangents.is_turned => {
                let Form::Round(round) = &**form else { return f64::INFINITY };
                let ((q, travel), axes) = (course.at(centre), course.axes());
                let cube = Cube { half, radius, axes, inside: f64::NEG_INFINITY, outside: 0.0 };
                // What a hollow piece leaves is not convex.
                let solid = round.lowest(&q, &travel, &cube).filter(|(piece, _)| piece.bore.is_none());
                let nearest = solid.min_by(|(_, a), (_, b)| a.least.high.total_cmp(&b.least.high));
                let Some((piece, found)) = nearest.filter(|(_, found)| found.least.high.is_finite()) else {
                    return f64::INFINITY;
                };
                let (there, slack) = (q - travel * found.at, self.pad + course.bend() * radius);
                // The greatest value is not below the centre's.
                if tangents.below(&Vector::zeros(), found.least.high + self.pad) >= than_mm {
                    return f64::INFINITY;
                }
                let excess = |offset: &Vector| {
                    let p = there + axes[0] * offset.x + axes[1] * offset.y + axes[2] * offset.z;
                    piece.short_of(rho(&p), p.z) + slack
                };
                greatest(corners(half), tangents, excess)
            }
            Way::Turned { section, shift, axis_from_stock, ring } if tangents.is_turned => {
                let ring = Ring::new(&(axis_from_stock * centre), ring.map(|part| part * half));
                let Some((piece, at)) = section.nearest(ring.rho, ring.z, shift) else { return f64::INFINITY };
                let excess = |offset: &Vector| excess_of_section(piece, &ring, offset, shift.at(at)) + self.pad;
                greatest(ring.corners(), tangents, excess)
            }
            _ => f64::INFINITY,
        }
    }
}

fn greatest(corners: impl Iterator<Item = Vector>, tangents: &Tangents, excess: impl Fn(&Vector) -> f64) -> f64 {
    corners.map(|offset| tangents.below(&offset, excess(&offset))).fold(f64::NEG_INFINITY, f64::max)
}

fn excess_of_section(piece: &Convex, ring: &Ring, offset: &Vector, [x, z]: [f64; 2]) -> f64 {
    piece.excess(ring.rho + offset.x - x, ring.z + offset.z - z)
}

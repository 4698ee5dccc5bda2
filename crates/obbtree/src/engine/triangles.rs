//! Pairs of triangles, four at a time: which of them touch, exactly.
//!
//! The corners of each triangle are put on a side of the other's plane (O. Devillers, P. Guigue, INRIA RR-4488, 2002), four pairs at once.
//! A pair whose triangle is strictly on one side by more than the error of the determinants is apart; most are. The others are decided one by one, from
//! the sides that the lanes have found, by what is left of the test in [`certified`], and what that cannot decide goes to the exact test.
//!
//! The corners of `b` are moved and snapped by the very operations of [`crate::engine::geometry::grid::Placement`], so that all methods see the same triangles.

use super::lanes::{DOUBLES, DoubleLanes, three};
use super::measure::{self, Measured, minus};
use super::node::WideTree;
use super::volume::WideVolume;
use crate::engine::geometry::grid::Placement;
use crate::engine::geometry::plane::{ERROR, Side};
use crate::engine::geometry::{Point, Triangle};
use crate::engine::geometry::{certified, exact};

/// Rounding of a component of a normal, relative to the sum of its products' magnitudes, 8·2⁻⁵³: see [`sides`].
const NORMAL: f64 = 8.0 / 9_007_199_254_740_992.0;
/// What a height over a plane is multiplied by, 1 - 32·2⁻⁵³: see [`sides`].
const HEIGHT: f64 = 1.0 - 32.0 / 9_007_199_254_740_992.0;

/// Pairs that wait until they fill the lanes. Of a search that ends with the first contact more at a time would cost visits: it is
/// known sooner with few.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Batch {
    pairs: [(u32, u32); DOUBLES],
    len: usize,
}

impl Batch {
    /// One pair more, by their places in tree order. Whether it is full now.
    #[inline(always)]
    pub fn push(&mut self, pair: (u32, u32)) -> bool {
        self.pairs[self.len] = pair;
        self.len += 1;
        self.len == DOUBLES
    }

    /// How many pairs wait.
    #[inline(always)]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// The pair with the given number.
    #[inline(always)]
    pub const fn pair(&self, i: usize) -> (u32, u32) {
        self.pairs[i]
    }

    /// What the planes tell of each pair, into `sided`; with `KEEPS` also how far apart they are at least. The batch is empty afterwards.
    #[inline(always)]
    pub fn side<D: DoubleLanes, V: WideVolume, const KEEPS: bool>(
        &mut self,
        (a, b): (&WideTree<V>, &WideTree<V>),
        placement: &Placement,
        sided: &mut Sided,
    ) {
        let (waiting, [p, q]) = self.take::<D, V>(a, b, placement);
        let ((of_b, height_b), (of_a, height_a)) = (sides::<D, KEEPS>(&p, &q), sides::<D, KEEPS>(&q, &p));
        (sided.of_b, sided.of_a) = (of_b, of_a);
        sided.unparted = waiting & !(of_b.on_one() | of_a.on_one());
        if sided.unparted != 0 {
            sided.corners = [stored(&p), stored(&q)];
        }
        if KEEPS {
            let unparted_mm = if sided.unparted == 0 { [0.0; DOUBLES] } else { measure::at_least_mm(&p, &q) };
            let (of_b, of_a) = ((of_b.on_one(), height_b.stored()), (of_a.on_one(), height_a.stored()));
            for (lane, apart_mm) in sided.apart_mm.iter_mut().enumerate() {
                let height =
                    |(parted, height): (u8, [f64; DOUBLES])| if parted >> lane & 1 != 0 { height[lane] } else { 0.0 };
                *apart_mm = height(of_b).max(height(of_a)).max(unparted_mm[lane]);
            }
        }
    }

    /// A bit for each pair, and about how far apart they are; the batch is empty afterwards.
    #[inline(always)]
    pub fn measured<D: DoubleLanes, V: WideVolume>(
        &mut self,
        a: &WideTree<V>,
        b: &WideTree<V>,
        placement: &Placement,
    ) -> (u8, Measured<D>) {
        let (waiting, [p, q]) = self.take::<D, V>(a, b, placement);
        (waiting, Measured::of(&p, &q))
    }

    /// A bit for each pair, and their corners in the frame of `a`; the batch is empty afterwards.
    #[inline(always)]
    fn take<D: DoubleLanes, V: WideVolume>(
        &mut self,
        a: &WideTree<V>,
        b: &WideTree<V>,
        placement: &Placement,
    ) -> (u8, [[[D; 3]; 3]; 2]) {
        let mut corners = [[[[0.0; DOUBLES]; 3]; 3]; 2];
        for (lane, &(i, j)) in self.pairs.iter().enumerate().take(self.len) {
            spread(&a.triangle(i), lane, &mut corners[0]);
            spread(&b.triangle(j), lane, &mut corners[1]);
        }
        let waiting = (1 << self.len) - 1;
        self.len = 0;
        let [p, q] = [loaded::<D>(&corners[0]), loaded::<D>(&corners[1])];
        (waiting, [p, three!(corner => placement.coordinates(q[corner]))])
    }
}

/// Puts a triangle's coordinates into a lane.
#[inline(always)]
fn spread(triangle: &Triangle, lane: usize, to: &mut [[[f64; DOUBLES]; 3]; 3]) {
    for (corner, lanes) in triangle.corners.iter().zip(to) {
        for (x, lanes) in corner.iter().zip(lanes) {
            lanes[lane] = *x;
        }
    }
}

/// Pairs of triangles, and on which sides of their planes they are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sided {
    /// A bit for each pair that the planes do not part.
    pub unparted: u8,
    /// The sides of the planes of `a` that the corners of `b` are on, and the other way round.
    of_b: Sides,
    of_a: Sides,
    /// The corners of `a` and of `b` in the frame of `a`, mm, where a pair is unparted.
    corners: [[[[f64; DOUBLES]; 3]; 3]; 2],
    /// How far apart each pair is at least if it does not touch, mm, where that is asked for.
    pub apart_mm: [f64; DOUBLES],
}

impl Sided {
    /// Whether the unparted pair in a lane touches; exactly.
    #[inline(always)]
    pub fn touch(&self, lane: u32) -> bool {
        let of = |corners: &[[[f64; DOUBLES]; 3]; 3]| {
            let corner = |i: usize| Point::from(three!(k => corners[i][k][lane as usize]));
            Triangle { corners: three!(i => corner(i)) }
        };
        let (a, b) = (of(&self.corners[0]), of(&self.corners[1]));
        certified::by_sides((&a, &b), self.of_b.in_lane(lane), self.of_a.in_lane(lane))
            .unwrap_or_else(|| exact::bounds_overlap(&a, &b) && certified::undecided(&a, &b))
    }
}

/// For each corner a bit for each lane in which it is above a plane, and one for each in which it is below it, for certain.
#[derive(Clone, Copy, Debug, Default)]
struct Sides {
    above: [u8; 3],
    below: [u8; 3],
}

impl Sides {
    /// A bit for each lane in which all corners are strictly on one side.
    #[inline(always)]
    const fn on_one(&self) -> u8 {
        let Self { above: [x, y, z], below: [u, v, w] } = *self;
        (x & y & z) | (u & v & w)
    }

    /// The sides in a lane.
    #[inline(always)]
    const fn in_lane(&self, lane: u32) -> [Side; 3] {
        three!(i => (self.above[i] >> lane & 1) as Side - (self.below[i] >> lane & 1) as Side)
    }
}

/// The sides of the plane of `p` that the corners of `q` are on; with `KEEPS` also how far all of them are from it at least, mm, where they are on one.
///
/// That is the least determinant less its error, over the length of the normal, which is at most that of a computed one whose components are
/// enlarged by `NORMAL`·2⁻⁵³ of their products' magnitudes. `HEIGHT` pays for the roundings of both.
#[inline(always)]
fn sides<D: DoubleLanes, const KEEPS: bool>(p: &[[D; 3]; 3], q: &[[D; 3]; 3]) -> (Sides, D) {
    let (e, f) = (minus(&p[1], &p[0]), minus(&p[2], &p[0]));
    let (mut normal, mut size) = ([D::all(0.0); 3], [D::all(0.0); 3]);
    for k in 0..3 {
        let (k1, k2) = ((k + 1) % 3, (k + 2) % 3);
        let (one, other) = (e[k1] * f[k2], e[k2] * f[k1]);
        (normal[k], size[k]) = (one - other, one.abs() + other.abs());
    }
    let mut sides = Sides { above: [0; 3], below: [0; 3] };
    let mut least = D::all(f64::INFINITY);
    for (i, corner) in q.iter().enumerate() {
        let d = minus(corner, &p[0]);
        let height = d[0] * normal[0] + d[1] * normal[1] + d[2] * normal[2];
        let error = D::all(ERROR) * (d[0].abs() * size[0] + d[1].abs() * size[1] + d[2].abs() * size[2]);
        sides.above[i] = height.exceeds(error);
        sides.below[i] = (D::all(0.0) - height).exceeds(error);
        if KEEPS {
            least = least.min(height.abs() - error);
        }
    }
    if KEEPS {
        let long = three!(k => normal[k].abs() + D::all(NORMAL) * size[k]);
        let squared = long[0] * long[0] + long[1] * long[1] + long[2] * long[2];
        least = least / squared.sqrt() * D::all(HEIGHT);
    }
    (sides, least)
}

#[inline(always)]
fn stored<D: DoubleLanes>(corners: &[[D; 3]; 3]) -> [[[f64; DOUBLES]; 3]; 3] {
    three!(i => three!(k => corners[i][k].stored()))
}

#[inline(always)]
fn loaded<D: DoubleLanes>(from: &[[[f64; DOUBLES]; 3]; 3]) -> [[D; 3]; 3] {
    three!(corner => three!(k => D::load(&from[corner][k])))
}

#[cfg(test)]
mod tests {
    use super::super::lanes::{Machine, Simd, Work};
    use super::*;
    use crate::engine::geometry::Vector;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// The sides of one plane that the corners of a triangle are on, and how far they are from it at least.
    struct Siding<'a>(&'a Triangle, &'a Triangle);

    impl Work for Siding<'_> {
        type Output = ([Side; 3], f64);

        #[inline(always)]
        fn run<M: Machine>(self) -> Self::Output {
            let mut corners = [[[[0.0; DOUBLES]; 3]; 3]; 2];
            spread(self.0, 2, &mut corners[0]);
            spread(self.1, 2, &mut corners[1]);
            let [p, q] = corners.each_ref().map(loaded::<M::Double>);
            let (sides, height) = sides::<M::Double, true>(&p, &q);
            (sides.in_lane(2), height.stored()[2])
        }
    }

    /// 1 mm over a right triangle of legs of 1 mm: the determinant less 8·2⁻⁵³, over the normal and 8·2⁻⁵³ more, less 32·2⁻⁵³. Beside it, where two more
    /// products have errors, the determinant is not as sure.
    #[test]
    fn a_height_is_told_less_its_errors() {
        let u = 0.5_f64.powi(53);
        for simd in Simd::available() {
            for axis in 0..3 {
                let at = |x: f64, y: f64, z: f64| {
                    let mut corner = Point::origin();
                    (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (z, x, y);
                    corner
                };
                let flat = Triangle::new(at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0));
                for (z, side) in [(1.0, 1), (-1.0, -1)] {
                    let over = Triangle::new(at(0.3, 0.2, z), at(7.0, -3.0, 2.0 * z), at(0.0, 0.0, 9.0 * z));
                    let (sides, height) = simd.run(Siding(&flat, &over));
                    assert_eq!(sides, [side; 3], "{}", simd.name());
                    assert!((44.0..52.0).contains(&((1.0 - height) / u)), "{} {height}", simd.name());
                }
            }
        }
    }

    /// Corners over a plane by a share of the error of their determinant, which the rounding of the corners changes by a third of it at most.
    #[test]
    fn a_corner_is_on_a_side_when_the_determinant_exceeds_its_error() {
        let mut random = Pcg64::seed_from_u64(11);
        let mut vector = |scale: [f64; 3]| Vector::from(scale.map(|scale| scale * random.random_range(-1.0..=1.0_f64)));
        let mut asked = 0;
        for k in 0..2000 {
            let scale = [[1.0, 1.0, 1.0], [30.0, 1.0, 1.0], [1.0, 30.0, 1.0], [1.0, 1.0, 30.0]][k % 4];
            let (p, e, f) = (vector([1.0; 3]), vector(scale), vector(scale));
            let normal = e.cross(&f);
            let size = Vector::from_fn(|k, _| {
                let (k1, k2) = ((k + 1) % 3, (k + 2) % 3);
                (e[k1] * f[k2]).abs() + (e[k2] * f[k1]).abs()
            });
            let plane = Triangle::new(p.into(), (p + e).into(), (p + f).into());
            let way = e * 0.4 - f * 0.7;
            let error = ERROR * way.abs().dot(&size);
            for (share, side) in [(0.4, 0), (2.0, 1), (-0.4, 0), (-2.0, -1)] {
                let over = Point::from(p + way + normal * (share * error / normal.norm_squared()));
                let found = exact_height(&plane, &over) / error;
                // What rounding has left of the share.
                if (found - share).abs() > 0.3 {
                    continue;
                }
                asked += 1;
                for simd in Simd::available() {
                    let (sides, _) = simd.run(Siding(&plane, &Triangle::new(over, over, over)));
                    assert_eq!(sides, [side; 3], "{k}, {share}, {}", simd.name());
                }
            }
        }
        assert!(asked > 4000, "{asked} of 8000");
    }

    /// The determinant, by expansions of `f64`.
    fn exact_height(plane: &Triangle, point: &Point) -> f64 {
        let coord = |p: &Point| robust::Coord3D { x: p.x, y: p.y, z: p.z };
        let [a, b, c] = plane.corners.each_ref().map(coord);
        -robust::orient3d(a, b, c, coord(point))
    }
}

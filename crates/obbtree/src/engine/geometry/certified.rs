//! Whether two closed triangles share a point: the triangle test that all methods, and the ground truth, share. It is exact, and nearly
//! always as fast as a test in plain `f64`.
//!
//! O. Devillers, P. Guigue, INRIA RR-4488, 2002: the corners of each triangle are classified by the side of the other's plane, which
//! settles most pairs. Otherwise both triangles intersect the common line of the two planes in an interval, and two more determinants
//! decide whether the intervals overlap. Every determinant has an error bound ([`super::plane`], which states the range of coordinates).
//! When a sign is not certain, [`super::exact`] decides, in integers if the corners are on the grid. Touching counts as contact.
//!
//! Deviation: pairs whose coordinate intervals do not overlap are disjoint, which is decided first because it is exact and cheapest.

use super::plane::{Plane, Side};
use super::{Point, Triangle, exact};

/// Whether the triangles, mm, share at least one point. Exact; unspecified when a coordinate is not finite.
#[inline]
#[must_use]
pub fn touch(a: &Triangle, b: &Triangle) -> bool {
    exact::bounds_overlap(a, b) && touch_in_bounds(a, b)
}

/// Like [`touch`], for triangles whose coordinate intervals overlap, with planes that the caller keeps.
#[inline]
#[must_use]
pub fn touch_by_planes((a, plane_of_a): (&Triangle, &Plane), (b, plane_of_b): (&Triangle, &Plane)) -> bool {
    decided((a, b), plane_of_a.sides(b), || plane_of_b.sides(a)).unwrap_or_else(|| undecided(a, b))
}

/// Like [`touch`], for triangles whose coordinate intervals overlap.
fn touch_in_bounds(a: &Triangle, b: &Triangle) -> bool {
    decided((a, b), Plane::of(a).sides(b), || Plane::of(b).sides(a)).unwrap_or_else(|| undecided(a, b))
}

/// The answer if `f64` can give it, from the certain sides of the corners: `b_sides` are the sides of `b`'s corners relative to the plane
/// of `a`, and `a_sides` the reverse. Neither plane may separate the triangles.
#[inline(always)]
pub(crate) fn by_sides(pair: (&Triangle, &Triangle), b_sides: [Side; 3], a_sides: [Side; 3]) -> Option<bool> {
    decided(pair, b_sides, || a_sides)
}

/// Decides the pairs that `f64` leaves undecided. Not inlined, because such pairs are rare.
#[cold]
#[inline(never)]
pub(crate) fn undecided(a: &Triangle, b: &Triangle) -> bool {
    exact::touch_on_grid(a, b).unwrap_or_else(|| exact::touch(a, b))
}

/// The answer if `f64` can give it, from the sides of each triangle's corners relative to the other's plane; `a_sides` is called only when
/// needed.
#[inline(always)]
fn decided((a, b): (&Triangle, &Triangle), b_sides: [Side; 3], a_sides: impl FnOnce() -> [Side; 3]) -> Option<bool> {
    if on_one_side(b_sides) {
        return Some(false);
    }
    let a_sides = a_sides();
    if on_one_side(a_sides) {
        return Some(false);
    }
    let ((apex_a, a_above), (apex_b, b_above)) = (apex(a_sides)?, apex(b_sides)?);
    let from = |t: &Triangle, i: usize| [t.corners[i], t.corners[(i + 1) % 3], t.corners[(i + 2) % 3]];
    let [a0, mut a1, mut a2] = from(a, apex_a);
    let [b0, mut b1, mut b2] = from(b, apex_b);
    // Turning a triangle over turns its plane over: afterwards both apexes are above the other's plane, and both
    // intervals run the same way: from the edge (0, 1) to the edge (0, 2) for b, the other way for a.
    if !a_above {
        std::mem::swap(&mut b1, &mut b2);
    }
    if !b_above {
        std::mem::swap(&mut a1, &mut a2);
    }
    let low = side([&a0, &a1, &b0], &b1);
    if low > 0 {
        return Some(false);
    }
    let high = side([&a0, &a2, &b0], &b2);
    if high < 0 {
        return Some(false);
    }
    (low < 0 && high > 0).then_some(true)
}

fn side([p, q, r]: [&Point; 3], s: &Point) -> Side {
    Plane::new(p, q, r).side(s)
}

const fn on_one_side([x, y, z]: [Side; 3]) -> bool {
    x != 0 && x == y && y == z
}

/// The corner that the other plane separates from the other two, and whether it is above; `None` when a side is not certain.
const fn apex(sides: [Side; 3]) -> Option<(usize, bool)> {
    match sides {
        [x, y, z] if x == 0 || y == 0 || z == 0 => None,
        [x, y, z] if y == z => Some((0, x > 0)),
        [x, y, z] if x == z => Some((1, y > 0)),
        [_, _, z] => Some((2, z > 0)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::cross_check::{compare, needles};
    use super::super::exact::tests::{hand_made, orders};
    use super::super::exact_integer;
    use super::super::grid::{LIMIT_MM, STEP_MM};
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Number of pairs. In an unoptimised build, two hundred thousand take a minute.
    const PAIRS: u64 = if cfg!(debug_assertions) { 20_000 } else { 200_000 };

    #[test]
    fn every_hand_made_case_in_every_order_and_both_ways() {
        for (name, a, b, expected) in hand_made() {
            for a in orders(&a) {
                for b in orders(&b) {
                    assert_eq!(touch(&a, &b), expected, "{name}: {a:?} {b:?}");
                    assert_eq!(touch(&b, &a), expected, "{name}, swapped: {a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn the_answer_is_the_integer_twins_on_two_hundred_thousand_hard_pairs() {
        let check = compare(7, PAIRS, &[&touch]);
        assert_eq!(check.disagreements, 0, "{:?}", check.examples);
        // Were every answer taken from `f64`, some would be wrong: the bound is needed.
        let unbounded = compare(7, PAIRS, &[&without_bound]);
        assert!(unbounded.disagreements > PAIRS / 2000, "{}", unbounded.disagreements);
    }

    /// The same determinants without error bounds.
    fn without_bound(a: &Triangle, b: &Triangle) -> bool {
        let sides = |t: &Triangle, other: &Triangle| {
            let (p, normal) = (t.corners[0], t.double_area_normal());
            other.corners.each_ref().map(|corner| {
                let height = normal.dot(&(corner - p));
                Side::from(height > 0.0) - Side::from(height < 0.0)
            })
        };
        exact::bounds_overlap(a, b)
            && decided((a, b), sides(a, b), || sides(b, a)).unwrap_or_else(|| exact::touch(a, b))
    }

    /// Fifty thousand pairs of needles, 1 to 1000 mm long and 1e-9 to 1e-3 mm wide. A test in plain `f64` missed 1.5 % of the contacts.
    #[test]
    fn needles_that_cross_are_seen_and_needles_that_pass_are_not() {
        let mut random = Pcg64::seed_from_u64(11);
        let (mut touching, mut missed, mut invented) = (0, 0, 0);
        for _ in 0..50_000 {
            let [a, b] = needles(&mut random);
            let truth = exact_integer::touch(&a, &b).expect("needles are on the grid");
            assert_eq!((touch(&a, &b), touch(&b, &a)), (truth, truth), "{a:?} {b:?}");
            let planes = exact::bounds_overlap(&a, &b) && touch_by_planes((&a, &Plane::of(&a)), (&b, &Plane::of(&b)));
            assert_eq!(planes, truth, "by planes: {a:?} {b:?}");
            touching += u32::from(truth);
            missed += u32::from(truth && !without_bound(&a, &b));
            invented += u32::from(!truth && without_bound(&a, &b));
        }
        assert!((10_000..40_000).contains(&touching), "{touching}");
        assert!(
            missed + invented > 100,
            "the needles are hard: {missed} missed, {invented} invented without the bound"
        );
    }

    /// Tests from the finest grid step to the far corners of a mesh's range, unmoved and moved.
    #[test]
    fn the_ends_of_the_range_are_exact() {
        let mut random = Pcg64::seed_from_u64(12);
        let mut touching = 0;
        for round in 0..20_000 {
            let limit = [LIMIT_MM, exact_integer::LIMIT_MM][round % 2];
            // Corners within three steps of a corner of the range, one of them of a second corner: needles across all of it.
            let mut ends =
                [(); 2].map(|()| Point::from([(); 3].map(|()| if random.random_bool(0.5) { limit } else { -limit })));
            ends[1] = -ends[0];
            let mut corner =
                |end: usize| ends[end].map(|x| x - x.signum() * f64::from(random.random_range(0..4)) * STEP_MM);
            let [a, b] = [[0, 0, 1], [0, 1, 1]].map(|ends| Triangle { corners: ends.map(&mut corner) });
            let truth = exact_integer::touch(&a, &b).expect("the corners are on the grid and in range");
            assert_eq!(touch(&a, &b), truth, "{a:?} {b:?}");
            touching += u32::from(truth);
        }
        assert!((1000..19_000).contains(&touching), "{touching}");
    }

    /// Multiplying by a power of two is exact, so the answer must not change, up to the range that [`super::super::plane`] states.
    #[test]
    fn the_answer_does_not_depend_on_the_scale() {
        let mut random = Pcg64::seed_from_u64(13);
        for _ in 0..5_000 {
            let pair = needles(&mut random);
            let [a, b] = pair;
            let truth = exact_integer::touch(&a, &b).expect("needles are on the grid");
            for exponent in [-290, -100, 11, 100, 305] {
                let [a, b] = pair.map(|t| t.map(|p| p * 2f64.powi(exponent)));
                assert_eq!(touch(&a, &b), truth, "2^{exponent}: {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn what_is_not_decided_is_near_contact() {
        let floor = Triangle { corners: [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(Point::from) };
        let above =
            |z: f64| Triangle { corners: [[1.0, 1.1, z], [1.3, 1.0, z + 1.0], [2.0, 1.0, 1.7]].map(Point::from) };
        let decided = |a: &Triangle, b: &Triangle| decided((a, b), Plane::of(a).sides(b), || Plane::of(b).sides(a));
        assert_eq!(decided(&floor, &above(1e-12)), Some(false));
        assert_eq!(decided(&floor, &above(-1e-12)), Some(true));
        assert_eq!(decided(&floor, &above(0.0)), None);
    }
}

//! Whether two closed triangles share a point: `f64` where that is certain, [`super::exact`] where it is not. Always the exact
//! answer, and nearly always as fast as the plain test.
//!
//! The same determinants as in [`super::intersect`], each with a bound of its error ([`super::plane`]).

use super::plane::{Plane, Side};
use super::{Point, Triangle, exact};

/// Whether the triangles, mm, share at least one point. Exact; unspecified when a coordinate is not finite.
#[must_use]
pub fn touch(a: &Triangle, b: &Triangle) -> bool {
    decided(a, b).unwrap_or_else(|| exact::touch(a, b))
}

/// The answer where `f64` can give it.
#[must_use]
pub fn decided(a: &Triangle, b: &Triangle) -> Option<bool> {
    if !exact::bounds_overlap(a, b) {
        return Some(false);
    }
    decided_by_sides((a, b), Plane::of(a).sides(b), || Plane::of(b).sides(a))
}

/// The same for triangles whose coordinate intervals overlap, and whose planes somebody keeps.
#[inline]
#[must_use]
pub fn decided_by_planes((a, plane_of_a): (&Triangle, &Plane), (b, plane_of_b): (&Triangle, &Plane)) -> Option<bool> {
    decided_by_sides((a, b), plane_of_a.sides(b), || plane_of_b.sides(a))
}

/// The answer from the sides of either plane that the other's corners are on; `a_sides` are asked for where they matter. What is decided
/// here is also what [`super::intersect`] answers: its determinants are these, and their signs are certain.
#[inline(always)]
fn decided_by_sides(
    (a, b): (&Triangle, &Triangle),
    b_sides: [Side; 3],
    a_sides: impl FnOnce() -> [Side; 3],
) -> Option<bool> {
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
    // As in `intersect`: afterwards both apexes are above the other's plane and both intervals run the same way.
    if !a_above {
        std::mem::swap(&mut b1, &mut b2);
    }
    if !b_above {
        std::mem::swap(&mut a1, &mut a2);
    }
    let (low, high) = (side([&a0, &a1, &b0], &b1), side([&a0, &a2, &b0], &b2));
    if low > 0 || high < 0 {
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

/// The corner that the other plane parts from the other two, and whether it is above; `None` when a side is not certain.
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
    use super::super::cross_check::compare;
    use super::super::exact::tests::{hand_made, orders};
    use super::*;

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
        let check = compare(7, 200_000, touch);
        assert_eq!(check.disagreements, 0, "{:?}", check.examples);
        // Were every answer taken from `f64`, some would be wrong: the bound is needed.
        assert!(check.fast_disagreements > 0);
    }

    #[test]
    fn what_is_not_decided_is_near_contact() {
        let floor = Triangle { corners: [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]].map(Point::from) };
        let above =
            |z: f64| Triangle { corners: [[1.0, 1.1, z], [1.3, 1.0, z + 1.0], [2.0, 1.0, 1.7]].map(Point::from) };
        assert_eq!(decided(&floor, &above(1e-12)), Some(false));
        assert_eq!(decided(&floor, &above(-1e-12)), Some(true));
        assert_eq!(decided(&floor, &above(0.0)), None);
    }
}

//! Compares triangle tests with the integer test of [`exact_integer`], on pairs chosen to be difficult.
//!
//! There are six kinds of pairs, in turn: triangles of any size anywhere on the grid; corners on a small integer lattice, where corners,
//! edges and planes often coincide; triangles in one slanted plane; exact contacts, displaced by a step or two of the grid; triangles at
//! the limit of the integer test; and needles that cross, pierce each other slightly, or pass each other.

use super::grid::{STEP_MM, snap_coordinate};
use super::{Point, Triangle, Vector, certified, exact, exact_integer};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

/// Result of comparing triangle tests with [`exact_integer`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrossCheck {
    /// Pairs compared.
    pub pairs: u64,
    /// Pairs that touch, by the integer test.
    pub touching: u64,
    /// Pairs in which at least one triangle has no area.
    pub degenerate: u64,
    /// Pairs on which a test differs from the integer test.
    pub disagreements: u64,
    /// The first few disagreements, in the order of the sequence.
    pub examples: Vec<[Triangle; 2]>,
}

/// Largest number of disagreements kept as examples.
const EXAMPLES: usize = 8;
/// Number of pairs per unit of parallel work; it is part of the definition of the sequence.
const CHUNK: u64 = 4096;

/// A triangle test.
pub type Test<'t> = &'t (dyn Fn(&Triangle, &Triangle) -> bool + Sync);

/// Compares [`certified::touch`], which all methods share, and [`exact::touch`], which decides where it cannot, with
/// [`exact_integer::touch`] on `pairs` pairs. The same seed gives the same pairs on every machine and for any number of threads.
#[must_use]
pub fn cross_check(seed: u64, pairs: u64) -> CrossCheck {
    compare(seed, pairs, &[&certified::touch, &exact::touch])
}

/// Compares the given triangle tests with the integer test, like [`cross_check`].
#[must_use]
pub fn compare(seed: u64, pairs: u64, tests: &[Test<'_>]) -> CrossCheck {
    let chunks: Vec<CrossCheck> =
        (0..pairs.div_ceil(CHUNK)).into_par_iter().map(|chunk| compare_chunk(seed, chunk, pairs, tests)).collect();
    chunks.into_iter().fold(CrossCheck::default(), CrossCheck::and)
}

impl CrossCheck {
    fn and(mut self, next: Self) -> Self {
        self.pairs += next.pairs;
        self.touching += next.touching;
        self.degenerate += next.degenerate;
        self.disagreements += next.disagreements;
        let room = EXAMPLES - self.examples.len();
        self.examples.extend(next.examples.into_iter().take(room));
        self
    }
}

fn compare_chunk(seed: u64, chunk: u64, pairs: u64, tests: &[Test<'_>]) -> CrossCheck {
    let mut random = Pcg64::seed_from_u64(seed ^ (chunk + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let mut result = CrossCheck::default();
    for index in chunk * CHUNK..((chunk + 1) * CHUNK).min(pairs) {
        let [a, b] = pair(&mut random, index);
        let truth = exact_integer::touch(&a, &b);
        result.pairs += 1;
        result.touching += u64::from(truth == Some(true));
        result.degenerate += u64::from(exact::has_no_area(&a) || exact::has_no_area(&b));
        if tests.iter().any(|test| truth != Some(test(&a, &b))) {
            result.disagreements += 1;
            if result.examples.len() < EXAMPLES {
                result.examples.push([a, b]);
            }
        }
    }
    result
}

/// The pair with the given number; its kind follows from the number.
fn pair(random: &mut Pcg64, index: u64) -> [Triangle; 2] {
    match index % 6 {
        0 => anywhere(random),
        1 => lattice(random),
        2 => one_plane(random),
        3 => near_contact(random),
        4 => far_out(random),
        _ => needles(random),
    }
}

fn triangle_of(mut corner: impl FnMut() -> Point) -> Triangle {
    Triangle::new(corner(), corner(), corner())
}

fn uniform(random: &mut Pcg64, half_width: f64) -> Vector {
    Vector::from_fn(|_, _| random.random_range(-half_width..=half_width))
}

fn snapped(v: &Vector) -> Point {
    Point::from(v.map(snap_coordinate))
}

/// Two triangles of similar size, 1e-6 to 1e3 mm, near each other, anywhere within 2000 mm.
fn anywhere(random: &mut Pcg64) -> [Triangle; 2] {
    let size = 10f64.powf(random.random_range(-6.0..3.0));
    let (centre, flatness) = (uniform(random, 2000.0), 10f64.powf(random.random_range(-4.0..0.0)));
    let squeeze = Vector::new(1.0, 1.0, flatness);
    [(); 2].map(|()| triangle_of(|| snapped(&(centre + uniform(random, size).component_mul(&squeeze)))))
}

/// A point of {0, ..., n}³ as whole steps of the given length from an origin.
fn lattice_point(random: &mut Pcg64, n: i32, origin: &Vector, step: f64) -> Point {
    Point::from(origin + Vector::from_fn(|_, _| f64::from(random.random_range(0..=n))) * step)
}

/// Triangles with corners on a lattice of three to five points a side.
fn lattice(random: &mut Pcg64) -> [Triangle; 2] {
    let step = [STEP_MM, 2f64.powi(-10), 1.0, 64.0][random.random_range(0..4)];
    let (n, origin) = (random.random_range(2..=4), snapped(&uniform(random, 100.0)).coords);
    [(); 2].map(|()| triangle_of(|| lattice_point(random, n, &origin, step)))
}

/// Triangles with corners on a two-dimensional lattice in a slanted plane (or on a line, when the lattice directions are parallel).
fn one_plane(random: &mut Pcg64) -> [Triangle; 2] {
    let mut direction = || Vector::from_fn(|_, _| f64::from(random.random_range(-5..=5)));
    let (u, v) = (direction(), direction());
    let step = [STEP_MM, 0.125, 8.0][random.random_range(0..3)];
    let lift = Vector::from_fn(|_, _| f64::from(random.random_range(-1..=1))) * STEP_MM;
    // One pair in two stays exactly in the plane; in the other a corner is lifted off it by a step.
    let lifted = random.random_bool(0.5);
    let mut pair = [(); 2].map(|()| {
        triangle_of(|| {
            let mut along = || f64::from(random.random_range(-3..=3));
            Point::from((u * along() + v * along()) * step)
        })
    });
    if lifted {
        pair[0].corners[random.random_range(0..3)] += lift;
    }
    pair
}

/// A corner, edge point or inner point of one triangle is placed on such a point of the other; then every coordinate is displaced by up to
/// two steps.
fn near_contact(random: &mut Pcg64) -> [Triangle; 2] {
    let steps = random.random_range(0..=2);
    let unit = [2f64.powi(-6), 1.0, 16.0][random.random_range(0..3)];
    let origin = Vector::zeros();
    let [a, b] = [(); 2].map(|()| triangle_of(|| lattice_point(random, 64, &origin, unit)));
    // Weights in quarters keep the points on the grid.
    let mut on = |t: &Triangle| {
        let first = random.random_range(0..=4);
        let second = random.random_range(0..=4 - first);
        let weights = [first, second, 4 - first - second].map(|w| f64::from(w) / 4.0);
        t.corners.iter().zip(weights).map(|(corner, w)| corner.coords * w).sum::<Vector>()
    };
    let shift = on(&a) - on(&b);
    let mut shaken = |p: &Point| p + Vector::from_fn(|_, _| f64::from(random.random_range(-steps..=steps))) * STEP_MM;
    [a, b.map(|p| p + shift)].map(|t| Triangle { corners: t.corners.map(|corner| shaken(&corner)) })
}

/// Triangles with corners anywhere in the range of the integer test, many of them at its limit.
fn far_out(random: &mut Pcg64) -> [Triangle; 2] {
    let mut coordinate = || {
        let limit = exact_integer::LIMIT_MM;
        match random.random_range(0..4) {
            0 => limit,
            1 => -limit,
            _ => snap_coordinate(random.random_range(-limit..=limit)),
        }
    };
    [(); 2].map(|()| triangle_of(|| Point::new(coordinate(), coordinate(), coordinate())))
}

/// Two needles, 1 to 1000 mm long and 1e-9 to 1e-3 mm wide, in any direction. The second passes through a point of the first, across it,
/// nearly along it, or with its tip there, and is then displaced by 1e-9 to 1e-2 mm.
pub(crate) fn needles(random: &mut Pcg64) -> [Triangle; 2] {
    let mut size = |low: f64, high: f64| 10f64.powf(random.random_range(low..high));
    let (length, widths, angle, offset) =
        (size(0.0, 3.0), [size(-9.0, -3.0), size(-9.0, -3.0)], size(-9.0, -1.0), size(-9.0, -2.0));
    let mut direction = || loop {
        let v = uniform(random, 1.0);
        if (0.1..1.0).contains(&v.norm()) {
            return v.normalize();
        }
    };
    let (along, across, sideways, shift) = (direction(), direction(), direction(), direction());
    let other = if random.random_bool(0.5) { across } else { (along + across * angle).normalize() };
    // Either the middle parts meet, or the tip of the second meets the first.
    let [of_first, of_second] = [random.random_range(0.05..0.95), random.random_range(0.05..0.95)];
    let of_second = if random.random_bool(0.3) { 0.0 } else { of_second };
    let start = uniform(random, 100.0);
    let meeting = start + along * (length * of_first);
    let first = needle(start, along * length, sideways.cross(&along) * widths[0], random);
    let base = meeting - other * (length * of_second) + shift * offset;
    [first, needle(base, other * length, sideways.cross(&other) * widths[1], random)]
}

/// A triangle with one edge from `base` to `base + length` and another along `width`; the third corner is at an end or between. Snapped to
/// the grid.
fn needle(base: Vector, length: Vector, width: Vector, random: &mut Pcg64) -> Triangle {
    let third = if random.random_bool(0.5) { 0.0 } else { random.random_range(0.0..1.0) };
    Triangle::new(
        snapped(&(base - width * 0.5)),
        snapped(&(base + length)),
        snapped(&(base + length * third + width * 0.5)),
    )
}

#[cfg(test)]
mod tests {
    use super::super::exact::tests::orders;
    use super::*;

    #[test]
    fn both_tests_agree_with_their_twin_on_a_million_pairs() {
        // Without optimisation a million take minutes.
        const PAIRS: u64 = if cfg!(debug_assertions) { 20_000 } else { 1_000_000 };
        let check = cross_check(2, PAIRS);
        assert_eq!(check.disagreements, 0, "{:?}", check.examples);
        assert_eq!(check.pairs, PAIRS);
        // The pairs are worth comparing: both answers and all kinds of degeneracy are common.
        assert!(check.touching > PAIRS / 5 && check.touching < PAIRS / 5 * 4, "{check:?}");
        assert!(check.degenerate > PAIRS / 50, "{check:?}");
    }

    #[test]
    fn the_answer_does_not_depend_on_the_order_of_corners_or_triangles() {
        let mut random = Pcg64::seed_from_u64(3);
        for index in 0..4000 {
            let [a, b] = pair(&mut random, index);
            let expected = exact_integer::touch(&a, &b).expect("generated pairs are on the grid");
            for a in orders(&a) {
                for b in orders(&b) {
                    assert_eq!(exact::touch(&a, &b), expected, "pair {index}: {a:?} {b:?}");
                    assert_eq!(exact::touch(&b, &a), expected, "pair {index}, swapped: {a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn a_wrong_test_is_caught() {
        // Open instead of closed: contact that a shrunken triangle loses.
        let open = |a: &Triangle, b: &Triangle| {
            let centroid = a.centroid();
            exact::touch(&a.map(|p| centroid + (p - centroid) * (1.0 - 1e-9)), b)
        };
        assert!(compare(4, 20_000, &[&exact::touch, &open]).disagreements > 100);
        // A tolerance where there must be none.
        let tolerant =
            |a: &Triangle, b: &Triangle| exact::touch(a, b) || exact::touch(&a.map(|p| p.map(|x| x + STEP_MM)), b);
        assert!(compare(4, 20_000, &[&exact::touch, &tolerant]).disagreements > 100);
        // A degenerate triangle that is overlooked.
        let no_area = |a: &Triangle, b: &Triangle| !exact::has_no_area(a) && exact::touch(a, b);
        assert!(compare(4, 20_000, &[&exact::touch, &no_area]).disagreements > 100);
    }

    #[test]
    fn the_same_seed_gives_the_same_pairs_for_any_number_of_threads() {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| cross_check(5, 20_000))
        };
        assert_eq!(run(1), run(3));
        assert_ne!(cross_check(5, 20_000), cross_check(6, 20_000));
    }
}

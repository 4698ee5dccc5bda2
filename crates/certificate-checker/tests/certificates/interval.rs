//! Interval arithmetic: it holds the exact result, and little else.

use certificate_checker::interval::{I, ONE, Pose, V, ZERO, cross, dot, minus, norm, plus, times};

/// A few whole numbers of up to 53 bits, from a fixed sequence.
fn whole_numbers() -> Vec<i64> {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    (0..60)
        .map(|i| (next() >> (11 + i % 40)) as i64 * if next() % 2 == 0 { 1 } else { -1 })
        .filter(|&x| x != 0)
        .collect()
}

/// A bound that is a whole number, without rounding.
fn exact(bound: f64) -> i128 {
    assert!(bound.abs() < 1e36 && (bound.fract() == 0.0));
    bound as i128
}

#[test]
fn sums_and_products_hold_the_exact_one() {
    let numbers = whole_numbers();
    for &a in &numbers {
        for &b in &numbers {
            let [x, y] = [a, b].map(|n| I::of(n as f64));
            let [a, b] = [a, b].map(i128::from);
            for (found, wanted) in [(x + y, a + b), (x - y, a - b), (x * y, a * b)] {
                let (low, high) = (exact(found.lo.floor()), exact(found.hi.ceil()));
                assert!(low <= wanted && wanted <= high, "{a} {b}: {found:?}");
                assert!((high - low) as f64 <= 2.0 + 1e-15 * wanted.unsigned_abs() as f64, "{a} {b}: {found:?}");
                assert!(found.lo < wanted as f64 && found.hi > wanted as f64, "the rounded result itself: {found:?}");
            }
            // q = a / b: q b holds a.
            let q = x.over(y);
            let again = q * y;
            assert!(again.lo <= x.lo && x.hi <= again.hi && q.hi - q.lo <= 2e-15 * q.most(), "{a} / {b}: {q:?}");
        }
    }
}

/// Every sign of both: the extreme products are of the ends.
#[test]
fn products_and_quotients_of_intervals_hold_those_of_their_numbers() {
    let ends = [-3.0, -2.0, -0.5, 0.0, 0.25, 1.0, 4.0];
    let intervals: Vec<I> =
        ends.iter().flat_map(|&lo| ends.iter().filter(move |hi| **hi >= lo).map(move |&hi| I { lo, hi })).collect();
    let near = |found: f64, wanted: f64| (found - wanted).abs() < 1e-12;
    for a in &intervals {
        for b in &intervals {
            let products = [a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi];
            let (least, most) =
                (products.iter().copied().fold(f64::MAX, f64::min), products.iter().copied().fold(f64::MIN, f64::max));
            let found = *a * *b;
            let is_zero = *a == ZERO || *b == ZERO;
            assert!(
                if is_zero { found == ZERO } else { found.lo < least && found.hi > most }
                    && near(found.lo, least)
                    && near(found.hi, most),
                "{a:?} {b:?}"
            );
            let found = a.over(*b);
            if b.lo <= 0.0 && b.hi >= 0.0 {
                assert_eq!([found.lo, found.hi], [f64::NEG_INFINITY, f64::INFINITY], "{b:?}");
            } else {
                let quotients = [a.lo / b.lo, a.lo / b.hi, a.hi / b.lo, a.hi / b.hi];
                let (least, most) = (
                    quotients.iter().copied().fold(f64::MAX, f64::min),
                    quotients.iter().copied().fold(f64::MIN, f64::max),
                );
                assert!(
                    if *a == ZERO { found == ZERO } else { found.lo < least && found.hi > most }
                        && near(found.lo, least)
                        && near(found.hi, most),
                    "{a:?} / {b:?}"
                );
            }
            let hull = a.hull(*b);
            assert_eq!([hull.lo, hull.hi], [a.lo.min(b.lo), a.hi.max(b.hi)]);
        }
        assert_eq!(a.most(), a.lo.abs().max(a.hi.abs()));
        assert_eq!(a.both_ways(), I { lo: -a.most(), hi: a.most() });
        assert_eq!(-*a, I { lo: -a.hi, hi: -a.lo });
        let square = a.squared();
        let least = if a.lo <= 0.0 && a.hi >= 0.0 { 0.0 } else { (a.lo * a.lo).min(a.hi * a.hi) };
        assert!(square.lo <= least && square.lo >= 0.0 && near(square.lo, least));
        assert!(if *a == ZERO { square == ZERO } else { square.hi > a.most() * a.most() });
        assert!(near(square.hi, a.most() * a.most()), "{a:?}: {square:?}");
    }
    let everything = I { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    let product = everything * ZERO;
    assert_eq!([product.lo, product.hi], [f64::NEG_INFINITY, f64::INFINITY]);
}

#[test]
fn square_roots_hold_the_exact_one() {
    for x in whole_numbers().into_iter().map(i64::abs) {
        let root = I::of(x as f64).sqrt();
        let wanted = (x as u128) << 52;
        assert!(squared(root.lo) <= wanted && wanted <= squared(root.hi) + 1, "{x}: {root:?}");
        assert!(root.hi - root.lo <= 1e-15 * root.hi, "{x}: {root:?}");
    }
    assert_eq!(I { lo: -1.0, hi: 4.0 }.sqrt(), I { lo: 0.0, hi: 2.0_f64.next_up() });
    let nothing = I { lo: -2.0, hi: -1.0 }.sqrt();
    assert!(nothing.lo == 0.0 && nothing.hi < 1e-200);
    assert!(I::of(f64::NAN).sqrt().hi.is_nan() && norm(&[I::of(f64::NAN), ONE, ZERO]).hi == f64::INFINITY);
}

/// What is exact stays so, and what underflows is widened to numbers that are no burden to a processor.
#[test]
fn zero_is_exact_and_underflow_is_not() {
    let (x, tiny) = (I { lo: -2.0, hi: 3.0 }, I::of(1e-200));
    for exact in [x + ZERO, ZERO + x, x - ZERO, -(ZERO - x)] {
        assert_eq!(exact, x);
    }
    for zero in [x * ZERO, ZERO * x, ZERO.squared(), ZERO.sqrt(), ZERO.over(I::of(7.0)), ZERO + ZERO] {
        assert_eq!(zero, ZERO);
    }
    for found in [tiny * tiny, tiny * -tiny, -tiny * tiny, tiny.squared(), tiny - tiny, I::of(0.0) * x + tiny * tiny] {
        assert!(found.lo <= 0.0 && found.hi > f64::MIN_POSITIVE && found.most() < 1e-280, "{found:?}");
    }
}

/// The square of a bound from 1 to 2^27 in units of 2^-52, rounded down.
fn squared(bound: f64) -> u128 {
    let (mantissa, exponent) = (bound.to_bits() & ((1 << 52) - 1) | 1 << 52, (bound.to_bits() >> 52) as i32 - 1075);
    let square = u128::from(mantissa) * u128::from(mantissa);
    let shift = 2 * exponent + 52;
    if shift >= 0 { square << shift } else { square >> -shift }
}

#[test]
fn sines_and_cosines_of_known_angles() {
    // To more digits than an f64 has.
    let known = [
        (0.0, 0.0, 1.0),
        (0.5, 0.479_425_538_604_203, 0.877_582_561_890_372_7),
        (1.0, 0.841_470_984_807_896_5, 0.540_302_305_868_139_7),
        (2.0, 0.909_297_426_825_681_7, -0.416_146_836_547_142_4),
        (3.0, 0.141_120_008_059_867_2, -0.989_992_496_600_445_4),
        (4.0, -0.756_802_495_307_928_3, -0.653_643_620_863_611_9),
        (5.0, -0.958_924_274_663_138_5, 0.283_662_185_463_226_3),
        (6.0, -0.279_415_498_198_925_9, 0.960_170_286_650_366),
        (100.0, -0.506_365_641_109_758_8, 0.862_318_872_287_683_9),
    ];
    for (angle, sine, cosine) in known {
        for sign in [1.0, -1.0] {
            let [s, c] = I::of(sign * angle).sin_cos();
            for (found, wanted) in [(s, sign * sine), (c, cosine)] {
                assert!(found.lo <= wanted && wanted <= found.hi, "{angle}: {found:?}, {wanted}");
                assert!(found.hi - found.lo < 1e-13, "{angle}: {found:?}");
            }
        }
    }
    // An angle that is not one number: 0.1 to either side.
    let [s, c] = I { lo: 0.4, hi: 0.6 }.sin_cos();
    for x in [0.4_f64, 0.45, 0.5, 0.55, 0.6] {
        assert!(s.lo < x.sin() && x.sin() < s.hi && c.lo < x.cos() && x.cos() < c.hi);
    }
    assert!((s.hi - s.lo - 0.2).abs() < 1e-12 && (c.hi - c.lo - 0.2).abs() < 1e-12);
}

fn vector(v: [f64; 3]) -> V {
    v.map(I::of)
}

#[track_caller]
fn is_vector(found: &V, wanted: [f64; 3]) {
    for (found, wanted) in found.iter().zip(wanted) {
        assert!(
            found.lo <= wanted + 1e-14 && wanted - 1e-14 <= found.hi && found.hi - found.lo < 1e-12,
            "{found:?}, {wanted}"
        );
    }
}

#[test]
fn vectors() {
    let (a, b) = (vector([1.0, 2.0, 3.0]), vector([5.0, -7.0, 11.0]));
    is_vector(&plus(&a, &b), [6.0, -5.0, 14.0]);
    is_vector(&minus(&a, &b), [-4.0, 9.0, -8.0]);
    is_vector(&times(&a, I::of(-2.0)), [-2.0, -4.0, -6.0]);
    is_vector(&cross(&a, &b), [2.0 * 11.0 + 3.0 * 7.0, 3.0 * 5.0 - 11.0, -7.0 - 10.0]);
    is_vector(&[dot(&a, &b), norm(&vector([2.0, -3.0, 6.0])), ONE], [5.0 - 14.0 + 33.0, 7.0, 1.0]);
}

#[test]
fn poses() {
    // 1 + 2i + 3j + 4k by hand: of its square, 30, these parts.
    let rows = [[-20.0, 4.0, 22.0], [20.0, -10.0, 20.0], [10.0, 28.0, 4.0]].map(|row| row.map(|x| x / 30.0));
    let pose = Pose::of([1.0, 2.0, 3.0, 4.0], vector([7.0, 8.0, 9.0]));
    (0..3).for_each(|j| is_vector(&pose.r[j], [0, 1, 2].map(|i| rows[i][j])));
    let p = vector([3.0, -1.0, 2.0]);
    let turned = rows.map(|row| row[0] * 3.0 - row[1] + row[2] * 2.0);
    is_vector(&pose.turn(&p), turned);
    is_vector(&pose.turn_back(&vector(turned)), [3.0, -1.0, 2.0]);
    is_vector(&pose.point(&p), [turned[0] + 7.0, turned[1] + 8.0, turned[2] + 9.0]);
    is_vector(&pose.inverse().point(&pose.point(&p)), [3.0, -1.0, 2.0]);
    is_vector(&pose.inverse().turn(&pose.turn(&p)), [3.0, -1.0, 2.0]);
    is_vector(&Pose::IDENTITY.point(&p), [3.0, -1.0, 2.0]);
    // Half a turn about Z behind a step along X, and the other way round.
    let (step, turn) =
        (Pose { t: vector([10.0, 0.0, 0.0]), ..Pose::IDENTITY }, Pose::of([0.0, 0.0, 0.0, 2.0], [ZERO; 3]));
    is_vector(&turn.after(&step).point(&p), [-13.0, 1.0, 2.0]);
    is_vector(&step.after(&turn).point(&p), [7.0, 1.0, 2.0]);
    is_vector(&pose.after(&turn).point(&p), pose.point(&turn.point(&p)).map(|x| 0.5 * (x.lo + x.hi)));
    // About (2, 3, 6) / 7 by 0.8 rad: the quaternion (cos 0.4, sin 0.4 (2, 3, 6) / 7).
    let axis = [2.0, 3.0, 6.0].map(|x| x / 7.0);
    let (sin, cos) = 0.4_f64.sin_cos();
    let wanted = Pose::of([cos, sin * axis[0], sin * axis[1], sin * axis[2]], [ZERO; 3]);
    let found = Pose::about(&vector(axis), I::of(0.8));
    for (found, wanted) in found.r.iter().flatten().zip(wanted.r.iter().flatten()) {
        assert!((*found - *wanted).most() < 1e-14, "{found:?} {wanted:?}");
    }
}

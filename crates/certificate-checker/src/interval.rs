//! Intervals of `f64` with outward rounding. An operation of IEEE 754 is off by half a unit in the last place at most, so the next number below or above holds the
//! exact result. What is exactly zero stays so: most entries of a machine's rotations are. No function of a mathematical library is trusted: sine and cosine are Taylor's series with their remainder.

use std::f64::consts::FRAC_PI_2;
use std::ops::{Add, Mul, Neg, Sub};

/// All numbers from `lo` to `hi`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct I {
    /// Least.
    pub lo: f64,
    /// Greatest.
    pub hi: f64,
}

/// Zero.
pub const ZERO: I = I { lo: 0.0, hi: 0.0 };
/// One.
pub const ONE: I = I { lo: 1.0, hi: 1.0 };
/// π/2 = 1.57079632679489661923..., between 1.57079632679489655799... and the next number.
const QUARTER: I = I { lo: FRAC_PI_2, hi: FRAC_PI_2.next_up() };

impl I {
    /// One number.
    pub const fn of(x: f64) -> Self {
        Self { lo: x, hi: x }
    }

    /// From `lo` to `hi`, which rounded operations gave. A bound of zero may have underflowed. It is moved by 1e-290, because
    /// processors are slow with the numbers next to zero.
    pub(crate) fn outward(lo: f64, hi: f64) -> Self {
        const TINY: f64 = 1e-290;
        Self { lo: if lo == 0.0 { -TINY } else { lo.next_down() }, hi: if hi == 0.0 { TINY } else { hi.next_up() } }
    }

    /// All numbers of both.
    pub const fn hull(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// The greatest absolute value.
    pub fn most(self) -> f64 {
        self.hi.max(-self.lo)
    }

    /// From minus the greatest absolute value to it.
    pub fn both_ways(self) -> Self {
        Self { lo: -self.most(), hi: self.most() }
    }

    /// The square.
    pub fn squared(self) -> Self {
        let product = self * self;
        Self { lo: product.lo.max(0.0), ..product }
    }

    /// The square root of what is not negative.
    pub fn sqrt(self) -> Self {
        // What is not a number stays so.
        let root = |x: f64| if x < 0.0 { 0.0 } else { x.sqrt() };
        let whole = Self::outward(root(self.lo), root(self.hi));
        if self == ZERO { ZERO } else { Self { lo: whole.lo.max(0.0), ..whole } }
    }

    /// The quotient; everything where the divisor may be zero.
    pub fn over(self, divisor: Self) -> Self {
        if divisor.lo <= 0.0 && divisor.hi >= 0.0 {
            return Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
        }
        self * Self::outward((1.0 / divisor.hi).min(1.0 / divisor.lo), (1.0 / divisor.hi).max(1.0 / divisor.lo))
    }

    /// Sine and cosine of an angle in radians. Both change by no more than the angle does.
    pub fn sin_cos(self) -> [Self; 2] {
        let middle = 0.5 * (self.lo + self.hi);
        let spread = (self - Self::of(middle)).both_ways();
        let quarters = (middle / QUARTER.lo).round();
        let x = Self::of(middle) - QUARTER * Self::of(quarters);
        let square = x.squared();
        // 1 - x²/(n (n + 1)) (1 - x²/((n + 2) (n + 3)) (1 - ...)), the last n being 20 or 19.
        let series = |n: u32| {
            let term = |rest, n: u32| ONE - square.over(Self::of(f64::from(n * (n + 1)))) * rest;
            (n..21).step_by(2).rev().fold(ONE, term)
        };
        // x is 0.8 at most: the first terms left out, of x^22 and x^23, are below 0.8^22 / 22! < 1e-23.
        let rest = Self { lo: -1e-23, hi: 1e-23 };
        let (s, c) = (x * series(2) + rest + spread, series(1) + rest + spread);
        // Each quarter on, the sine becomes the cosine and the cosine the sine turned back.
        let (ring, quarter) = ([s, c, -s, -c], quarters.rem_euclid(4.0) as usize);
        [ring[quarter], ring[(quarter + 1) % 4]]
    }
}

impl Add for I {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        match (self == ZERO, other == ZERO) {
            (true, _) => other,
            (_, true) => self,
            _ => Self::outward(self.lo + other.lo, self.hi + other.hi),
        }
    }
}

impl Sub for I {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for I {
    type Output = Self;
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Mul for I {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let p = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        // Not a number: zero times what is infinite is among them.
        if (p[0] + p[1] + p[2] + p[3]).is_nan() {
            return Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
        }
        if self == ZERO || other == ZERO {
            return ZERO;
        }
        let least = |a, b| if a < b { a } else { b };
        let most = |a, b| if a > b { a } else { b };
        Self::outward(least(least(p[0], p[1]), least(p[2], p[3])), most(most(p[0], p[1]), most(p[2], p[3])))
    }
}

/// A vector.
pub type V = [I; 3];

/// The inner product.
pub fn dot(a: &V, b: &V) -> I {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross product.
pub fn cross(a: &V, b: &V) -> V {
    [1, 2, 0].map(|i| a[i] * b[(i + 1) % 3] - a[(i + 1) % 3] * b[i])
}

/// The length.
pub fn norm(a: &V) -> I {
    (a[0].squared() + a[1].squared() + a[2].squared()).sqrt()
}

/// The direction; everything where there may be none.
pub fn unit(a: &V) -> V {
    let length = norm(a);
    a.map(|x| x.over(length))
}

/// The sum.
pub fn plus(a: &V, b: &V) -> V {
    [0, 1, 2].map(|i| a[i] + b[i])
}

/// The difference.
pub fn minus(a: &V, b: &V) -> V {
    [0, 1, 2].map(|i| a[i] - b[i])
}

/// The product with a number.
pub fn times(a: &V, x: I) -> V {
    a.map(|a| a * x)
}

/// A rotation and a translation.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// Columns of the rotation.
    pub r: [V; 3],
    /// Translation, mm.
    pub t: V,
}

impl Pose {
    /// No motion.
    pub const IDENTITY: Self = Self { r: [[ONE, ZERO, ZERO], [ZERO, ONE, ZERO], [ZERO, ZERO, ONE]], t: [ZERO; 3] };

    /// By a quaternion (w, x, y, z) of any length; everything where that may be zero.
    pub fn of([w, x, y, z]: [f64; 4], t: V) -> Self {
        let (w, v) = (I::of(w), [x, y, z].map(I::of));
        let [along, across] = [w.squared(), v[0].squared() + v[1].squared() + v[2].squared()];
        let by = ONE.over(along + across);
        Self { t, ..Self::rodrigues(&v, (along - across) * by, (w + w) * by, by + by) }
    }

    /// About a unit vector by an angle, radians.
    pub fn about(u: &V, angle: I) -> Self {
        let [sin, cos] = angle.sin_cos();
        Self::rodrigues(u, cos, sin, ONE - cos)
    }

    /// x ↦ c x + s (u × x) + a u (u · x).
    fn rodrigues(u: &V, c: I, s: I, a: I) -> Self {
        let [x, y, z] = times(u, s);
        let columns = [[c, z, -y], [-z, c, x], [y, -x, c]];
        Self { r: [0, 1, 2].map(|j| plus(&columns[j], &times(u, a * u[j]))), t: [ZERO; 3] }
    }

    /// A direction turned.
    pub fn turn(&self, v: &V) -> V {
        plus(&plus(&times(&self.r[0], v[0]), &times(&self.r[1], v[1])), &times(&self.r[2], v[2]))
    }

    /// A direction turned back.
    pub fn turn_back(&self, v: &V) -> V {
        self.r.map(|column| dot(&column, v))
    }

    /// A point moved.
    pub fn point(&self, p: &V) -> V {
        plus(&self.turn(p), &self.t)
    }

    /// First `other`, then this.
    pub fn after(&self, other: &Self) -> Self {
        Self { r: other.r.map(|column| self.turn(&column)), t: self.point(&other.t) }
    }

    /// The way back.
    pub fn inverse(&self) -> Self {
        let r = [0, 1, 2].map(|i| self.r.map(|column| column[i]));
        Self { r, t: self.turn_back(&self.t).map(Neg::neg) }
    }
}

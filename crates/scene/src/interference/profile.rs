//! The profile of a tool: its generating line, and the distance of a point from the solid that the line sweeps.
//!
//! A tool is a solid of revolution about its z axis, with its tip at z = 0, bounded by lines and corner arcs in the half plane (ρ, z),
//! ρ >= 0. The distance of a point from the solid equals the distance of (hypot(x, y), z) from the profile. It is exact but for rounding.
//! (The generalised cutter of APT, as in the models of Chang and Lee and of Ding, Mannan and Poo, is the case of a corner arc between two
//! lines.)

use nalgebra::Point2;
use thiserror::Error;

/// A point (ρ, z) of the half plane, mm.
pub type P2 = Point2<f64>;

/// Why dimensions do not give a profile.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ProfileError {
    /// A dimension is not finite, or is out of range.
    #[error("{what} is {value} mm; it must be {wanted}")]
    Dimension {
        /// Name of the dimension.
        what: &'static str,
        /// The value given.
        value: f64,
        /// The permitted range.
        wanted: &'static str,
    },
}

/// A piece of a profile along which z and ρ are monotonic: a line, or an arc within the lower outer quadrant of its circle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    from: P2,
    to: P2,
    /// Centre and radius of an arc.
    arc: Option<(P2, f64)>,
}

impl Piece {
    fn distance_squared(&self, p: &P2) -> f64 {
        match self.arc {
            None => {
                let (u, v) = (self.to - self.from, p - self.from);
                let t = (u.dot(&v) / u.norm_squared()).clamp(0.0, 1.0);
                (v - u * t).norm_squared()
            }
            Some((centre, radius)) => {
                let (v, a, b) = (p - centre, self.from - centre, self.to - centre);
                // Within a quadrant the arc turns by less than half a turn, whichever way.
                let turn = a.perp(&b).signum();
                if turn * a.perp(&v) >= 0.0 && turn * v.perp(&b) >= 0.0 {
                    (v.norm() - radius).powi(2)
                } else {
                    (p - self.from).norm_squared().min((p - self.to).norm_squared())
                }
            }
        }
    }

    /// ρ at a height within the piece, mm.
    fn radius_at(&self, z: f64) -> f64 {
        let (from, to) = (self.from, self.to);
        match self.arc {
            None if from.y == to.y => from.x.max(to.x),
            None => from.x + (to.x - from.x) * ((z - from.y) / (to.y - from.y)),
            Some((centre, radius)) => centre.x + (radius * radius - (z - centre.y).powi(2)).max(0.0).sqrt(),
        }
    }

    /// Whether the ray from the point along +ρ crosses the piece.
    fn is_crossed(&self, p: &P2) -> bool {
        (self.from.y <= p.y) != (self.to.y <= p.y) && self.radius_at(p.y) > p.x
    }
}

/// A generating line that starts and ends on the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pieces: Vec<Piece>,
    /// Largest ρ, mm.
    radius: f64,
    /// Range of z, mm.
    span: [f64; 2],
}

impl Profile {
    /// A profile of straight lines through points (ρ, z), mm, closed to the axis at both ends. Segments of zero length are left out.
    pub fn of_lines(points: &[P2]) -> Self {
        let mut path = Path::at(points.first().copied().unwrap_or_default());
        points.iter().skip(1).for_each(|&p| path.line(p));
        path.finish()
    }

    /// A flat end mill.
    ///
    /// # Errors
    /// When a dimension is not a positive finite number.
    pub fn cylinder(radius_mm: f64, height_mm: f64) -> Result<Self, ProfileError> {
        Self::bull_nose(radius_mm, 0.0, height_mm)
    }

    /// A ball end mill: a half sphere under a cylinder.
    ///
    /// # Errors
    /// When a dimension is not a positive finite number, or the tool is lower than its ball.
    pub fn ball(radius_mm: f64, height_mm: f64) -> Result<Self, ProfileError> {
        Self::bull_nose(radius_mm, radius_mm, height_mm)
    }

    /// An end mill with a rounded corner.
    ///
    /// # Errors
    /// When a dimension is not finite or not in its range.
    pub fn bull_nose(radius_mm: f64, corner_mm: f64, height_mm: f64) -> Result<Self, ProfileError> {
        let radius = positive("radius", radius_mm)?;
        let corner = in_range("corner radius", corner_mm, 0.0, radius, "between 0 and the radius")?;
        let height = in_range("height", height_mm, corner.max(f64::MIN_POSITIVE), f64::MAX, "above the corner radius")?;
        let mut path = Path::at(P2::origin());
        path.line(P2::new(radius - corner, 0.0));
        path.corner(P2::new(radius, corner), P2::new(radius - corner, corner), corner);
        path.line(P2::new(radius, height));
        path.line(P2::new(0.0, height));
        Ok(path.finish())
    }

    /// A cone, or a frustum: a taper cutter, a shank's or a holder's shoulder.
    ///
    /// # Errors
    /// When a dimension is not finite or negative, or both radii are 0.
    pub fn cone(lower_radius_mm: f64, upper_radius_mm: f64, height_mm: f64) -> Result<Self, ProfileError> {
        let wanted = "at least 0";
        let lower = in_range("lower radius", lower_radius_mm, 0.0, f64::MAX, wanted)?;
        let upper = in_range("upper radius", upper_radius_mm, 0.0, f64::MAX, wanted)?;
        positive("larger radius", lower.max(upper))?;
        let height = positive("height", height_mm)?;
        Ok(Self::of_lines(&[P2::origin(), P2::new(lower, 0.0), P2::new(upper, height), P2::new(0.0, height)]))
    }

    /// The same profile, moved up by `height_mm`.
    pub fn raised(&self, height_mm: f64) -> Self {
        let up = |p: P2| P2::new(p.x, p.y + height_mm);
        let pieces = self.pieces.iter().map(|piece| Piece {
            from: up(piece.from),
            to: up(piece.to),
            arc: piece.arc.map(|(centre, radius)| (up(centre), radius)),
        });
        Self { pieces: pieces.collect(), radius: self.radius, span: self.span.map(|z| z + height_mm) }
    }

    /// Distance of a point (ρ, z) from the solid's surface, mm, negative inside.
    pub fn signed_distance_mm(&self, p: &P2) -> f64 {
        let mut least = f64::INFINITY;
        let mut inside = false;
        for piece in &self.pieces {
            least = least.min(piece.distance_squared(p));
            inside ^= piece.is_crossed(p);
        }
        if inside { -least.sqrt() } else { least.sqrt() }
    }

    /// The largest radius, mm.
    pub const fn radius_mm(&self) -> f64 {
        self.radius
    }

    /// Lowest and highest z, mm.
    pub const fn span_mm(&self) -> [f64; 2] {
        self.span
    }

    /// The largest radius between two heights, mm; 0 where there is nothing.
    pub fn radius_between_mm(&self, low: f64, high: f64) -> f64 {
        let of_piece = |piece: &Piece| {
            let (bottom, top) = (piece.from.y.min(piece.to.y), piece.from.y.max(piece.to.y));
            if top < low || bottom > high {
                return 0.0;
            }
            // A piece does not turn back in ρ, so its largest radius is at an end of what is left of it.
            if bottom == top {
                return piece.from.x.max(piece.to.x);
            }
            piece.radius_at(bottom.max(low)).max(piece.radius_at(top.min(high)))
        };
        self.pieces.iter().map(of_piece).fold(0.0, f64::max)
    }

    /// Heights of the ends of the pieces, mm, ascending.
    pub fn heights_mm(&self) -> Vec<f64> {
        let mut heights: Vec<f64> = self.pieces.iter().flat_map(|piece| [piece.from.y, piece.to.y]).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        heights
    }
}

/// A profile under construction.
struct Path {
    at: P2,
    pieces: Vec<Piece>,
}

impl Path {
    const fn at(at: P2) -> Self {
        Self { at, pieces: Vec::new() }
    }

    fn line(&mut self, to: P2) {
        if to != self.at {
            self.pieces.push(Piece { from: self.at, to, arc: None });
            self.at = to;
        }
    }

    /// Adds a rounded corner: the lower outer quarter of the circle about `centre`, which begins here.
    fn corner(&mut self, to: P2, centre: P2, radius: f64) {
        if to != self.at {
            self.pieces.push(Piece { from: self.at, to, arc: Some((centre, radius)) });
            self.at = to;
        }
    }

    fn finish(self) -> Profile {
        let ends = || self.pieces.iter().flat_map(|piece| [piece.from, piece.to]);
        let radius = ends().map(|p| p.x).fold(0.0, f64::max);
        let low = ends().map(|p| p.y).fold(f64::INFINITY, f64::min);
        let high = ends().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
        // What runs along the axis is inside the solid.
        let pieces = self.pieces.into_iter().filter(|piece| piece.from.x > 0.0 || piece.to.x > 0.0).collect();
        Profile { pieces, radius, span: [low, high] }
    }
}

fn positive(what: &'static str, value: f64) -> Result<f64, ProfileError> {
    in_range(what, value, f64::MIN_POSITIVE, f64::MAX, "a finite number above 0")
}

fn in_range(what: &'static str, value: f64, low: f64, high: f64, wanted: &'static str) -> Result<f64, ProfileError> {
    if value >= low && value <= high { Ok(value) } else { Err(ProfileError::Dimension { what, value, wanted }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    fn distance(profile: &Profile, rho: f64, z: f64) -> f64 {
        profile.signed_distance_mm(&P2::new(rho, z))
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }

    #[test]
    fn distances_known_by_hand() {
        let flat = Profile::cylinder(5.0, 20.0).unwrap();
        near(distance(&flat, 0.0, -3.0), 3.0); // under the face
        near(distance(&flat, 8.0, -4.0), 5.0); // from the edge: 3, 4
        near(distance(&flat, 4.0, 10.0), -1.0);
        near(distance(&flat, 0.0, 2.0), -2.0); // the axis is no boundary
        let ball = Profile::ball(5.0, 20.0).unwrap();
        near(distance(&ball, 0.0, 0.0), 0.0);
        near(distance(&ball, 3.0, 1.0), 0.0); // 3, 4 from the centre (0, 5)
        near(distance(&ball, 6.0, -3.0), 5.0); // 6, 8 from the centre
        near(distance(&ball, 0.0, 5.0), -5.0);
        let bull = Profile::bull_nose(5.0, 2.0, 20.0).unwrap();
        near(distance(&bull, 2.0, -1.0), 1.0);
        near(distance(&bull, 3.0 + 3.0, 2.0 - 4.0), 3.0); // 3, 4 from the corner's centre (3, 2), less 2
        near(distance(&bull.raised(7.0), 2.0, 6.0), 1.0);
        near(bull.radius_mm(), 5.0);
        let cone = Profile::cone(0.0, 4.0, 3.0).unwrap();
        near(distance(&cone, 4.0, 0.0), 2.4); // the line 3 ρ = 4 z: |12| / 5
    }

    #[test]
    fn radii_between_heights() {
        let ball = Profile::ball(5.0, 20.0).unwrap();
        near(ball.radius_between_mm(0.0, 1.0), 3.0);
        near(ball.radius_between_mm(0.0, 30.0), 5.0);
        near(ball.radius_between_mm(21.0, 30.0), 0.0);
        assert_eq!(Profile::cylinder(5.0, 20.0).unwrap().heights_mm(), [0.0, 20.0]);
    }

    #[test]
    fn impossible_tools_are_refused_with_the_dimension() {
        let message = |result: Result<Profile, ProfileError>| result.unwrap_err().to_string();
        assert_eq!(message(Profile::cylinder(-1.0, 2.0)), "radius is -1 mm; it must be a finite number above 0");
        assert_eq!(
            message(Profile::bull_nose(5.0, 6.0, 20.0)),
            "corner radius is 6 mm; it must be between 0 and the radius"
        );
        assert!(Profile::ball(5.0, f64::NAN).is_err() && Profile::cone(0.0, 0.0, 1.0).is_err());
    }

    proptest! {
        /// Compares a profile with arcs with the same profile of many short lines, which shares no formula with arcs.
        #[test]
        fn arcs_are_as_far_as_their_chords(rho in 0.0..15.0f64, z in -8.0..30.0f64, is_ball in any::<bool>()) {
            let corner = if is_ball { 6.0 } else { 2.0 };
            let exact = Profile::bull_nose(6.0, corner, 20.0).unwrap();
            let mut points = vec![P2::origin()];
            points.extend((0..=4000).map(|k| {
                let angle = (f64::from(k) / 4000.0 - 1.0) * FRAC_PI_2;
                P2::new(6.0 - corner, corner) + Vector2::new(angle.cos(), angle.sin()) * corner
            }));
            points.extend([P2::new(6.0, 20.0), P2::new(0.0, 20.0)]);
            let chords = Profile::of_lines(&points);
            let (found, expected) = (distance(&exact, rho, z), distance(&chords, rho, z));
            prop_assert!((found - expected).abs() < 1e-5, "{found}, by chords {expected}");
        }
    }
}

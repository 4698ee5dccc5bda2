//! Convex polytopes as faces, computed by clipping: the volume, area and edges of an intersection of half-spaces.

use crate::geometry::{Point, Vector};
use crate::volume::Segment;
use std::ops::Range;

/// A convex solid: planar faces, each a loop of corners, mm.
#[derive(Clone, Debug, Default)]
pub struct Polytope {
    /// The corners of all faces, one loop behind the other.
    corners: Vec<Point>,
    /// End of each loop in `corners`.
    ends: Vec<usize>,
}

impl Polytope {
    /// The cube of half-length `half`, mm, about `centre`.
    pub fn cube(centre: &Point, half: f64) -> Self {
        let mut cube = Self::default();
        for (axis, side) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0)] {
            for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut offset = Vector::zeros();
                offset[axis] = side * half;
                offset[(axis + 1) % 3] = s * half;
                offset[(axis + 2) % 3] = t * half;
                cube.corners.push(centre + offset);
            }
            cube.ends.push(cube.corners.len());
        }
        cube
    }

    /// Keeps the part of the solid where `normal · x <= offset` for each of the half-spaces (`normal` of unit length, `offset` in mm).
    pub fn clip(mut self, half_spaces: impl IntoIterator<Item = (Vector, f64)>) -> Self {
        let (mut kept, mut heights, mut rim) = (Self::default(), Vec::new(), Vec::new());
        for (normal, offset) in half_spaces {
            heights.clear();
            heights.extend(self.corners.iter().map(|p| normal.dot(&p.coords) - offset));
            if heights.iter().all(|&height| height < 0.0) {
                continue;
            }
            kept.corners.clear();
            kept.ends.clear();
            rim.clear();
            for range in self.loops() {
                kept.add_part(&self.corners[range.clone()], &heights[range], &mut rim);
            }
            if rim.len() >= 3 {
                kept.corners.extend(around(&rim, &normal));
                kept.ends.push(kept.corners.len());
            }
            std::mem::swap(&mut self, &mut kept);
        }
        self
    }

    /// Adds the part of a face that is not above a plane, and adds to `rim` the points in which the face's edges meet the plane. `heights`
    /// are the heights of the face's corners above the plane.
    fn add_part(&mut self, face: &[Point], heights: &[f64], rim: &mut Vec<Point>) {
        let before = self.corners.len();
        for (i, here) in face.iter().enumerate() {
            let next = if i + 1 < face.len() { i + 1 } else { 0 };
            let (h, n) = (heights[i], heights[next]);
            if h <= 0.0 {
                self.corners.push(*here);
            }
            if (h < 0.0 && n > 0.0) || (h > 0.0 && n < 0.0) {
                let crossing = here + (face[next] - here) * (h / (h - n));
                self.corners.push(crossing);
                rim.push(crossing);
            } else if h == 0.0 {
                rim.push(*here);
            }
        }
        if self.corners.len() - before >= 3 {
            self.ends.push(self.corners.len());
        } else {
            self.corners.truncate(before);
        }
    }

    fn loops(&self) -> impl Iterator<Item = Range<usize>> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| start..end)
    }

    fn faces(&self) -> impl Iterator<Item = &[Point]> {
        self.loops().map(|range| &self.corners[range])
    }

    /// Surface area, mm².
    pub fn surface_area(&self) -> f64 {
        self.faces().map(|face| area_vector(face).norm()).sum()
    }

    /// Volume, mm³: pyramids from an inner point over the faces.
    pub fn volume(&self) -> f64 {
        if self.corners.is_empty() {
            return 0.0;
        }
        let apex = Point::from(self.corners.iter().map(|p| p.coords).sum::<Vector>() / self.corners.len() as f64);
        self.faces().map(|face| area_vector(face).dot(&(face[0] - apex)).abs() / 3.0).sum()
    }

    /// The edges; each occurs once or twice.
    pub fn edges(&self) -> Vec<Segment> {
        self.faces().flat_map(|face| (0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]])).collect()
    }
}

/// Half the sum of cross products around a loop: a normal whose length is the area of the loop, mm².
fn area_vector(face: &[Point]) -> Vector {
    let fan = face.windows(2).skip(1).map(|pair| (pair[0] - face[0]).cross(&(pair[1] - face[0])));
    fan.sum::<Vector>() * 0.5
}

/// Coplanar points of a convex loop, sorted around `normal`.
fn around(points: &[Point], normal: &Vector) -> Vec<Point> {
    let middle = Point::from(points.iter().map(|p| p.coords).sum::<Vector>() / points.len() as f64);
    let helper = if normal.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
    let u = normal.cross(&helper).normalize();
    let v = normal.cross(&u);
    let key = |p: &Point| like_angle(u.dot(&(p - middle)), v.dot(&(p - middle)));
    let mut keyed: Vec<(f64, Point)> = points.iter().map(|p| (key(p), *p)).collect();
    keyed.sort_by(|(p, _), (q, _)| p.total_cmp(q));
    keyed.into_iter().map(|(_, p)| p).collect()
}

/// A monotonic function of the angle of (x, y), from -2 to 2, cheaper than an arc tangent.
fn like_angle(x: f64, y: f64) -> f64 {
    let slope = y / (x.abs() + y.abs());
    if x >= 0.0 { slope } else { 2f64.copysign(y) - slope }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_without_a_corner_has_lost_a_pyramid() {
        let cube = Polytope::cube(&Point::origin(), 1.0);
        assert!((cube.volume() - 8.0).abs() < 1e-12 && (cube.surface_area() - 24.0).abs() < 1e-12);
        // x + y + z <= 2 cuts a right pyramid with legs of 1 off the corner (1,1,1): volume 1/6; three half squares give
        // way to an equilateral triangle of side √2.
        let diagonal = Vector::repeat(1.0).normalize();
        let cut = cube.clip([(diagonal, 2.0 / 3.0_f64.sqrt())]);
        assert!((cut.volume() - (8.0 - 1.0 / 6.0)).abs() < 1e-12);
        assert!((cut.surface_area() - (24.0 - 1.5 + 3.0_f64.sqrt() / 2.0)).abs() < 1e-12);
    }

    #[test]
    fn a_cube_may_be_cut_square_to_any_direction() {
        for normal in [Vector::x(), Vector::y(), Vector::z(), -Vector::x(), -Vector::y(), -Vector::z()] {
            let half = Polytope::cube(&Point::new(3.0, 3.0, 3.0), 1.0)
                .clip([(normal, normal.dot(&Vector::repeat(3.0)) + 0.5)]);
            assert!((half.volume() - 6.0).abs() < 1e-12 && (half.surface_area() - 20.0).abs() < 1e-12, "{normal}");
        }
        // Through opposite edges: half of it, with two triangles and a rectangle of 2 by 2√2.
        let wedge = Polytope::cube(&Point::origin(), 1.0).clip([(Vector::new(1.0, 1.0, 0.0).normalize(), 0.0)]);
        assert!((wedge.volume() - 4.0).abs() < 1e-9, "{}", wedge.volume());
        assert!((wedge.surface_area() - (12.0 + 4.0 * 2.0_f64.sqrt())).abs() < 1e-9, "{}", wedge.surface_area());
    }

    #[test]
    fn the_key_of_the_sort_grows_with_the_angle() {
        let keys: Vec<f64> =
            (-179..=180).map(|k| f64::from(k).to_radians()).map(|t| like_angle(t.cos(), t.sin())).collect();
        assert!(keys.windows(2).all(|pair| pair[0] < pair[1]), "{keys:?}");
    }

    #[test]
    fn nothing_is_left_of_a_cube_clipped_away() {
        let gone = Polytope::cube(&Point::origin(), 1.0).clip([(Vector::x(), -2.0)]);
        assert_eq!((gone.volume(), gone.surface_area(), gone.edges().len()), (0.0, 0.0, 0));
    }
}

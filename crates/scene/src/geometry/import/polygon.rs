//! Divides the polygons of a file into triangles.
//!
//! A polygon becomes the fan from its first corner where all triangles of the fan face the same way, as those of convex polygons do. Any other
//! polygon loses one ear after the other, a triangle of three neighbouring corners that holds no further corner (Meisters, "Polygons have
//! ears", American Mathematical Monthly 82, 1975), seen along the axis nearest to its normal.

use super::super::{Point, Vector};
use super::{MOST, Raw};
use robust::{Coord, orient2d};

/// Share of a polygon's area by which a triangle of its fan may face the other way: corners on a line, in single precision, differ by less.
const FLAT: f64 = 1e-6;
/// Most corners of a polygon without a fan; the time to divide it grows with their square.
const MOST_CORNERS: usize = 1 << 12;

impl Raw {
    /// Adds a polygon by its corners, which must be vertices. Points and lines, of one and two corners, have no triangle.
    ///
    /// # Errors
    /// When there are too many triangles, or the polygon's sides cross.
    pub(super) fn add_polygon(&mut self, corners: &[u32]) -> Result<(), String> {
        let count = corners.len().saturating_sub(2);
        check_count(self.faces.len(), count)?;
        let triangle = |[a, b, c]: [usize; 3]| [a, b, c].map(|corner| corners[corner]);
        let fan = (0..count).map(|k| [0, k + 1, k + 2]);
        let points = || corners.iter().map(|&corner| self.vertices[corner as usize]).collect::<Vec<_>>();
        if count < 2 || is_fan(&points()) {
            self.faces.extend(fan.map(triangle));
            return Ok(());
        }
        if corners.len() > MOST_CORNERS {
            return Err(format!(
                "a polygon of {} corners is not convex; at most {MOST_CORNERS} are divided",
                corners.len()
            ));
        }
        let ears = ears(&points()).ok_or_else(|| {
            format!("the sides of this polygon of {} corners cross; divide it into triangles", corners.len())
        })?;
        self.faces.extend(ears.into_iter().map(triangle));
        Ok(())
    }
}

/// Refuses more triangles than a file may have.
fn check_count(have: usize, more: usize) -> Result<(), String> {
    if have + more > MOST {
        return Err(format!("with this face, the file has more than {MOST} triangles"));
    }
    Ok(())
}

/// Normals of the triangles of a polygon's fan, twice as long as their areas. Their sum is the polygon's normal (Newell's).
fn fan_normals(points: &[Point]) -> impl Iterator<Item = Vector> {
    let spokes = points.iter().map(|point| point - points[0]).skip(1);
    spokes.clone().zip(spokes.skip(1)).map(|(one, other)| one.cross(&other))
}

/// Whether the triangles of the fan face the same way. A polygon with numbers that are not finite has one: the mesh is refused later.
fn is_fan(points: &[Point]) -> bool {
    let normal: Vector = fan_normals(points).sum();
    let size = normal.norm_squared();
    let largest = largest(points);
    !(size.is_finite() && largest.is_finite())
        || largest == 0.0
        || (size.sqrt() > FLAT * largest && fan_normals(points).all(|one| one.dot(&normal) >= -FLAT * size))
}

/// Twice the largest area of a triangle of the fan.
fn largest(points: &[Point]) -> f64 {
    fan_normals(points).map(|normal| normal.norm()).fold(0.0, f64::max)
}

/// The triangles of a polygon, by the numbers of its corners; `None` when its sides cross.
fn ears(points: &[Point]) -> Option<Vec<[usize; 3]>> {
    let normal: Vector = fan_normals(points).sum();
    if normal.norm() <= FLAT * largest(points) {
        return None;
    }
    let along = normal.iamax();
    let (u, v) = ((along + 1) % 3, (along + 2) % 3);
    // Seen against the normal, the polygon winds counter-clockwise.
    let (u, v) = if normal[along] < 0.0 { (v, u) } else { (u, v) };
    let shadow = |corner: usize| Coord { x: points[corner][u], y: points[corner][v] };
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    let mut begin = 0;
    while left.len() > 2 {
        let count = left.len();
        let corners = |at: usize| [left[(at + count - 1) % count], left[at % count], left[(at + 1) % count]];
        let turn = |at: usize| {
            let [a, b, c] = corners(at).map(shadow);
            orient2d(a, b, c)
        };
        let is_ear = |&at: &usize| {
            let triangle = corners(at).map(shadow);
            let [a, b, c] = triangle;
            let holds = |p: Coord<f64>| {
                !triangle.contains(&p)
                    && [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| orient2d(from, to, p) >= 0.0)
            };
            turn(at) > 0.0 && !left.iter().any(|&corner| holds(shadow(corner)))
        };
        // Corners on a line go last: they make triangles without area.
        let mut all = (begin..begin + count).map(|at| at % count);
        let ear = all.find(is_ear).or_else(|| (0..count).find(|&at| turn(at) == 0.0))?;
        triangles.push(corners(ear));
        left.remove(ear);
        begin = ear;
    }
    Some(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn raw(points: &[[f64; 3]]) -> (Raw, Vec<u32>) {
        let vertices: Vec<Point> = points.iter().map(|&point| Point::from(point)).collect();
        let corners = (0..vertices.len() as u32).collect();
        (Raw { vertices, ..Raw::default() }, corners)
    }

    /// Areas of the triangles of a polygon, along its normal.
    fn areas(points: &[[f64; 3]]) -> Result<Vec<f64>, String> {
        let (mut raw, corners) = raw(points);
        raw.add_polygon(&corners)?;
        let normal: Vector = fan_normals(&raw.vertices).sum::<Vector>().normalize();
        let corner = |vertex: u32| raw.vertices[vertex as usize];
        let area = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(&(corner(c) - corner(a))).dot(&normal) / 2.0;
        Ok(raw.faces.iter().map(area).collect())
    }

    #[test]
    fn a_convex_polygon_is_its_fan() {
        let (mut raw, corners) =
            raw(&[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 2.0, 1.0], [1.0, 3.0, 1.0], [0.0, 2.0, 1.0]]);
        raw.add_polygon(&corners).unwrap();
        raw.add_polygon(&corners[..2]).unwrap();
        assert_eq!(raw.faces, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    }

    #[test]
    fn concave_polygons_are_covered_once() {
        // An L, from the corner opposite to its notch and from others; in the three planes, either way round.
        let outline = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        for first in 0..outline.len() {
            for plane in 0..6 {
                let place = |[u, v]: [f64; 2]| {
                    let (u, v) = if plane < 3 { (u, v) } else { (v, u) };
                    let mut point = [7.0; 3];
                    (point[plane % 3], point[(plane + 1) % 3]) = (u, v);
                    point
                };
                let points: Vec<[f64; 3]> = (0..7).map(|i| place(outline[(first + i) % 7])).collect();
                let areas = areas(&points).unwrap();
                assert_eq!(areas.len(), 5);
                assert!(areas.iter().all(|&area| area >= 0.0), "{first} {plane}: {areas:?}");
                assert!((areas.iter().sum::<f64>() - 5.0).abs() < 1e-12, "{first} {plane}: {areas:?}");
            }
        }
    }

    #[test]
    fn polygons_whose_sides_cross_are_refused() {
        let flat = |points: &[[f64; 2]]| areas(&points.iter().map(|&[x, y]| [x, y, 0.0]).collect::<Vec<_>>());
        for crossed in
            [&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]][..], &[[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 1.0]]]
        {
            assert!(flat(crossed).unwrap_err().contains("cross"), "{crossed:?}");
        }
        let star = |i: usize| {
            let angle = i as f64 * 0.001;
            let radius = if i.is_multiple_of(2) { 1.0 } else { 2.0 };
            [radius * angle.cos(), radius * angle.sin()]
        };
        assert!(flat(&(0..6000).map(star).collect::<Vec<_>>()).unwrap_err().contains("at most 4096"));
    }

    #[test]
    fn no_file_has_more_triangles_than_the_limit() {
        assert!(check_count(MOST - 2, 2).is_ok());
        assert!(check_count(MOST - 1, 2).unwrap_err().contains("more than 16777216 triangles"));
    }

    proptest! {
        /// Polygons around a point, by their radii at equal angles: simple, and rarely convex.
        #[test]
        fn simple_polygons_are_covered_once(
            radii in prop::collection::vec(0.1..10.0_f64, 3..40), tilt in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let turn = nalgebra::Rotation3::from_euler_angles(tilt[0], tilt[1], tilt[2]);
            let point = |(i, radius): (usize, &f64)| {
                let angle = std::f64::consts::TAU * i as f64 / radii.len() as f64;
                let turned: [f64; 3] = (turn * Vector::new(radius * angle.cos(), radius * angle.sin(), 0.0)).into();
                turned
            };
            let points: Vec<[f64; 3]> = radii.iter().enumerate().map(point).collect();
            let step = (std::f64::consts::TAU / radii.len() as f64).sin();
            let expected: f64 = (0..radii.len()).map(|i| 0.5 * radii[i] * radii[(i + 1) % radii.len()] * step).sum();
            let areas = areas(&points).unwrap();
            prop_assert!(areas.iter().all(|&area| area > -1e-3 * expected));
            prop_assert!((areas.iter().sum::<f64>() - expected).abs() < 1e-9 * expected);
        }
    }
}

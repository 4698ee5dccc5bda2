//! Axes of the box of least volume.
//!
//! J. O'Rourke, "Finding Minimal Enclosing Boxes", 1985: each of two neighbouring faces of the smallest box around a convex solid contains
//! an edge of it. (Seen along the normal of any face, the box is a smallest rectangle, and one side of that contains an edge.) For every
//! pair of edges, the boxes whose faces contain them form a family with one parameter. Deviations: O'Rourke solves a polynomial on every
//! interval between changes of contact; here each family is searched by branch and bound (`minimum/edges.rs`). Pairs of edges without a
//! common box are discarded as in J. Jylänki, "An Exact Algorithm for Finding Minimum Oriented Bounding Boxes", 2015; the further
//! conjecture there is not used.
//!
//! Guarantee: up to [`EXACT_VERTICES`] hull vertices and [`MAX_STEPS`] steps, no box is smaller by more than the fraction [`TOLERANCE`].
//! With more vertices, the search uses only the extreme vertices along [`EXACT_VERTICES`] directions. For contents thinner than [`FLAT`],
//! it tries only boxes with a face on a face, or an edge along an edge. In every case, the result is improved until no turn about one of
//! its axes makes it smaller. The search starts with the boxes of all other rules, so the result is never larger than those. Volumes
//! include the pad of the stored box, so that boxes of flat contents are compared by their area.

mod arc;
mod edges;
mod family;
mod search;

use super::dito::Dito14;
use super::frame::{AreaCovariance, FrameRule, HullAreaCovariance, VertexCovariance, any_frame, reach_mm};
use crate::geometry::hull::{Hull, Solid};
use crate::geometry::separating_axes::pad_mm;
use crate::geometry::{Point, Triangle, Vector, covariance, triangle};
use edges::BoxesOnEdges;
use nalgebra::Matrix3;
use search::Search;

/// Permitted relative excess of the result over the smallest volume.
pub const TOLERANCE: f64 = 1e-3;
/// Largest number of hull vertices that are searched exactly.
pub const EXACT_VERTICES: usize = 400;
/// Largest number of boxes that branch and bound examines.
pub const MAX_STEPS: u32 = 200_000;

/// Contents thinner than this fraction of their diameter count as flat. Their smallest box has a face on their plane, and branch and bound
/// would have to resolve angles of this size.
pub const FLAT: f64 = 1e-6;

/// Axes of the smallest box.
#[derive(Clone, Copy, Debug)]
pub struct MinimumVolume;

impl FrameRule for MinimumVolume {
    /// The mean of this rule is the mean of the corners.
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (mean, _) = covariance::vertex_weighted(triangles);
        let pad = pad_mm(reach_mm(triangles));
        let axes = match Hull::of(triangle::corners(triangles)) {
            None | Some(Hull::Point(_)) => Matrix3::identity(),
            Some(Hull::Segment([p, q])) => any_frame(&(q - p)),
            Some(Hull::Polygon(corners)) => of_polygon(&corners, pad),
            Some(Hull::Solid(solid)) => of_solid(triangles, &solid, pad),
        };
        (mean, axes)
    }
}

/// The frame of a polygon: the frame of its plane, turned to the polygon's smallest rectangle.
fn of_polygon(corners: &[Point], pad: f64) -> Matrix3<f64> {
    let fan = corners.windows(2).skip(1).map(|pair| (pair[0] - corners[0]).cross(&(pair[1] - corners[0])));
    let frame = any_frame(&fan.sum());
    let mut search = Search::new(corners.iter(), pad);
    search.turn_about(&frame, 0);
    search.best.1
}

fn of_solid(triangles: &[Triangle], solid: &Solid, pad: f64) -> Matrix3<f64> {
    let mut search = Search::new(solid.vertices.iter(), pad);
    for axes in [
        VertexCovariance::mean_and_axes(triangles).1,
        AreaCovariance::mean_and_axes(triangles).1,
        HullAreaCovariance::mean_and_axes(triangles).1,
        Dito14::mean_and_axes(triangles).1,
    ] {
        search.offer(&axes);
    }
    search.descend();
    if solid.vertices.len() <= EXACT_VERTICES {
        BoxesOnEdges::new(&mut search, solid).try_all();
    } else if let Some(Hull::Solid(coarse)) = Hull::of(extreme_vertices(solid).iter()) {
        let mut on_coarse = Search::new(coarse.vertices.iter(), pad);
        on_coarse.offer(&search.best.1);
        BoxesOnEdges::new(&mut on_coarse, &coarse).try_all();
        search.offer(&on_coarse.best.1);
        search.descend();
    }
    search.best.1
}

/// The extreme vertices along [`EXACT_VERTICES`] directions, spread over the sphere by a golden spiral.
fn extreme_vertices(solid: &Solid) -> Vec<Point> {
    let direction = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f64 / EXACT_VERTICES as f64;
        let turn = i as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        let radius = (1.0 - z * z).sqrt();
        Vector::new(radius * turn.cos(), radius * turn.sin(), z)
    };
    let extreme = |d: Vector| {
        let height = |p: &&Point| d.dot(&p.coords);
        solid.vertices.iter().max_by(|p, q| height(p).total_cmp(&height(q))).copied()
    };
    (0..EXACT_VERTICES).filter_map(|i| extreme(direction(i))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;
    use obbtree::cases::{Draw, meshes};

    fn volume(triangles: &[Triangle]) -> f64 {
        let (_, axes) = MinimumVolume::mean_and_axes(triangles);
        Search::new(triangle::corners(triangles), 0.0).widths(&axes).product()
    }

    #[test]
    fn a_turned_cuboid_is_its_own_box() {
        let turn = Isometry::rotation(Vector::new(0.4, -0.9, 0.5));
        let triangles = meshes::moved(&meshes::cuboid(20.0, 12.0, 5.0), 1.0, &turn).triangles();
        assert!((volume(&triangles) - 1200.0).abs() < 1e-3);
    }

    #[test]
    fn a_regular_tetrahedron_fits_a_cube_whose_diagonals_are_its_edges() {
        // Alternate corners of the cube of edge 2, turned: no face of the box contains a face of the tetrahedron.
        let turn = Isometry::rotation(Vector::new(-0.3, 1.9, 0.2));
        let [a, b, c, d] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
            .map(|p: [f64; 3]| turn * Point::from(p));
        let triangles = [Triangle::new(a, b, c), Triangle::new(a, b, d)];
        assert!((volume(&triangles) - 8.0).abs() < 8.0 * TOLERANCE, "{}", volume(&triangles));
    }

    /// Points on an ellipsoid with half-lengths of 4, 2 and 1 mm, turned; three to a triangle.
    fn ellipsoid(points: u32) -> Vec<Triangle> {
        let turn = Isometry::rotation(Vector::new(-0.3, 1.9, 0.2));
        let corners: Vec<Point> = (0..points)
            .map(|k| {
                let on_sphere = Draw::new(11, &["ellipsoid"], u64::from(k)).in_ball().normalize();
                turn * Point::from(on_sphere.component_mul(&Vector::new(4.0, 2.0, 1.0)))
            })
            .collect();
        corners.chunks_exact(3).map(|three| Triangle::new(three[0], three[1], three[2])).collect()
    }

    #[test]
    fn the_extreme_corners_of_many_are_spread_all_around() {
        let triangles = ellipsoid(3000);
        let Some(Hull::Solid(solid)) = Hull::of(triangle::corners(&triangles)) else { panic!("no solid") };
        assert!(solid.vertices.len() > EXACT_VERTICES);
        let extreme = extreme_vertices(&solid);
        assert_eq!(extreme.len(), EXACT_VERTICES);
        for k in 0..500 {
            let direction = Draw::new(12, &["direction"], k).in_ball().normalize();
            let height =
                |points: &[Point]| points.iter().map(|p| direction.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max);
            let (coarse, all) = (height(&extreme), height(&solid.vertices));
            assert!(coarse <= all && coarse > 0.97 * all, "{direction}: {coarse} of {all}");
        }
        // 8 · 4 · 2 · 1 mm³.
        assert!((volume(&triangles) - 64.0).abs() < 1.3, "{}", volume(&triangles));
    }

    #[test]
    fn a_triangle_gets_its_smallest_rectangle() {
        let t = Triangle::new(Point::new(0.0, 0.0, 1.0), Point::new(4.0, 0.0, 1.0), Point::new(0.0, 3.0, 1.0));
        let (_, axes) = MinimumVolume::mean_and_axes(&[t]);
        let mut widths: Vec<f64> = Search::new(t.corners.iter(), 0.0).widths(&axes).iter().copied().collect();
        widths.sort_by(f64::total_cmp);
        // Either the legs, 3 by 4, or the hypotenuse and its height, 5 by 2.4: both 12.
        assert!(widths[0] < 1e-12 && (widths[1] * widths[2] - 12.0).abs() < 1e-12, "{widths:?}");
    }
}

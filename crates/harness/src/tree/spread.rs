//! Empty space in volumes: how far a volume extends beyond the convex hull of its contents, and how much space two siblings share.
//!
//! Both are computed from the volume's drawing and its `contains`, so they have the same meaning for every volume.

use crate::geometry::hull::Hull;
use crate::geometry::{Point, Triangle, Vector, triangle_distance};
use crate::volume::Solid;
use nalgebra::Matrix3;

/// Sample points in the box around what two siblings share: enough to know the filled fraction of that box to a few hundredths, and the sum
/// over a level better.
const SAMPLES: u32 = 256;

/// Queries on the convex hull of a node's contents.
#[derive(Clone, Debug)]
pub struct Contents {
    /// The hull's corners, mm.
    pub corners: Vec<Point>,
    /// The faces of the hull, and its volume in mm³; `None` for contents that are flat, or nearly so.
    pub solid: Option<(Vec<Triangle>, f64)>,
}

impl Contents {
    /// The convex hull of points, mm, in any order; points may repeat.
    pub fn of<'a>(points: impl Iterator<Item = &'a Point>) -> Self {
        match Hull::of(points) {
            None => Self { corners: Vec::new(), solid: None },
            Some(Hull::Point(point)) => Self { corners: vec![point], solid: None },
            Some(Hull::Segment(ends)) => Self { corners: ends.to_vec(), solid: None },
            Some(Hull::Polygon(corners)) => Self { corners, solid: None },
            Some(Hull::Solid(solid)) => {
                Self { solid: thick(&solid.vertices, solid.triangles()), corners: solid.vertices }
            }
        }
    }
}

/// The faces of a solid with its volume, mm³; `None` when the solid is so thin that the volume would be rounding error.
fn thick(corners: &[Point], faces: Vec<Triangle>) -> Option<(Vec<Triangle>, f64)> {
    /// A hull with less volume than this fraction of the cube of its extent counts as flat.
    const FLAT: f64 = 1e-6;
    let apex = corners.first()?;
    let below = |face: &Triangle| {
        let [a, b, c] = face.corners.map(|corner| corner - apex);
        a.dot(&b.cross(&c)) / 6.0
    };
    let volume: f64 = faces.iter().map(below).sum();
    let (low, high) = corners.iter().fold((*apex, *apex), |(low, high), p| (low.inf(p), high.sup(p)));
    (volume > FLAT * (high - low).norm().powi(3)).then_some((faces, volume))
}

/// The directed Hausdorff distance from a volume to the convex hull of its contents, mm: the distance from the hull to the farthest point
/// of the volume's drawing. Exact for boxes and polytopes, because their farthest points are corners.
pub fn hausdorff_mm(volume: &dyn Solid, hull: &[Triangle]) -> f64 {
    farthest_outside_mm(volume.outline().into_iter().flatten().collect(), hull)
}

/// The largest distance from a hull to any of `points` outside it, mm; 0 when no point is outside.
///
/// Only faces that a point is above are measured. If the point were below all faces at the nearest point of the hull, the segment between
/// the two would pass through the hull, and some other point of the hull would be nearer.
fn farthest_outside_mm(mut points: Vec<Point>, hull: &[Triangle]) -> f64 {
    let inside = Point::from(hull.iter().map(|face| face.centroid().coords).sum::<Vector>() / hull.len() as f64);
    let outward = |face: &Triangle| {
        let normal = face.double_area_normal().try_normalize(0.0).unwrap_or_default();
        // Whichever way the face is wound, the hull lies on the side of its own inner point.
        if (inside - face.corners[0]).dot(&normal) > 0.0 { -normal } else { normal }
    };
    let planes: Vec<(Vector, &Triangle)> = hull.iter().map(|face| (outward(face), face)).collect();
    let distance_squared = |point: &Point| {
        let mut least = f64::INFINITY;
        for (normal, face) in &planes {
            let height = (point - face.corners[0]).dot(normal);
            if height > 0.0 && height * height < least {
                least = least.min(triangle_distance::point_squared(point, face));
            }
        }
        if least < f64::INFINITY { least } else { 0.0 }
    };
    points.sort_unstable_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z)));
    points.dedup();
    points.iter().map(distance_squared).fold(0.0, f64::max).sqrt()
}

/// The volume of the intersection of two volumes, mm³, estimated from a fixed set of evenly spread points (Halton 1960). Both volumes are
/// boxed along the axes of the one, and again along those of the other; the points fill the smaller of the two intersections of boxes.
/// Along the coordinate axes a thin turned volume would fill next to nothing of its box, and be missed, or hit once by chance.
pub fn overlap_mm3(one: &dyn Solid, other: &dyn Solid) -> f64 {
    let outlines = [one, other].map(|volume| volume.outline().into_iter().flatten().collect::<Vec<Point>>());
    let left = |axes: Matrix3<f64>| {
        let [(low, high), (low_b, high_b)] = [0, 1].map(|i| bounds(&outlines[i], &axes));
        let low = low.sup(&low_b);
        // Nothing is left where they are disjoint along an axis.
        (axes, low, (high.inf(&high_b) - low).sup(&Vector::zeros()))
    };
    let (first, second) = (left(one.axes()), left(other.axes()));
    let (axes, low, size) = if second.2.product() < first.2.product() { second } else { first };
    if size.min() <= 0.0 {
        return 0.0;
    }
    let place =
        |i: u32| Point::from(axes * (low + Vector::new(halton(i, 2), halton(i, 3), halton(i, 5)).component_mul(&size)));
    let in_both = |point: &Point| one.contains(point, 0.0) && other.contains(point, 0.0);
    let hits = (1..=SAMPLES).filter(|&i| in_both(&place(i))).count();
    size.product() * hits as f64 / f64::from(SAMPLES)
}

/// Least and largest coordinates of points along axes, mm.
fn bounds(points: &[Point], axes: &Matrix3<f64>) -> (Vector, Vector) {
    let along = points.iter().map(|point| axes.tr_mul(&point.coords));
    let none = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    along.fold(none, |(low, high), point| (low.inf(&point), high.sup(&point)))
}

/// The `index`-th number of the van der Corput sequence in a base: its digits, mirrored at the radix point.
fn halton(mut index: u32, base: u32) -> f64 {
    let (mut value, mut weight) = (0.0, 1.0);
    while index > 0 {
        weight /= f64::from(base);
        value += weight * f64::from(index % base);
        index /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Isometry, Point, Triangle, Vector, triangle, triangle_distance};
    use crate::volume::BoundingVolume;
    use crate::volume::aabb::Aabb;
    use crate::volume::obb_area::ObbArea;
    use crate::volume::obb_area_f32::ObbAreaF32;
    use crate::volume::obbrss::ObbRss;
    use crate::volume::rss::Rss;
    use crate::volume::shape::obb::Obb;
    use crate::volume::sphere_ritter::SphereRitter;
    use obbtree::cases::meshes;
    use proptest::prelude::*;

    fn cube(low: f64) -> Vec<Triangle> {
        let shift = Vector::repeat(low + 1.0);
        meshes::cuboid(2.0, 2.0, 2.0).triangles().iter().map(|t| t.map(|p| p + shift)).collect()
    }

    #[test]
    fn the_corner_opposite_a_corner_tetrahedron_is_farthest_out() {
        let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
        let (o, x, y, z) = (p(0.0, 0.0, 0.0), p(3.0, 0.0, 0.0), p(0.0, 3.0, 0.0), p(0.0, 0.0, 3.0));
        let corner = [Triangle::new(o, y, x), Triangle::new(o, x, z), Triangle::new(o, z, y), Triangle::new(x, y, z)];
        let hull = |triangles: &[Triangle]| Contents::of(triangle::corners(triangles));
        let (faces, volume) = hull(&corner).solid.unwrap();
        assert!((volume - 4.5).abs() < 1e-9); // 27/6
        // (3, 3, 3) lies 6/√3 beyond the plane x + y + z = 3, and its foot (1, 1, 1) is in the face.
        assert!((hausdorff_mm(&Aabb::fit(&corner), &faces) - 6.0 / 3.0_f64.sqrt()).abs() < 1e-6);
        assert!(hausdorff_mm(&Aabb::fit(&cube(0.0)), &hull(&cube(0.0)).solid.unwrap().0) < 1e-6);
        let flat = hull(&corner[..1]);
        assert!(flat.solid.is_none() && flat.corners.len() == 3);
    }

    #[test]
    fn flat_is_what_has_next_to_no_volume_for_its_extent() {
        let tetrahedron = |size: f64, height: f64| {
            let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
            let corners = [p(0.0, 0.0, 0.0), p(size, 0.0, 0.0), p(0.0, size, 0.0), p(0.0, 0.0, height)];
            let [o, x, y, z] = corners;
            let faces = [[o, y, x], [o, x, z], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
            thick(&corners, faces.to_vec()).map(|found| found.1)
        };
        // A sixth of the size squared times the height, and a millionth of 2√2 times the size cubed.
        assert!((tetrahedron(0.01, 0.01).unwrap() - 1e-6 / 6.0).abs() < 1e-15);
        assert!(tetrahedron(1000.0, 0.016).is_none() && tetrahedron(1000.0, 0.018).is_some());
    }

    #[test]
    fn it_does_not_matter_how_the_hull_is_wound() {
        // Cubes of edge 2 from `low` on, and points beside them.
        for (low, x, distance) in [(0.0, 2.5, 0.5), (40.0, 42.5, 0.5), (-40.0, -41.5, 1.5)] {
            let outward = cube(low);
            let inward: Vec<Triangle> =
                outward.iter().map(|face| Triangle::new(face.corners[0], face.corners[2], face.corners[1])).collect();
            for hull in [&outward, &inward] {
                let found = farthest_outside_mm(vec![Point::new(x, low + 1.0, low + 1.0)], hull);
                assert!((found - distance).abs() < 1e-9, "{low}: {found}");
            }
        }
    }

    #[test]
    fn the_overlap_with_a_thin_rod_is_sampled_along_the_rod() {
        let rod = Obb {
            axes: crate::volume::fit::frame::any_frame(&Vector::repeat(1.0)),
            centre: Point::new(1.0, 1.0, 1.0),
            half: Vector::new(0.9, 0.005, 0.005),
        };
        let block = Aabb::fit(&cube(0.0));
        for shared in [overlap_mm3(&rod, &block), overlap_mm3(&block, &rod)] {
            assert!((shared / rod.volume() - 1.0).abs() < 1e-9, "{shared}");
        }
    }

    proptest! {
        #[test]
        fn the_faces_below_a_point_are_not_missed(
            corners in prop::collection::vec(prop::array::uniform3(-3.0..3.0f64), 4..40),
            points in prop::collection::vec(prop::array::uniform3(-5.0..5.0f64), 1..20),
        ) {
            let corners: Vec<Point> = corners.into_iter().map(Point::from).collect();
            let contents = Contents::of(corners.iter());
            prop_assume!(contents.solid.is_some());
            let (faces, _) = contents.solid.unwrap();
            let inside = nalgebra::center(&faces[0].centroid(), &faces[faces.len() - 1].centroid());
            let is_outside = |point: &Point| {
                let beyond = |face: &Triangle, p: &Point| (p - face.corners[0]).dot(&face.double_area_normal());
                faces.iter().any(|face| beyond(face, point) * beyond(face, &inside) < 0.0)
            };
            for point in points.into_iter().map(Point::from) {
                let squared = faces.iter().map(|face| triangle_distance::point_squared(&point, face));
                let distance = if is_outside(&point) { squared.fold(f64::INFINITY, f64::min).sqrt() } else { 0.0 };
                prop_assert!((farthest_outside_mm(vec![point], &faces) - distance).abs() < 1e-9, "{point}");
            }
        }
    }

    #[test]
    fn cubes_share_a_cube_and_balls_a_lens() {
        let shared = overlap_mm3(&Aabb::fit(&cube(0.0)), &Aabb::fit(&cube(1.0)));
        assert!((shared - 1.0).abs() < 1e-6, "{shared}");
        assert_eq!(overlap_mm3(&Aabb::fit(&cube(0.0)), &Aabb::fit(&cube(3.0))), 0.0);
        // Equal balls of radius r, their middles d apart: a lens of π (4 r + d) (2 r - d)² / 12.
        let (one, other) = (SphereRitter::fit(&cube(0.0)), SphereRitter::fit(&cube(1.0)));
        let pi = std::f64::consts::PI;
        let (r, d) = (one.radius, (one.centre - other.centre).norm());
        let lens = pi * (4.0 * r + d) * (2.0 * r - d).powi(2) / 12.0;
        let shared = overlap_mm3(&one, &other);
        assert!((shared / lens - 1.0).abs() < 0.1, "{shared} {lens}");
    }

    /// The share of its volume that a thin sheet shares with another, shifted by half its length, both turned.
    fn half_of_a_sheet<V: BoundingVolume>() -> f64 {
        let turn = Isometry::new(Vector::new(7.0, -3.0, 2.0), Vector::new(0.4, -0.7, 0.3));
        let sheet = meshes::cuboid(400.0, 300.0, 0.05).triangles();
        let [one, other] = [0.0, 200.0].map(|shift| {
            let placed: Vec<Triangle> =
                sheet.iter().map(|t| t.map(|p| turn * (p + Vector::new(shift, 0.0, 0.0)))).collect();
            V::fit(&placed)
        });
        overlap_mm3(&one, &other) / one.volume()
    }

    #[test]
    fn thin_turned_sheets_share_what_they_share_along_the_axes() {
        let shares = [
            ("box", half_of_a_sheet::<ObbArea>()),
            ("box in single precision", half_of_a_sheet::<ObbAreaF32>()),
            ("swept sphere", half_of_a_sheet::<Rss>()),
            ("both", half_of_a_sheet::<ObbRss>()),
        ];
        for (shape, share) in shares {
            assert!((share - 0.5).abs() < 0.05, "{shape}: {share}");
        }
    }
}

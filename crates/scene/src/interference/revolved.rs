//! A mesh as a tool: the smallest body of revolution about its axis that contains it, to the resolution of the heights.
//!
//! Tools come as meshes, and their axis is not named. The axis is taken to be the line about which the mesh fits the smallest cylinder,
//! which for a body of revolution is its true axis. The body's radius at each height is the mesh's largest distance from the axis there.
//! Along an edge of the mesh, that distance is a convex function of the height, so the chord between the edge's ends bounds it. A
//! triangle's cross-section at a height is farthest from the axis at the triangle's edges. Hollows towards the axis, such as flutes and
//! bores, are filled.

use super::profile::{P2, Profile};
use crate::geometry::covariance::{area_weighted, principal_frame};
use crate::geometry::{Isometry, Mesh, Point, Vector, turn_between};
use std::f64::consts::PI;

/// Heights nearer than this, mm, count as equal. It is above the rounding error of rotating a mesh, and below [`super::detect::SLACK_MM`],
/// which covers it.
const SAME_HEIGHT_MM: f64 = 1e-7;
/// Largest number of heights at which the profile may have a corner; a mesh with more heights gets equal steps.
const MOST_HEIGHTS: usize = 96;
/// The same where depths in the body are told: between the heights of equal steps the body is larger than the mesh.
const FINE_HEIGHTS: usize = 400;
/// Sine of the angle below which three points of a profile count as collinear; over a metre the deviation is less than [`SAME_HEIGHT_MM`].
const STRAIGHT: f64 = 1e-10;
/// Smallest fraction of the body that a mesh must fill to count as round; a prism with eight sides fills 0.90 of its cylinder.
pub const ROUND: f64 = 0.88;

/// A mesh and the body of revolution around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Revolved {
    /// The body, its axis +z.
    pub profile: Profile,
    /// Maps coordinates in the mesh's frame to the frame of the body.
    pub tool_from_mesh: Isometry,
    /// Volume of the body, mm³.
    pub volume_mm3: f64,
    /// Fraction of the body's volume that the mesh fills, 0 to 1; 0 for a mesh that encloses nothing.
    pub filled: f64,
}

impl Revolved {
    /// Finds the axis of a mesh and the body around it.
    pub fn around(mesh: &Mesh) -> Self {
        Self::about(mesh, upright(mesh))
    }

    /// The same with corners at up to 400 heights.
    pub fn finely_around(mesh: &Mesh) -> Self {
        Self::of(mesh, upright(mesh), FINE_HEIGHTS)
    }

    /// The body about the middle of the smallest circle around the mesh, seen along the axis that [`Self::around`] finds: what turns about its outside, notched as it may be.
    pub fn within(mesh: &Mesh) -> Self {
        let around = Self::around(mesh);
        let seen: Vec<P2> = mesh.vertices().iter().map(|vertex| (around.tool_from_mesh * vertex).xy()).collect();
        let (middle, radius) = smallest_circle(&seen);
        // Only by more than rounding, as below.
        if radius >= around.profile.radius_mm() * (1.0 - 1e-9) {
            return around;
        }
        Self::about(mesh, Isometry::translation(-middle.x, -middle.y, 0.0) * around.tool_from_mesh)
    }

    /// The body around a mesh whose axis is z of the frame to which `tool_from_mesh` leads.
    pub fn about(mesh: &Mesh, tool_from_mesh: Isometry) -> Self {
        Self::of(mesh, tool_from_mesh, MOST_HEIGHTS)
    }

    fn of(mesh: &Mesh, tool_from_mesh: Isometry, most_heights: usize) -> Self {
        let places: Vec<P2> = mesh
            .vertices()
            .iter()
            .map(|vertex| tool_from_mesh * vertex)
            .map(|p| P2::new(p.x.hypot(p.y).max(SAME_HEIGHT_MM), p.z))
            .collect();
        let outline = outline(&places, mesh.faces(), most_heights);
        let slice = |pair: &[P2]| frustum_mm3([pair[0].x, pair[1].x], pair[1].y - pair[0].y);
        let volume_mm3 = outline.windows(2).map(slice).sum::<f64>();
        let volume = mesh.signed_volume();
        // A mirrored part faces inwards, and fills as much.
        let volume = if volume < 0.0 && mesh.edge_report().is_watertight() { -volume } else { volume };
        let filled = if volume_mm3 > 0.0 { (volume / volume_mm3).clamp(0.0, 1.0) } else { 0.0 };
        Self { profile: Profile::of_lines(&outline), tool_from_mesh, volume_mm3, filled }
    }

    /// Whether this mesh is the tool when paired with `other`: the round one; of two round ones, the smaller; of two that are not round,
    /// the one that fills more of its body.
    pub fn is_tool_against(&self, other: &Self) -> bool {
        match (self.filled >= ROUND, other.filled >= ROUND) {
            (true, true) => self.volume_mm3 < other.volume_mm3,
            (false, false) => self.filled > other.filled,
            (is_round, _) => is_round,
        }
    }
}

/// Volume of a frustum with these radii at its ends, mm³.
pub fn frustum_mm3([r, s]: [f64; 2], height: f64) -> f64 {
    PI / 3.0 * height * (r * r + r * s + s * s)
}

/// The motion that brings the axis of a mesh to +z.
fn upright(mesh: &Mesh) -> Isometry {
    let (middle, covariance) = area_weighted(&mesh.triangles());
    let principal = principal_frame(&covariance);
    let axes = |through: Point, directions: [Vector; 3]| directions.map(|direction| (through, direction));
    let own = [Vector::z(), Vector::x(), Vector::y()];
    let principal: [Vector; 3] = std::array::from_fn(|i| principal.column(i).into_owned());
    let lines = [axes(Point::origin(), own), axes(middle, own), axes(middle, principal)].concat();
    let cylinder = |(through, direction): &(Point, Vector)| {
        let (mut low, mut high, mut radius) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        for vertex in mesh.vertices() {
            let v = vertex - through;
            let height = v.dot(direction);
            (low, high) = (low.min(height), high.max(height));
            radius = radius.max((v - direction * height).norm_squared());
        }
        radius * (high - low)
    };
    let mut best = (f64::INFINITY, lines[0]);
    for line in lines {
        // Only by more than rounding: the mesh's own axes are those that its maker meant.
        let volume = cylinder(&line);
        if volume < best.0 * (1.0 - 1e-9) {
            best = (volume, line);
        }
    }
    let (through, direction) = best.1;
    line_to_z(&through, &direction)
}

/// Middle and radius of the smallest circle around points: the farthest point outside enters those that determine it, at most three of them (B. Gärtner, "Fast and Robust
/// Smallest Enclosing Balls", 1999).
fn smallest_circle(points: &[P2]) -> (P2, f64) {
    let Some(&first) = points.first() else { return (P2::origin(), 0.0) };
    let (mut middle, mut radius, mut support) = (first, 0.0, vec![first]);
    let outside = |middle: P2| move |a: &&P2, b: &&P2| (*a - middle).norm().total_cmp(&(*b - middle).norm());
    // The radius grows each time, by more than rounding.
    while let Some(&far) =
        points.iter().max_by(outside(middle)).filter(|far| (*far - middle).norm() > radius * (1.0 + 1e-13))
    {
        let pairs = support.iter().map(|p| vec![far, *p]);
        let triples = support.iter().enumerate().flat_map(|(k, p)| support[..k].iter().map(move |q| vec![far, *p, *q]));
        let circle = |on: Vec<P2>| {
            let middle = match on[..] {
                [p, q] => nalgebra::center(&p, &q),
                [p, q, r] => {
                    let (u, v) = (q - p, r - p);
                    let across = v * u.norm_squared() - u * v.norm_squared();
                    p + nalgebra::Vector2::new(across.y, -across.x) / (2.0 * u.perp(&v))
                }
                _ => return None,
            };
            let radius = on.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
            let holds = support.iter().all(|p| (p - middle).norm() <= radius * (1.0 + 1e-12));
            (holds && radius.is_finite()).then_some((middle, radius, on))
        };
        let found = pairs.chain(triples).filter_map(circle).min_by(|a, b| a.1.total_cmp(&b.1));
        let Some(found) = found.filter(|found| found.1 > radius) else { break };
        (middle, radius, support) = found;
    }
    (middle, radius)
}

/// Takes a line to z.
pub fn line_to_z(point: &Point, direction: &Vector) -> Isometry {
    let turn = turn_between(direction, &Vector::z());
    Isometry::from_parts((turn * -point.coords).into(), turn)
}

/// The profile of a mesh with its vertices at `places`, from the axis to the axis, bottom first.
fn outline(places: &[P2], faces: &[[u32; 3]], most_heights: usize) -> Vec<P2> {
    let heights = Heights::of(places, most_heights);
    let count = heights.values.len();
    // The largest radius at a height, and at both ends of the slab above it.
    let mut at = vec![0.0_f64; count];
    let mut slabs = vec![[0.0_f64; 2]; count.saturating_sub(1)];
    for place in places {
        if heights.are_exact {
            let index = heights.index(place.y);
            at[index] = at[index].max(place.x);
        }
    }
    for face in faces {
        for side in 0..3 {
            let [p, q] = [face[side], face[(side + 1) % 3]].map(|corner| places[corner as usize]);
            let (p, q) = if p.y <= q.y { (p, q) } else { (q, p) };
            heights.add_edge(&p, &q, &mut slabs);
        }
    }
    let mut points = Vec::with_capacity(3 * count + 2);
    let ends = |index: usize| P2::new(0.0, heights.values[index]);
    points.push(ends(0));
    for index in 0..count {
        let z = heights.values[index];
        if index > 0 {
            add(&mut points, P2::new(slabs[index - 1][1], z));
        }
        if at[index] > 0.0 {
            add(&mut points, P2::new(at[index], z));
        }
        if index + 1 < count {
            add(&mut points, P2::new(slabs[index][0], z));
        }
    }
    points.push(ends(count - 1));
    points
}

/// Adds a point; it replaces the last point when that is collinear with its neighbours.
fn add(points: &mut Vec<P2>, point: P2) {
    if let [.., before, last] = points.as_slice() {
        let (u, v) = (last - before, point - last);
        if u.dot(&v) > 0.0 && u.perp(&v).abs() <= STRAIGHT * u.norm() * v.norm() {
            points.pop();
        }
    }
    points.push(point);
}

/// The part of a triangle between two heights, as the corners of a polygon.
pub fn clipped(corners: &[Point; 3], low: f64, high: f64) -> Vec<Point> {
    let mut polygon = corners.to_vec();
    for (border, sign) in [(low, 1.0), (high, -1.0)] {
        let above = |p: &Point| sign * (p.z - border);
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (p, q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let (from, to) = (above(p), above(q));
            if from >= 0.0 {
                kept.push(*p);
            }
            if from * to < 0.0 {
                kept.push(p + (q - p) * (from / (from - to)));
            }
        }
        polygon = kept;
    }
    polygon
}

/// The point of a polygon that is nearest to z, up to its height; `None` of a polygon without corners.
pub fn nearest_to_axis(polygon: &[Point]) -> Option<Point> {
    let edges = || polygon.iter().zip(polygon.iter().cycle().skip(1));
    let side = |(p, q): (&Point, &Point)| p.x * q.y - p.y * q.x;
    let is_around = edges().all(|edge| side(edge) > 0.0) || edges().all(|edge| side(edge) < 0.0);
    let of_edge = |(p, q): (&Point, &Point)| {
        let (dx, dy) = (q.x - p.x, q.y - p.y);
        let squared = dx * dx + dy * dy;
        let part = if squared > 0.0 { (-(p.x * dx + p.y * dy) / squared).clamp(0.0, 1.0) } else { 0.0 };
        p + (q - p) * part
    };
    let first = polygon.first()?;
    if is_around {
        return Some(Point::new(0.0, 0.0, first.z));
    }
    edges().map(of_edge).min_by(|a, b| a.x.hypot(a.y).total_cmp(&b.x.hypot(b.y)))
}

/// Heights at which a profile may have a corner, ascending, mm.
struct Heights {
    values: Vec<f64>,
    /// Whether every vertex is at one of the heights.
    are_exact: bool,
}

impl Heights {
    fn of(places: &[P2], most: usize) -> Self {
        let mut all: Vec<f64> = places.iter().map(|place| place.y).collect();
        all.sort_by(f64::total_cmp);
        let (low, high) = (all[0], all[all.len() - 1]);
        all.dedup_by(|next, kept| *next - *kept <= SAME_HEIGHT_MM);
        if all.len() <= most {
            return Self { values: all, are_exact: true };
        }
        let step = (high - low) / (most - 1) as f64;
        let mut values: Vec<f64> = (0..most).map(|k| low + step * k as f64).collect();
        values[most - 1] = high;
        Self { values, are_exact: false }
    }

    /// The last height that is not above `z`, up to rounding.
    fn index(&self, z: f64) -> usize {
        self.values.partition_point(|&height| height <= z + SAME_HEIGHT_MM).saturating_sub(1)
    }

    /// Widens the slabs that an edge crosses; `p` is not above `q`.
    fn add_edge(&self, p: &P2, q: &P2, slabs: &mut [[f64; 2]]) {
        let radius = |z: f64| {
            let part = if q.y > p.y { ((z - p.y) / (q.y - p.y)).clamp(0.0, 1.0) } else { 1.0 };
            p.x + part * (q.x - p.x)
        };
        let (from, to) = (self.index(p.y), self.index(q.y));
        if self.are_exact {
            for (slab, ends) in slabs[from..to].iter_mut().zip(self.values[from..].windows(2)) {
                *slab = [slab[0].max(radius(ends[0])), slab[1].max(radius(ends[1]))];
            }
            return;
        }
        // Steps: a slab has the largest radius anywhere in it; a vertex on a border belongs to both sides.
        let first = from.saturating_sub(1);
        for (slab, ends) in slabs.iter_mut().zip(self.values.windows(2)).skip(first).take(to + 1 - first) {
            let [low, high] = [ends[0], ends[1]];
            if p.y > high + SAME_HEIGHT_MM || q.y < low - SAME_HEIGHT_MM {
                continue;
            }
            let is_within = q.y <= high && p.y >= low;
            let most = radius(low).max(radius(high)).max(if is_within { p.x.max(q.x) } else { 0.0 });
            *slab = slab.map(|r| r.max(most));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::outline::OutlinePoint;
    use crate::geometry::shapes::{Revolve, Shape, Tessellation};
    use nalgebra::UnitQuaternion;
    use obbtree::cases::meshes;
    use proptest::prelude::*;

    fn stepped() -> Mesh {
        // Radius 4 to z = 10, a cone to 6 at z = 14, 6 to z = 20.
        let profile_mm = [[0.0, 0.0], [4.0, 0.0], [4.0, 10.0], [6.0, 14.0], [6.0, 20.0], [0.0, 20.0]];
        Shape::Revolve(Revolve { profile_mm: profile_mm.map(OutlinePoint::Sharp).to_vec() })
            .mesh(&Tessellation { density: 4.0, grading: 1.0 })
            .unwrap()
    }

    fn distance(revolved: &Revolved, p: &Point) -> f64 {
        let q = revolved.tool_from_mesh * p;
        revolved.profile.signed_distance_mm(&P2::new(q.x.hypot(q.y), q.z))
    }

    #[test]
    fn a_bar_with_a_keyway_turns_about_the_middle_of_its_outside() {
        let corner = |k: u32| {
            let (sin, cos) = (2.0 * f64::from(k)).to_radians().sin_cos();
            let radius = if (1..=10).contains(&k) { 15.0 } else { 20.0 };
            [300.0 + radius * cos, radius * sin]
        };
        let outline: Vec<[f64; 2]> = (0..180).map(corner).collect();
        let bar: Shape =
            toml::from_str(&format!("kind = \"extrude\"\nheight_mm = 50\noutline_mm = {outline:?}")).unwrap();
        let bar = bar.mesh(&Tessellation::default()).unwrap();
        let middle = |of: &Revolved| (of.tool_from_mesh.inverse() * Point::origin()).xy();
        let found = Revolved::within(&bar);
        assert!(
            (middle(&found) - P2::new(300.0, 0.0)).norm() < 1e-9 && (found.profile.radius_mm() - 20.0).abs() < 1e-6
        );
        assert!((middle(&Revolved::around(&bar)) - P2::new(300.0, 0.0)).norm() > 0.1);
        // What is round stays as it is.
        assert_eq!(Revolved::within(&stepped()), Revolved::around(&stepped()));
    }

    proptest! {
        #[test]
        fn the_smallest_circle_is_no_larger_than_any_through_two_or_three_points(
            points in prop::collection::vec(prop::array::uniform2(-9.0..9.0f64), 1..9),
        ) {
            let points: Vec<P2> = points.into_iter().map(P2::from).collect();
            let (middle, radius) = smallest_circle(&points);
            prop_assert!(points.iter().all(|p| (p - middle).norm() <= radius + 1e-9));
            let holds = |middle: P2, radius: f64| points.iter().all(|p| (p - middle).norm() <= radius + 1e-12);
            for p in &points {
                for q in &points {
                    let (half, middle) = (0.5 * (p - q).norm(), nalgebra::center(p, q));
                    prop_assert!(!holds(middle, half) || radius <= half + 1e-9);
                    // Farther along the bisector.
                    for k in -8..8 {
                        let aside = nalgebra::Vector2::new(q.y - p.y, p.x - q.x) * (0.15 * f64::from(k));
                        let to = (middle + aside - p).norm();
                        prop_assert!(!holds(middle + aside, to) || radius <= to + 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn a_turned_part_has_its_own_profile_wherever_it_lies() {
        let turn = UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0);
        let moved = Isometry::from_parts(Vector::new(30.0, -7.0, 55.0).into(), turn);
        for placement in [Isometry::identity(), moved] {
            let revolved = Revolved::around(&meshes::moved(&stepped(), 1.0, &placement));
            for (p, expected) in [
                (Point::new(7.0, 0.0, 5.0), 3.0),
                (Point::new(0.0, 1.0, 5.0), -3.0),
                (Point::new(0.0, 0.0, 25.0), 5.0),
                (Point::new(9.0, 0.0, 24.0), 5.0), // 3, 4 from the upper edge
                (Point::new(0.0, 8.0, 17.0), 2.0),
            ] {
                assert!((distance(&revolved, &(placement * p)) - expected).abs() < 1e-6, "{p}");
            }
            // The mesh's circles are inscribed, the body's are not.
            assert!(revolved.filled > 0.97 && revolved.filled < 1.0, "{}", revolved.filled);
            // 160 π below, 4 π / 3 (16 + 24 + 36) between, 216 π above.
            assert!((revolved.volume_mm3 / PI - (160.0 + 4.0 / 3.0 * 76.0 + 216.0)).abs() < 1e-3);
        }
    }

    #[test]
    fn a_mirrored_part_is_as_round_and_an_open_one_that_faces_inwards_is_not() {
        let (vertices, mut faces) = stepped().into_parts();
        faces.iter_mut().for_each(|face| face.swap(0, 1));
        let mirrored = Revolved::around(&Mesh::new(vertices.clone(), faces.clone()).unwrap());
        assert!((mirrored.filled - Revolved::around(&stepped()).filled).abs() < 1e-12 && mirrored.filled >= ROUND);
        faces.pop();
        assert!(Revolved::around(&Mesh::new(vertices, faces).unwrap()).filled < ROUND);
    }

    #[test]
    fn the_round_one_is_the_tool_and_of_two_the_smaller() {
        let (tool, ring) = (Revolved::around(&stepped()), Revolved::around(&meshes::torus(30.0, 5.0, 24, 12)));
        let small = Revolved::around(&meshes::moved(&stepped(), 0.5, &Isometry::identity()));
        assert!(ring.filled < ROUND);
        assert!(tool.is_tool_against(&ring) && !ring.is_tool_against(&tool));
        assert!(small.is_tool_against(&tool) && !tool.is_tool_against(&small));
        assert!(!tool.is_tool_against(&tool));
    }

    proptest! {
        /// The profile of any mesh, round or not, from few heights or many.
        #[test]
        fn every_point_of_the_mesh_is_in_the_body(which in 0..64usize, face in 0..10_000usize, u in 0.0..1.0f64, v in 0.0..1.0f64) {
            let subjects = meshes::subjects();
            let mesh = &subjects[which % subjects.len()].mesh;
            let revolved = Revolved::around(mesh);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let [a, b, c] = mesh.triangles()[face % mesh.faces().len()].corners;
            let outside = distance(&revolved, &(a + (b - a) * u + (c - a) * v));
            prop_assert!(outside < super::super::detect::SLACK_MM / 2.0, "{outside} mm outside of {}", subjects[which % subjects.len()].name);
        }
    }
}

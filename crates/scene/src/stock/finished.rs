//! A finished workpiece, which stays whole: how deep a cutter goes into it.
//!
//! The depth is how far the workpiece's surface lies inside the body of revolution around the cutter: minus the least signed distance of the surface from that body.
//! It is found by branch and bound over the triangles of the surface and halves of them (Land and Doig 1960). Two bounds hold for a piece of a triangle. The signed
//! distance is at least that of the piece's centre less the piece's radius. It is also at least that from the convex hull of the body, which is a convex function of
//! the place, above its tangent plane at any point. So a face that lies flat on a cutter, or touches it in a line, is seldom divided. On a straight way
//! a plane is least at one of the two ends, so one plane bounds the distance on all of it; where the cutter slides along the surface, that is hardly less than at one place.

use super::bore::upper_envelope;
use super::skin::Skin;
use super::sweep::ROUNDING_MM;
use crate::geometry::{Isometry, Mesh, Point, Triangle, Vector};
use crate::interference::Revolved;
use crate::interference::profile::{P2, Profile};
use nalgebra::Vector2;
use std::sync::Arc;

/// How close to the true one the least distance is found, mm.
const CLOSE_MM: f64 = 1e-3;
/// The same as a part of a depth, where that is more.
const CLOSE_PART: f64 = 0.05;
/// Radius of pieces that are not divided, mm. Pieces are as small as this only at sharp edges and in hollows of the cutter, where its hull is no close bound.
const SMALLEST_MM: f64 = 0.01;
/// Places asked about after which that radius grows in proportion to them. On a way the search ends there.
const MANY: f64 = 1000.0;
/// Places on a way at which a tangent plane is tried.
const CROSSINGS: usize = 4;

/// The surface of a finished workpiece, prepared once for all cutters.
#[derive(Clone, Debug)]
pub struct Surface(Arc<Skin>);

impl Surface {
    /// Prepares it.
    pub fn of(workpiece: &Arc<Mesh>) -> Self {
        Self(Arc::new(Skin::new(workpiece)))
    }
}

/// A finished workpiece and a cutter.
#[derive(Clone, Debug)]
pub struct Finished {
    surface: Arc<Skin>,
    cutter: Revolved,
    hull: Vec<Side>,
}

/// A side of the convex hull of a body of revolution, in (ρ, z).
#[derive(Clone, Copy, Debug)]
struct Side {
    from: P2,
    along: Vector2<f64>,
    /// Outwards, of length 1.
    normal: Vector2<f64>,
}

impl Finished {
    /// Prepares the cutter.
    pub fn new(Surface(surface): Surface, cutter: &Mesh) -> Self {
        let cutter = Revolved::finely_around(cutter);
        Self { surface, hull: hull(&cutter.profile), cutter }
    }

    /// The least distance of the workpiece's surface from the body of revolution around the cutter, mm, negative inside; `below_mm` where it is at least that. It is
    /// at most 0.001 mm, or a twentieth of a depth, above the true one; in hollows of the cutter and at its tip at most the radius of the smallest pieces.
    pub fn least_mm(&self, cutter_from_workpiece: &Isometry, below_mm: f64) -> f64 {
        let body_from_workpiece = self.cutter.tool_from_mesh * cutter_from_workpiece;
        let bound = |node: u32| {
            let (centre, radius) = self.surface.ball(node);
            (self.distance_mm(&(body_from_workpiece * centre)) - radius, node)
        };
        let mut search = Search { of: self, least: below_mm, asked: 0 };
        let mut open = vec![bound(0)];
        while let Some((least, node)) = open.pop() {
            if search.is_answered(least) {
                continue;
            }
            let Some(children) = self.surface.children(node) else {
                let triangles = self.surface.triangles(node).iter();
                triangles.for_each(|triangle| search.divide(triangle.corners.map(|p| body_from_workpiece * p)));
                continue;
            };
            let mut children = children.map(bound);
            // The nearer one last, which is taken first.
            children.sort_by(|a, b| b.0.total_cmp(&a.0));
            open.extend(children);
        }
        search.least
    }

    /// Whether the surface may come deeper than `depth_mm` into the body while the workpiece goes from one frame in the cutter's to another. Seen from the cutter, each of
    /// its places near the cutter goes straight, up to `sag_mm`. `true` also where a thousand pieces of triangles do not tell.
    pub fn may_be_deeper(&self, cutter_from_workpiece: [&Isometry; 2], sag_mm: f64, depth_mm: f64) -> bool {
        let ways = cutter_from_workpiece.map(|pose| self.cutter.tool_from_mesh * pose);
        // Whether nothing is too deep, all the way, of what is within `radius` of a place, or in the triangle with these corners.
        let is_free = |centre: &Point, radius: f64, corners: Option<&[Point; 3]>| {
            let [from, to] = ways.map(|pose| pose * centre);
            let is_above = |place: &Point| {
                let tangent = self.tangent(place);
                let of_ball = tangent.at(&from).min(tangent.at(&to)) - radius;
                let of_corners = |corners: &[Point; 3]| {
                    let all = ways.iter().flat_map(|pose| corners.map(|corner| tangent.at(&(pose * corner))));
                    all.fold(f64::INFINITY, f64::min)
                };
                corners.map_or(of_ball, |corners| of_ball.max(of_corners(corners))) - sag_mm >= -depth_mm
            };
            let middle = nalgebra::center(&from, &to);
            let beside = self.distance_mm(&middle) - radius - sag_mm;
            // What is not free in the middle of the way is not free on it.
            beside - 0.5 * (to - from).norm() >= -depth_mm
                || is_above(&middle)
                || beside >= -depth_mm
                    && ([from, to].iter().any(is_above) || self.towards_nearest([from, to]).iter().any(is_above))
        };
        let (mut nodes, mut pieces) = (vec![0], Vec::new());
        while let Some(node) = nodes.pop() {
            let (centre, radius) = self.surface.ball(node);
            if is_free(&centre, radius, None) {
                continue;
            }
            match self.surface.children(node) {
                Some(children) => nodes.extend(children),
                None => pieces.extend(self.surface.triangles(node).iter().map(|triangle| triangle.corners)),
            }
        }
        let mut asked = 0.0;
        while let Some(corners) = pieces.pop() {
            let [a, b, c] = corners;
            let centre = Triangle::new(a, b, c).centroid();
            let radius = corners.iter().map(|corner| (corner - centre).norm()).fold(0.0, f64::max);
            if is_free(&centre, radius, Some(&corners)) {
                continue;
            }
            asked += 1.0;
            if radius <= SMALLEST_MM || asked > MANY {
                return true;
            }
            let [a, b, c] = longest_first(corners, |corner| corner);
            let middle = nalgebra::center(&a, &b);
            pieces.extend([[a, middle, c], [middle, b, c]]);
        }
        false
    }

    /// Whether a watertight workpiece holds the middle of the cutter's axis: then all of the cutter is inside, where the surface does not come into it.
    pub fn holds(&self, cutter_from_workpiece: &Isometry) -> bool {
        let [low, high] = self.cutter.profile.span_mm();
        let middle = Point::new(0.0, 0.0, f64::midpoint(low, high));
        self.surface.holds(&(self.cutter.tool_from_mesh * cutter_from_workpiece).inverse_transform_point(&middle))
    }

    /// Places on a straight way, each nearer than the one before to where the way is nearest to the body's hull: where the tangent planes on both sides cross.
    fn towards_nearest(&self, [from, to]: [Point; 2]) -> [Point; CROSSINGS] {
        let way = to - from;
        let mut ends = [from, to].map(|place| self.tangent(&place));
        [(); CROSSINGS].map(|()| {
            let [falls, rises] = ends.map(|end| end.slope.dot(&way));
            let part_of_way = (ends[1].place - ends[0].place).dot(&way) / way.norm_squared();
            let part = (ends[0].value - ends[1].value + rises * part_of_way) / (rises - falls);
            // Planes with the same slope cross nowhere.
            let part = if part.is_finite() { part.clamp(0.0, part_of_way) } else { 0.5 * part_of_way };
            let place = ends[0].place + way * part;
            let tangent = self.tangent(&place);
            ends[usize::from(tangent.slope.dot(&way) >= 0.0)] = tangent;
            place
        })
    }

    /// The tangent plane of the distance from the body's hull at a place of its frame.
    fn tangent(&self, place: &Point) -> Tangent {
        let at = half_plane(place);
        let (value, slope) = gradient(&self.hull, &at);
        // On the axis the slope is any mean of all directions.
        let out = if at.x > 0.0 { place.xy().coords / at.x } else { Vector2::zeros() };
        Tangent { place: *place, value, slope: Vector::new(slope.x * out.x, slope.x * out.y, slope.y) }
    }

    /// Distance of a point of the body's frame from the body, mm, negative inside.
    fn distance_mm(&self, place: &Point) -> f64 {
        self.cutter.profile.signed_distance_mm(&half_plane(place))
    }
}

fn half_plane(place: &Point) -> P2 {
    P2::new(place.x.hypot(place.y), place.z)
}

/// The convex hull of a body of revolution, from its lowest place on the axis to its highest.
fn hull(profile: &Profile) -> Vec<Side> {
    let heights = profile.heights_mm().into_iter();
    let outline = upper_envelope(&heights.map(|z| [profile.radius_between_mm(z, z), z]).collect::<Vec<_>>());
    let end = |place: Option<&[f64; 2]>| place.map(|&[_, z]| P2::new(0.0, z));
    let around = outline.iter().map(|&[rho, z]| P2::new(rho, z));
    let corners: Vec<P2> = end(outline.first()).into_iter().chain(around).chain(end(outline.last())).collect();
    let side = |pair: &[P2]| {
        let along = pair[1] - pair[0];
        let normal = Vector2::new(along.y, -along.x).try_normalize(0.0)?;
        Some(Side { from: pair[0], along, normal })
    };
    corners.windows(2).filter_map(side).collect()
}

/// The signed distance from a convex hull at a place of (ρ, z), and its gradient.
fn gradient(hull: &[Side], place: &P2) -> (f64, Vector2<f64>) {
    let mut beyond = (f64::NEG_INFINITY, Vector2::zeros());
    let mut nearest = Vector2::repeat(f64::INFINITY);
    for side in hull {
        let from = place - side.from;
        let above = side.normal.dot(&from);
        if above > beyond.0 {
            beyond = (above, side.normal);
        }
        let part = (side.along.dot(&from) / side.along.norm_squared()).clamp(0.0, 1.0);
        let apart = from - side.along * part;
        if apart.norm_squared() < nearest.norm_squared() {
            nearest = apart;
        }
    }
    // On the hull the way to it has no direction; the plane of a side is below the distance everywhere.
    if beyond.0 <= ROUNDING_MM {
        return beyond;
    }
    let distance = nearest.norm();
    (distance, nearest / distance)
}

/// The tangent plane of the distance from the hull at a place.
#[derive(Clone, Copy)]
struct Tangent {
    place: Point,
    value: f64,
    slope: Vector,
}

impl Tangent {
    fn at(&self, place: &Point) -> f64 {
        self.value + self.slope.dot(&(place - self.place))
    }
}

/// A piece of a triangle.
struct Piece {
    corners: [Tangent; 3],
    radius: f64,
    /// The distance is nowhere less on it.
    bound: f64,
}

struct Search<'a> {
    of: &'a Finished,
    /// The least distance found, mm.
    least: f64,
    /// Places of the surface asked about.
    asked: u32,
}

impl Search<'_> {
    /// Whether what is nowhere nearer than `bound` is not asked about.
    fn is_answered(&self, bound: f64) -> bool {
        bound >= self.least - CLOSE_MM.max(-CLOSE_PART * self.least)
    }

    /// Takes in a triangle in the frame of the body.
    fn divide(&mut self, corners: [Point; 3]) {
        let corners = corners.map(|place| self.ask(place).0);
        let mut open = vec![self.piece(corners)];
        while let Some(piece) = open.pop() {
            let smallest = SMALLEST_MM * (f64::from(self.asked) / MANY).max(1.0);
            if self.is_answered(piece.bound) || piece.radius <= smallest {
                continue;
            }
            let [a, b, c] = longest_first(piece.corners, |corner| corner.place);
            let middle = self.ask(nalgebra::center(&a.place, &b.place)).0;
            let mut halves = [self.piece([a, middle, c]), self.piece([middle, b, c])];
            halves.sort_by(|a, b| b.bound.total_cmp(&a.bound));
            open.extend(halves);
        }
    }

    fn piece(&mut self, corners: [Tangent; 3]) -> Piece {
        let [a, b, c] = corners.map(|corner| corner.place);
        let centre = Triangle::new(a, b, c).centroid();
        let radius = [a, b, c].iter().map(|corner| (corner - centre).norm()).fold(0.0, f64::max);
        let (middle, distance) = self.ask(centre);
        let least = |tangent: &Tangent| [a, b, c].iter().map(|p| tangent.at(p)).fold(f64::INFINITY, f64::min);
        let bound = corners.iter().chain([&middle]).map(least).fold(distance - radius, f64::max);
        Piece { corners, radius, bound }
    }

    /// The tangent at a place of the surface, and its distance from the body.
    fn ask(&mut self, place: Point) -> (Tangent, f64) {
        self.asked += 1;
        let distance = self.of.distance_mm(&place);
        self.least = self.least.min(distance);
        (self.of.tangent(&place), distance)
    }
}

/// The same corners, the longest edge between the first two.
fn longest_first<T: Copy>(corners: [T; 3], place: impl Fn(T) -> Point) -> [T; 3] {
    let length = |k: usize| (place(corners[(k + 1) % 3]) - place(corners[k])).norm_squared();
    let longest = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    [0, 1, 2].map(|k| corners[(longest + k) % 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::{Shape, Tessellation};
    use crate::interference::Samples;
    use obbtree::cases::meshes;

    fn mesh(shape: &str) -> Arc<Mesh> {
        let shape: Shape = toml::from_str(shape).unwrap();
        Arc::new(shape.mesh(&Tessellation::default()).unwrap())
    }

    fn cylinder(radius_mm: f64, height_mm: f64) -> Arc<Mesh> {
        mesh(&format!("kind = \"cylinder\"\nradius_mm = {radius_mm:?}\nheight_mm = {height_mm:?}"))
    }

    fn finished(workpiece: &Arc<Mesh>, cutter: &Mesh) -> Finished {
        Finished::new(Surface::of(workpiece), cutter)
    }

    /// A head of 10 mm radius on a neck of 3 mm.
    fn slotting() -> Arc<Mesh> {
        mesh("kind = \"revolve\"\nprofile_mm = [[0, 0], [10, 0], [10, 5], [3, 5], [3, 30], [0, 30]]")
    }

    #[test]
    fn depths_known_by_hand() {
        // Its top is at z = 10.
        let block = mesh("kind = \"rounded-box\"\nsize_mm = [100, 100, 20]");
        // Where the middle of the cutter's lower end is, and how far the block's surface is from the cutter.
        for (cutter, at, expected) in [
            (cylinder(5.0, 30.0), [3.0, 7.0, 12.0], 2.0),
            (cylinder(5.0, 30.0), [3.0, 7.0, 9.97], -0.03),
            // A needle is as deep as it is thick.
            (cylinder(0.05, 30.0), [13.37, 7.21, 5.0], -0.05),
            // Inside the block, 4 mm below its top and 12 mm above its bottom.
            (cylinder(1.0, 4.0), [0.0, 0.0, 2.0], 4.0),
            (slotting(), [0.0, 0.0, 9.9], -0.1),
            // Beside the block, the head 1 mm below it and the neck 2 mm off it.
            (slotting(), [55.0, 0.0, -16.0], 1.0),
        ] {
            let found = finished(&block, &cutter);
            let cutter_from_block = Isometry::translation(-at[0], -at[1], -at[2]);
            let found = found.least_mm(&cutter_from_block, 50.0);
            // Pieces that are not divided take a little of the needle's depth.
            assert!((found - expected).abs() <= CLOSE_MM.max(-1.1 * CLOSE_PART * expected) + 1e-6, "{at:?}: {found}");
        }
        // Up to the top, and beyond it by more than half of it.
        let pin = finished(&block, &cylinder(1.0, 4.0));
        let is_inside = |z: f64| pin.holds(&Isometry::translation(-3.0, 0.0, -z));
        assert!(is_inside(-9.0) && is_inside(6.0) && !is_inside(8.5) && !is_inside(10.0));
        let far = Isometry::translation(0.0, 0.0, -500.0);
        assert_eq!(finished(&block, &slotting()).least_mm(&far, 50.0), 50.0);
    }

    /// A ball of 5 mm radius with 200 rings, leaning by 45 degrees, 0.2 mm above the block.
    #[test]
    fn a_finely_divided_ball_is_as_large_as_it_is() {
        let block = mesh("kind = \"rounded-box\"\nsize_mm = [100, 100, 20]");
        let ring = |k: u32| {
            let (sin, cos) = (std::f64::consts::FRAC_PI_2 * f64::from(k) / 200.0).sin_cos();
            format!("[{:?}, {:?}], ", 5.0 * sin, 5.0 - 5.0 * cos)
        };
        let rings: String = (0..=200).map(ring).collect();
        let ball = mesh(&format!("kind = \"revolve\"\nprofile_mm = [{rings}[5, 60], [0, 60]]"));
        let leaning = Isometry::rotation(Vector::x() * std::f64::consts::FRAC_PI_4);
        let place = Vector::new(0.0, 0.0, 15.2) - leaning * Vector::new(0.0, 0.0, 5.0);
        let block_from_cutter = Isometry::from_parts(place.into(), leaning.rotation);
        let found = finished(&block, &ball).least_mm(&block_from_cutter.inverse(), 50.0);
        assert!((found - 0.2).abs() < 0.01, "{found}");
    }

    #[test]
    fn no_sample_of_the_surface_is_deeper() {
        let ring = Arc::new(meshes::torus(12.0, 4.0, 24, 12));
        let samples = Samples::of(&ring, 0.4).points;
        let (mut touching, mut free) = (0, 0);
        for cutter in [cylinder(3.0, 20.0), cylinder(0.2, 20.0), slotting()] {
            let finished = finished(&ring, &cutter);
            for k in 0..60 {
                let k = f64::from(k);
                let turn = Vector::new(1.3 * (0.37 * k).sin(), 1.1 * (0.53 * k).cos(), 0.2 * k);
                let at = Vector::new(12.0 * (0.05 * k).cos(), 12.0 * (0.05 * k).sin(), 5.0 + 4.0 * (0.29 * k).sin());
                let cutter_from_ring = Isometry::new(at, turn).inverse();
                let found = finished.least_mm(&cutter_from_ring, 100.0);
                let distance =
                    |p: &Point| finished.distance_mm(&(finished.cutter.tool_from_mesh * cutter_from_ring * p));
                let least = samples.iter().map(distance).fold(f64::INFINITY, f64::min);
                // Between samples 0.4 mm apart.
                assert!(found - least <= (-CLOSE_PART * found).max(0.1) && least - found <= 0.4, "{found} {least}");
                touching += u32::from(found < 0.0);
                // Nor on a way of about 1 mm, in which its places go straight.
                let end =
                    Isometry::new(at + Vector::new(0.5, -0.6, 0.4), turn + Vector::new(0.01, 0.0, -0.02)).inverse();
                let deepest = |p: &Point| {
                    let [from, to] = [cutter_from_ring, end].map(|pose| finished.cutter.tool_from_mesh * pose * p);
                    (0..=5)
                        .map(|k| finished.distance_mm(&(from + (to - from) * (0.2 * f64::from(k)))))
                        .fold(0.0, f64::min)
                };
                let deepest_mm = -samples.iter().map(deepest).fold(0.0, f64::min);
                let is_deeper = |mm: f64| finished.may_be_deeper([&cutter_from_ring, &end], 0.0, mm);
                assert!(deepest_mm == 0.0 || is_deeper(deepest_mm - 1e-9), "{deepest_mm}");
                free += u32::from(!is_deeper(deepest_mm + 0.4));
            }
        }
        assert!(touching > 20 && free > 100, "{touching} {free}");
    }

    #[test]
    fn on_a_way_it_is_deeper_where_a_place_of_it_is() {
        // A block of 20 mm height and cutters of 5 mm radius, the one with a chamfer: over it, in it by 0.1 mm, and from one side of a fin of 1 mm to the other.
        let block = mesh("kind = \"rounded-box\"\nsize_mm = [100, 100, 20]");
        let fin = mesh("kind = \"rounded-box\"\nsize_mm = [1, 100, 20]");
        let at = |x: f64, z: f64| Isometry::translation(-x, 0.0, -z);
        for (workpiece, [from, to], depth_mm, expected) in [
            (&block, [[-1.0, 10.0], [1.0, 10.0]], 0.05, false),
            (&block, [[-1.0, 9.9], [1.0, 9.9]], 0.15, false),
            (&block, [[-1.0, 9.9], [1.0, 9.9]], 0.09, true),
            (&block, [[-1.0, 10.1], [1.0, 9.85]], 0.1, true),
            (&block, [[-1.0, 30.0], [1.0, 10.1]], 0.0, false),
            (&fin, [[-5.6, 0.0], [5.6, 0.0]], 4.0, true),
            (&fin, [[-5.6, 0.0], [5.6, 0.0]], 5.2, false),
            (&fin, [[-9.0, 0.0], [-5.6, 0.0]], 0.0, false),
        ] {
            let ways = [at(from[0], from[1]), at(to[0], to[1])];
            for cutter in [
                cylinder(5.0, 30.0),
                mesh("kind = \"revolve\"\nprofile_mm = [[0, 0], [3, 0], [5, 2], [5, 30], [0, 30]]"),
            ] {
                let told = finished(workpiece, &cutter).may_be_deeper([&ways[0], &ways[1]], 0.0, depth_mm);
                assert_eq!(told, expected, "{from:?} {to:?} {depth_mm}");
            }
        }
    }
}

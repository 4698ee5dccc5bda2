//! All boxes that can be the smallest around a convex solid, enumerated by pairs of its edges.
//!
//! Two neighbouring faces of the box have their normals on the [`Arc`]s of two edges. Branch and bound divides the first arc where a
//! smaller box is possible; [`Family`] computes the bounds.

use super::arc::Arc;
use super::family::{Family, least_product};
use super::search::{PROGRESS, Search};
use super::{FLAT, MAX_STEPS, TOLERANCE, any_frame};
use crate::geometry::Vector;
use crate::geometry::hull::Solid;
use nalgebra::Matrix3;

/// Parts of an arc below this angle, rad, are not divided. Where an axis is nearly along the other edge, the frame turns too fast for the
/// bounds; the frames there are tried separately.
const SHORTEST: f64 = 2e-7;
/// Two edges with an angle whose cosine is below this make only boxes with an axis along the first edge, because their tilt or their σ is
/// below [`SHORTEST`]. All boxes with an axis along an edge are tried separately.
const PERPENDICULAR: f64 = 1e-14;
/// Angle to which arcs are trimmed, rad, approximately. Of 0.02, 0.07, 0.2 and 0.5, none was clearly the fastest on two meshes.
const TRIM: f64 = 0.1;

/// The search among the boxes that have two neighbouring faces on edges of a solid.
pub(super) struct BoxesOnEdges<'a> {
    search: &'a mut Search,
    solid: &'a Solid,
    /// Outward normals with the length of the face's area, mm².
    faces: Vec<Vector>,
    /// The corners joined to corner i by an edge are `joined[starts[i]..starts[i + 1]]`.
    joined: Vec<u32>,
    starts: Vec<u32>,
    /// The lowest and highest corners along each axis of the last box; those of the next box are near them.
    extremes: [[u32; 2]; 3],
    steps: u32,
}

impl<'a> BoxesOnEdges<'a> {
    /// The points of `search` are the corners of `solid`.
    pub(super) fn new(search: &'a mut Search, solid: &'a Solid) -> Self {
        let faces = (0..solid.faces.len()).map(|face| solid.triangle(face).double_area_normal() / 2.0).collect();
        let mut pairs: Vec<(u32, u32)> = solid.faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        pairs.sort_unstable();
        let starts = (0..=solid.vertices.len()).map(|i| pairs.partition_point(|&(from, _)| (from as usize) < i) as u32);
        Self {
            faces,
            starts: starts.collect(),
            joined: pairs.into_iter().map(|(_, to)| to).collect(),
            extremes: [[0; 2]; 3],
            steps: 0,
            search,
            solid,
        }
    }

    /// Offers every box that may be the smallest.
    pub(super) fn try_all(&mut self) {
        let normals = self.solid.normals();
        let edges = self.solid.edges();
        // A face of the box in a face of the solid; and an edge of the box along an edge of the solid.
        let faces: Vec<Vector> = distinct(edges.iter().flat_map(|edge| edge.faces.map(|face| normals[face as usize])));
        let alongs = distinct(edges.iter().filter_map(|edge| (edge.ends[1] - edge.ends[0]).try_normalize(0.0)));
        for axis in faces.iter().chain(&alongs) {
            self.search_about(axis);
        }
        if faces.iter().any(|axis| self.width(axis) - 2.0 * self.search.pad < FLAT * self.search.diameter) {
            return;
        }
        let arcs: Vec<Arc> = edges.iter().filter_map(|edge| self.trimmed(&Arc::new(edge, &normals)?)).collect();
        for (i, moving) in arcs.iter().enumerate() {
            for other in arcs[i + 1..].iter().filter(|other| moving.edge.dot(&other.edge).abs() > PERPENDICULAR) {
                for part in moving.meets(other).into_iter().flatten() {
                    self.search_pair(part, &other.edge);
                }
            }
        }
    }

    /// Upper limit on the volume of a box that is still of interest, mm³.
    fn wanted(&self) -> f64 {
        self.search.best.0 * (1.0 - TOLERANCE)
    }

    /// Offers the boxes with one axis along `axis`.
    fn search_about(&mut self, axis: &Vector) {
        if self.shadow(axis).dot(axis) * self.width(axis) < self.wanted() && self.search.turn_about(&any_frame(axis), 0)
        {
            self.search.descend();
        }
    }

    /// Trims the arc, to about [`TRIM`], to the part whose normals may have a box that is small enough; `None` when no such normal is left.
    /// The volume of the box with normal n is at least the area of the solid's shadow along n times the width along n. The faces and
    /// corners seen from the middle of the arc give a lower bound of each factor, and each bound is a sinusoid.
    fn trimmed(&mut self, arc: &Arc) -> Option<Arc> {
        let mut kept: Option<[f64; 2]> = None;
        let mut open = vec![(0.0, *arc)];
        while let Some((start, part)) = open.pop() {
            let middle = part.middle();
            let (shadow, span) = (self.shadow(&middle), self.span(0, &middle));
            let lines = [&shadow, &span].map(|d| part.ends.map(|n| d.dot(&n)));
            if least_product(&lines, [0.0, 2.0 * self.search.pad]) >= self.wanted() {
                continue;
            }
            if part.angle > TRIM {
                let [first, second] = part.halves();
                // The first is looked at first, so that what is kept grows at its end.
                open.extend([(start + first.angle, second), (start, first)]);
            } else {
                kept = Some([kept.map_or(start, |k| k[0]), start + part.angle]);
            }
        }
        kept.map(|[low, high]| arc.part(low, high))
    }

    /// Offers the boxes with one normal on `part` and one perpendicular to an edge with unit direction `along`.
    fn search_pair(&mut self, part: Arc, along: &Vector) {
        let mut open = vec![part];
        while let Some(part) = open.pop() {
            if self.steps >= MAX_STEPS {
                return;
            }
            self.steps += 1;
            let normal = part.middle();
            let divisible = part.angle > SHORTEST;
            let Some(second) = along.cross(&normal).try_normalize(SHORTEST) else {
                open.extend(part.halves().into_iter().filter(|_| divisible));
                continue;
            };
            let axes = [normal, second, normal.cross(&second)];
            let spans = [0, 1, 2].map(|i| self.span(i, &axes[i]));
            let volume: f64 = (0..3).map(|i| axes[i].dot(&spans[i]) + 2.0 * self.search.pad).product();
            if volume < self.search.best.0 * (1.0 - PROGRESS) && self.search.offer(&Matrix3::from_columns(&axes)) {
                self.search.descend();
            }
            let family = Family::new(&part, along, spans, 2.0 * self.search.pad);
            if divisible && family.least_by_numerators().max(family.least_by_tilt(&second)) < self.wanted() {
                open.extend(part.halves());
            }
        }
    }

    /// Extent along a unit axis, including the pad, mm.
    fn width(&mut self, axis: &Vector) -> f64 {
        self.span(0, axis).dot(axis) + 2.0 * self.search.pad
    }

    /// The sum of the area vectors of the faces seen along `axis`, mm². Its component along the axis is the area of the solid's shadow,
    /// which no rectangle around the shadow undercuts. Its component along any other axis is at most the area of the shadow there.
    fn shadow(&self, axis: &Vector) -> Vector {
        self.faces.iter().filter(|face| face.dot(axis) > 0.0).sum()
    }

    /// The vector from the lowest to the highest corner along an axis, mm. `slot` is the nearest of the last box's axes.
    fn span(&mut self, slot: usize, axis: &Vector) -> Vector {
        let [low, high] = self.extremes[slot];
        let (low, high) = (self.climb(low, &-axis), self.climb(high, axis));
        self.extremes[slot] = [low, high];
        self.search.points[high as usize] - self.search.points[low as usize]
    }

    /// The highest corner along `axis`, found by climbing from `from`. In a convex solid, a corner without a higher neighbour is the
    /// highest.
    fn climb(&self, from: u32, axis: &Vector) -> u32 {
        let (mut at, mut height) = (from, axis.dot(&self.search.points[from as usize]));
        loop {
            let [start, end] = [at, at + 1].map(|i| self.starts[i as usize] as usize);
            let next = self.joined[start..end].iter().map(|&next| (next, axis.dot(&self.search.points[next as usize])));
            match next.into_iter().find(|&(_, next_height)| next_height > height) {
                Some(higher) => (at, height) = higher,
                None => return at,
            }
        }
    }
}

/// The unit vectors without duplicates: vectors that are equal or opposite to rounding count once.
fn distinct(vectors: impl Iterator<Item = Vector>) -> Vec<Vector> {
    /// 1 - cos of 1e-7 rad is 5e-15.
    const SAME: f64 = 5e-15;
    let mut kept: Vec<Vector> = Vec::new();
    for v in vectors {
        if kept.iter().all(|k| k.dot(&v).abs() < 1.0 - SAME) {
            kept.push(v);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hull::Hull;
    use crate::geometry::{Point, rectangle};
    use obbtree::cases::Draw;
    use proptest::prelude::*;

    fn solid(corners: &[[f64; 3]]) -> Option<Solid> {
        let points: Vec<Point> = corners.iter().map(|&p| Point::from(p)).collect();
        match Hull::of(points.iter())? {
            Hull::Solid(solid) => Some(solid),
            _ => None,
        }
    }

    #[test]
    fn an_arc_whose_middle_is_along_the_other_edge_is_divided() {
        let solid = solid(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 5.0]]).unwrap();
        let mut search = Search::new(solid.vertices.iter(), 0.0);
        search.best.0 = f64::INFINITY;
        let mut boxes = BoxesOnEdges::new(&mut search, &solid);
        let normals = solid.normals();
        let arc = solid.edges().iter().find_map(|edge| Arc::new(edge, &normals)).unwrap();
        // Off the middle by less than makes an axis, and not quite square to the arc's edge.
        boxes.search_pair(arc, &(arc.middle() + arc.edge * 1e-8).normalize());
        assert!(boxes.steps > 2 && boxes.search.best.0.is_finite());
    }

    #[test]
    fn equal_and_opposite_directions_count_once() {
        let (x, y) = (Vector::x(), Vector::y());
        let nearly = (x + y * 1e-9).normalize();
        let (aslant, apart) = ((x + y).normalize(), (x + y * 1e-6).normalize());
        assert_eq!(distinct([x, y, -x, nearly, aslant, -aslant, y, apart].into_iter()), [x, y, aslant, apart]);
    }

    #[test]
    fn of_a_thin_wedge_the_boxes_on_pairs_of_edges_are_tried_and_of_a_flat_one_not() {
        let steps = |thick: f64| {
            let solid =
                solid(&[[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [1.0, 1.0, thick]]).expect("four corners in space");
            let mut search = Search::new(solid.vertices.iter(), 0.0);
            let mut boxes = BoxesOnEdges::new(&mut search, &solid);
            boxes.try_all();
            boxes.steps
        };
        // Flat is what is thinner than a millionth of its diameter of √13 mm.
        assert!(steps(1.0) > 0 && steps(2.0 * FLAT * 13.0_f64.sqrt()) > 0);
        assert_eq!(steps(0.5 * FLAT * 13.0_f64.sqrt()), 0);
    }

    /// Bounds that are too loose cost steps, bounds that are too tight lose boxes.
    #[test]
    fn the_search_takes_the_steps_that_it_took() {
        let random = |corners: u64| {
            let on_sphere = (0..corners).map(|k| Draw::new(5, &["steps"], k).in_ball().normalize());
            on_sphere.map(|p| [4.0 * p.x, 2.0 * p.y, p.z]).collect::<Vec<_>>()
        };
        let wedge = vec![[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.5, 0.7, 5.0]];
        for (corners, steps, volume) in
            [(wedge, 478, 28.497_072), (random(9), 308, 21.084_591), (random(30), 1568, 54.737_512)]
        {
            let solid = solid(&corners).unwrap();
            let mut search = Search::new(solid.vertices.iter(), 1e-3);
            search.descend();
            let mut boxes = BoxesOnEdges::new(&mut search, &solid);
            boxes.try_all();
            // A hundredth for what another processor's sines round otherwise.
            assert!(boxes.steps.abs_diff(steps) <= steps / 100, "{} steps, not {steps}", boxes.steps);
            assert!((boxes.search.best.0 / volume - 1.0).abs() < 1e-6, "{} mm³, not {volume}", boxes.search.best.0);
        }
    }

    proptest! {
        #[test]
        fn climbing_finds_what_looking_at_all_corners_finds(
            corners in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 4..60),
            axes in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 20),
        ) {
            let Some(solid) = solid(&corners) else { return Ok(()) };
            let mut search = Search::new(solid.vertices.iter(), 0.0);
            let mut boxes = BoxesOnEdges::new(&mut search, &solid);
            for axis in axes {
                let axis = Vector::from(axis);
                let heights = || solid.vertices.iter().map(|p| axis.dot(&p.coords));
                let extent = heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
                prop_assert!((boxes.span(1, &axis).dot(&axis) - extent).abs() < 1e-12);
            }
        }

        /// Trimming removes only normals whose boxes are too large to be of interest.
        #[test]
        fn what_is_trimmed_has_no_smaller_box(
            corners in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 4..20),
            flat in prop_oneof![Just(1.0), Just(0.03)],
        ) {
            let Some(solid) = solid(&corners.iter().map(|[x, y, z]| [*x, *y, z * flat]).collect::<Vec<_>>()) else {
                return Ok(());
            };
            let mut search = Search::new(solid.vertices.iter(), 1e-9);
            search.descend();
            let points = search.points.clone();
            let mut boxes = BoxesOnEdges::new(&mut search, &solid);
            let normals = solid.normals();
            for arc in solid.edges().iter().filter_map(|edge| Arc::new(edge, &normals)) {
                let kept = boxes.trimmed(&arc);
                for normal in (0..=20).map(|k| arc.part(arc.angle * f64::from(k) / 20.0, arc.angle).ends[0]) {
                    let inside = kept.as_ref().is_some_and(|kept| {
                        let [low, high] = kept.ends.map(|end| end.cross(&normal).dot(&arc.edge));
                        low > -1e-9 && high < 1e-9
                    });
                    let frame = any_frame(&normal);
                    let seen: Vec<[f64; 2]> =
                        points.iter().map(|p| [frame.column(1).dot(p), frame.column(2).dot(p)]).collect();
                    let least = rectangle::smallest(&seen, 1e-9).unwrap().area * boxes.width(&normal);
                    prop_assert!(inside || least > boxes.wanted() * (1.0 - 1e-9), "{least} {}", boxes.wanted());
                }
            }
        }
    }
}

//! What `check` found, for the page: events at keys, and of collisions the triangles that touch and the lines along which they cut.

use super::Models;
use super::data::{Contact, EventData, FaultData};
use super::motion::Motion;
use super::pack::Packed;
use crate::check::{Event, Kind, Outcome, Path};
use crate::geometry::{Isometry, Point, Triangle};
use crate::method::Model;
use crate::scene::{Pair, Scene};
use rayon::prelude::*;
use rs274::{Axis, Sample};

/// Poses of a collision at which its triangles are found, the first contact among them.
const POSES: usize = 16;
/// Most collisions whose triangles are found: a program that collides more often shows where, but not with which.
const MOST_COLLISIONS: usize = 256;
/// Most pairs of triangles that are kept of a pose, evenly out of all.
const MOST_TRIANGLES: usize = 500;

/// Every event.
pub(super) fn all(scene: &Scene, path: &Path, motion: &Motion, outcome: &Outcome, models: &Models) -> Vec<EventData> {
    let collisions = outcome.events.iter().filter(|event| event.kind.is_collision()).take(MOST_COLLISIONS);
    let mut contacts: Vec<Vec<Contact>> = collisions
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|event| touching(scene, path, motion, event, models))
        .collect();
    contacts.reverse();
    outcome.events.iter().map(|event| of(event, motion, &mut contacts)).collect()
}

/// What is of no pair: each line on which an axis is beyond its limits, and each time that a tool without a part is in the spindle.
pub(super) fn faults(scene: &Scene, path: &Path, motion: &Motion, outcome: &Outcome) -> Vec<FaultData> {
    let fault = |kind, [first, last]: [usize; 2], text: String| FaultData {
        kind,
        line: path.line_at(first as f64),
        first: motion.key_at(first as f64),
        last: motion.key_at(last as f64),
        text,
    };
    let over = outcome.over_travel.iter().map(|over| {
        let axis = Axis::from_letter(over.cause.axis);
        let is_beyond = |sample: &&Sample| {
            sample.line == over.line
                && axis.is_some_and(|axis| scene.machine.check_axis(axis, &sample.position).is_err())
        };
        let behind = path.samples().iter().skip(over.place).take_while(is_beyond).count();
        fault("over-travel", [over.place, over.place + behind], over.cause.to_string())
    });
    let tools = without_parts(path, &outcome.tools_without_parts).into_iter().map(|(tool, places)| {
        let text = match tool {
            0 => "the program feeds with no tool in the spindle".to_owned(),
            tool => format!("tool {tool} has no part in the scene, or only a holder"),
        };
        fault("tool-without-part", places, text)
    });
    over.chain(tools).collect()
}

/// First and last place of each time that one of these tools is in the spindle; without a tool, from the first feed on.
fn without_parts(path: &Path, tools: &[u32]) -> Vec<(u32, [usize; 2])> {
    let (mut found, mut begin) = (Vec::new(), 1);
    while begin <= path.samples().len() {
        let tool = path.tool(begin);
        let end = begin + (begin..=path.samples().len()).take_while(|&place| path.tool(place) == tool).count();
        let first = (begin..end).find(|&place| tool != 0 || path.step(place as f64).kind.is_feed());
        found.extend(first.filter(|_| tools.contains(&tool)).map(|first| (tool, [first, end - 1])));
        begin = end;
    }
    found
}

/// `contacts` holds those of the collisions that are still to come, the next one last.
fn of(event: &Event, motion: &Motion, contacts: &mut Vec<Vec<Contact>>) -> EventData {
    EventData {
        kind: event.kind.name(),
        zone_mm: if let Kind::Near { zone_mm } = event.kind { Some(zone_mm) } else { None },
        pair: [event.pair.a, event.pair.b],
        first: motion.key_at(event.first.place),
        last: motion.key_at(event.last.place),
        nearest: motion.key_at(event.nearest.place),
        line: event.first.line,
        last_line: event.last.line,
        time_s: event.first.time_s,
        least_mm: event.least_mm,
        inside: event.inside,
        to_the_end: event.to_the_end,
        contacts: if event.kind.is_collision() { contacts.pop().unwrap_or_default() } else { Vec::new() },
    }
}

/// The triangles that touch, from first contact to last.
fn touching(scene: &Scene, path: &Path, motion: &Motion, event: &Event, models: &Models) -> Vec<Contact> {
    let (first, last) = (event.first.place, event.last.place);
    let poses = if last > first { POSES } else { 1 };
    let place = |pose: usize| first + (last - first) * pose as f64 / (poses.max(2) - 1) as f64;
    let contact = |place: f64| {
        let poses = scene.machine.forward(&path.position_at(place));
        let a_from_b = scene.a_from_b(event.pair, &poses);
        Some(at_pose(scene, event.pair, models.of(event.pair)?, &a_from_b, motion.key_at(place)))
    };
    (0..poses).filter_map(|pose| contact(place(pose))).collect()
}

fn at_pose(scene: &Scene, pair: Pair, [a, b]: [&dyn Model; 2], a_from_b: &Isometry, key: f64) -> Contact {
    let (faces, _) = a.all_counted(b, a_from_b);
    let stride = faces.len().div_ceil(MOST_TRIANGLES).max(1);
    let shown: Vec<(u32, u32)> = faces.iter().step_by(stride).copied().collect();
    let [in_a, in_b] = [pair.a, pair.b].map(|part| &scene.parts[part].mesh);
    let corners = |mesh: &crate::geometry::Mesh, face: u32| {
        let [p, q, r] = mesh.faces()[face as usize].map(|vertex| mesh.vertices()[vertex as usize]);
        Triangle::new(p, q, r)
    };
    let cuts: Vec<[Point; 2]> = shown
        .iter()
        .filter_map(|&(a, b)| cut(&corners(in_a, a), &corners(in_b, b).map(|corner| a_from_b * corner)))
        .collect();
    let middle = |points: Vec<Point>| {
        let count = points.len() as f64;
        points.into_iter().map(|p| p.coords).reduce(|sum, p| sum + p).map(|sum| (sum / count).into())
    };
    let of_cuts = middle(cuts.iter().flatten().copied().collect());
    let distinct = |mut faces: Vec<u32>| {
        faces.sort_unstable();
        faces.dedup();
        Packed::u32(faces)
    };
    Contact {
        key,
        pairs: faces.len(),
        a: distinct(shown.iter().map(|&(a, _)| a).collect()),
        b: distinct(shown.iter().map(|&(_, b)| b).collect()),
        // Triangles in one plane have no line in common, but a patch.
        at: of_cuts.or_else(|| middle(shown.iter().map(|&(a, _)| corners(in_a, a).centroid()).collect())),
        lines: Packed::f32(cuts.iter().flatten().flat_map(|p| [p.x, p.y, p.z])),
    }
}

/// The segment that two triangles share, mm, as far as `f64` can tell; `None` for triangles in one plane, or apart.
fn cut(a: &Triangle, b: &Triangle) -> Option<[Point; 2]> {
    let (normal_a, normal_b) = (a.double_area_normal(), b.double_area_normal());
    let along = normal_a.cross(&normal_b).try_normalize(0.0)?;
    let origin = a.corners[0];
    let of_a = crossing(a, |p| normal_b.dot(&(p - b.corners[0])))?;
    let of_b = crossing(b, |p| normal_a.dot(&(p - origin)))?;
    let sorted = |[p, q]: [Point; 2]| if along.dot(&(q - p)) < 0.0 { [q, p] } else { [p, q] };
    let ([a_from, a_to], [b_from, b_to]) = (sorted(of_a), sorted(of_b));
    let place = |p: &Point| along.dot(&(p - origin));
    let from = if place(&a_from) > place(&b_from) { a_from } else { b_from };
    let to = if place(&a_to) < place(&b_to) { a_to } else { b_to };
    (place(&from) <= place(&to)).then_some([from, to])
}

/// Where a triangle goes through the plane on which `height` is zero.
fn crossing(triangle: &Triangle, height: impl Fn(&Point) -> f64) -> Option<[Point; 2]> {
    let heights = triangle.corners.map(|corner| height(&corner));
    let mut found = Vec::with_capacity(3);
    for i in 0..3 {
        let (p, q) = (triangle.corners[i], triangle.corners[(i + 1) % 3]);
        let (h, k) = (heights[i], heights[(i + 1) % 3]);
        if h == 0.0 {
            found.push(p);
        } else if (h < 0.0 && k > 0.0) || (h > 0.0 && k < 0.0) {
            found.push(p + (q - p) * (h / (h - k)));
        }
    }
    Some([*found.first()?, *found.last()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f64; 3]; 3]) -> Triangle {
        let [p, q, r] = corners.map(Point::from);
        Triangle::new(p, q, r)
    }

    #[test]
    fn two_triangles_cut_along_a_segment() {
        // One in the plane z = 0 with its edge y = 0 from x = 0 to 4; the other upright in y = 1, from x = 1 to 9 at z = -2,
        // with its tip at z = 2 over x = 5. At z = 0 it is half as wide: from x = 3 to 7. At y = 1 the first reaches from 0 to 3.
        let flat = triangle([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
        let upright =
            |shift: f64| triangle([[1.0 - shift, 1.0, -2.0], [9.0 - shift, 1.0, -2.0], [5.0 - shift, 1.0, 2.0]]);
        let mut ends = cut(&flat, &upright(1.0)).unwrap().map(|p| p.x);
        ends.sort_by(f64::total_cmp);
        assert_eq!(ends, [2.0, 3.0]);
        assert_eq!(cut(&flat, &upright(0.0)).unwrap().map(|p| p.x), [3.0, 3.0]);
        assert!(cut(&flat, &upright(-1.0)).is_none());
        assert!(cut(&flat, &flat).is_none());
    }
}

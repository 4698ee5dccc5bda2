//! Classes of poses of a pair; the same for every revision, since all that decides them are verdicts, which are exact.

use crate::pairs::Recorded;
use crate::{Class, Pair, Query, Tree};
use obbtree::cases::Draw;
use obbtree::engine::Simd;
use obbtree::engine::geometry::{GridMesh, Isometry, Point, Vector};
use obbtree::engine::traverse::{Scratch, first};
use obbtree::nalgebra::{Translation3, UnitQuaternion};

/// Poses of a class that is drawn.
const DRAWN: u64 = 192;
/// Poses of a recorded class at most.
const MOST: usize = 512;
/// Poses that are asked for a distance at most, in a class.
const MOST_DISTANCES: usize = 96;
/// Steps of a path.
const STEPS: usize = 192;
/// Paths of a pair.
const PATHS: usize = 6;
/// Lengths of steps, mm.
const STEPS_MM: [f64; 4] = [0.01, 0.05, 0.1, 0.3];

/// All classes of a pair.
pub fn classes(pair: &Pair, trees: (&Tree, &Tree), recorded: &Recorded) -> Vec<Class> {
    if recorded.is_path {
        return paths(&pair.b, recorded);
    }
    let drawn = Drawn { pair, trees };
    if pair.name.starts_with("flat") {
        let poses = if pair.name == "flat-ring:cylinder" { drawn.in_ring() } else { drawn.flat() };
        let above = |mm: f64| poses.iter().map(|pose| Translation3::new(0.0, 0.0, mm) * pose).collect();
        return vec![
            Class { name: "flat".into(), query: Query::First, poses: poses.clone() },
            Class { name: "flat-above".into(), query: Query::First, poses: above(1.5e-8) },
            Class { name: "flat-above-1e-6".into(), query: Query::First, poses: above(1e-6) },
            Class { name: "all".into(), query: Query::All, poses: thinned(&poses, MOST_DISTANCES) },
            Class { name: "distance".into(), query: Query::Distance, poses: thinned(&poses, MOST_DISTANCES) },
        ];
    }
    if pair.name.starts_with("bore") {
        let poses = drawn.coaxial();
        return vec![
            Class { name: "coaxial".into(), query: Query::First, poses: poses.clone() },
            Class { name: "distance".into(), query: Query::Distance, poses: thinned(&poses, MOST_DISTANCES) },
        ];
    }
    let mut classes: Vec<Class> = if recorded.poses.is_empty() {
        let [apart, near] = [drawn.before_contact(5.0, 80.0), drawn.before_contact(0.01, 1.0)];
        vec![("far", apart), ("near", near)]
            .into_iter()
            .map(|(name, poses)| Class { name: name.into(), query: Query::First, poses })
            .collect()
    } else {
        let of = |stratum: u8| {
            let poses: Vec<Isometry> =
                recorded.poses.iter().zip(&recorded.strata).filter(|(_, s)| **s == stratum).map(|(p, _)| *p).collect();
            thinned(&poses, MOST)
        };
        (0..4)
            .zip(["colliding", "near", "medium", "far"])
            .map(|(stratum, name)| Class { name: name.into(), query: Query::First, poses: of(stratum) })
            .collect()
    };
    let shallow = drawn.from(&near_poses(recorded), 0.1, 1.0);
    let deep = drawn.from(&near_poses(recorded), 1.0, 10.0);
    let mut distance: Vec<Isometry> = classes.iter().flat_map(|class| thinned(&class.poses, 40)).collect();
    distance = thinned(&distance, MOST_DISTANCES);
    let all = [thinned(&shallow, MOST_DISTANCES / 2), thinned(&deep, MOST_DISTANCES / 2)].concat();
    classes.push(Class { name: "shallow".into(), query: Query::First, poses: shallow });
    classes.push(Class { name: "deep".into(), query: Query::First, poses: deep });
    classes.push(Class { name: "all".into(), query: Query::All, poses: all });
    classes.push(Class { name: "distance".into(), query: Query::Distance, poses: distance });
    classes.retain(|class| !class.poses.is_empty());
    classes
}

/// At most so many of them, at equal strides.
fn thinned(poses: &[Isometry], most: usize) -> Vec<Isometry> {
    poses.iter().step_by(poses.len().div_ceil(most).max(1)).copied().collect()
}

fn near_poses(recorded: &Recorded) -> Vec<Isometry> {
    let near = recorded.poses.iter().zip(&recorded.strata).filter(|(_, stratum)| matches!(stratum, 1 | 2));
    near.map(|(pose, _)| *pose).collect()
}

/// Steps of each length along the programs of a path, fresh and coherent.
fn paths(b: &GridMesh, recorded: &Recorded) -> Vec<Class> {
    let stride = recorded.starts.len().div_ceil(PATHS).max(1);
    let mut classes = Vec::new();
    for step_mm in STEPS_MM {
        let mut poses = Vec::new();
        for &start in recorded.starts.iter().step_by(stride) {
            let (from, to) = (&recorded.poses[start], &recorded.poses[start + 1]);
            let moved_mm = b.vertices().iter().map(|p| (to * p - from * p).norm()).fold(0.0, f64::max);
            if moved_mm <= 0.0 {
                continue;
            }
            poses.extend((0..STEPS).map(|k| along(from, to, k as f64 * step_mm / moved_mm)));
        }
        for (name, query) in [("fresh", Query::PathFresh), ("kept", Query::Path)] {
            classes.push(Class { name: format!("path-{step_mm}-{name}"), query, poses: poses.clone() });
        }
    }
    classes
}

/// The pose that many times the motion from one to another away.
fn along(from: &Isometry, to: &Isometry, times: f64) -> Isometry {
    let way = (to.translation.vector - from.translation.vector) * times;
    let turn = (to.rotation * from.rotation.inverse()).scaled_axis() * times;
    Isometry::from_parts(
        Translation3::from(from.translation.vector + way),
        UnitQuaternion::new_normalize((UnitQuaternion::from_scaled_axis(turn) * from.rotation).into_inner()),
    )
}

struct Drawn<'a> {
    pair: &'a Pair,
    trees: (&'a Tree, &'a Tree),
}

impl Drawn<'_> {
    fn touching(&self, pose: &Isometry) -> bool {
        first(self.trees.0, self.trees.1, pose, Simd::in_use(), &mut Scratch::default())
    }

    fn draw(&self, label: &str, index: u64) -> Draw {
        Draw::new(0, &["engine bench", &self.pair.name, label], index)
    }

    fn size_mm(&self) -> f64 {
        let size = |mesh: &GridMesh| mesh.vertices().iter().map(|p| p.coords.norm()).fold(0.0, f64::max);
        size(&self.pair.a) + size(&self.pair.b)
    }

    /// How far a pose can be moved along a direction, mm, before it touches; looked for in steps of 2 mm.
    fn free_mm(&self, pose: &Isometry, way: &Vector) -> Option<f64> {
        let at = |mm: f64| Translation3::from(way * mm) * pose;
        let most = (self.size_mm() * 1.5) as u32 / 2;
        let touching = (0..most).map(|i| 2.0 * f64::from(i)).find(|&mm| self.touching(&at(mm)))?;
        let (mut free, mut touching) = (touching - 2.0, touching);
        if free < 0.0 {
            return None;
        }
        for _ in 0..30 {
            let middle = f64::midpoint(free, touching);
            if self.touching(&at(middle)) { touching = middle } else { free = middle }
        }
        Some(free)
    }

    /// Poses that are free and from where a way leads into contact: moved on by a draw of `by` of the way that is free.
    fn approached(&self, label: &str, starts: &[Isometry], by: impl Fn(&mut Draw) -> f64) -> Vec<Isometry> {
        let (a, size) = (self.pair.a.vertices(), self.size_mm());
        let mut poses = Vec::new();
        for index in 0..4 * DRAWN {
            if poses.len() as u64 == DRAWN {
                break;
            }
            let mut draw = self.draw(label, index);
            let pick = |draw: &mut Draw, of: usize| (draw.unit() * of as f64) as usize;
            let start = if starts.is_empty() {
                Isometry::from_parts((draw.direction().into_inner() * size).into(), draw.rotation())
            } else {
                starts[pick(&mut draw, starts.len())]
            };
            let target = a[pick(&mut draw, a.len())];
            let b = self.pair.b.vertices();
            let from: Point = start * b[pick(&mut draw, b.len())];
            let way = (target - from).normalize();
            let Some(free) = self.free_mm(&start, &way) else { continue };
            let moved = Translation3::from(way * (free + by(&mut draw))) * start;
            poses.push(moved);
        }
        poses
    }

    /// Poses before contact by that much, mm.
    fn before_contact(&self, low: f64, high: f64) -> Vec<Isometry> {
        self.approached("before", &[], |draw| -draw.log_uniform(low, high))
    }

    /// Poses past contact by that much, mm, from near poses.
    fn from(&self, starts: &[Isometry], low: f64, high: f64) -> Vec<Isometry> {
        let mut poses = self.approached("past", starts, |draw| draw.log_uniform(low, high));
        poses.retain(|pose| self.touching(pose));
        poses
    }

    /// The faces in the planes z = 0 touch flat, or lie side by side: shifted and turned in the plane, half of them along the axes.
    fn flat(&self) -> Vec<Isometry> {
        let size = 0.5 * self.size_mm();
        let pose = |index: u64| {
            let mut draw = self.draw("flat", index);
            let angle = if index.is_multiple_of(2) { 0.0 } else { 3.0 * draw.signed_unit() };
            let shift = Vector::new(draw.signed_unit(), draw.signed_unit(), 0.0) * size;
            let shift = if index % 4 < 2 { shift } else { shift * 0.2 };
            Isometry::new(shift, Vector::z() * angle)
        };
        (0..DRAWN).map(pose).collect()
    }

    /// The ends of a cylinder in a ring in one plane, nearly coaxial: flat beside one another, mostly apart.
    fn in_ring(&self) -> Vec<Isometry> {
        let pose = |index: u64| {
            let mut draw = self.draw("in ring", index);
            let shift = draw.in_ball() * 1.1;
            Isometry::new(Vector::new(shift.x, shift.y, 0.0), Vector::z() * draw.signed_unit())
        };
        (0..DRAWN).map(pose).collect()
    }

    /// A shaft in a bore, off the middle by less than the gap and slightly askew; mostly free.
    fn coaxial(&self) -> Vec<Isometry> {
        let pose = |index: u64| {
            let mut draw = self.draw("coaxial", index);
            let shift = draw.in_ball() * draw.log_uniform(1e-3, 0.45);
            let tilt = draw.in_ball() * draw.log_uniform(1e-5, 2e-3);
            let spin = UnitQuaternion::from_scaled_axis(Vector::z() * draw.signed_unit());
            let turn = UnitQuaternion::from_scaled_axis(Vector::new(tilt.x, tilt.y, 0.0)) * spin;
            Isometry::from_parts(Vector::new(shift.x, shift.y, shift.z * 10.0).into(), turn)
        };
        (0..DRAWN).map(pose).collect()
    }
}

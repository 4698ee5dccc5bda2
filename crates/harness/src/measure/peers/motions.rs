//! What is asked in mode `motion`: motions of one part past another, thin walls that a part crosses between two free poses, and the truth about them.
//!
//! Truth is conservative advancement with the exact oracle: up to a time nothing touches, since the oracle's distance exceeds the farthest way of any point; at a later time the
//! surfaces share a point, exactly. First contact is between the two.

use super::posed::{PosedMeshes, Question};
use crate::geometry::{Isometry, Mesh, Point, Vector, grid};
use crate::measure::judged::JudgedPair;
use crate::method::motion::{Motion, reach_mm};
use crate::record::{Band, Stratum};
use crate::scene::{Pair, Scene};
use crate::truth::PairOracle;
use nalgebra::{Translation3, UnitQuaternion};
use obbtree::cases::meshes::cuboid;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::sync::Arc;

/// Name of the planted scene.
pub const THIN_WALLS: &str = "thin-walls";
/// Thicknesses of its walls and blades, mm.
const THICK_MM: [f64; 6] = [0.3, 0.1, 0.03, 0.01, 0.003, 0.001];

/// Motions of a chunk.
const CHUNK: usize = 8;
/// Longest way of the part's middle, mm.
const MOST_WAY_MM: f64 = 100.0;
/// Largest turn, degrees.
const MOST_TURN_DEG: f64 = 20.0;
/// Pairs of vertices of which the nearest gives the direction of a motion.
const AIMS: usize = 8;

/// Motions that come this near without contact do not count, as met by the truth's samples, mm: between them the surfaces may be half as far apart.
const NEAR_MM: f64 = 2e-3;
/// A contact counts when it is known to this travel, mm.
const CONTACT_KNOWN_MM: f64 = 1e-3;
/// And when it is still there after this much more travel, mm.
const DEEPER_MM: f64 = 1e-4;
/// Most steps towards the truth of a motion.
const MOST_STEPS: u32 = 20_000;

/// The motions of a scene, `count` of them, from poses without contact of all its pairs.
pub fn of_scene(scene: &Scene, judged: &[JudgedPair], count: usize, seed: u64) -> Vec<PosedMeshes> {
    let mut pairs: Vec<(Pair, Vec<Isometry>)> = Vec::new();
    for of_pair in judged {
        let free = of_pair.poses.iter().filter(|pose| !pose.touches() && !pose.contained).map(|pose| pose.a_from_b);
        match pairs.iter_mut().find(|(pair, _)| *pair == of_pair.pair) {
            Some((_, starts)) => starts.extend(free),
            None => pairs.push((of_pair.pair, free.collect())),
        }
    }
    pairs.retain(|(_, starts)| !starts.is_empty());
    let share = count.div_ceil(pairs.len().max(1));
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let of_pair = |(pair, starts): (Pair, Vec<Isometry>)| {
        let a = Arc::clone(&scene.parts[pair.a].mesh);
        let (b, middle) = centred(&scene.parts[pair.b].mesh);
        let mut motion = || {
            let start = starts[random.random_range(0..starts.len())] * Translation3::from(middle);
            aimed(&a, &b, start, &mut random)
        };
        let motions: Vec<Motion> = (0..share).map(|_| motion()).collect();
        judged_motions(scene.pair_name(pair), a, Arc::new(b), &motions)
    };
    pairs.into_iter().map(of_pair).collect()
}

/// Blades that cross walls of the same thickness, or stop short of them; `count` for all thicknesses together.
pub fn thin_walls(count: usize, seed: u64) -> Vec<PosedMeshes> {
    let of_thickness = |thick_mm: f64| {
        let (wall, blade) = (cuboid(60.0, 60.0, thick_mm), cuboid(22.0, 20.0, thick_mm));
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let share = count.div_ceil(THICK_MM.len());
        let motions: Vec<Motion> = (0..share).map(|index| planted(index, thick_mm, &mut random)).collect();
        judged_motions(format!("wall-{thick_mm}:blade"), Arc::new(wall), Arc::new(blade), &motions)
    };
    THICK_MM.into_iter().map(of_thickness).collect()
}

/// The mesh about the middle of its box, and where that was. Vertices stay on the grid.
fn centred(mesh: &Mesh) -> (Mesh, Vector) {
    let first = mesh.vertices()[0];
    let (low, high) = mesh.vertices().iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
    let middle = grid::snap(&nalgebra::center(&low, &high)).coords;
    let vertices = mesh.vertices().iter().map(|p| p - middle).collect();
    (Mesh::new(vertices, mesh.faces().to_vec()).expect("a mesh stays one where it is moved"), middle)
}

fn any_vertex(mesh: &Mesh, random: &mut Pcg64Mcg) -> Point {
    mesh.vertices()[random.random_range(0..mesh.vertices().len())]
}

/// A rotation by up to so many degrees about any axis.
fn any_turn(most_deg: f64, random: &mut Pcg64Mcg) -> Vector {
    let axis = Vector::from_fn(|_, _| random.random_range(-1.0..1.0));
    axis.normalize() * random.random_range(0.0..most_deg).to_radians()
}

/// A motion towards the other part, that ends before it or goes beyond its surface; every other one turns.
fn aimed(a: &Mesh, b: &Mesh, start: Isometry, random: &mut Pcg64Mcg) -> Motion {
    let aims = (0..AIMS).map(|_| any_vertex(a, random) - start * any_vertex(b, random));
    let aim = aims.min_by(|x, y| x.norm().total_cmp(&y.norm())).unwrap_or_else(Vector::x);
    let way = aim * random.random_range(0.3..1.7);
    let way = way * (MOST_WAY_MM / way.norm().max(MOST_WAY_MM));
    let turn = if random.random::<f64>() < 0.5 { any_turn(MOST_TURN_DEG, random) } else { Vector::zeros() };
    Motion { start, way, turn }
}

/// Of four motions one goes straight and flat through the wall, one straight and tilted, one turns on its way, and one stops 0.01 to 1 mm before it.
fn planted(index: usize, thick_mm: f64, random: &mut Pcg64Mcg) -> Motion {
    let [x, y] = [0; 2].map(|_| random.random_range(-15.0..15.0));
    let [above, below] = [0; 2].map(|_| random.random_range(10.0..40.0));
    let tilt = any_turn(MOST_TURN_DEG, random);
    let gap_mm = thick_mm + 10f64.powf(random.random_range(-2.0..0.0));
    let (tilt, turn, end) = match index % 4 {
        0 => (Vector::zeros(), Vector::zeros(), -below),
        1 => (tilt, Vector::zeros(), -below),
        2 => (tilt, any_turn(MOST_TURN_DEG, random), -below),
        _ => (Vector::zeros(), Vector::zeros(), gap_mm),
    };
    let start = Isometry::from_parts(Translation3::new(x, y, above), UnitQuaternion::from_scaled_axis(tilt));
    Motion { start, way: Vector::z() * (end - above), turn }
}

/// The exact truth about a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Truth {
    /// The surfaces share no point before the first of these times, and share one at the second; `None` where they never do.
    contact: Option<[f64; 2]>,
    /// Least distance at the times that were looked at, mm.
    least_mm: f64,
    /// Whether it comes so near to touching that contact and no contact both count as right.
    is_grazing: bool,
}

fn truth(oracle: &PairOracle, motion: &Motion, reach_mm: f64) -> Truth {
    let speed_mm = motion.speed_mm(reach_mm);
    let (mut time, mut free_to, mut least_mm, mut is_sure) = (0.0, 0.0, f64::INFINITY, true);
    let mut nudge_mm = Band::GRAZING_MM;
    for _ in 0..MOST_STEPS {
        let apart_mm = oracle.clearance_mm(&motion.at(time), speed_mm * (1.0 - time) + Stratum::BORDERS_MM[1]);
        if apart_mm == 0.0 {
            let deeper = time + DEEPER_MM / speed_mm;
            let is_known = (time - free_to) * speed_mm <= CONTACT_KNOWN_MM;
            let is_deep = deeper <= 1.0 && oracle.touches(&motion.at(deeper));
            return Truth { contact: Some([free_to, time]), least_mm: 0.0, is_grazing: !is_known || !is_deep };
        }
        least_mm = least_mm.min(apart_mm);
        if time == 1.0 {
            return Truth { contact: None, least_mm, is_grazing: !is_sure || least_mm < NEAR_MM };
        }
        let step_mm = if apart_mm > Band::GRAZING_MM {
            nudge_mm = Band::GRAZING_MM;
            apart_mm - 0.5 * Band::GRAZING_MM
        } else {
            // Too near to prove anything: a little farther there is contact, or distance again.
            is_sure = false;
            nudge_mm *= 2.0;
            nudge_mm
        };
        time = (time + step_mm / speed_mm).min(1.0);
        if is_sure {
            free_to = time;
        }
    }
    Truth { contact: None, least_mm, is_grazing: true }
}

/// The motions with their truth, those of a stratum together.
fn judged_motions(pair: String, a: Arc<Mesh>, b: Arc<Mesh>, motions: &[Motion]) -> PosedMeshes {
    let oracle = PairOracle::new(Arc::clone(&a), Arc::clone(&b));
    let reach_mm = reach_mm(&b);
    let question = |(number, motion): (usize, &Motion)| {
        let truth = truth(&oracle, motion, reach_mm);
        Question {
            a_from_b: motion.start,
            end: Some(motion.at(1.0)),
            line: number as u32,
            exact: truth.contact.is_some(),
            grazing: truth.is_grazing,
            stratum: Stratum::of(truth.contact.is_some(), truth.least_mm),
            value: truth.contact.map(|[free_to, touching]| f64::midpoint(free_to, touching)),
        }
    };
    let mut questions: Vec<Question> = motions.par_iter().enumerate().map(question).collect();
    questions.sort_by_key(|question| question.stratum as u8);
    let mut posed = PosedMeshes { pair, a, b, questions: Vec::new(), chunks: Vec::new() };
    for of_stratum in questions.chunk_by(|one, other| one.stratum == other.stratum) {
        of_stratum.chunks(CHUNK).for_each(|chunk| posed.add(chunk.to_vec()));
    }
    posed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thin_walls_are_crossed_where_they_should_be() {
        for posed in thin_walls(96, 5) {
            assert_eq!(posed.questions.len(), 16);
            let crossing: Vec<&Question> = posed.questions.iter().filter(|question| question.exact).collect();
            assert_eq!(crossing.len(), 12, "{}", posed.pair);
            let oracle = PairOracle::new(Arc::clone(&posed.a), Arc::clone(&posed.b));
            for question in &posed.questions {
                let end = question.end.unwrap();
                assert!(!oracle.touches(&question.a_from_b) && !oracle.touches(&end) && !question.grazing);
                let value = question.value.unwrap_or(0.0);
                assert_eq!(question.exact, value > 0.0);
                let is_flat = question.a_from_b.rotation == end.rotation && question.a_from_b.rotation.angle() == 0.0;
                if question.exact && is_flat {
                    // The lower side of the blade meets the upper side of the wall.
                    let (above, way) =
                        (question.a_from_b.translation.z, question.a_from_b.translation.z - end.translation.z);
                    let thick: f64 = posed.pair["wall-".len()..posed.pair.find(':').unwrap()].parse().unwrap();
                    assert!((value - (above - thick) / way).abs() < 1e-7, "{} {value}", posed.pair);
                }
            }
        }
    }

    #[test]
    fn what_only_grazes_does_not_count() {
        let (a, b) = (Arc::new(cuboid(20.0, 20.0, 2.0)), Arc::new(cuboid(4.0, 4.0, 2.0)));
        let oracle = PairOracle::new(Arc::clone(&a), Arc::clone(&b));
        let along = |z: f64| Motion {
            start: Isometry::translation(-20.0, 0.0, z),
            way: Vector::x() * 40.0,
            turn: Vector::zeros(),
        };
        // Faces on the grid that slide on each other share points, exactly, and for longer than a contact must last.
        for (z, touches, is_grazing) in
            [(2.5, false, false), (2.0005, false, true), (2.0, true, false), (1.9, true, false)]
        {
            let found = truth(&oracle, &along(z), reach_mm(&b));
            assert_eq!((found.contact.is_some(), found.is_grazing), (touches, is_grazing), "{z}: {found:?}");
        }
    }
}

//! What is asked of the engines: two meshes, poses in chunks, and the truth about them; and the same as a folder of arrays.
//!
//! | file | type, shape | content |
//! |---|---|---|
//! | `a_vertices.npy`, `b_vertices.npy` | f8 (n, 3) | mm, in the part's own frame |
//! | `a_faces.npy`, `b_faces.npy` | u4 (n, 3) | indices of vertices |
//! | `poses.npy` | f8 (n, 3, 4) | part `b` in the frame of part `a`, rotation and translation (mm), row by row |
//! | `ends.npy` | f8 (n, 3, 4) | mode `motion` only: the poses at which the motions from `poses.npy` end |
//! | `chunks.npy` | u4 (n, 2) | first pose of a chunk, and the one after its last |
//! | `exact.npy` | u1 (n) | 1 when the surfaces touch |
//! | `grazing.npy` | u1 (n) | 1 when they are within 1e-6 mm of first contact: either answer is right |
//! | `stratum.npy` | u1 (n) | 0 colliding, 1 near miss, 2 medium, 3 far |
//! | `truth.npy` | f8 (n) | modes `all`, `distance` and `motion` only: touching pairs of triangles; mm; time of first contact, infinite without |

use super::{Mode, PeersError, Step, motions, npy};
use crate::analysis::distinct;
use crate::geometry::{Isometry, Mesh, Point, rigid};
use crate::measure::chunk::{self, Chunk, Participants};
use crate::measure::judged::{self, JudgedPair, JudgedPose};
use crate::measure::{Plan, Progress};
use crate::method::motion::Motion;
use crate::record::{Band, Stratum};
use crate::scene::{Pair, Scene};
use crate::truth::{PairOracle, Sought, TruthCache, judge_all};
use crate::workload::Source;
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// How many times more poses are generated than asked about, so that every stratum fills its share.
const POSE_RESERVE: usize = 4;

/// Steps of a chunk of mode `path`.
const PATH_STEPS: usize = 64;

/// A pose and the truth about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// Part `b` in the frame of part `a`.
    pub a_from_b: Isometry,
    /// Where a motion from there ends, in mode `motion`; the rest is then said of the motion.
    pub end: Option<Isometry>,
    /// The line that the pose lies on, numbered within the pair; in mode `path` that of the chunk's first pose, in mode `motion` each motion is one.
    pub line: u32,
    /// Whether the surfaces touch, exactly.
    pub exact: bool,
    /// Whether they are within [`Band::GRAZING_MM`] of first contact; in mode `motion` whether the motion comes near contact without a sure one.
    pub grazing: bool,
    /// Distance stratum.
    pub stratum: Stratum,
    /// The true answer in modes `all` (touching pairs of triangles), `distance` (mm) and `motion` (time of first contact, `None` without).
    pub value: Option<f64>,
}

/// All questions about a pair of parts.
#[derive(Clone, Debug, PartialEq)]
pub struct PosedMeshes {
    /// Name of the pair, `a:b`.
    pub pair: String,
    /// The mesh in whose frame poses are given.
    pub a: Arc<Mesh>,
    /// The mesh that poses move.
    pub b: Arc<Mesh>,
    /// The poses.
    pub questions: Vec<Question>,
    /// Which consecutive poses are asked about together.
    pub chunks: Vec<Range<usize>>,
}

/// The questions of a scene, about `poses` of them: equal shares for the strata, as in every other measurement.
///
/// # Errors
/// When poses cannot be made or judged, or there are none for the mode.
pub fn questions(
    plan: &Plan,
    scene: &Scene,
    mode: Mode,
    poses: usize,
    cache: Option<&TruthCache>,
    progress: &dyn Progress,
) -> Result<Vec<PosedMeshes>, PeersError> {
    let judged = judged::judge(plan, scene, poses * POSE_RESERVE, judged::Strata::Sought, cache, progress)?;
    if mode == Mode::Motion {
        let found = motions::of_scene(scene, &judged, poses, plan.selection.seed);
        return if found.is_empty() { Err(PeersError::NoPoses { scene: scene.name.clone(), mode }) } else { Ok(found) };
    }
    let usable: Vec<JudgedPair> = judged
        .into_iter()
        .filter(|pair| !matches!(mode, Mode::Path(_)) || pair.workload == Source::Program.name())
        .collect();
    let chunks: Vec<Chunk> = chunk::select_windows(&usable, poses, chunk::LONG)
        .into_iter()
        .filter(|chunk| chunk.participants != Participants::Control)
        .collect();
    let pairs = distinct(usable.iter().map(|pair| pair.pair)).into_iter();
    let found: Vec<PosedMeshes> = pairs
        .map(|pair| of_pair(scene, pair, &usable, &chunks, mode))
        .filter(|posed| !posed.chunks.is_empty())
        .collect();
    if found.is_empty() {
        return Err(PeersError::NoPoses { scene: scene.name.clone(), mode });
    }
    Ok(found)
}

/// What is asked of one pair.
fn of_pair(scene: &Scene, pair: Pair, usable: &[JudgedPair], chunks: &[Chunk], mode: Mode) -> PosedMeshes {
    let mut posed = PosedMeshes {
        pair: scene.pair_name(pair),
        a: Arc::clone(&scene.parts[pair.a].mesh),
        b: Arc::clone(&scene.parts[pair.b].mesh),
        questions: Vec::new(),
        chunks: Vec::new(),
    };
    let oracle = PairOracle::new(Arc::clone(&posed.a), Arc::clone(&posed.b));
    // Workloads number their lines each from 0.
    let mut lines: BTreeMap<(usize, u32), u32> = BTreeMap::new();
    for chunk in chunks.iter().filter(|chunk| usable[chunk.pair].pair == pair) {
        let all = &usable[chunk.pair].poses;
        let mut asked: Vec<Question> = match mode {
            Mode::Path(step) => fine_steps(&oracle, all, chunk, step),
            _ => chunk.poses.par_iter().map(|&index| question(&oracle, &all[index], mode)).collect(),
        };
        for question in &mut asked {
            let next = lines.len() as u32;
            question.line = *lines.entry((chunk.pair, question.line)).or_insert(next);
        }
        posed.add(asked);
    }
    if mode == Mode::Batch {
        posed.one_chunk_a_stratum();
    }
    posed
}

fn question(oracle: &PairOracle, pose: &JudgedPose, mode: Mode) -> Question {
    let grazing = match pose.stratum {
        Stratum::Colliding => pose.band == Band::Grazing,
        Stratum::NearMiss => oracle.clearance_mm(&pose.a_from_b, Band::GRAZING_MM).is_finite(),
        Stratum::Medium | Stratum::Far => false,
    };
    let value = match mode {
        Mode::All => Some(oracle.touching_pairs(&pose.a_from_b) as f64),
        Mode::Distance => Some(oracle.clearance_mm(&pose.a_from_b, f64::INFINITY)),
        Mode::First | Mode::Path(_) | Mode::Batch | Mode::Motion => None,
    };
    let (a_from_b, stratum) = (pose.a_from_b, pose.stratum);
    Question { a_from_b, end: None, line: pose.line, exact: pose.touches(), grazing, stratum, value }
}

/// Fine steps along the path, from a chunk's first pose.
fn fine_steps(oracle: &PairOracle, path: &[JudgedPose], chunk: &Chunk, step: Step) -> Vec<Question> {
    let line = path[chunk.poses[0]].line;
    let path: Vec<Isometry> = path[chunk.poses[0]..].iter().map(|pose| pose.a_from_b).collect();
    let poses = stepped(&path, oracle.mesh_b().vertices(), step.mm());
    let judgements = judge_all(oracle, &poses, &Sought::Borders(&Stratum::BORDERS_MM), &|_| {});
    let judged = poses.into_iter().zip(judgements).map(|(a_from_b, judgement)| {
        let exact = judgement.verdict.touches();
        let stratum = Stratum::of(exact, judgement.clearance_mm);
        // How deep a step is nobody has found; grazing ones are known from the free side only.
        let grazing = stratum == Stratum::NearMiss && oracle.clearance_mm(&a_from_b, Band::GRAZING_MM).is_finite();
        Question { a_from_b, end: None, line, exact, grazing, stratum, value: None }
    });
    judged.collect()
}

/// [`PATH_STEPS`] poses along a path, from one to the next of which the vertex that moves farthest moves by `step_mm`, measured along chords
/// between the path's poses: where it turns, by up to a hundredth more. The last pose of the path is
/// repeated when there is no way left.
fn stepped(path: &[Isometry], vertices: &[Point], step_mm: f64) -> Vec<Isometry> {
    let mut poses = Vec::with_capacity(PATH_STEPS);
    // Where the next pose is, from the begin of the leg between two poses of the path.
    let mut next_mm = 0.0;
    for leg in path.windows(2) {
        let [from, to] = [&leg[0], &leg[1]];
        let leg_mm = vertices.iter().map(|p| (to * p - from * p).norm()).fold(0.0, f64::max);
        while next_mm < leg_mm && poses.len() < PATH_STEPS {
            poses.push(from.lerp_slerp(to, next_mm / leg_mm));
            next_mm += step_mm;
        }
        if poses.len() == PATH_STEPS {
            return poses;
        }
        next_mm -= leg_mm;
    }
    let last = path[path.len() - 1];
    poses.resize(PATH_STEPS, last);
    poses
}

impl PosedMeshes {
    /// Puts the poses of a stratum side by side, in one chunk: many at once are asked about.
    fn one_chunk_a_stratum(&mut self) {
        self.questions.sort_by_key(|question| question.stratum as u8);
        let mut start = 0;
        self.chunks.clear();
        for questions in self.questions.chunk_by(|one, other| one.stratum == other.stratum) {
            self.chunks.push(start..start + questions.len());
            start += questions.len();
        }
    }

    pub(super) fn add(&mut self, chunk: Vec<Question>) {
        let start = self.questions.len();
        self.questions.extend(chunk);
        self.chunks.push(start..self.questions.len());
    }

    /// Writes the arrays to a folder.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), PeersError> {
        for (side, mesh) in [("a", &self.a), ("b", &self.b)] {
            let vertices: Vec<f64> = mesh.vertices().iter().flat_map(|p| <[f64; 3]>::from(p.coords)).collect();
            npy::write(&folder.join(format!("{side}_vertices.npy")), &[mesh.vertices().len(), 3], &vertices)?;
            npy::write(
                &folder.join(format!("{side}_faces.npy")),
                &[mesh.faces().len(), 3],
                mesh.faces().as_flattened(),
            )?;
        }
        let count = self.questions.len();
        let poses: Vec<f64> = self.questions.iter().flat_map(|question| to_matrix(&question.a_from_b)).collect();
        npy::write(&folder.join("poses.npy"), &[count, 3, 4], &poses)?;
        let ends: Vec<Isometry> = self.questions.iter().filter_map(|question| question.end).collect();
        if !ends.is_empty() {
            let ends: Vec<f64> = ends.iter().flat_map(to_matrix).collect();
            npy::write(&folder.join("ends.npy"), &[ends.len() / 12, 3, 4], &ends)?;
        }
        let chunks: Vec<u32> = self.chunks.iter().flat_map(|chunk| [chunk.start as u32, chunk.end as u32]).collect();
        npy::write(&folder.join("chunks.npy"), &[self.chunks.len(), 2], &chunks)?;
        let flags = |name: &str, flag: &dyn Fn(&Question) -> u8| {
            npy::write(&folder.join(name), &[count], &self.questions.iter().map(flag).collect::<Vec<u8>>())
        };
        flags("exact.npy", &|question| u8::from(question.exact))?;
        flags("grazing.npy", &|question| u8::from(question.grazing))?;
        flags("stratum.npy", &|question| question.stratum as u8)?;
        let never = |question: &Question| question.end.map(|_| f64::INFINITY);
        let truth: Vec<f64> =
            self.questions.iter().filter_map(|question| question.value.or_else(|| never(question))).collect();
        if truth.len() == count {
            npy::write(&folder.join("truth.npy"), &[count], &truth)?;
        }
        Ok(())
    }
}

/// Reads the two meshes of a folder.
///
/// # Errors
/// When a file cannot be read or holds no mesh.
pub fn read_meshes(folder: &Path) -> Result<[Mesh; 2], PeersError> {
    let mesh = |side: char| {
        let vertices = npy::read::<f64>(&folder.join(format!("{side}_vertices.npy")), &[3])?;
        let faces = npy::read::<u32>(&folder.join(format!("{side}_faces.npy")), &[3])?;
        let vertices = vertices.as_chunks::<3>().0.iter().map(|&p| Point::from(p)).collect();
        Mesh::new(vertices, faces.as_chunks::<3>().0.to_vec()).map_err(|cause| PeersError::Mesh {
            folder: folder.to_owned(),
            side,
            cause,
        })
    };
    Ok([mesh('a')?, mesh('b')?])
}

/// Reads the poses of a folder.
///
/// # Errors
/// When the file cannot be read.
pub fn read_poses(folder: &Path) -> Result<Vec<Isometry>, PeersError> {
    read_matrices(folder, "poses.npy")
}

/// Reads the motions of a folder, from the poses to their ends.
///
/// # Errors
/// When a file cannot be read, or there are not as many ends as poses.
pub fn read_motions(folder: &Path) -> Result<Vec<Motion>, PeersError> {
    let (starts, ends) = (read_poses(folder)?, read_matrices(folder, "ends.npy")?);
    if starts.len() != ends.len() {
        let message = format!("{} poses and {} ends", starts.len(), ends.len());
        return Err(PeersError::Pair { folder: folder.to_owned(), message });
    }
    Ok(starts.iter().zip(&ends).map(|(start, end)| Motion::between(start, end)).collect())
}

fn read_matrices(folder: &Path, name: &str) -> Result<Vec<Isometry>, PeersError> {
    let numbers = npy::read::<f64>(&folder.join(name), &[3, 4])?;
    Ok(numbers.as_chunks::<12>().0.iter().map(from_matrix).collect())
}

/// The upper three rows of the homogeneous matrix, row by row.
fn to_matrix(a_from_b: &Isometry) -> [f64; 12] {
    let matrix = rigid::rigid(a_from_b).to_homogeneous();
    std::array::from_fn(|i| matrix[(i / 4, i % 4)])
}

fn from_matrix(numbers: &[f64; 12]) -> Isometry {
    let rotation = Matrix3::from_fn(|row, column| numbers[4 * row + column]);
    let translation = Vector3::from_fn(|row, _| numbers[4 * row + 3]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    Isometry::from_parts(Translation3::from(translation), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use obbtree::cases::meshes;

    #[test]
    fn a_matrix_is_written_row_by_row() {
        // A quarter turn about z takes x to y: rows (0, -1, 0), (1, 0, 0), (0, 0, 1).
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
        let pose = Isometry::from_parts(Translation3::new(4.0, 5.0, 6.0), turn);
        let expected = [0.0, -1.0, 0.0, 4.0, 1.0, 0.0, 0.0, 5.0, 0.0, 0.0, 1.0, 6.0];
        let found = to_matrix(&pose);
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-15), "{found:?}");
        assert!((from_matrix(&found).to_homogeneous() - pose.to_homogeneous()).amax() < 1e-15);
    }

    #[test]
    fn steps_go_along_all_of_a_path_and_no_vertex_much_farther_than_a_step() {
        let mesh = meshes::cuboid(20.0, 3.0, 4.0);
        let path = [
            Isometry::identity(),
            Isometry::translation(0.5, 0.0, 0.0),
            Isometry::new(Vector3::new(0.5, 0.25, 0.0), Vector3::new(0.0, 0.0, 0.1)),
            Isometry::translation(9.0, 0.0, 0.0),
        ];
        for step_mm in [0.01, 0.05, 0.3] {
            let poses = stepped(&path, mesh.vertices(), step_mm);
            assert_eq!(poses.len(), PATH_STEPS);
            let moved = |pair: &[Isometry]| {
                mesh.vertices().iter().map(|p| (pair[1] * p - pair[0] * p).norm()).fold(0.0, f64::max)
            };
            let steps: Vec<f64> = poses.windows(2).map(moved).collect();
            assert!(steps.iter().all(|&mm| mm <= step_mm * 1.01), "{steps:?}");
            // Nearly all are as long as they may be: a corner of the path is cut.
            // Where there is no way left, the last pose is repeated.
            let moving = steps.iter().filter(|&&mm| mm > 0.0).count();
            assert!(moving > PATH_STEPS / 3, "{steps:?}");
            assert!(steps.iter().filter(|&&mm| mm > 0.99 * step_mm).count() + 5 >= moving, "{steps:?}");
        }
        assert_eq!(stepped(&path[..2], mesh.vertices(), 0.3)[63], path[1]);
        assert_eq!(stepped(&path[..1], mesh.vertices(), 0.3), vec![path[0]; PATH_STEPS]);
    }

    #[test]
    fn a_batch_has_one_chunk_a_stratum() {
        let (a, b) = (Arc::new(meshes::cuboid(2.0, 3.0, 4.0)), Arc::new(meshes::cuboid(2.0, 3.0, 4.0)));
        let question = |stratum| Question {
            a_from_b: Isometry::identity(),
            end: None,
            line: 0,
            exact: true,
            grazing: false,
            stratum,
            value: None,
        };
        let mut posed = PosedMeshes { pair: "a:b".into(), a, b, questions: Vec::new(), chunks: Vec::new() };
        for stratum in [Stratum::Far, Stratum::Colliding, Stratum::Far] {
            posed.add(vec![question(stratum); 2]);
        }
        posed.one_chunk_a_stratum();
        assert_eq!(posed.chunks, [0..2, 2..6]);
        assert_eq!(posed.questions[5].stratum, Stratum::Far);
    }

    #[test]
    fn a_folder_holds_the_meshes_and_the_poses() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (Arc::new(meshes::torus(12.0, 4.0, 14, 7)), Arc::new(meshes::cuboid(2.0, 3.0, 4.0)));
        let pose = |x: f64| Isometry::new(Vector3::new(x, 1.0, 0.1), Vector3::new(0.3, 0.1, x));
        let question = |x| Question {
            a_from_b: pose(x),
            end: Some(pose(-x)),
            line: 0,
            exact: true,
            grazing: false,
            stratum: Stratum::Medium,
            value: Some(x),
        };
        let mut posed = PosedMeshes { pair: "a:b".into(), a, b, questions: Vec::new(), chunks: Vec::new() };
        posed.add([1.0, 2.0, 3.0].map(question).to_vec());
        posed.add([4.0].map(question).to_vec());
        posed.write(folder.path()).unwrap();
        let [a, b] = read_meshes(folder.path()).unwrap();
        assert_eq!((&a, &b), (posed.a.as_ref(), posed.b.as_ref()));
        let poses = read_poses(folder.path()).unwrap();
        assert_eq!(poses.len(), 4);
        for (found, x) in poses.iter().zip([1.0, 2.0, 3.0, 4.0]) {
            assert!((found.to_homogeneous() - pose(x).to_homogeneous()).amax() < 1e-15);
        }
        let motions = read_motions(folder.path()).unwrap();
        assert!((motions[1].at(1.0).to_homogeneous() - pose(-2.0).to_homogeneous()).amax() < 1e-14);
        let chunks = npy::read::<u32>(&folder.path().join("chunks.npy"), &[2]).unwrap();
        assert_eq!(chunks, [0, 3, 3, 4]);
        assert_eq!(npy::read::<u8>(&folder.path().join("stratum.npy"), &[]).unwrap(), [2; 4]);
        assert_eq!(npy::read::<f64>(&folder.path().join("truth.npy"), &[]).unwrap(), [1.0, 2.0, 3.0, 4.0]);
    }
}

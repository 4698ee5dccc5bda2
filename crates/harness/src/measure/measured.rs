//! What is counted and timed in a scene: chunks of its workloads, and whole programs up to their first collision.

use super::chunk::{self, Chunk, Participants};
use super::judged::{self, JudgedPair, JudgedPose, Strata};
use super::plan::Plan;
use super::{MeasureError, Progress};
use crate::geometry::Isometry;
use crate::record::{CONTROL_WORKLOAD, PROGRAM_TIME, PoseRow};
use crate::scene::{Pair, ProgramRun, Scene};
use crate::truth::TruthCache;
use std::collections::BTreeSet;
use std::path::Path;

/// How many times more poses are generated than measured, so that every stratum finds lines of its own.
const POSE_RESERVE: usize = 6;

/// Everything that is counted and timed in a scene. Poses are numbered through: those of the chunks in their order, then those of the programs.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The judged poses that chunks refer to.
    pub judged: Vec<JudgedPair>,
    /// The chunks.
    pub chunks: Vec<Chunk>,
    /// The programs; each is one more chunk.
    pub programs: Vec<ProgramSteps>,
}

/// A program, step by step and pair by pair, up to its first collision.
#[derive(Clone, Debug)]
pub struct ProgramSteps {
    /// Its file: the name, and as many folders before it as tell it from the scene's other programs.
    pub file: String,
    /// The chunk it is timed in.
    pub chunk: u32,
    /// The queries in the order in which a controller would ask them.
    pub queries: Vec<ProgramQuery>,
}

/// One query of a program.
#[derive(Clone, Debug)]
pub struct ProgramQuery {
    /// The pair.
    pub pair: Pair,
    /// Step of the program.
    pub step: u32,
    /// The pose with its truth.
    pub pose: JudgedPose,
}

/// A pose of a chunk with its number.
#[derive(Clone, Copy, Debug)]
pub struct Numbered {
    /// The number.
    pub number: u32,
    /// Which of the judged pairs.
    pub pair: usize,
    /// Index into that pair's poses.
    pub pose: usize,
    /// Who answers.
    pub participants: Participants,
}

impl Measured {
    /// Chooses and judges the poses of a scene.
    ///
    /// # Errors
    /// When poses cannot be made or judged.
    pub fn choose(
        plan: &Plan,
        scene: &Scene,
        cache: Option<&TruthCache>,
        progress: &dyn Progress,
    ) -> Result<Self, MeasureError> {
        let poses = plan.budget.measure_poses;
        let judged = judged::judge(plan, scene, poses * POSE_RESERVE, Strata::Sought, cache, progress)?;
        let chunks = chunk::select(&judged, poses);
        let mut programs = Vec::new();
        let asked = &plan.selection.workloads;
        if asked.is_empty() || asked.iter().any(|workload| workload == PROGRAM_TIME) {
            let mut runs: Vec<&ProgramRun> = scene.program.iter().chain(&scene.more_programs).collect();
            let mut seen = BTreeSet::new();
            runs.retain(|run| seen.insert(&run.file));
            let files: Vec<&Path> = runs.iter().map(|run| run.file.as_path()).collect();
            for run in runs {
                let queries = judged::judge_program(plan, scene, run, cache, progress)?;
                if !queries.is_empty() {
                    let (file, chunk) = (name_among(&run.file, &files), (chunks.len() + programs.len()) as u32);
                    programs.push(ProgramSteps { file, chunk, queries });
                }
            }
        }
        Ok(Self { judged, chunks, programs })
    }

    /// The poses of the chunks, in the order of their numbers.
    pub fn numbered(&self) -> impl Iterator<Item = Numbered> {
        let of = |chunk: &Chunk| {
            let (pair, participants) = (chunk.pair, chunk.participants);
            chunk.poses.clone().into_iter().map(move |pose| (pair, pose, participants))
        };
        let poses = self.chunks.iter().flat_map(of).zip(0..);
        poses.map(|((pair, pose, participants), number)| Numbered { number, pair, pose, participants })
    }

    /// `poses.csv` of the scene.
    pub fn rows(&self, scene: &Scene) -> Vec<PoseRow> {
        let mut rows = pose_rows(scene, &self.judged, &self.chunks);
        for program in &self.programs {
            rows.extend(program.queries.iter().map(|query| PoseRow {
                workload: PROGRAM_TIME.to_owned(),
                program: program.file.clone(),
                ..pose_row(scene, query.pair, query.step as usize, program.chunk, &query.pose)
            }));
        }
        number(&mut rows);
        rows
    }

    /// What is timed, chunk by chunk.
    pub fn timed(&self) -> Vec<TimedChunk> {
        let of_chunk = |chunk: &Chunk| {
            let judged = &self.judged[chunk.pair];
            let poses = chunk.poses.iter().map(|&pose| judged.poses[pose].a_from_b).collect();
            TimedChunk {
                number: chunk.number,
                participants: chunk.participants,
                is_program: false,
                runs: vec![(judged.pair, poses)],
            }
        };
        let of_program = |program: &ProgramSteps| {
            let mut runs: Vec<(Pair, Vec<Isometry>)> = Vec::new();
            for query in &program.queries {
                match runs.last_mut() {
                    Some((pair, poses)) if *pair == query.pair => poses.push(query.pose.a_from_b),
                    _ => runs.push((query.pair, vec![query.pose.a_from_b])),
                }
            }
            TimedChunk { number: program.chunk, participants: Participants::Everyone, is_program: true, runs }
        };
        self.chunks.iter().map(of_chunk).chain(self.programs.iter().map(of_program)).collect()
    }
}

/// The end of a program's path that none of the others has, its parts joined by `/`: the file's name where no other has that.
fn name_among(file: &Path, files: &[&Path]) -> String {
    let parts: Vec<_> = file.components().map(|part| part.as_os_str().to_string_lossy()).collect();
    let end = |count: usize| parts[parts.len() - count..].join("/");
    let is_only = |end: &String| files.iter().filter(|other| other.ends_with(end)).count() == 1;
    (1..=parts.len()).map(end).find(is_only).unwrap_or_else(|| end(parts.len()))
}

/// The rows of the poses of chunks, numbered in their order.
pub fn pose_rows(scene: &Scene, judged: &[JudgedPair], chunks: &[Chunk]) -> Vec<PoseRow> {
    let mut rows = Vec::new();
    for chunk in chunks {
        let judged = &judged[chunk.pair];
        let is_control = chunk.participants == Participants::Control;
        let workload = if is_control { CONTROL_WORKLOAD } else { judged.workload.as_str() };
        let of_stratum = judged.poses_in(chunk.stratum).len() as u32;
        rows.extend(chunk.poses.iter().map(|&pose| PoseRow {
            workload: workload.to_owned(),
            judged: Some(of_stratum),
            ..pose_row(scene, judged.pair, pose, chunk.number, &judged.poses[pose])
        }));
    }
    number(&mut rows);
    rows
}

fn number(rows: &mut [PoseRow]) {
    for (number, row) in (0..).zip(rows) {
        row.pose = number;
    }
}

fn pose_row(scene: &Scene, pair: Pair, step: usize, chunk: u32, pose: &JudgedPose) -> PoseRow {
    PoseRow {
        scene: scene.name.clone(),
        pose: 0,
        pair: scene.pair_name(pair),
        workload: String::new(),
        program: String::new(),
        line: pose.line,
        step: step as u32,
        chunk,
        stratum: pose.stratum,
        band: pose.band,
        clearance_mm: pose.clearance_mm.is_finite().then_some(pose.clearance_mm),
        exact: u8::from(pose.touches()),
        contained: u8::from(pose.contained),
        judged: None,
    }
}

/// Queries that are timed together: consecutive poses of a pair, then of the next.
#[derive(Clone, Debug)]
pub struct TimedChunk {
    /// Number within the scene.
    pub number: u32,
    /// Who runs it.
    pub participants: Participants,
    /// Whether it is a whole program.
    pub is_program: bool,
    /// The poses.
    pub runs: Vec<(Pair, Vec<Isometry>)>,
}

impl TimedChunk {
    /// Number of poses.
    pub fn len(&self) -> usize {
        self.runs.iter().map(|(_, poses)| poses.len()).sum()
    }

    /// Whether there is no pose.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_of_one_file_name_have_names_of_their_own() {
        let files = ["mill/a/part.ngc", "mill/b/part.ngc", "mill/other.ngc", "mill/part.ngc"].map(Path::new);
        let names = files.map(|file| name_among(file, &files));
        assert_eq!(names, ["a/part.ngc", "b/part.ngc", "other.ngc", "mill/part.ngc"]);
    }
}

//! Our own variants as runners: the protocol's other end, in Rust.

use super::drive::LONG_CHUNK_NS;
use super::{Mode, PeersError, npy, posed};
use crate::geometry::{Isometry, Mesh};
use crate::measure::timer;
use crate::method::Model;
use crate::method::motion::{Motion, reach_mm};
use crate::registry::Variant;
use crate::tree::Policy;
use crate::tree::distance::Proximity;
use obbtree::engine::{Coherence, Memory};
use rayon::prelude::*;
use std::io::{BufRead, Write};
use std::ops::Range;
use std::path::Path;

/// Poses that a thread takes at a time in mode `batch`.
const BATCH_POSES: usize = 64;

/// Answers as a variant until it is told to stop. Reads commands from `commands` and says what it does to `replies`.
///
/// # Errors
/// When the folders cannot be read or written, or a command is none.
#[expect(clippy::too_many_arguments, reason = "the protocol's command line, and its two pipes")]
pub fn run(
    variant: &Variant,
    policy: Option<Policy>,
    coherence: Coherence,
    mode: Mode,
    pair: &Path,
    out: &Path,
    rounds: usize,
    commands: impl BufRead,
    mut replies: impl Write,
) -> Result<(), PeersError> {
    let mut say = |text: &str| writeln!(replies, "{text}").and_then(|()| replies.flush()).map_err(PeersError::Gone);
    let (meshes, poses) = (posed::read_meshes(pair)?, posed::read_poses(pair)?);
    let motions = if mode == Mode::Motion { posed::read_motions(pair)? } else { Vec::new() };
    let count = poses.len();
    let (ns, asked, answers) = (vec![0; rounds * count], vec![0; count], vec![0.0; count]);
    let mut runner =
        Runner { variant, policy, coherence, mode, meshes, models: None, poses, motions, rounds, ns, asked, answers };
    // A peer here answers only whether two meshes touch, and how far apart they are; so do samples.
    if mode == Mode::All && matches!(variant.kind, crate::method::Kind::Peer | crate::method::Kind::Sampling) {
        return say("unsupported");
    }
    say("ready")?;
    for line in commands.lines() {
        let line = line.map_err(PeersError::Gone)?;
        let no_command = || PeersError::Command { line: line.clone() };
        let done = match line.split_whitespace().collect::<Vec<_>>().as_slice() {
            ["build"] => runner.build(),
            ["bytes"] => runner.models.as_ref().map_or(0, |[a, b]| (a.bytes() + b.bytes()) as u64),
            ["chunk", start, end] => {
                let number = |text: &str| text.parse::<usize>().map_err(|_| no_command());
                let chunk = number(start)?..number(end)?;
                if chunk.is_empty() || chunk.end > runner.poses.len() {
                    return Err(no_command());
                }
                runner.chunk(chunk)
            }
            ["quit"] => {
                runner.write(out)?;
                return say("done 0");
            }
            _ => return Err(no_command()),
        };
        say(&format!("done {done}"))?;
    }
    Ok(())
}

struct Runner<'a> {
    variant: &'a Variant,
    policy: Option<Policy>,
    coherence: Coherence,
    mode: Mode,
    meshes: [Mesh; 2],
    models: Option<[Box<dyn Model>; 2]>,
    poses: Vec<Isometry>,
    /// In mode `motion` one for each pose.
    motions: Vec<Motion>,
    rounds: usize,
    /// Times of each pose, ns: a row per round.
    ns: Vec<u64>,
    /// How often each pose has been asked about.
    asked: Vec<usize>,
    answers: Vec<f64>,
}

impl Runner<'_> {
    fn build(&mut self) -> u64 {
        self.models = None;
        let (ns, models) = timer::time(|| {
            let [a, b] = &self.meshes;
            [self.variant.prepare(a, self.policy), self.variant.prepare(b, self.policy)]
        });
        self.models = Some(models);
        ns
    }

    fn chunk(&mut self, chunk: Range<usize>) -> u64 {
        if self.models.is_none() {
            self.build();
        }
        let Some([a, b]) = &self.models else { return 0 };
        let mut asker = Asker {
            mode: self.mode,
            coherence: self.coherence,
            a: a.as_ref(),
            b: b.as_ref(),
            reach_mm: reach_mm(&self.meshes[1]),
            memory: Memory::default(),
            proximity: Proximity::default(),
            verdicts: Vec::new(),
            answers: Vec::new(),
        };
        let motions = if self.mode == Mode::Motion { &self.motions[chunk.clone()] } else { &[] };
        let poses = Asked { poses: &self.poses[chunk.clone()], motions };
        let mode = self.mode;
        let mut measure = || {
            let times = asker.alone(poses);
            let once: u64 = times.iter().sum();
            if once >= LONG_CHUNK_NS {
                return (once, times);
            }
            let passes = timer::passes_for(once);
            let (total, ()) = timer::time(|| (0..passes).for_each(|_| asker.pass(poses)));
            (total / u64::from(passes), if mode == Mode::Batch { times } else { asker.one_by_one(poses) })
        };
        // A batch is answered by the threads of the pool, of which the one that measures is one: whoever waits outside is woken late.
        let (ns, times) = if mode == Mode::Batch { rayon::scope(|_| measure()) } else { measure() };
        self.answers[chunk.clone()].copy_from_slice(&asker.answers);
        for (index, ns) in chunk.zip(times) {
            if self.asked[index] < self.rounds {
                self.ns[self.asked[index] * self.poses.len() + index] = ns.max(1);
                self.asked[index] += 1;
            }
        }
        ns
    }

    fn write(&self, out: &Path) -> Result<(), PeersError> {
        let count = self.poses.len();
        let touching = |&answer: &f64| {
            u8::from(match self.mode {
                Mode::Distance => answer <= 0.0,
                Mode::Motion => answer.is_finite(),
                _ => answer > 0.0,
            })
        };
        let verdicts: Vec<u8> = self.answers.iter().map(touching).collect();
        npy::write(&out.join("verdicts.npy"), &[count], &verdicts)?;
        npy::write(&out.join("ns.npy"), &[self.rounds, count], &self.ns)?;
        if self.mode.has_values() {
            npy::write(&out.join("values.npy"), &[count], &self.answers)?;
        }
        Ok(())
    }
}

/// Poses, and in mode `motion` the motions from them.
#[derive(Clone, Copy)]
struct Asked<'a> {
    poses: &'a [Isometry],
    motions: &'a [Motion],
}

impl<'a> Asked<'a> {
    /// Each alone.
    fn each(self) -> impl Iterator<Item = Asked<'a>> {
        let Asked { poses, motions } = self;
        let one = move |i: usize| Asked {
            poses: &poses[i..=i],
            motions: if motions.is_empty() { motions } else { &motions[i..=i] },
        };
        (0..poses.len()).map(one)
    }
}

/// Two models and what asking them reuses.
struct Asker<'a> {
    mode: Mode,
    coherence: Coherence,
    a: &'a dyn Model,
    b: &'a dyn Model,
    /// How far `b` reaches from its origin, mm.
    reach_mm: f64,
    /// What poses of the pass have left behind.
    memory: Memory,
    /// Memory of distance queries. The pair that was nearest is forgotten before each, so that it stands alone.
    proximity: Proximity,
    verdicts: Vec<bool>,
    /// Answers of the last pass.
    answers: Vec<f64>,
}

impl Asker<'_> {
    fn forget(&mut self) {
        self.memory.forget();
        self.verdicts.clear();
        self.answers.clear();
    }

    /// Answers the poses, and returns the time of each, ns.
    fn one_by_one(&mut self, asked: Asked<'_>) -> Vec<u64> {
        self.forget();
        asked.each().map(|one| timer::time(|| self.ask(one)).0).collect()
    }

    /// The time of each pose, ns: in a batch its share of a pass.
    fn alone(&mut self, asked: Asked<'_>) -> Vec<u64> {
        if self.mode != Mode::Batch {
            return self.one_by_one(asked);
        }
        let (ns, ()) = timer::time(|| self.pass(asked));
        vec![ns / asked.poses.len() as u64; asked.poses.len()]
    }

    fn pass(&mut self, asked: Asked<'_>) {
        self.forget();
        self.ask(asked);
    }

    fn ask(&mut self, Asked { poses, motions }: Asked<'_>) {
        match self.mode {
            Mode::Batch => {
                let (a, b) = (self.a, self.b);
                let answer = |(poses, answers): (&[Isometry], &mut [f64])| {
                    let mut verdicts = Vec::with_capacity(poses.len());
                    a.first(b, poses, &mut verdicts);
                    for (answer, touching) in answers.iter_mut().zip(verdicts) {
                        *answer = f64::from(u8::from(touching));
                    }
                };
                self.answers.resize(poses.len(), 0.0);
                poses.par_chunks(BATCH_POSES).zip(self.answers.par_chunks_mut(BATCH_POSES)).for_each(answer);
            }
            Mode::First | Mode::Path(_) => {
                let before = self.verdicts.len();
                if matches!(self.mode, Mode::Path(_)) {
                    self.a.along(self.b, poses, self.coherence, &mut self.memory, &mut self.verdicts);
                } else {
                    self.a.first(self.b, poses, &mut self.verdicts);
                }
                self.answers.extend(self.verdicts[before..].iter().map(|&touching| f64::from(u8::from(touching))));
            }
            Mode::All => {
                self.answers.extend(poses.iter().map(|pose| self.a.all_counted(self.b, pose).0.len() as f64));
            }
            Mode::Distance => {
                let (a, b, proximity) = (self.a, self.b, &mut self.proximity);
                let distance = |pose| {
                    proximity.nearest = None;
                    a.distance_mm(b, pose, f64::INFINITY, proximity)
                };
                self.answers.extend(poses.iter().map(distance));
            }
            Mode::Motion => {
                let (a, b, reach_mm) = (self.a, self.b, self.reach_mm);
                let first = |motion| a.first_contact(b, motion, reach_mm).unwrap_or(f64::INFINITY);
                self.answers.extend(motions.iter().map(first));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Stratum;
    use crate::registry;
    use obbtree::cases::meshes;
    use std::sync::Arc;

    /// A torus and a cuboid far away and in the ring's tube: each mode's answers, and what is written.
    fn answers(mode: Mode) -> (Vec<String>, tempfile::TempDir) {
        let folder = tempfile::tempdir().unwrap();
        let torus = Arc::new(meshes::torus(12.0, 4.0, 14, 7));
        let cuboid = Arc::new(meshes::cuboid(2.0, 2.0, 2.0));
        let question = |x| posed::Question {
            a_from_b: Isometry::translation(x, 0.0, 0.0),
            // 40 mm towards the torus.
            end: Some(Isometry::translation(x - 40.0, 0.0, 0.0)),
            line: 0,
            exact: false,
            grazing: false,
            stratum: Stratum::Far,
            value: None,
        };
        let questions = vec![question(50.0), question(16.0), question(60.0)];
        let chunks = vec![0..2, 2..3];
        let asked = posed::PosedMeshes { pair: "a:b".into(), a: torus, b: cuboid, questions, chunks };
        asked.write(folder.path()).unwrap();
        let registry = registry::standard();
        let variant = registry.variants().iter().find(|variant| variant.is_reference).unwrap();
        let commands = b"build\nbytes\nchunk 0 2\nchunk 2 3\nchunk 0 2\nquit\n";
        let mut replies = Vec::new();
        run(variant, None, Coherence::None, mode, folder.path(), folder.path(), 2, commands.as_slice(), &mut replies)
            .unwrap();
        (String::from_utf8(replies).unwrap().lines().map(str::to_owned).collect(), folder)
    }

    #[test]
    fn a_runner_of_ours_speaks_the_protocol() {
        let (replies, folder) = answers(Mode::First);
        assert_eq!(replies.len(), 7, "{replies:?}");
        assert_eq!((replies[0].as_str(), replies[6].as_str()), ("ready", "done 0"));
        assert!(
            replies[1..6]
                .iter()
                .all(|reply| reply.strip_prefix("done ").is_some_and(|n| n.parse::<u64>().is_ok_and(|n| n > 0))),
            "{replies:?}"
        );
        assert_eq!(npy::read::<u8>(&folder.path().join("verdicts.npy"), &[]).unwrap(), [0, 1, 0]);
        let ns = npy::read::<u64>(&folder.path().join("ns.npy"), &[3]).unwrap();
        assert_eq!(ns.iter().map(|&ns| ns > 0).collect::<Vec<_>>(), [true, true, true, true, true, false]);
    }

    #[test]
    fn distances_and_counts_are_values() {
        // The torus reaches to x = 16, where the cuboid, at x = 50, has its face at 49: 33 mm; at 60 it is 43 mm.
        let (_, folder) = answers(Mode::Distance);
        let values = npy::read::<f64>(&folder.path().join("values.npy"), &[]).unwrap();
        assert!((values[0] - 33.0).abs() < 1e-6 && values[1] == 0.0 && (values[2] - 43.0).abs() < 1e-6, "{values:?}");
        // So it takes 33 of 40 mm; the second is in contact where it begins; the third would take 43.
        let (_, folder) = answers(Mode::Motion);
        let values = npy::read::<f64>(&folder.path().join("values.npy"), &[]).unwrap();
        assert!((values[0] - 33.0 / 40.0).abs() < 1e-5 && values[1] == 0.0 && values[2].is_infinite(), "{values:?}");
        assert_eq!(npy::read::<u8>(&folder.path().join("verdicts.npy"), &[]).unwrap(), [1, 1, 0]);
        let (_, folder) = answers(Mode::All);
        let values = npy::read::<f64>(&folder.path().join("values.npy"), &[]).unwrap();
        assert!(values[0] == 0.0 && values[1] > 1.0 && values[2] == 0.0, "{values:?}");
    }

    #[test]
    fn what_is_no_command_is_refused() {
        let (_, folder) = answers(Mode::First);
        let registry = registry::standard();
        let variant = &registry.variants()[0];
        for bad in ["hello\n", "chunk 0\n", "chunk 0 9\n", "chunk 2 1\n", "chunk a b\n"] {
            let result = run(
                variant,
                None,
                Coherence::None,
                Mode::First,
                folder.path(),
                folder.path(),
                1,
                bad.as_bytes(),
                &mut Vec::new(),
            );
            assert!(matches!(result, Err(PeersError::Command { .. })), "{bad}");
        }
    }
}

//! The driver: starts the runners of all engines, and has them answer the same chunks in turn.
//!
//! In every round the chunks come in a fresh random order, and for each chunk the engines in a fresh random order. The first round
//! warms up and is dropped. A chunk that takes an engine longer than `LONG_CHUNK_NS` is asked once more only: it
//! averages the machine's noise itself.

use super::engine::Engine;
use super::posed::PosedMeshes;
use super::{Mode, PeersError, npy};
use crate::analysis::grouped;
use crate::measure::Progress;
use crate::record::{PeerAnswerRow, PeerBuildRow, PeerTimingRow, RecordError, Stratum};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64Mcg;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// A chunk that takes an engine longer than this, ns, is asked once in the warm-up round and once more, timed. A single pass is enough
/// there: what a cold start adds is small beside it.
pub const LONG_CHUNK_NS: u64 = 20_000_000;

/// Rounds that begin with constructions.
const BUILD_ROUNDS: u32 = 5;

/// An engine constructs in a round until what is timed has taken this long, ns, and the median counts. The first is not timed, as a pass goes
/// before each that is, unless it alone takes longer: a thread that has slept while other engines worked is awake then, which on a virtual
/// machine alone can take tens of milliseconds.
const BUILDS_NS: u64 = 200_000_000;
/// No more than this often: more says nothing, and a runner's clock may stand still.
const MOST_BUILDS: usize = 100;

/// How long the driver waits for an answer: no pass over a chunk and no construction should take longer.
const PATIENCE: Duration = Duration::from_secs(600);
/// The longest time that a runner may tell, ns.
const LONGEST_NS: u64 = PATIENCE.as_secs() * 1_000_000_000;
/// How long a runner may take to end once its input has ended.
const PATIENCE_AT_END: Duration = Duration::from_secs(5);

/// How much is asked, and in what order.
#[derive(Clone, Copy, Debug)]
pub struct Amounts {
    /// Mode.
    pub mode: Mode,
    /// Timed rounds of each process; none: poses are asked about once, and nothing is timed.
    pub rounds: u32,
    /// Processes of each engine, one after the other: where a process puts its data tells on its times, up to a tenth.
    pub processes: u32,
    /// Seed of the random orders.
    pub seed: u64,
}

/// What a comparison leaves behind.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// Times of construction, and memory.
    pub builds: Vec<PeerBuildRow>,
    /// Times of chunks.
    pub timings: Vec<PeerTimingRow>,
    /// Answers, with the times of single poses.
    pub answers: Vec<PeerAnswerRow>,
    /// Engines that did not take part on a pair, with the reason.
    pub skipped: Vec<String>,
}

/// Asks all engines about all pairs of a scene. The arrays and the runners' answers are left in `folder`.
///
/// An engine that cannot be started, fails, or says what the protocol does not know, is skipped, with the reason in
/// [`Comparison::skipped`].
///
/// # Errors
/// When the arrays cannot be written.
pub fn compare(
    engines: &[Engine],
    scene: &str,
    pairs: &[PosedMeshes],
    amounts: Amounts,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Comparison, PeersError> {
    let mut found = Comparison::default();
    let chunks: usize = pairs.iter().map(|pair| pair.chunks.len()).sum();
    let title = format!("{scene}: {} engines, {}", engines.len(), amounts.mode);
    progress.begin(&title, steps(chunks, amounts.rounds) * u64::from(amounts.processes));
    for posed in pairs {
        let folder = pair_folder(folder, scene, &posed.pair);
        posed.write(&folder)?;
        // Runners may change folders.
        let folder = folder.canonicalize().map_err(RecordError::io("find", &folder))?;
        let mut of_pair = Comparison::default();
        let mut failures: Vec<(&str, String)> = Vec::new();
        for process in 0..amounts.processes {
            let place = Place { scene, posed, amounts, process };
            place.compare(engines, &folder, &mut of_pair, &mut failures, progress);
        }
        let place = Place { scene, posed, amounts, process: 0 };
        let mut answers = Vec::new();
        for engine in engines {
            let own = of_pair.answers.iter().filter(|row| row.engine == engine.name);
            if failures.iter().any(|(name, _)| *name == engine.name) {
                continue;
            }
            match over_processes(own) {
                Ok(rows) => answers.extend(rows),
                Err(reason) => failures.push((engine.name.as_str(), reason)),
            }
        }
        let took_part = |engine: &str| failures.iter().all(|(name, _)| *name != engine);
        found.builds.extend(of_pair.builds.into_iter().filter(|row| took_part(&row.engine)));
        found.timings.extend(of_pair.timings.into_iter().filter(|row| took_part(&row.engine)));
        found.answers.extend(answers);
        found.skipped.extend(failures.iter().map(|(name, reason)| place.skipped(name, reason)));
    }
    // Written in one order whatever the order of execution.
    found.timings.sort_by_cached_key(|row| (row.engine.clone(), row.pair.clone(), row.round, row.chunk));
    found.builds.sort_by_cached_key(|row| (row.engine.clone(), row.pair.clone(), row.round));
    Ok(found)
}

/// The answers of an engine's processes as one: the median (the lower one of two) of their times.
fn over_processes<'a>(rows: impl Iterator<Item = &'a PeerAnswerRow>) -> Result<Vec<PeerAnswerRow>, String> {
    let poses = grouped(rows.map(|row| (row.pose, row)));
    let one = |(pose, rows): (u32, Vec<&PeerAnswerRow>)| {
        let mut row = rows[0].clone();
        if rows.iter().any(|other| other.touching != row.touching) {
            return Err(format!("its processes answer pose {pose} differently"));
        }
        let mut ns: Vec<u64> = rows.iter().map(|row| row.ns).filter(|&ns| ns > 0).collect();
        ns.sort_unstable();
        row.ns = ns.get(ns.len().saturating_sub(1) / 2).copied().unwrap_or(0);
        Ok(row)
    };
    poses.into_iter().map(one).collect()
}

/// The folder of a pair's arrays.
pub fn pair_folder(folder: &Path, scene: &str, pair: &str) -> PathBuf {
    folder.join(file_name(scene)).join(file_name(pair))
}

/// Steps of progress: the chunks of all rounds.
const fn steps(chunks: usize, rounds: u32) -> u64 {
    chunks as u64 * (rounds as u64 + 1)
}

/// A name as a folder's: letters, digits, `.`, `-` and `_` only.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '-' }).collect()
}

/// A pair of a scene, and how it is asked about.
struct Place<'a> {
    scene: &'a str,
    posed: &'a PosedMeshes,
    amounts: Amounts,
    /// Which of the processes of each engine, from 0.
    process: u32,
}

impl Place<'_> {
    /// Starts a process of each engine that has not failed, and has them answer in turn.
    fn compare<'a>(
        &self,
        engines: &'a [Engine],
        folder: &Path,
        found: &mut Comparison,
        failures: &mut Vec<(&'a str, String)>,
        progress: &dyn Progress,
    ) {
        let mut runners = Vec::new();
        for engine in engines {
            if failures.iter().any(|(name, _)| *name == engine.name) {
                continue;
            }
            match Runner::start(engine, self.amounts, folder) {
                Ok(runner) => runners.push(runner),
                Err(reason) => failures.push((engine.name.as_str(), reason)),
            }
        }
        self.ask(&mut runners, found, progress);
        for mut runner in runners {
            let failure = match runner.failure.take() {
                Some(reason) => Some(reason),
                None => self.collect(&mut runner, &mut found.answers).err(),
            };
            failures.extend(failure.map(|reason| (runner.engine.name.as_str(), reason)));
        }
    }

    /// The number of a round of this process among those of all.
    const fn numbered(&self, round: u32) -> u32 {
        self.process * self.amounts.rounds + round
    }

    fn skipped(&self, engine: &str, reason: &str) -> String {
        format!("{engine} on {} {}, mode {}: {reason}", self.scene, self.posed.pair, self.amounts.mode)
    }

    fn stratum(&self, chunk: usize) -> Stratum {
        self.posed.questions[self.posed.chunks[chunk].start].stratum
    }

    /// All rounds. A runner that fails is asked nothing more.
    fn ask(&self, runners: &mut [Runner], found: &mut Comparison, progress: &dyn Progress) {
        let mut rng = Pcg64Mcg::seed_from_u64(self.amounts.seed.wrapping_add(u64::from(self.process)));
        let mut chunk_order: Vec<usize> = (0..self.posed.chunks.len()).collect();
        let mut runner_order: Vec<usize> = (0..runners.len()).collect();
        let mut is_long = vec![vec![false; runners.len()]; self.posed.chunks.len()];
        for round in 0..=self.amounts.rounds {
            runner_order.shuffle(&mut rng);
            for &r in &runner_order {
                if round <= BUILD_ROUNDS {
                    self.build(&mut runners[r], round, &mut found.builds);
                }
            }
            chunk_order.shuffle(&mut rng);
            for &c in &chunk_order {
                let chunk = &self.posed.chunks[c];
                runner_order.shuffle(&mut rng);
                for &r in &runner_order {
                    if round > 1 && is_long[c][r] {
                        continue;
                    }
                    let runner = &mut runners[r];
                    let Some(ns) = runner.ask_time(&format!("chunk {} {}", chunk.start, chunk.end), 1) else {
                        continue;
                    };
                    if let Some(round) = round.checked_sub(1) {
                        found.timings.push(self.timing(runner, c, round, ns));
                    } else {
                        is_long[c][r] = ns > LONG_CHUNK_NS;
                    }
                }
                progress.advance(1);
            }
        }
    }

    fn build(&self, runner: &mut Runner, round: u32, builds: &mut Vec<PeerBuildRow>) {
        let Some(first) = runner.ask_time("build", 0) else { return };
        let Some(round) = round.checked_sub(1) else { return };
        let mut times: Vec<u64> = (first > BUILDS_NS).then_some(first).into_iter().collect();
        while times.iter().sum::<u64>() < BUILDS_NS && times.len() < MOST_BUILDS {
            let Some(ns) = runner.ask_time("build", 0) else { return };
            times.push(ns);
        }
        times.sort_unstable();
        let ns = times[times.len() / 2];
        let Some(bytes) = runner.ask("bytes") else { return };
        builds.push(PeerBuildRow {
            engine: runner.engine.name.clone(),
            scene: self.scene.to_owned(),
            pair: self.posed.pair.clone(),
            mode: self.amounts.mode.to_string(),
            round: self.process * BUILD_ROUNDS + round,
            ns,
            bytes,
            triangles: (self.posed.a.faces().len() + self.posed.b.faces().len()) as u64,
        });
    }

    fn timing(&self, runner: &Runner, chunk: usize, round: u32, ns: u64) -> PeerTimingRow {
        PeerTimingRow {
            engine: runner.engine.name.clone(),
            scene: self.scene.to_owned(),
            pair: self.posed.pair.clone(),
            mode: self.amounts.mode.to_string(),
            stratum: self.stratum(chunk),
            chunk: chunk as u32,
            poses: self.posed.chunks[chunk].len() as u32,
            round: self.numbered(round),
            ns,
        }
    }

    /// Ends a runner and reads what it leaves behind.
    fn collect(&self, runner: &mut Runner, answers: &mut Vec<PeerAnswerRow>) -> Result<(), String> {
        runner.request("quit")?;
        let status = runner.ended()?;
        if !status.success() {
            return Err(format!("its process ended with {status}"));
        }
        let (count, mode) = (self.posed.questions.len(), self.amounts.mode);
        let text = |cause: npy::NpyError| cause.to_string();
        let verdicts = npy::read::<u8>(&runner.out.join("verdicts.npy"), &[]).map_err(text)?;
        let ns = npy::read::<u64>(&runner.out.join("ns.npy"), &[count]).map_err(text)?;
        let values = match mode.has_values() {
            true => npy::read::<f64>(&runner.out.join("values.npy"), &[]).map_err(text)?,
            false => Vec::new(),
        };
        if verdicts.len() != count || (mode.has_values() && values.len() != count) {
            return Err(format!("{} verdicts and {} values on {count} poses", verdicts.len(), values.len()));
        }
        let single = self.single_times(&ns)?;
        for (chunk, poses) in self.posed.chunks.iter().enumerate() {
            answers.extend(poses.clone().map(|pose| {
                let question = &self.posed.questions[pose];
                PeerAnswerRow {
                    engine: runner.engine.name.clone(),
                    scene: self.scene.to_owned(),
                    pair: self.posed.pair.clone(),
                    mode: mode.to_string(),
                    pose: pose as u32,
                    line: question.line,
                    chunk: chunk as u32,
                    stratum: self.stratum(chunk),
                    exact: u8::from(question.exact),
                    grazing: u8::from(question.grazing),
                    touching: u8::from(verdicts[pose] != 0),
                    // A time that is not there is infinite.
                    value: values.get(pose).copied().filter(|value| mode != Mode::Motion || value.is_finite()),
                    true_value: question.value,
                    ns: single[pose],
                }
            }));
        }
        Ok(())
    }

    /// The time of each pose alone, ns: the median of its column in `ns.npy`. Without timed rounds there is none.
    fn single_times(&self, ns: &[u64]) -> Result<Vec<u64>, String> {
        let count = self.posed.questions.len();
        let of_pose = |pose| median_after_first(ns.iter().skip(pose).step_by(count).copied());
        let single: Vec<u64> = (0..count).map(of_pose).collect();
        let is_wrong = |&pose: &usize| !(1..=LONGEST_NS).contains(&single[pose]);
        match self.posed.chunks.iter().cloned().flatten().find(is_wrong) {
            Some(pose) if self.amounts.rounds > 0 => {
                Err(format!("ns.npy holds {} ns for pose {pose}: a time is from 1 to {LONGEST_NS} ns", single[pose]))
            }
            _ => Ok(single),
        }
    }
}

/// The median (the lower one of two) of the times but the first, which warmed up, and those that are 0, never taken.
fn median_after_first(ns: impl Iterator<Item = u64>) -> u64 {
    let mut taken: Vec<u64> = ns.skip(1).filter(|&ns| ns > 0).collect();
    taken.sort_unstable();
    taken.get(taken.len().saturating_sub(1) / 2).copied().unwrap_or(0)
}

/// A runner's process. It is killed when it is dropped before it has ended.
struct Runner<'a> {
    engine: &'a Engine,
    child: Child,
    /// Its standard input; `None` once nothing more will be asked.
    commands: Option<ChildStdin>,
    /// Lines of its standard output, read by a thread of their own so that waiting can end.
    replies: Receiver<std::io::Result<String>>,
    out: PathBuf,
    failure: Option<String>,
}

impl<'a> Runner<'a> {
    fn start(engine: &'a Engine, amounts: Amounts, pair: &Path) -> Result<Self, String> {
        let out = pair.join(format!("{}-{}", file_name(&engine.name), amounts.mode));
        fs::create_dir_all(&out).map_err(|cause| format!("cannot create {}: {cause}", out.display()))?;
        let [program, arguments @ ..] = engine.command.as_slice() else { return Err("no program is named".to_owned()) };
        let mut child = Command::new(program)
            .args(arguments)
            .arg(amounts.mode.id())
            .args([pair, &out])
            .arg((amounts.rounds + 1).to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|cause| format!("{program} cannot be started: {cause}"))?;
        let (Some(commands), Some(replies)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("its process has no pipes".to_owned());
        };
        let (sender, receiver) = channel();
        // The thread ends when the process does, or with the first line after the driver has gone.
        thread::spawn(move || BufReader::new(replies).lines().try_for_each(|line| sender.send(line)));
        let mut runner = Self { engine, child, commands: Some(commands), replies: receiver, out, failure: None };
        match runner.reply()?.as_str() {
            "ready" => Ok(runner),
            "unsupported" => Err("it has no such mode".to_owned()),
            other => Err(format!("it said `{other}` in the place of `ready`")),
        }
    }

    /// The answer to a command; `None` when the runner has failed, now or before.
    fn ask(&mut self, command: &str) -> Option<u64> {
        if self.failure.is_some() {
            return None;
        }
        self.request(command).map_err(|reason| self.failure = Some(reason)).ok()
    }

    /// The time in the answer to a command, at least `least` ns; `None` as [`Runner::ask`].
    fn ask_time(&mut self, command: &str, least: u64) -> Option<u64> {
        let ns = self.ask(command)?;
        if (least..=LONGEST_NS).contains(&ns) {
            return Some(ns);
        }
        let range = format!("a time is from {least} to {LONGEST_NS} ns");
        self.failure = Some(format!("it said `done {ns}` to `{command}`: {range}"));
        None
    }

    fn request(&mut self, command: &str) -> Result<u64, String> {
        let Some(commands) = &mut self.commands else { return Err("nothing more can be asked".to_owned()) };
        writeln!(commands, "{command}")
            .and_then(|()| commands.flush())
            .map_err(|cause| format!("`{command}` cannot be sent: {cause}"))?;
        let reply = self.reply()?;
        let number = reply.strip_prefix("done ").and_then(|number| number.parse().ok());
        number.ok_or_else(|| format!("it said `{reply}` to `{command}`"))
    }

    fn reply(&mut self) -> Result<String, String> {
        match self.replies.recv_timeout(PATIENCE) {
            Ok(Ok(line)) => Ok(line.trim_end().to_owned()),
            Ok(Err(cause)) => Err(format!("its answer cannot be read: {cause}")),
            Err(RecvTimeoutError::Timeout) => Err(format!("no answer in {} s", PATIENCE.as_secs())),
            Err(RecvTimeoutError::Disconnected) => Err(match self.ended() {
                Ok(status) => format!("its process ended with {status}"),
                Err(cause) => format!("it says nothing more: {cause}"),
            }),
        }
    }

    /// Closes its input and waits until it has ended, which takes no longer than a moment when it keeps to the protocol.
    fn ended(&mut self) -> Result<ExitStatus, String> {
        drop(self.commands.take());
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE_AT_END {
            if let Some(status) = self.child.try_wait().map_err(|cause| cause.to_string())? {
                return Ok(status);
            }
            thread::sleep(Duration::from_millis(5));
        }
        Err(format!("it has not ended {} s after its input did", PATIENCE_AT_END.as_secs()))
    }
}

impl Drop for Runner<'_> {
    fn drop(&mut self) {
        if let Ok(None) = self.child.try_wait() {
            // It has failed or the driver has: nothing more is wanted of it, and both calls may only find it gone.
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processes_count_by_the_median_of_their_times_and_must_agree() {
        let row = |pose, touching, ns| PeerAnswerRow {
            engine: "one".into(),
            scene: "scene".into(),
            pair: "a:b".into(),
            mode: "first".into(),
            pose,
            line: 0,
            chunk: 0,
            stratum: Stratum::Far,
            exact: 0,
            grazing: 0,
            touching,
            value: None,
            true_value: None,
            ns,
        };
        let rows = [row(0, 0, 30), row(1, 1, 5), row(0, 0, 10), row(1, 1, 0), row(0, 0, 20), row(1, 1, 7)];
        let merged = over_processes(rows.iter()).unwrap();
        assert_eq!(merged, [row(0, 0, 20), row(1, 1, 5)]);
        let differing = over_processes([row(4, 0, 1), row(4, 1, 1)].iter()).unwrap_err();
        assert!(differing.contains("pose 4"), "{differing}");
    }
}

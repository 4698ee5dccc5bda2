//! Long runs: control and watch as processes of their own, over the loopback address, that are judged afterwards by what both wrote down.
//!
//! `program` plays a program to and fro and counts the verdicts that were missed or late. `collision` plays a program that collides, and may
//! kill either side on the way; the exact oracle says when it would have touched. Between the two a [`relay`] may delay and lose.
//!
//! A verdict is wrong when it permits motion, and the machine that is held a deadline after its sample touches before it stands.

use crate::claim;
use crate::config::Config;
use crate::latency::percentile;
use crate::opc::now_ns;
use crate::planted::Exact;
use crate::play::Plan;
use crate::relay::{self, Network};
use crate::trace::Cycle;
use anyhow::{Context as _, Result, anyhow, bail};
use bvbench::record::file::{write_bytes, write_rows};
use bvbench::scene::{ProgramRun, Scene};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{self, File};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio::net::TcpListener;
use tokio::runtime::Runtime;

/// Time between two looks at what control and watch wrote.
const LOOK: Duration = Duration::from_millis(50);
/// Time that a machine must stand, held, before a collision is over; after a kill, so that there is time to come back.
const STANDS: [Duration; 2] = [Duration::from_millis(500), Duration::from_secs(4)];
/// Longest time for one collision.
const LONGEST: Duration = Duration::from_secs(45);
/// Farthest clearance that is written down, mm.
const BEYOND_MM: f64 = 1000.0;

/// A row of `soak.csv`: a program that was played.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SoakRow {
    /// The scene.
    pub scene: String,
    /// The variant.
    pub variant: String,
    /// Cycle of the control.
    pub cycle_ns: u64,
    /// Delay of the network, each way.
    pub delay_ns: u64,
    /// Share of the pieces that it loses.
    pub loss: f64,
    /// Length of the run, from the first confirmed verdict to the last.
    pub run_ns: u64,
    /// Samples that the control had meanwhile.
    pub samples: u64,
    /// Samples without a confirmed verdict.
    pub missed: u64,
    /// From the sample's entry in the server to the confirmation of its verdict: median.
    pub p50_ns: u64,
    /// 99th percentile.
    pub p99_ns: u64,
    /// 99.9th percentile.
    pub p999_ns: u64,
    /// Longest.
    pub max_ns: u64,
    /// Deadline of the configuration.
    pub deadline_ns: u64,
    /// Verdicts that were confirmed later than the deadline.
    pub late: u64,
    /// Times that the watch called for a hold for contact.
    pub contact_holds: u64,
    /// Times that it called for a hold for another cause.
    pub fault_holds: u64,
    /// Times that the machine stopped for any cause, a verdict that came too late among them.
    pub stops: u64,
    /// Share of the cycles in which it moved.
    pub moving: f64,
}

/// A row of `planted.csv`: a collision that was planted.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct PlantedRow {
    /// The scene.
    pub scene: String,
    /// The variant.
    pub variant: String,
    /// Cycle of the control.
    pub cycle_ns: u64,
    /// Delay of the network, each way.
    pub delay_ns: u64,
    /// Share of the pieces that it loses.
    pub loss: f64,
    /// Side that was killed on the way: `none`, `watch` or `control`.
    pub kill: String,
    /// Number of the collision; from it and the seed come its program and the moment of the kill.
    pub collision: u32,
    /// When the program touches, by its own clock.
    pub contact_ns: u64,
    /// How it ended: `held` for contact, `stopped` before it by a deadline, `touched`, or `unfinished` when the machine had not stood for half
    /// a second when the time was over.
    pub end: String,
    /// Time of the program that was left to contact when the hold took effect.
    pub left_ns: u64,
    /// Exact clearance when the hold took effect, mm.
    pub held_mm: f64,
    /// Exact clearance where the machine stood, mm.
    pub stands_mm: f64,
    /// Verdicts that permitted motion, and should not have.
    pub wrong: u64,
    /// From the control's last cycle before the kill to the last in which the machine moved; 0 when it stood, or was killed itself.
    pub moved_ns: u64,
    /// From the kill to the next confirmed verdict that permits motion; 0 when none came before the end.
    pub back_ns: u64,
}

/// Amounts and conditions of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Folder for `soak.csv`, `planted.csv` and the `claims.csv` that follows from the first.
    pub out: PathBuf,
    /// The variant.
    pub variant: String,
    /// How long the program is played, s; 0 to leave it out.
    pub program_s: f64,
    /// Planted collisions.
    pub planted: u32,
    /// Planted collisions with a kill of the watch on the way, and as many with one of the control.
    pub kills: u32,
    /// The network between the two.
    pub network: Network,
    /// Seed of the collisions and kills.
    pub seed: u64,
}

/// A side that is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kill {
    Watch,
    Control,
}

impl Kill {
    const fn name(kill: Option<Self>) -> &'static str {
        match kill {
            None => "none",
            Some(Self::Watch) => "watch",
            Some(Self::Control) => "control",
        }
    }
}

/// A process of this program that is killed when it is dropped.
struct Side(Child);

impl Side {
    fn start(arguments: &[&std::ffi::OsStr], words: &Path) -> Result<Self> {
        let words = File::create(words).with_context(|| format!("cannot create {}", words.display()))?;
        let program = std::env::current_exe().context("the program does not know where it is")?;
        let mut command = Command::new(program);
        command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(words);
        Ok(Self(command.spawn().context("cannot start a process")?))
    }

    fn end(&mut self) {
        // SIGKILL on Unix.
        self.0.kill().ok();
        self.0.wait().ok();
    }

    fn is_over(&mut self) -> bool {
        !matches!(self.0.try_wait(), Ok(None))
    }
}

impl Drop for Side {
    fn drop(&mut self) {
        self.end();
    }
}

/// A scene and its configuration, for many runs.
pub struct Soak<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its configuration.
    pub config: &'a Config,
    /// The program that is played.
    pub run: &'a ProgramRun,
    /// Its file; `None` for the scene's own.
    pub program: Option<&'a Path>,
    /// How much, and under which conditions.
    pub settings: &'a Settings,
}

/// Files and processes of one run.
struct Stage {
    folder: TempDir,
    /// Keeps the relay alive.
    _relay: Option<Runtime>,
}

impl Stage {
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn control(&self, program: Option<&Path>, life: u32, repeats: bool) -> Result<Side> {
        let (config, trace) = (self.path("control.toml"), self.path(&format!("trace-{life}.csv")));
        let mut arguments = vec!["control".as_ref(), config.as_os_str()];
        arguments.extend(program.map(Path::as_os_str));
        arguments.extend(["--trace".as_ref(), trace.as_os_str()]);
        arguments.extend(repeats.then_some::<&std::ffi::OsStr>("--repeat".as_ref()));
        Side::start(&arguments, &self.path(&format!("control-{life}.txt")))
    }

    fn watch(&self, life: u32) -> Result<Side> {
        let (config, log) = (self.path("watch.toml"), self.path(&format!("log-{life}.csv")));
        let arguments = ["watch".as_ref(), config.as_os_str(), "--log".as_ref(), log.as_os_str()];
        Side::start(&arguments, &self.path(&format!("watch-{life}.txt")))
    }

    /// The last line that a process printed.
    fn words(&self, name: &str) -> String {
        let words = fs::read_to_string(self.path(name)).unwrap_or_default();
        words.lines().last().unwrap_or("nothing").to_owned()
    }
}

/// A row of a watch's log, as far as it is needed.
#[derive(Clone, Debug, Deserialize)]
struct Judged {
    source_ns: i64,
    published_ns: i64,
    written_ns: i64,
    holds: bool,
    fault: String,
}

impl Soak<'_> {
    /// Plays and plants; writes a table after each row.
    ///
    /// # Errors
    /// When a process cannot be started or fails, no collision is found, or a table cannot be written.
    pub fn run(&self, exact: &Exact<'_>, told: &mut dyn FnMut(&str)) -> Result<()> {
        let settings = self.settings;
        if settings.program_s > 0.0 {
            let row = self.program()?;
            told(&format!("{row:?}"));
            let same = |other: &SoakRow| {
                (&other.scene, &other.variant, other.cycle_ns, other.delay_ns, other.loss)
                    == (&row.scene, &row.variant, row.cycle_ns, row.delay_ns, row.loss)
            };
            let rows = replace(&settings.out.join("soak.csv"), same, &row)?;
            write_rows(&settings.out, &claim::judge(&rows))?;
        }
        let kills = |kill| (0..settings.kills).map(move |number| (number, Some(kill)));
        let planted = (0..settings.planted).map(|number| (number, None));
        for (number, kill) in planted.chain(kills(Kill::Watch)).chain(kills(Kill::Control)) {
            let row = self.collision(exact, number, kill)?;
            told(&format!("{row:?}"));
            let same = |other: &PlantedRow| {
                (&other.scene, &other.variant, other.cycle_ns, other.delay_ns, other.loss, &other.kill, other.collision)
                    == (&row.scene, &row.variant, row.cycle_ns, row.delay_ns, row.loss, &row.kill, row.collision)
            };
            replace(&settings.out.join("planted.csv"), same, &row)?;
        }
        Ok(())
    }

    /// Files for control and watch, and the relay between them.
    fn stage(&self, latched: bool) -> Result<Stage> {
        let folder = TempDir::new()?;
        let port = std::net::TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
        let control = SocketAddr::from(([127, 0, 0, 1], port));
        // The same port on another address of the computer: a client keeps the port that the server names.
        let near = SocketAddr::from(([127, 0, 0, 2], port));
        let is_bad = self.settings.network.is_bad();
        for (name, address) in [("control.toml", control), ("watch.toml", if is_bad { near } else { control })] {
            fs::write(folder.path().join(name), self.derived(&format!("opc.tcp://{address}/"), latched)?)?;
        }
        let relay = is_bad.then(|| -> Result<Runtime> {
            let runtime = Runtime::new()?;
            let listener =
                runtime.block_on(TcpListener::bind(near)).with_context(|| format!("cannot listen on {near}"))?;
            runtime.spawn(relay::serve(listener, control, self.settings.network));
            Ok(runtime)
        });
        Ok(Stage { folder, _relay: relay.transpose()? })
    }

    /// The configuration with another endpoint and variant; `latched` keeps a hold for contact for ever.
    fn derived(&self, endpoint: &str, latched: bool) -> Result<String> {
        let text = fs::read_to_string(&self.config.file)?;
        let mut table: toml::Table = toml::from_str(&text)?;
        for (key, value) in [("endpoint", endpoint), ("variant", &self.settings.variant), ("scene", &self.config.scene)]
        {
            table.insert(key.to_owned(), value.into());
        }
        if latched {
            table.remove("release_after_s");
        }
        Ok(table.to_string())
    }

    fn program(&self) -> Result<SoakRow> {
        let stage = self.stage(false)?;
        let mut control = stage.control(self.program, 0, true)?;
        let mut watch = stage.watch(0)?;
        let end = Instant::now() + Duration::from_secs_f64(self.settings.program_s);
        while Instant::now() < end {
            thread::sleep(LOOK);
            for (side, name) in [(&mut control, "control-0.txt"), (&mut watch, "watch-0.txt")] {
                if side.is_over() {
                    bail!("a side ended early: {}", stage.words(name));
                }
            }
        }
        drop((watch, control));
        self.soak_row(&rows(&stage.path("log-0.csv"))?, &rows(&stage.path("trace-0.csv"))?)
    }

    fn soak_row(&self, log: &[Judged], trace: &[Cycle]) -> Result<SoakRow> {
        let confirmed: Vec<&Judged> = log.iter().filter(|row| row.written_ns > 0 && row.published_ns > 0).collect();
        let [Some(first), Some(last)] = [confirmed.first(), confirmed.last()] else {
            bail!("no verdict was confirmed")
        };
        let (from, to) = (first.source_ns, last.source_ns);
        let within: Vec<&Cycle> = trace.iter().filter(|cycle| (from..=to).contains(&cycle.source_ns)).collect();
        let mut answered: Vec<i64> = confirmed.iter().map(|row| row.source_ns).collect();
        answered.dedup();
        let mut times: Vec<u64> =
            confirmed.iter().map(|row| u64::try_from(row.written_ns - row.published_ns).unwrap_or(0)).collect();
        times.sort_unstable();
        let deadline_ns = (self.config.deadline_s * 1e9) as u64;
        let holds = |is_contact: bool| {
            let begins = log.windows(2).filter(|pair| !pair[0].holds && pair[1].holds);
            begins.filter(|pair| (pair[1].fault == "contact") == is_contact).count() as u64
        };
        let network = &self.settings.network;
        Ok(SoakRow {
            scene: self.scene.name.clone(),
            variant: self.settings.variant.clone(),
            cycle_ns: (self.config.cycle_s * 1e9).round() as u64,
            delay_ns: network.delay.as_nanos() as u64,
            loss: network.loss,
            run_ns: u64::try_from(to - from).unwrap_or(0),
            samples: within.len() as u64,
            missed: (within.len() as u64).saturating_sub(answered.len() as u64),
            p50_ns: percentile(&times, 0.5),
            p99_ns: percentile(&times, 0.99),
            p999_ns: percentile(&times, 0.999),
            max_ns: percentile(&times, 1.0),
            deadline_ns,
            late: times.iter().filter(|&&time| time > deadline_ns).count() as u64,
            contact_holds: holds(true),
            fault_holds: holds(false),
            stops: within.windows(2).filter(|pair| pair[0].permitted && !pair[1].permitted).count() as u64,
            moving: within.iter().filter(|cycle| cycle.permitted).count() as f64 / within.len().max(1) as f64,
        })
    }

    fn collision(&self, exact: &Exact<'_>, number: u32, kill: Option<Kill>) -> Result<PlantedRow> {
        let dynamics = self.config.dynamics(&self.scene.machine)?;
        let clean = Plan::new(self.scene, self.run, &dynamics, self.config.cycle_s)?;
        let mut random = Pcg64Mcg::seed_from_u64(self.settings.seed ^ (u64::from(number) << 32));
        let text = exact.collision(&clean, &mut random).context("no place is found where the machine would collide")?;
        let stage = self.stage(true)?;
        let program = stage.path("collision.ngc");
        fs::write(&program, &text)?;
        let run = self.run.with_program(&program)?;
        let plan = Plan::new(self.scene, &run, &dynamics, self.config.cycle_s)?;
        let contact_s = exact.first_contact_s(&plan).context("the planted program does not touch")?;
        let kill = kill.map(|side| (side, Duration::from_secs_f64(random.random::<f64>() * contact_s)));
        let tail = play(&stage, &program, kill)?.judge(&stage, contact_s)?;
        let network = &self.settings.network;
        Ok(PlantedRow {
            scene: self.scene.name.clone(),
            variant: self.settings.variant.clone(),
            cycle_ns: (self.config.cycle_s * 1e9).round() as u64,
            delay_ns: network.delay.as_nanos() as u64,
            loss: network.loss,
            kill: Kill::name(kill.map(|(side, _)| side)).to_owned(),
            collision: number,
            contact_ns: (contact_s * 1e9) as u64,
            end: tail.end.to_owned(),
            left_ns: ((contact_s - tail.held_s).max(0.0) * 1e9) as u64,
            held_mm: exact.clearance_mm(&plan.at(tail.held_s).position, plan.at(tail.held_s).tool, BEYOND_MM),
            stands_mm: exact.clearance_mm(&plan.at(tail.stands_s).position, plan.at(tail.stands_s).tool, BEYOND_MM),
            wrong: tail.wrong,
            moved_ns: if matches!(kill, Some((Kill::Watch, _))) { tail.moved_ns } else { 0 },
            back_ns: tail.back_ns,
        })
    }
}

/// What happened while a collision was played.
struct Played {
    killed: Option<Killed>,
    /// Whether the machine stood at the end.
    stands: bool,
}

/// Plays a collision until the machine stands, and kills a side when it has moved for some time.
fn play(stage: &Stage, program: &Path, kill: Option<(Kill, Duration)>) -> Result<Played> {
    let (mut lives, begin) = ([0, 0], Instant::now());
    let mut control = stage.control(Some(program), 0, false)?;
    let mut watch = stage.watch(0)?;
    let (mut moves_since, mut killed) = (None, None);
    let (mut place, mut changed, mut stands) = (0.0, Instant::now(), false);
    while begin.elapsed() < LONGEST {
        // A kill at its moment, and not at the next look.
        let due = kill.zip(moves_since).map(|((side, after), since): (_, Instant)| (side, since + after));
        match due {
            Some((side, at)) if killed.is_none() && at <= Instant::now() + LOOK => {
                thread::sleep(at.saturating_duration_since(Instant::now()));
                let last = last_cycle(&stage.path(&format!("trace-{}.csv", lives[1])));
                let source_ns = last.map_or(0, |cycle| cycle.source_ns);
                killed = Some((Killed { source_ns, at_ns: now_ns() }, Instant::now()));
                lives[side as usize] += 1;
                match side {
                    Kill::Watch => {
                        watch.end();
                        watch = stage.watch(lives[0])?;
                    }
                    Kill::Control => {
                        control.end();
                        control = stage.control(Some(program), lives[1], false)?;
                    }
                }
            }
            _ => thread::sleep(LOOK),
        }
        if watch.is_over() {
            bail!("the watch ended early: {}", stage.words(&format!("watch-{}.txt", lives[0])));
        }
        let Some(last) = last_cycle(&stage.path(&format!("trace-{}.csv", lives[1]))) else { continue };
        if last.time_s != place {
            (place, changed) = (last.time_s, Instant::now());
            moves_since.get_or_insert(changed);
        }
        stands = changed.elapsed() >= STANDS[0] && !last.permitted;
        let is_held =
            fs::read_to_string(stage.path(&format!("log-{}.csv", lives[0]))).is_ok_and(|log| log.contains(",contact,"));
        let is_back = kill.is_none() || killed.is_some_and(|(_, at)| at.elapsed() >= STANDS[1]);
        if control.is_over() || stands && moves_since.is_some() && is_held && is_back {
            break;
        }
    }
    Ok(Played { killed: killed.map(|(at, _)| at), stands })
}

/// When a side was killed.
#[derive(Clone, Copy, Debug)]
struct Killed {
    /// By the control's clock, which begins with the control and is behind the other: its last cycle before.
    source_ns: i64,
    /// By the clock of the computer.
    at_ns: i64,
}

/// How a collision ended.
struct Tail {
    end: &'static str,
    held_s: f64,
    stands_s: f64,
    wrong: u64,
    moved_ns: u64,
    back_ns: u64,
}

impl Played {
    fn judge(&self, stage: &Stage, contact_s: f64) -> Result<Tail> {
        let lives = |name: &'static str| (0..2).map(move |life| format!("{name}-{life}.csv"));
        let mut trace: Vec<Cycle> = Vec::new();
        let mut last_life = 0;
        for file in lives("trace").map(|name| stage.path(&name)).filter(|path| path.exists()) {
            last_life = trace.len();
            trace.extend(rows::<Cycle>(&file)?);
        }
        let mut log: Vec<Judged> = Vec::new();
        for file in lives("log").map(|name| stage.path(&name)).filter(|path| path.exists()) {
            log.extend(rows::<Judged>(&file)?);
        }
        let reach: HashMap<i64, f64> = trace.iter().map(|cycle| (cycle.source_ns, cycle.reach_s)).collect();
        let is_wrong =
            |row: &&Judged| !row.holds && reach.get(&row.source_ns).is_some_and(|&reach_s| reach_s >= contact_s);
        let touched = trace.iter().any(|cycle| cycle.time_s >= contact_s);
        let held = log.iter().any(|row| row.fault == "contact");
        let own = &trace[last_life..];
        let last = own.iter().rposition(|cycle| cycle.permitted);
        let held_s = last.map_or(0.0, |at| own[at].time_s);
        let moved_ns = self.killed.map_or(0, |killed| moved_ns(&trace, killed.source_ns));
        let back_ns = self.killed.map_or(0, |killed| back_ns(&log, killed.at_ns));
        Ok(Tail {
            end: end(touched, held, self.stands),
            held_s,
            stands_s: own.last().map_or(0.0, |cycle| cycle.time_s),
            wrong: log.iter().filter(is_wrong).count() as u64,
            moved_ns,
            back_ns,
        })
    }
}

/// Name of an end.
const fn end(touched: bool, held: bool, stands: bool) -> &'static str {
    match (touched, stands, held) {
        (true, ..) => "touched",
        (_, false, _) => "unfinished",
        (_, _, true) => "held",
        _ => "stopped",
    }
}

/// How long the machine moved on after a cycle, ns; 0 when it stood.
fn moved_ns(trace: &[Cycle], source_ns: i64) -> u64 {
    let behind = trace.iter().filter(|cycle| cycle.source_ns > source_ns);
    let last = behind.take_while(|cycle| cycle.permitted).last();
    last.map_or(0, |cycle| u64::try_from(cycle.source_ns - source_ns).unwrap_or(0))
}

/// From a kill to the next confirmed verdict that permits motion, ns; 0 when none came.
fn back_ns(log: &[Judged], at_ns: i64) -> u64 {
    let next = log.iter().find(|row| !row.holds && row.written_ns > at_ns);
    next.map_or(0, |row| u64::try_from(row.written_ns - at_ns).unwrap_or(0))
}

/// The last whole cycle of a trace.
fn last_cycle(trace: &Path) -> Option<Cycle> {
    use std::io::{Read as _, Seek as _, SeekFrom};
    let mut file = File::open(trace).ok()?;
    let length = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(512))).ok()?;
    let mut text = String::new();
    file.read_to_string(&mut text).ok()?;
    let whole = &text[..=text.rfind('\n')?];
    let last = whole.lines().last()?.as_bytes();
    csv::ReaderBuilder::new().has_headers(false).from_reader(last).into_deserialize().next()?.ok()
}

/// The rows of a table; one that a kill cut short is left out when it is the last.
fn rows<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>> {
    let mut text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    text.truncate(text.rfind('\n').map_or(0, |at| at + 1));
    let rows: Result<Vec<T>, _> = csv::Reader::from_reader(text.as_bytes()).deserialize().collect();
    rows.with_context(|| format!("{} is not what was written", path.display()))
}

/// Puts a row in the place of those that are about the same; all rows of the table.
fn replace<T: Clone + DeserializeOwned + Serialize>(path: &Path, same: impl Fn(&T) -> bool, row: &T) -> Result<Vec<T>> {
    let mut all: Vec<T> = if path.exists() { rows(path)? } else { Vec::new() };
    all.retain(|other| !same(other));
    all.push(row.clone());
    let mut writer = csv::Writer::from_writer(Vec::new());
    all.iter().try_for_each(|row| writer.serialize(row))?;
    write_bytes(path, &writer.into_inner().map_err(|error| anyhow!("{error}"))?)?;
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_machine_that_moves_when_the_time_is_over_was_not_stopped() {
        assert_eq!(end(false, false, false), "unfinished");
        assert_eq!(end(false, true, false), "unfinished");
        assert_eq!((end(false, true, true), end(false, false, true)), ("held", "stopped"));
        assert_eq!(end(true, true, false), "touched");
    }
}

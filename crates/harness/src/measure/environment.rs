//! What the program is, what machine it runs on, and whether something else is running there.

use super::{binaries, sources};
use crate::record::command::command_line;
use crate::record::manifest::{MachineFacts, Program};
use obbtree::engine::Simd;
use serde::{Deserialize, Serialize};
use std::fs;
use std::sync::OnceLock;

/// What a program was built from, as its build script noted it; all empty when nobody told.
#[derive(Clone, Copy, Debug, Default)]
pub struct Build {
    /// Folder of the package.
    pub root: &'static str,
    /// Fingerprint of the source.
    pub fingerprint: &'static str,
    /// Git revision.
    pub revision: &'static str,
    /// Whether there were local changes, `true` or `false`.
    pub dirty: &'static str,
    /// Compiler.
    pub rustc: &'static str,
    /// Target triple.
    pub target: &'static str,
    /// Level of optimisation.
    pub opt_level: &'static str,
    /// Flags of the compiler.
    pub rustflags: &'static str,
}

static BUILD: OnceLock<Build> = OnceLock::new();

/// Says what this program was built from, before anything asks. The program says it, not this crate: a changed variant would build the
/// whole harness again for the sake of a fingerprint.
pub fn tell(build: Build) {
    BUILD.get_or_init(|| build);
}

fn build() -> Build {
    BUILD.get().copied().unwrap_or_default()
}

/// What this program is and how it was called, as it was at the first call: a commit or a new build changes no program that runs.
pub fn program() -> Program {
    static PROGRAM: OnceLock<Program> = OnceLock::new();
    PROGRAM.get_or_init(running_program).clone()
}

fn running_program() -> Program {
    let (revision, dirty) = revision();
    // Only the program's name, not the folder it lies in: the record is for others.
    let mut arguments = std::env::args_os().map(|argument| argument.to_string_lossy().into_owned());
    let name = arguments.next().unwrap_or_default();
    let name = std::path::Path::new(&name).file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let command = command_line(std::iter::once(name).chain(arguments));
    let hash = binaries::running().map_or_else(String::new, |binary| binary.hash);
    Program { hash, git_revision: revision, git_dirty: dirty, command, ..built() }
}

/// What a binary was built from, by its own account: two of equal identity differ in layout at most, but for what a crate of somebody else's adds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// bvbench's version.
    pub version: String,
    /// Fingerprint of the source; empty when it was unknown.
    pub source: String,
    /// Git revision when it was built; empty when unknown.
    pub revision: String,
    /// Compiler.
    pub rustc: String,
    /// Optimisation and target flags.
    pub flags: String,
}

/// What this binary was built from.
pub fn identity() -> Identity {
    let Program { version, source, rustc, flags, .. } = built();
    Identity { version, source, revision: build().revision.to_owned(), rustc, flags }
}

impl Identity {
    /// What differs from another one, with both values. Of known sources the fingerprint tells, else the revision.
    pub fn difference(&self, other: &Self) -> Option<(&'static str, String, String)> {
        let pairs = [
            ("version", &self.version, &other.version),
            ("source", &self.source, &other.source),
            ("compiler", &self.rustc, &other.rustc),
            ("set of flags", &self.flags, &other.flags),
        ];
        let revision = [("revision", &self.revision, &other.revision)];
        let asked = pairs.iter().chain(revision.iter().filter(|_| self.source.is_empty()));
        asked.filter(|(_, mine, others)| mine != others).map(|(name, a, b)| (*name, (*a).clone(), (*b).clone())).next()
    }
}

/// What the build script noted, without what a run adds.
fn built() -> Program {
    let Build { fingerprint, rustc, target, opt_level, rustflags, .. } = build();
    Program {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        source: fingerprint.to_owned(),
        rustc: rustc.to_owned(),
        flags: format!("target {target}, opt-level {opt_level}, RUSTFLAGS `{rustflags}`"),
        ..Program::default()
    }
}

/// The size of the machine's largest cache, bytes; 0 where the system does not tell.
pub fn largest_cache_bytes() -> u64 {
    let sizes = (0..8).map(|index| format!("/sys/devices/system/cpu/cpu0/cache/index{index}/size"));
    sizes.filter_map(|file| kib(&fs::read_to_string(file).ok()?)).max().unwrap_or(0)
}

/// Bytes of a size as the system writes it: `512K`, `32M`.
fn kib(text: &str) -> Option<u64> {
    let text = text.trim();
    let (number, unit) = text.split_at(text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len()));
    let shift = match unit {
        "" => 0,
        "K" => 10,
        "M" => 20,
        "G" => 30,
        _ => return None,
    };
    number.parse::<u64>().ok()?.checked_shl(shift)
}

/// The git revision of the source, and whether there were local changes: as it is now where the checkout still holds what the program was
/// built from, else as it was when it was built.
fn revision() -> (String, Option<bool>) {
    let built = build();
    let root = std::path::Path::new(built.root);
    let is_same = |now: &u64| now.to_string() == built.fingerprint;
    let now = sources::fingerprint(root).filter(is_same).and_then(|_| sources::checkout(root));
    let then = || (built.revision.to_owned(), built.dirty.parse().ok());
    now.map_or_else(then, |(revision, dirty)| (revision, Some(dirty)))
}

/// The machine, as far as Linux's `/proc` or the standard library tells.
pub fn machine() -> MachineFacts {
    let field = |file: &str, key: &str| {
        let text = fs::read_to_string(file).unwrap_or_default();
        let line = text.lines().find(|line| line.starts_with(key)).map(str::to_owned);
        line.and_then(|line| line.split_once(':').map(|(_, value)| value.trim().to_owned())).unwrap_or_default()
    };
    let memory_kib = field("/proc/meminfo", "MemTotal").split(' ').next().and_then(|n| n.parse::<u64>().ok());
    let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
    MachineFacts {
        cpu: field("/proc/cpuinfo", "model name"),
        simd: Simd::in_use().name().to_owned(),
        cores: std::thread::available_parallelism().map_or(0, std::num::NonZero::get),
        memory_bytes: memory_kib.unwrap_or(0) * 1024,
        os: format!("{} {}", std::env::consts::OS, kernel.trim()).trim().to_owned(),
        load: load_average(),
    }
}

fn load_average() -> Option<f64> {
    fs::read_to_string("/proc/loadavg").ok()?.split(' ').next()?.parse().ok()
}

/// Processor time used so far, in clock ticks: by everything on the machine, by this process, and taken by the host.
#[derive(Clone, Copy, Debug)]
pub struct BusyMeter {
    everything: u64,
    own: u64,
    stolen: u64,
    elapsed: u64,
}

/// What else the processors did between two readings, in cores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// Cores kept busy by other processes.
    pub others: f64,
    /// Cores the host gave to somebody else.
    pub stolen: f64,
}

impl BusyMeter {
    /// A reading; `None` where the system does not tell.
    pub fn read() -> Option<Self> {
        Self::of(&fs::read_to_string("/proc/stat").ok()?, &fs::read_to_string("/proc/self/stat").ok()?)
    }

    /// The reading in the texts of `/proc/stat` and `/proc/self/stat`.
    fn of(stat: &str, own: &str) -> Option<Self> {
        let fields = stat.lines().next()?.strip_prefix("cpu ")?;
        // user nice system idle iowait irq softirq steal (proc(5)); summed over all processors, those that this process may not use included.
        let ticks: Vec<u64> = fields.split_whitespace().take(8).map_while(|field| field.parse().ok()).collect();
        let &[user, nice, system, idle, iowait, irq, softirq, stolen] = ticks.as_slice() else { return None };
        let is_processor =
            |line: &&str| line.strip_prefix("cpu").is_some_and(|n| n.starts_with(|c: char| c.is_ascii_digit()));
        let processors = stat.lines().filter(is_processor).count() as u64;
        let everything = user + nice + system + irq + softirq;
        // The second field, the name in parentheses, may hold spaces; utime and stime are fields 14 and 15.
        let own: Vec<u64> =
            own.rsplit_once(')')?.1.split_whitespace().skip(11).take(2).map_while(|field| field.parse().ok()).collect();
        let elapsed = (everything + idle + iowait + stolen).checked_div(processors)?;
        Some(Self { everything, own: own.iter().sum(), stolen, elapsed })
    }

    /// What happened since an earlier reading; `None` when no time has passed.
    pub fn since(&self, earlier: &Self) -> Option<Disturbance> {
        let elapsed = self.elapsed.checked_sub(earlier.elapsed).filter(|&ticks| ticks > 0)? as f64;
        let everything = self.everything.saturating_sub(earlier.everything);
        let own = self.own.saturating_sub(earlier.own);
        Some(Disturbance {
            others: everything.saturating_sub(own) as f64 / elapsed,
            stolen: self.stolen.saturating_sub(earlier.stolen) as f64 / elapsed,
        })
    }
}

impl Disturbance {
    /// Above this many cores in use by others a run is called noisy. A quiet desktop stays below a tenth; one busy loop is
    /// a whole core.
    const NOISY_OTHERS: f64 = 0.3;
    /// Above this many cores stolen by the host a run is called noisy.
    const NOISY_STOLEN: f64 = 0.1;

    /// A sentence when it was too much.
    pub fn complaint(&self) -> Option<String> {
        if self.others > Self::NOISY_OTHERS {
            return Some(format!("other processes kept {:.1} cores busy while timing", self.others));
        }
        (self.stolen > Self::NOISY_STOLEN).then(|| format!("the host took away {:.1} cores while timing", self.stolen))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_caches() {
        assert_eq!(
            [kib("512K\n"), kib("32M"), kib("100"), kib("many")],
            [Some(524_288), Some(33_554_432), Some(100), None]
        );
    }

    #[test]
    fn a_binary_of_another_source_is_told_apart() {
        let here = identity();
        assert_eq!(here.difference(&here), None);
        let other = Identity { source: "1".into(), ..here.clone() };
        assert_eq!(other.difference(&here).map(|d| d.0), Some("source"));
        // A commit alone does not change what is built.
        let committed = Identity { source: "1".into(), revision: "later".into(), ..here.clone() };
        assert_eq!(committed.difference(&other), None);
        let unknown = |revision: &str| Identity { source: String::new(), revision: revision.into(), ..here.clone() };
        assert_eq!(unknown("a").difference(&unknown("b")).map(|d| d.0), Some("revision"));
    }

    /// Four processors for 100 ticks, one of them busy with something else: one core, also for a process that may use one of the four alone.
    #[test]
    fn processors_are_those_of_the_statistics() {
        let stat = |busy: u64, idle: u64| {
            let each = "cpu0 1 0 0 0 0 0 0 0 0 0\ncpu1 1 0 0 0 0 0 0 0 0 0\ncpu2 1 0 0 0 0 0 0 0 0 0\ncpu3 1 0 0 0 0 0 0 0 0 0";
            format!("cpu  {busy} 0 0 {idle} 0 0 0 0 0 0\n{each}\nintr 5\n")
        };
        let own = |ticks: u64| format!("7 (a (b) c) S 1 1 1 0 -1 0 0 0 0 0 {ticks} 0 0 0");
        let reading = |busy, idle, ticks| BusyMeter::of(&stat(busy, idle), &own(ticks)).unwrap();
        let found = reading(1200, 1200, 100).since(&reading(1000, 1000, 0)).unwrap();
        assert_eq!(found, Disturbance { others: 1.0, stolen: 0.0 });
        assert!(BusyMeter::of("cpu  1 0 0 1 0 0 0 0 0 0\n", &own(0)).is_none(), "no line of a processor");
    }

    #[test]
    fn a_busy_loop_beside_us_is_noise_and_our_own_work_is_not() {
        let reading = |everything, own, elapsed| BusyMeter { everything, own, stolen: 0, elapsed };
        let quiet = reading(1100, 100, 2000).since(&reading(1000, 0, 1900)).unwrap();
        assert_eq!(quiet, Disturbance { others: 0.0, stolen: 0.0 });
        assert_eq!(quiet.complaint(), None);
        let disturbed = reading(1200, 100, 2000).since(&reading(1000, 0, 1900)).unwrap();
        assert!((disturbed.others - 1.0).abs() < 1e-12); // 200 ticks, 100 of them ours, in 100 ticks of time
        assert!(disturbed.complaint().is_some());
    }
}

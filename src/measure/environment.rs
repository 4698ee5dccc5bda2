//! What the program is, what machine it runs on, and whether something else is running there.

use super::sources;
use crate::record::manifest::{MachineFacts, Program};
use obbtree::engine::Simd;
use std::fs;

/// What this program was built from and how it was called.
#[must_use]
pub fn program() -> Program {
    let (revision, dirty) = revision();
    // Only the program's name, not the folder it lies in: the record is for others.
    let mut arguments = std::env::args();
    let name = arguments.next().unwrap_or_default();
    let name = std::path::Path::new(&name).file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    Program {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        git_revision: revision,
        git_dirty: dirty,
        rustc: env!("BVBENCH_RUSTC").to_owned(),
        flags: format!(
            "target {}, opt-level {}, RUSTFLAGS `{}`",
            env!("BVBENCH_TARGET"),
            env!("BVBENCH_OPT_LEVEL"),
            env!("BVBENCH_RUSTFLAGS")
        ),
        command: std::iter::once(name).chain(arguments).collect::<Vec<_>>().join(" "),
    }
}

/// The git revision of the source, and whether there were local changes: as it is now where the checkout still holds what the program was
/// built from, else as it was when it was built.
fn revision() -> (String, Option<bool>) {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let is_same = |now: &u64| now.to_string() == env!("BVBENCH_FINGERPRINT");
    let now = sources::fingerprint(root).filter(is_same).and_then(|_| sources::checkout(root));
    let then = || (env!("BVBENCH_GIT_REVISION").to_owned(), env!("BVBENCH_GIT_DIRTY").parse().ok());
    now.map_or_else(then, |(revision, dirty)| (revision, Some(dirty)))
}

/// The machine, as far as Linux's `/proc` or the standard library tells.
#[must_use]
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
    #[must_use]
    pub fn read() -> Option<Self> {
        let cores = std::thread::available_parallelism().ok()?.get() as u64;
        let stat = fs::read_to_string("/proc/stat").ok()?;
        let fields = stat.lines().next()?.strip_prefix("cpu ")?;
        // user nice system idle iowait irq softirq steal (proc(5)); summed over all processors.
        let ticks: Vec<u64> = fields.split_whitespace().take(8).map_while(|field| field.parse().ok()).collect();
        let &[user, nice, system, idle, iowait, irq, softirq, stolen] = ticks.as_slice() else { return None };
        let everything = user + nice + system + irq + softirq;
        let own = fs::read_to_string("/proc/self/stat").ok()?;
        // The second field, the name in parentheses, may hold spaces; utime and stime are fields 14 and 15.
        let own: Vec<u64> =
            own.rsplit_once(')')?.1.split_whitespace().skip(11).take(2).map_while(|field| field.parse().ok()).collect();
        let elapsed = (everything + idle + iowait + stolen) / cores;
        Some(Self { everything, own: own.iter().sum(), stolen, elapsed })
    }

    /// What happened since an earlier reading; `None` when no time has passed.
    #[must_use]
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
    #[must_use]
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

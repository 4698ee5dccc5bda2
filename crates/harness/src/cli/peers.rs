//! `peers`: whole engines side by side, ours and others, each in a process of its own.

use super::options::{truth_cache, use_threads};
use super::progress::Bar;
use super::{CLEAR, FAILED, note, say, style};
use crate::analysis::peers::{Setting, summarise};
use crate::measure::peers::drive::{self, Amounts, Comparison};
use crate::measure::peers::engine::{self, Engine};
use crate::measure::peers::posed::PosedMeshes;
use crate::measure::peers::verify::{self, Verdict};
use crate::measure::peers::{Mode, answer, motions, posed};
use crate::measure::{Plan, Profile, Selection, environment};
use crate::method::Kind;
use crate::record::peers::ALL_STRATA;
use crate::record::rows::Row;
use crate::record::{
    FolderLock, PeerRatioRow, PeerRow, PeerTimingRow, Stratum, has_rows, merge_rows, read_rows, read_rows_if_there,
    write_text,
};
use crate::registry::{Registry, Variant};
use crate::tree::Policy;
use crate::truth::TruthCache;
use anyhow::{Context, Result, ensure};
use clap::{Args, Subcommand};
use comfy_table::Table;
use obbtree::engine::{Coherence, Simd};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[derive(Args)]
#[command(
    after_help = "Examples:\n  scripts/peers/run --quick              install, build and compare the engines there are runners for\n  bvbench peers export --scene lathe-toolpost --out DIR\n  bvbench peers run --scene lathe-toolpost --out DIR --variant ID --runner 'mine=path/to/runner --flag'\n  bvbench peers verify --scene lathe-toolpost --out DIR --runner 'mine=path/to/runner'\n  bvbench peers run --engines target/peers/engines.toml --engine fcl-obb --mode path-0.05 --out DIR\n  bvbench peers run --mode batch --processes 3 --out DIR --engines target/peers/engines.toml\n  bvbench peers table --out DIR --against NAME\n\nHow to write a runner: docs/adding-a-peer.md"
)]
pub struct Options {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Write meshes, poses and truth of a scene as NPY files
    Export(ExportOptions),
    /// Ask all engines about the same poses in turn, and hold their times and verdicts side by side
    Run(CompareOptions),
    /// Compare the answers of engines with exact truth, before any timing; exit code 1 when one is wrong
    #[command(
        after_help = "Examples:\n  bvbench peers verify --out DIR --runner 'mine=path/to/runner'\n  bvbench peers verify --mode distance --tolerance-mm 1e-5 --out DIR --engines target/peers/engines.toml --engine fcl-obbrss\n  bvbench peers verify --mode path-0.01 --out DIR --variant ID+evidence"
    )]
    Verify(VerifyOptions),
    /// Show the comparison in a folder again, of all scenes and modes whose raw rows are there
    Table(TableOptions),
    /// Answer as one of our variants, by the protocol on standard input and output
    Runner(RunnerOptions),
}

/// Which poses.
#[derive(Args)]
struct PoseOptions {
    /// Scene by name or by path; repeatable [default: two lathes and a 5-axis mill]
    #[arg(long = "scene", value_name = "NAME|PATH")]
    scenes: Vec<String>,
    /// Folder for all files
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What is asked: first (does it collide?), path (the same in steps of 0.02 mm; path-STEP for others, as in path-0.05), all (touching pairs of
    /// triangles), distance, batch (as first, many poses at once on all cores), motion (when do they touch first between two poses?)
    #[arg(long, default_value = "first", value_name = "MODE")]
    mode: Mode,
    /// About how many poses per scene, or motions: equal shares for strata, pairs and workloads, each rounded down to whole chunks of 64. Each share is
    /// one chunk at least, of fewer poses where there are not so many
    #[arg(long, default_value_t = 2048, value_name = "N")]
    poses: usize,
    /// Seed of all randomness
    #[arg(long, default_value_t = 2011)]
    seed: u64,
    /// Threads for finding the truth; engines use one, but in mode batch [default: all cores]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Folder in which exact answers are kept for the next time [default: .truth-cache in the folder for all files]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Print no progress
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Args)]
struct ExportOptions {
    #[command(flatten)]
    poses: PoseOptions,
}

/// Which engines.
#[derive(Args)]
struct EngineOptions {
    /// A file of engines: a TOML table [[engine]] for each, with name, version, build and command; repeatable
    #[arg(long = "engines", value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Only these of the engines of --engines; repeatable [default: all]
    #[arg(long = "engine", value_name = "NAME", requires = "files")]
    names: Vec<String>,
    /// A runner, as NAME=PROGRAM ARGUMENTS; repeatable
    #[arg(long = "runner", value_name = "NAME=COMMAND")]
    runners: Vec<String>,
    /// A variant of ours, as ID, with @POLICY for another tree, +axis, +witness or +evidence for what mode path may keep from pose to pose, and
    /// +avx512, +avx2 or +portable for one of this machine's instruction sets; repeatable [default: the reference variant and the peers in the
    /// registry]
    #[arg(long = "variant", value_name = "ID[@POLICY][+OPTION]...")]
    variants: Vec<String>,
}

#[derive(Args)]
struct CompareOptions {
    #[command(flatten)]
    poses: PoseOptions,
    #[command(flatten)]
    engines: EngineOptions,
    /// Timed rounds of each process
    #[arg(long, default_value_t = 5, value_name = "N")]
    rounds: u32,
    /// Processes of each engine, one after the other: where a process puts its data tells on its times
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    processes: u32,
    /// The engine that the others are compared with; of several the first that takes part [default: the first runner, else the
    /// first variant]
    #[arg(long, value_name = "NAME")]
    against: Vec<String>,
}

#[derive(Args)]
struct VerifyOptions {
    #[command(flatten)]
    poses: PoseOptions,
    #[command(flatten)]
    engines: EngineOptions,
    /// How far off a distance may be, mm
    #[arg(long, default_value_t = 1e-6, value_name = "MM")]
    tolerance_mm: f64,
}

#[derive(Args)]
struct TableOptions {
    /// Folder of the comparison
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// The engine that the others are compared with; of several the first that took part
    #[arg(long, value_name = "NAME", required = true)]
    against: Vec<String>,
    /// Seed of the intervals
    #[arg(long, default_value_t = 2011)]
    seed: u64,
}

#[derive(Args)]
struct RunnerOptions {
    /// Variant by id (see `list`)
    #[arg(long, value_name = "ID")]
    variant: String,
    /// Tree policy SPLIT[/AXES[/LEAF]] [default: the variant's own]
    #[arg(long, value_name = "POLICY")]
    policy: Option<Policy>,
    /// What a query of mode path may use of the one before: none, axis, witness or evidence; by variants that can
    #[arg(long, value_name = "WHAT", default_value_t)]
    coherence: Coherence,
    /// Instruction set of wide variants: avx512, avx2 or portable [default: the widest of this machine]
    #[arg(long, value_name = "SET")]
    simd: Option<String>,
    /// first, path, all, distance, batch or motion
    mode: Mode,
    /// Folder of the pair
    pair: PathBuf,
    /// Folder for the answers
    out: PathBuf,
    /// How often at most each pose is asked about
    rounds: usize,
}

pub fn run(options: &Options, registry: &Registry) -> Result<u8> {
    match &options.what {
        What::Export(options) => export(&options.poses, registry)?,
        What::Run(options) => return compare(options, registry),
        What::Verify(options) => return verify_all(options, registry),
        What::Table(options) => table_again(options)?,
        What::Runner(options) => answer_as(options, registry)?,
    }
    Ok(CLEAR)
}

impl PoseOptions {
    fn plan(&self, registry: &Registry) -> Result<Plan> {
        use_threads(self.threads)?;
        // No more than the scenes, the program's workload and the seed are used of it.
        let workloads = if matches!(self.mode, Mode::Path(_)) { vec!["program".to_owned()] } else { Vec::new() };
        let selection = Selection {
            profile: Profile::Quick,
            scenes: self.scenes.clone(),
            variants: Vec::new(),
            workloads,
            policies: Vec::new(),
            seed: self.seed,
        };
        Ok(Plan::new(selection, registry)?)
    }

    /// Names of the scenes, and what is asked of each: those of the plan, and in mode `motion` thin walls.
    fn scenes<'a>(
        &'a self,
        plan: &'a Plan,
        cache: &'a TruthCache,
        bar: &'a Bar,
    ) -> impl Iterator<Item = Result<(&'a str, Vec<PosedMeshes>)>> {
        let of_scene = move |scene: &'a crate::scene::Scene| {
            let found = posed::questions(plan, scene, self.mode, self.poses, Some(cache), bar)?;
            let folders: BTreeSet<PathBuf> =
                found.iter().map(|posed| drive::pair_folder(&self.out, &scene.name, &posed.pair)).collect();
            ensure!(
                folders.len() == found.len(),
                "{}: two pairs of parts would have one folder, as their names differ in signs alone: rename a part",
                scene.name
            );
            Ok((scene.name.as_str(), found))
        };
        let planted =
            (self.mode == Mode::Motion).then(|| Ok((motions::THIN_WALLS, motions::thin_walls(self.poses, self.seed))));
        plan.scenes.iter().map(of_scene).chain(planted)
    }

    fn cache(&self) -> Result<TruthCache> {
        let folder = self.cache.clone().unwrap_or_else(|| self.out.join(".truth-cache"));
        truth_cache(&folder)
    }
}

fn export(options: &PoseOptions, registry: &Registry) -> Result<()> {
    let (plan, cache) = (options.plan(registry)?, options.cache()?);
    let bar = Bar::new(options.quiet);
    for found in options.scenes(&plan, &cache, &bar) {
        let (scene, pairs) = found?;
        for posed in pairs {
            let folder = drive::pair_folder(&options.out, scene, &posed.pair);
            posed.write(&folder)?;
            let touching = posed.questions.iter().filter(|question| question.exact).count();
            bar.finish();
            say(format!("{} ({} poses, {touching} touching)", folder.display(), posed.questions.len()));
        }
    }
    Ok(())
}

/// Exit code: 1 when an engine failed on some pair.
fn compare(options: &CompareOptions, registry: &Registry) -> Result<u8> {
    let asked = &options.poses;
    ensure!(options.rounds > 0, "--rounds 0: at least one round is needed");
    let engines = engines(&options.engines, Unnamed::TakePart, registry)?;
    let against = match options.against.as_slice() {
        [] => vec![engines[0].name.clone()],
        names => names.to_vec(),
    };
    let _lock = FolderLock::take(&asked.out)?;
    ensure_there(&asked.out, &against, engines.iter().map(|engine| engine.name.clone()))?;
    let (plan, cache) = (asked.plan(registry)?, asked.cache()?);
    write_setting(options, &engines)?;
    let bar = Bar::new(asked.quiet);
    let (rounds, processes) = (options.rounds, options.processes);
    let amounts = Amounts { mode: asked.mode, rounds, processes, seed: asked.seed };
    let (mut failed, mut due) = (false, BTreeSet::new());
    for pairs in asked.scenes(&plan, &cache, &bar) {
        let (scene, pairs) = pairs?;
        let found = drive::compare(&engines, scene, &pairs, amounts, &asked.out, &bar)?;
        bar.finish();
        for skipped in &found.skipped {
            note(format!("SKIPPED: {skipped}"));
        }
        failed |= !found.skipped.is_empty();
        keep(&asked.out, scene, &found, asked.mode)?;
        due.insert((scene.to_owned(), asked.mode.to_string()));
    }
    show(&asked.out, &against, asked.seed, Some(due))?;
    Ok(if failed { FAILED } else { CLEAR })
}

/// Exit code: 1 when an engine failed or an answer is wrong.
fn verify_all(options: &VerifyOptions, registry: &Registry) -> Result<u8> {
    let asked = &options.poses;
    ensure!(options.tolerance_mm >= 0.0, "--tolerance-mm {}: a distance is at least 0 mm off", options.tolerance_mm);
    let engines = engines(&options.engines, Unnamed::StayOut, registry)?;
    let names: Vec<&str> = engines.iter().map(|engine| engine.name.as_str()).collect();
    let (plan, cache) = (asked.plan(registry)?, asked.cache()?);
    let bar = Bar::new(asked.quiet);
    let amounts = Amounts { mode: asked.mode, rounds: 0, processes: 1, seed: asked.seed };
    let mut failed = false;
    for pairs in asked.scenes(&plan, &cache, &bar) {
        let (scene, pairs) = pairs?;
        let found = drive::compare(&engines, scene, &pairs, amounts, &asked.out, &bar)?;
        bar.finish();
        for skipped in &found.skipped {
            note(format!("SKIPPED: {skipped}"));
        }
        let verdicts = verify::verdicts(&names, &found, asked.mode, options.tolerance_mm);
        say(format!("\n{scene}, mode {}:\n", asked.mode));
        say(verified(&verdicts).trim_fmt());
        for verdict in &verdicts {
            if let Some(wrong) = &verdict.first_wrong {
                let folder = drive::pair_folder(&asked.out, scene, &wrong.pair);
                let (pose, said, truth) = (wrong.pose, wrong.said, wrong.truth);
                note(format!("{}: pose {pose} of {}: said {said}, truth {truth}", verdict.engine, folder.display()));
            }
        }
        failed |= !found.skipped.is_empty() || !verdicts.iter().all(Verdict::is_right);
    }
    Ok(if failed { FAILED } else { CLEAR })
}

/// A row per engine.
fn verified(verdicts: &[Verdict]) -> Table {
    let mut table = table(["POSES", "MISSED", "FALSE+", "WRONG VALUES", "LARGEST ERROR", "VERDICT"]);
    for verdict in verdicts {
        table.add_row([
            verdict.engine.clone(),
            verdict.poses.to_string(),
            verdict.missed.to_string(),
            verdict.invented.to_string(),
            verdict.wrong_values.to_string(),
            verdict.largest_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.1e}")),
            if verdict.is_right() { "right" } else { "WRONG" }.to_owned(),
        ]);
    }
    table
}

/// Writes what was asked of whom, by what program on what machine, beside the rows.
fn write_setting(options: &CompareOptions, engines: &[Engine]) -> Result<()> {
    let asked = &options.poses;
    // This program by its name: where it lies says nothing elsewhere.
    let own = own_file()?;
    let named = |engine: &Engine| {
        let command = engine.command.iter().map(|word| if *word == own { "bvbench".to_owned() } else { word.clone() });
        Engine { command: command.collect(), ..engine.clone() }
    };
    let setting = serde_json::json!({
        "program": environment::program(),
        "machine": environment::machine(),
        "mode": asked.mode.id(),
        "poses": asked.poses,
        "rounds": options.rounds,
        "seed": asked.seed,
        "processes": options.processes,
        "engines": engines.iter().map(named).collect::<Vec<_>>(),
    });
    let text = serde_json::to_string_pretty(&setting)? + "\n";
    Ok(write_text(&asked.out.join(format!("peers-{}.json", asked.mode)), &text)?)
}

/// Whether our reference and the peers in the registry take part where no variant but other engines are named.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Unnamed {
    TakePart,
    StayOut,
}

fn own_file() -> Result<String> {
    let own = std::env::current_exe().context("this program's own file cannot be found")?;
    Ok(own.to_str().context("this program's path is not UTF-8")?.to_owned())
}

/// The engines of files, the runners, then our variants.
fn engines(options: &EngineOptions, unnamed: Unnamed, registry: &Registry) -> Result<Vec<Engine>> {
    let own = own_file()?;
    let mut engines = Vec::new();
    for file in &options.files {
        engines.extend(engine::read(file)?);
    }
    if let Some(name) = options.names.iter().find(|name| engines.iter().all(|engine| engine.name != **name)) {
        let known: Vec<&str> = engines.iter().map(|engine| engine.name.as_str()).collect();
        anyhow::bail!("--engine {name}: the files of --engines have {}", known.join(", "));
    }
    engines.retain(|engine| options.names.is_empty() || options.names.contains(&engine.name));
    for runner in &options.runners {
        let (name, command) = runner.split_once('=').with_context(|| format!("`{runner}` is not NAME=COMMAND"))?;
        let command: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
        ensure!(!name.is_empty() && !command.is_empty(), "`{runner}` is not NAME=COMMAND");
        engines.push(Engine::new(name, command).map_err(anyhow::Error::msg)?);
    }
    let is_default = |variant: &&Variant| variant.is_reference || variant.kind == Kind::Peer;
    let asked: Vec<String> = match options.variants.as_slice() {
        [] if unnamed == Unnamed::TakePart || engines.is_empty() => {
            registry.variants().iter().filter(is_default).map(|variant| variant.info.id.to_owned()).collect()
        }
        ids => ids.to_vec(),
    };
    for name in asked {
        let command = own_command(&own, &name, registry)?;
        let version = env!("CARGO_PKG_VERSION").to_owned();
        engines.push(Engine { name, version, build: "this program".to_owned(), command });
    }
    let twice = engines.iter().enumerate().find(|(i, engine)| engines[..*i].iter().any(|e| e.name == engine.name));
    if let Some((_, engine)) = twice {
        anyhow::bail!("two of the engines are called `{}`", engine.name);
    }
    ensure!(!engines.is_empty(), "there is no engine to compare; name one with --runner or --variant");
    Ok(engines)
}

/// How this program `own` is called to answer as ID[@POLICY][+OPTION]...
fn own_command(own: &str, name: &str, registry: &Registry) -> Result<Vec<String>> {
    let mut parts = name.split('+');
    let variant = parts.next().unwrap_or_default();
    let (id, policy) = variant.split_once('@').map_or((variant, None), |(id, policy)| (id, Some(policy)));
    find(registry, id)?;
    let mut command = [own, "peers", "runner", "--variant", id].map(str::to_owned).to_vec();
    if let Some(policy) = policy {
        let policy: Policy = policy.parse()?;
        command.extend(["--policy".to_owned(), policy.to_string()]);
    }
    for option in parts {
        let flag = if option.parse::<Coherence>().is_ok() { "--coherence" } else { "--simd" };
        if flag == "--simd" {
            simd(option).with_context(|| format!("`{name}`"))?;
        }
        command.extend([flag.to_owned(), option.to_owned()]);
    }
    Ok(command)
}

fn simd(name: &str) -> Result<Simd> {
    Simd::named(name).with_context(|| {
        let here: Vec<&str> = Simd::available().into_iter().map(Simd::name).collect();
        format!("`{name}` is none of this machine's instruction sets: {}", here.join(", "))
    })
}

fn find<'a>(registry: &'a Registry, id: &str) -> Result<&'a Variant> {
    registry.find(id).with_context(|| format!("there is no variant `{id}`; `bvbench list` shows them"))
}

/// Puts a scene's rows in the place of earlier ones of the same scene and mode.
fn keep(folder: &Path, scene: &str, found: &Comparison, mode: Mode) -> Result<()> {
    let is_other = |row_scene: &str, row_mode: &str| row_scene != scene || row_mode != mode.to_string();
    merge_rows(folder, &found.builds, |row| is_other(&row.scene, &row.mode))?;
    merge_rows(folder, &found.timings, |row| is_other(&row.scene, &row.mode))?;
    merge_rows(folder, &found.answers, |row| is_other(&row.scene, &row.mode))?;
    Ok(())
}

fn answer_as(options: &RunnerOptions, registry: &Registry) -> Result<()> {
    let variant = find(registry, &options.variant)?;
    let RunnerOptions { policy, coherence, mode, pair, out, rounds, .. } = options;
    if let Some(name) = &options.simd {
        ensure!(simd(name)?.choose(), "--simd {name}: another instruction set is in use already");
    }
    let (commands, replies) = (std::io::stdin().lock(), std::io::stdout().lock());
    Ok(answer::run(variant, *policy, *coherence, *mode, pair, out, *rounds, commands, replies)?)
}

/// Refuses to compare with engines of which neither the record in a folder nor `others` has one; without any engine there is more to say than that.
fn ensure_there(folder: &Path, against: &[String], others: impl Iterator<Item = String>) -> Result<()> {
    let timings: Vec<PeerTimingRow> = read_rows_if_there(folder)?;
    let there: BTreeSet<String> = timings.into_iter().map(|row| row.engine).chain(others).collect();
    ensure!(
        there.is_empty() || against.iter().any(|name| there.contains(name)),
        "--against {}: no such engine takes part; there are {}",
        against.join(", "),
        there.iter().map(String::as_str).collect::<Vec<_>>().join(", ")
    );
    Ok(())
}

/// Derives the tables of a folder anew from its raw rows and shows them. Of a published record, which has none, shows those that were derived.
fn table_again(options: &TableOptions) -> Result<()> {
    let TableOptions { out, against, seed } = options;
    if has_rows::<PeerTimingRow>(out) {
        ensure_there(out, against, std::iter::empty())?;
        return show(out, against, *seed, None);
    }
    let (rows, mut ratios): (Vec<PeerRow>, Vec<PeerRatioRow>) = (read_rows(out)?, read_rows(out)?);
    let references: BTreeSet<String> = ratios.iter().map(|row| row.reference.clone()).collect();
    ratios.retain(|row| against.contains(&row.reference));
    ensure!(
        !ratios.is_empty(),
        "--against {}: {} has no raw rows, and its ratios are those to {}",
        against.join(", "),
        out.display(),
        references.into_iter().collect::<Vec<_>>().join(", ")
    );
    note(format!("{} has no raw rows: these are the tables that were derived from them", out.display()));
    show_rows(out, against, &rows, &ratios);
    Ok(())
}

/// Derives the tables of the settings that are due, or of all with raw rows, and shows them.
fn show(folder: &Path, against: &[String], seed: u64, due: Option<BTreeSet<Setting>>) -> Result<()> {
    let (rows, ratios) = summarise(folder, against, seed, due)?;
    show_rows(folder, against, &rows, &ratios);
    Ok(())
}

fn show_rows(folder: &Path, against: &[String], rows: &[PeerRow], ratios: &[PeerRatioRow]) {
    let mut settings: Vec<(&str, &str)> = rows.iter().map(|row| (row.scene.as_str(), row.mode.as_str())).collect();
    settings.sort_unstable();
    settings.dedup();
    for (scene, mode) in settings {
        let is_here = |s: &str, m: &str| s == scene && m == mode;
        let rows: Vec<&PeerRow> =
            rows.iter().filter(|row| is_here(&row.scene, &row.mode) && row.stratum == ALL_STRATA).collect();
        let ratios: Vec<&PeerRatioRow> = ratios.iter().filter(|row| is_here(&row.scene, &row.mode)).collect();
        let compared = ratios.first().map_or_else(
            || format!("{} did not take part", against.join(", ")),
            |ratio| format!("times faster than {}", ratio.reference),
        );
        say(format!("\n{scene}, mode {mode}, {} poses; {compared}:\n", rows[0].poses));
        say(times(&rows, &ratios).trim_fmt());
        say("");
        say(by_stratum(&rows, &ratios).trim_fmt());
        if mode == Mode::Batch.id() {
            say("");
            say(throughput(&rows).trim_fmt());
        }
    }
    say(format!("\nRows: {}", folder.join(PeerRow::FILE).display()));
}

/// A table of engines, whose names are aligned left and all else right.
fn table<S: AsRef<str>>(header: impl IntoIterator<Item = S>) -> Table {
    style::plain(
        std::iter::once("ENGINE".to_owned()).chain(header.into_iter().map(|name| format!(">{}", name.as_ref()))),
    )
}

/// A row per engine, the fastest first.
fn times(rows: &[&PeerRow], ratios: &[&PeerRatioRow]) -> Table {
    let mut table = table([
        "MEAN us",
        "FASTER",
        "95 %",
        "MEDIAN us",
        "P99 us",
        "FASTER",
        "MISSED",
        "FALSE+",
        "ERROR",
        "BUILD ms",
        "BYTES/TRI",
    ]);
    let mut rows = rows.to_vec();
    rows.sort_by(|x, y| x.mean_ns.total_cmp(&y.mean_ns));
    for row in rows {
        let micro = |ns: f64| format!("{:.3}", ns / 1e3);
        let ratio = ratios.iter().find(|ratio| ratio.engine == row.engine && ratio.stratum == ALL_STRATA);
        let (faster, interval, tail) = ratio.map_or_else(Default::default, |ratio| {
            (format!("{:.2}", ratio.ratio), ends(ratio).unwrap_or_default(), format!("{:.2}", ratio.p99_ratio))
        });
        table.add_row([
            row.engine.clone(),
            micro(row.mean_ns),
            faster,
            interval,
            micro(row.median_ns),
            micro(row.p99_ns),
            tail,
            row.false_negatives.to_string(),
            row.false_positives.to_string(),
            row.largest_error.map_or_else(|| "-".to_owned(), |error| format!("{error:.1e}")),
            format!("{:.2}", row.build_ns as f64 / 1e6),
            if row.bytes == 0 { "-".to_owned() } else { format!("{:.0}", row.bytes as f64 / row.triangles as f64) },
        ]);
    }
    table
}

/// The ends of a ratio's interval; `None` of a single chunk, which has none.
fn ends(row: &PeerRatioRow) -> Option<String> {
    (row.low.is_finite() && row.high.is_finite()).then(|| format!("{:.2} to {:.2}", row.low, row.high))
}

/// Poses per second on all cores, a row per engine.
fn throughput(rows: &[&PeerRow]) -> Table {
    let mut table = table(["POSES PER SECOND"]);
    for row in rows {
        table.add_row([row.engine.clone(), format!("{:.0}", 1e9 / row.mean_ns)]);
    }
    table
}

/// Times faster in each stratum.
fn by_stratum(rows: &[&PeerRow], ratios: &[&PeerRatioRow]) -> Table {
    let strata = Stratum::ALL.map(Stratum::id);
    let mut table = table(strata.map(str::to_uppercase));
    for row in rows {
        let cells = strata.map(|stratum| {
            let ratio = ratios.iter().find(|ratio| ratio.engine == row.engine && ratio.stratum == stratum);
            ratio.map_or_else(String::new, |row| {
                format!("{:.2}{}", row.ratio, ends(row).map_or_else(String::new, |ends| format!(" ({ends})")))
            })
        });
        table.add_row(std::iter::once(row.engine.clone()).chain(cells));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::write_rows;

    /// Of several names one is enough, of the record or of what is asked now.
    #[test]
    fn an_engine_to_compare_with_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let timing = PeerTimingRow {
            engine: "fast".to_owned(),
            scene: "mill".to_owned(),
            pair: "a:b".to_owned(),
            mode: "first".to_owned(),
            stratum: Stratum::Far,
            chunk: 0,
            poses: 64,
            round: 0,
            ns: 1,
        };
        write_rows(folder.path(), &[timing]).unwrap();
        let asked = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
            ensure_there(folder.path(), &names, ["slow".to_owned()].into_iter())
        };
        assert!(asked(&["nobody", "fast"]).is_ok() && asked(&["slow"]).is_ok());
        let refused = asked(&["nobody"]).unwrap_err().to_string();
        assert_eq!(refused, "--against nobody: no such engine takes part; there are fast, slow");
    }

    #[test]
    fn a_ratio_without_an_interval_stands_alone() {
        let [engine, reference, scene, stratum, mode] = ["a", "b", "c", "all", "first"].map(str::to_owned);
        let mut row =
            PeerRatioRow { engine, reference, scene, stratum, mode, ratio: 1.5, low: 1.25, high: 2.0, p99_ratio: 1.5 };
        assert_eq!(ends(&row).as_deref(), Some("1.25 to 2.00"));
        (row.low, row.high) = (f64::NAN, f64::NAN);
        assert_eq!(ends(&row), None);
    }
}

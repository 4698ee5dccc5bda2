//! Options that several verbs share.

use super::repetitions::Repetitions;
use crate::analysis::claims;
use crate::measure::shard::Shard;
use crate::measure::{Plan, Profile, Run, Selection};
use crate::record::Manifest;
use crate::record::manifest::Stage;
use crate::registry::Registry;
use crate::scene::{Clearance, Clearances, Scene};
use crate::tree::Policy;
use crate::truth::TruthCache;
use anyhow::{Context, Result, anyhow, ensure};
use clap::Args;
use std::path::{Path, PathBuf};

/// Seed unless another is given: the year of the paper.
pub const DEFAULT_SEED: u64 = 2011;

/// How near parts may come.
#[derive(Args)]
pub struct ClearanceOptions {
    /// Tell when parts come nearer than this, mm; 0 for not at all; repeatable. For some pairs alone: NAME=MM or NAME:NAME=MM, each NAME a part or a role (machine,
    /// workpiece, cutter, shank, holder, fixture); the closest description of a pair holds [default: the scene's, else 14, 8 and 2]
    #[arg(long = "clearance", value_name = "[NAME[:NAME]=]MM", allow_negative_numbers = true)]
    clearances: Vec<Clearance>,
}

impl ClearanceOptions {
    /// The clearances asked for; `None` for those of the scene.
    pub fn read(&self, scene: &Scene) -> Result<Option<Clearances>> {
        if self.clearances.is_empty() {
            return Ok(None);
        }
        for clearance in &self.clearances {
            clearance.check_names(&scene.parts).map_err(|message| anyhow!("--clearance: {message}"))?;
        }
        Ok(Some(Clearances::new(self.clearances.clone())))
    }
}

/// What to measure, and where to put it.
#[derive(Args, Clone)]
pub struct RunOptions {
    /// Scene by name or by path; repeatable [default: two lathes and a 5-axis mill]
    #[arg(long = "scene", value_name = "NAME|PATH")]
    scenes: Vec<String>,
    /// Carry out one part of the plan, to be put together with the others by `stage merge`: the I-th of N
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    #[command(flatten)]
    extent: Extent,
    #[command(flatten)]
    pub output: OutputOptions,
}

/// How much of it to measure, with what, and where to put it.
#[derive(Args, Clone)]
pub struct Extent {
    /// How much: smoke (two minutes), quick (five minutes), full (hours)
    #[arg(long, default_value = "quick", value_name = "PROFILE")]
    profile: Profile,
    /// Folder of the run [default: below results, by profile or scene]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Variant by id (see `list`), or `all`; repeatable [default: the standard ones]
    #[arg(long = "variant", value_name = "ID")]
    variants: Vec<String>,
    /// Workload by name: program, approach, random, recorded; repeatable [default: all]
    #[arg(long = "workload", value_name = "NAME")]
    workloads: Vec<String>,
    /// Tree policy SPLIT[/AXES[/LEAF]], as in median/shared/4; repeatable [default: each variant's own, and median/shared/1]
    #[arg(long = "policy", value_name = "POLICY")]
    policies: Vec<Policy>,
    /// Seed of all randomness
    #[arg(long, default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Threads for everything but timing, where only wide trees are built by more than one [default: all cores]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    #[command(flatten)]
    repetitions: Repetitions,
    /// Folder in which exact answers are kept for the next run [default: .truth-cache beside the run's folder]
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Replace a run of another request that is in the folder
    #[arg(long)]
    pub fresh: bool,
}

/// How results are shown.
#[derive(Args, Clone, Copy)]
pub struct OutputOptions {
    /// Print the result as JSON
    #[arg(long)]
    pub json: bool,
    /// Print no progress
    #[arg(long, short)]
    pub quiet: bool,
}

/// How a study is carried out.
#[derive(Args, Clone, Copy)]
pub struct StudyOptions {
    /// Time nothing
    #[arg(long)]
    pub counts_only: bool,
    /// Carry out one shard, number I of N; its units stay in DIR for `stage merge`
    #[arg(long, value_name = "I/N", requires = "out")]
    pub shard: Option<Shard>,
    /// Seed of all randomness
    #[arg(long, default_value_t = DEFAULT_SEED)]
    pub seed: u64,
    /// Threads for everything but timing, which uses one [default: all cores]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

/// Which finished run.
#[derive(Args, Clone)]
pub struct FolderOptions {
    /// Folder of the run
    #[arg(long, default_value = "results/quick", value_name = "DIR")]
    pub out: PathBuf,
    /// Take raw rows that changed since the run wrote them
    #[arg(long)]
    pub accept_changed_rows: bool,
}

impl FolderOptions {
    /// The folder of a run that is measured, its raw rows being those that the run wrote.
    ///
    /// # Errors
    /// When it holds no such run, or changed rows that are not accepted.
    pub fn checked(&self) -> Result<&Path> {
        check_rows(&self.out, self.accept_changed_rows)?;
        Ok(&self.out)
    }

    /// Like [`Self::checked`], of a run that is analysed too.
    ///
    /// # Errors
    /// Those of [`Self::checked`], and when the run is not analysed.
    pub fn analysed(&self) -> Result<&Path> {
        let (folder, path) = (self.checked()?, self.out.display());
        let is_there = folder.join(claims::FILE).exists();
        ensure!(is_there, "{path} is not analysed: run `bvbench stage analyze --out {path}` first");
        Ok(folder)
    }
}

/// Checks that a run is verified and measured, and that its raw rows are those that it wrote, unless others are accepted.
///
/// # Errors
/// When the folder holds no such run, or changed rows.
pub fn check_rows(folder: &Path, accept: bool) -> Result<()> {
    let manifest = Manifest::read(folder)?;
    let stages = [(Stage::Verify, "`bvbench stage verify`"), (Stage::Measure, "`bvbench stage measure`")];
    let lacking = stages.into_iter().filter(|(stage, _)| !manifest.finished.contains(stage));
    let lacking: Vec<&str> = lacking.map(|(_, command)| command).collect();
    let (folder_name, commands) = (folder.display(), lacking.join(" and then "));
    ensure!(
        lacking.is_empty(),
        "{folder_name} is not finished: complete it with {commands} and the run's own options first"
    );
    if !accept {
        manifest.check_rows(folder)?;
    }
    Ok(())
}

impl RunOptions {
    /// The folder of exact answers.
    pub fn cache_folder(&self) -> PathBuf {
        self.extent.cache_folder(&self.folder())
    }

    fn folder(&self) -> PathBuf {
        let profile = self.extent.profile.id();
        self.extent.folder(
            &self
                .shard
                .map_or_else(|| profile.to_owned(), |Shard { number, of }| format!("{profile}-shard-{number}-of-{of}")),
        )
    }

    /// Loads what was asked for and opens its run.
    ///
    /// # Errors
    /// When something named does not exist, or the folder cannot be used.
    pub fn open(&self, registry: &Registry) -> Result<Run> {
        self.extent.open((&self.scenes, self.shard), &self.folder(), registry)
    }
}

impl Extent {
    /// The run's folder, unless one is given that of this name below `results`.
    pub fn folder(&self, name: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| Path::new("results").join(name))
    }

    /// The folder of exact answers of a run in `folder`.
    pub fn cache_folder(&self, folder: &Path) -> PathBuf {
        self.cache.clone().unwrap_or_else(|| {
            let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty());
            parent.unwrap_or(Path::new(".")).join(".truth-cache")
        })
    }

    /// Loads what was asked for of `scenes`, or a shard of it, and opens its run in `folder`.
    ///
    /// # Errors
    /// When something named does not exist, or the folder cannot be used.
    pub fn open(&self, (scenes, shard): (&[String], Option<Shard>), folder: &Path, registry: &Registry) -> Result<Run> {
        use_threads(self.threads)?;
        let mut plan = self.repetitions.apply(Plan::new(self.selection(scenes), registry)?)?;
        plan.shard = shard;
        open_run(plan, folder, &self.cache_folder(folder), self.fresh)
    }

    /// The plan of what was asked for of one scene, whose path or name is given; `load` loads it.
    ///
    /// # Errors
    /// When the scene cannot be loaded, or something named does not exist.
    pub fn plan_of(&self, scene: &str, load: impl FnOnce() -> Result<Scene>, registry: &Registry) -> Result<Plan> {
        use_threads(self.threads)?;
        let plan = Plan::of_scenes(self.selection(&[scene.to_owned()]), [Ok(load()?)], registry)?;
        self.repetitions.apply(plan)
    }

    fn selection(&self, scenes: &[String]) -> Selection {
        Selection {
            profile: self.profile,
            scenes: scenes.to_vec(),
            variants: self.variants.clone(),
            workloads: self.workloads.clone(),
            policies: self.policies.clone(),
            seed: self.seed,
        }
    }
}

/// Opens a run with its cache.
///
/// # Errors
/// When one of the folders cannot be used.
pub fn open_run(plan: Plan, folder: &Path, cache: &Path, fresh: bool) -> Result<Run> {
    refuse_file("--out", folder)?;
    let run = Run::open(plan, folder, fresh)?;
    Ok(run.with_cache(truth_cache(cache)?))
}

/// A number on the command line.
///
/// # Errors
/// When it is none.
pub fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("`{text}` is not a number"))
}

/// Makes the folder that an option names, with those it lies in.
///
/// # Errors
/// When it is a file, or cannot be made.
pub fn make_folder(option: &str, folder: &Path) -> Result<()> {
    refuse_file(option, folder)?;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))
}

/// Refuses a file where an option names a folder.
fn refuse_file(option: &str, folder: &Path) -> Result<()> {
    ensure!(!folder.is_file(), "{option} {}: this is a file; name a folder", folder.display());
    Ok(())
}

/// Opens the folder in which exact answers are kept.
pub fn truth_cache(folder: &Path) -> Result<TruthCache> {
    TruthCache::at(folder).context("exact answers cannot be kept; name another folder with --out or --cache")
}

/// Most threads per core of the machine, and most on machines of few cores: more only wait for one another, for minutes.
const MOST_PER_CORE: usize = 4;
const MOST_ON_FEW_CORES: usize = 256;

/// Sets how many threads everything but timing uses.
///
/// # Errors
/// When there are none, or more than any machine can use.
pub fn use_threads(threads: Option<usize>) -> Result<()> {
    let Some(threads) = threads else { return Ok(()) };
    ensure!(threads > 0, "--threads 0: at least one thread is needed");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let most = (MOST_PER_CORE * cores).max(MOST_ON_FEW_CORES);
    ensure!(threads <= most, "--threads {threads}: at most {most} are started");
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().context("threads cannot be started")
}

//! The audit: a full factorial experiment on what makes a tree of boxes good.
//!
//! Four factors are crossed: how the boxes are oriented, where their centres lie, where nodes are divided, and how many
//! triangles a leaf holds ([`cell`]). Every cell gets the same chunks of poses as every other. Counts and trees are
//! deterministic; times are taken beside a reference cell, in blocks of random order, so that what the machine does
//! meanwhile strikes both.
//!
//! A unit is one cell on one scene: an audit that was killed goes on with the units it lacks.

mod axes;
pub mod cell;
mod count;
mod memory;
mod time;

use self::memory::Memory;
use super::chunk::{self, Chunk, Participants};
use super::folder::{self, UNITS, write_unit};
use super::judged::{self, JudgedPair, Strata};
use super::plan::{Plan, PlanError, Selection};
use super::run::new_manifest;
use super::{MeasureError, Profile, Progress, Silent};
use crate::record::manifest::Stage;
use crate::record::{
    AuditAxisRow, AuditBuildRow, AuditRow, AuditTimingRow, AuditTreeRow, Manifest, Row, Stratum, read_rows, write_rows,
};
use crate::registry::Registry;
use crate::scene::Scene;
use crate::truth::TruthCache;
use cell::Cell;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// What an audit leaves in its folder beside the manifest and the units.
const FILES: [&str; 10] = [
    AuditRow::FILE,
    AuditTreeRow::FILE,
    AuditAxisRow::FILE,
    AuditTimingRow::FILE,
    AuditBuildRow::FILE,
    crate::record::AuditCellRow::FILE,
    crate::record::AuditEffectRow::FILE,
    crate::record::AuditShareRow::FILE,
    "audit.md",
    "plots",
];
/// How many times more poses are generated than measured, so that every stratum fills its share.
const POSE_RESERVE: usize = 4;

/// How much an audit does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Amount {
    /// Chunks of each stratum and scene, at most.
    chunks: usize,
    /// Timed blocks, after the warm-up.
    blocks: u32,
}

const fn amount(profile: Profile) -> Amount {
    match profile {
        Profile::Smoke => Amount { chunks: 1, blocks: 1 },
        Profile::Quick => Amount { chunks: 4, blocks: 2 },
        Profile::Full => Amount { chunks: 32, blocks: 8 },
    }
}

/// An audit: scenes, cells, and the folder it is carried out in.
#[derive(Debug)]
pub struct Audit {
    folder: PathBuf,
    plan: Plan,
    cells: Vec<Cell>,
    amount: Amount,
    manifest: Manifest,
    cache: Option<TruthCache>,
    _lock: crate::record::FolderLock,
}

/// What a scene's cells are asked: its chosen poses with their truth.
struct Questions<'a> {
    scene: &'a Scene,
    judged: Vec<JudgedPair>,
    chunks: Vec<Chunk>,
}

impl Audit {
    /// What an audit of some scenes (all that are asked for by default) would do.
    ///
    /// # Errors
    /// When a scene cannot be loaded.
    pub fn plan(profile: Profile, scenes: Vec<String>, seed: u64, registry: &Registry) -> Result<Plan, PlanError> {
        let selection =
            Selection { profile, scenes, variants: Vec::new(), workloads: Vec::new(), policies: Vec::new(), seed };
        let mut plan = Plan::new(selection, registry)?;
        // The cells take the place of the variants.
        (plan.variants, plan.cases) = (Vec::new(), Vec::new());
        let amount = amount(profile);
        (plan.budget.verify_poses, plan.budget.launches, plan.budget.blocks) = (0, 1, amount.blocks);
        Ok(plan)
    }

    /// Opens an audit's folder: a new one, or one to go on with. Only cells of `orientations` and with leaves of `leaves` triangles are audited,
    /// when any are named; `fresh` replaces an audit of another request.
    ///
    /// # Errors
    /// When there is no such orientation or leaf size, or the folder holds something else or cannot be written.
    pub fn open(
        plan: Plan,
        orientations: &[String],
        leaves: &[u8],
        folder: &Path,
        fresh: bool,
    ) -> Result<Self, MeasureError> {
        let amount = amount(plan.selection.profile);
        let mut cells = Cell::all();
        if let Some(asked) = orientations.iter().find(|asked| cells.iter().all(|cell| cell.orientation != *asked)) {
            let mut known: Vec<&str> = cells.iter().map(|cell| cell.orientation).collect();
            known.dedup();
            return Err(MeasureError::NoSuchOrientation { asked: asked.clone(), known: known.join(", ") });
        }
        if let Some(&asked) = leaves.iter().find(|asked| !cell::LEAVES.contains(asked)) {
            return Err(MeasureError::NoSuchLeaf {
                asked,
                known: cell::LEAVES.map(|leaf| leaf.to_string()).join(", "),
            });
        }
        cells.retain(|cell| orientations.is_empty() || orientations.iter().any(|asked| asked == cell.orientation));
        cells.retain(|cell| leaves.is_empty() || leaves.contains(&cell.leaf));
        let mut manifest = new_manifest(&plan);
        manifest.request.policies = cells.iter().map(Cell::name).collect();
        let (manifest, lock) = folder::open(folder, manifest, fresh, &FILES)?;
        Ok(Self { folder: folder.to_owned(), plan, cells, amount, manifest, cache: None, _lock: lock })
    }

    /// The same audit with a place where exact answers are kept.
    #[must_use]
    pub fn with_cache(mut self, cache: TruthCache) -> Self {
        self.cache = Some(cache);
        self
    }

    /// The audit's folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Number of cells.
    #[must_use]
    pub const fn cells(&self) -> usize {
        self.cells.len()
    }

    /// Carries the audit out, or what is lacking of it, and writes its raw records; without `timed`, only the deterministic
    /// ones.
    ///
    /// # Errors
    /// When poses cannot be judged or files cannot be written.
    pub fn run(&mut self, timed: bool, progress: &dyn Progress) -> Result<(), MeasureError> {
        for scene in &self.plan.scenes {
            self.run_scene(scene, timed, progress)?;
        }
        self.join::<AuditRow>("counts")?;
        self.join::<AuditTreeRow>("counts")?;
        let mut axes: Vec<AuditAxisRow> = Vec::new();
        for scene in &self.plan.scenes {
            axes.extend(read_rows::<AuditAxisRow>(&self.axes_unit(scene))?);
        }
        write_rows(&self.folder, &axes)?;
        if timed {
            self.join::<AuditTimingRow>("times")?;
            self.join::<AuditBuildRow>("times")?;
            self.manifest.finished = vec![Stage::Measure];
            self.manifest.write(&self.folder)?;
        }
        Ok(())
    }

    fn run_scene(&self, scene: &Scene, timed: bool, progress: &dyn Progress) -> Result<(), MeasureError> {
        let lacking = |kind: &str| -> Vec<&Cell> {
            self.cells.iter().filter(|cell| !self.unit(kind, scene, cell).exists()).collect()
        };
        let (uncounted, untimed) = (lacking("counts"), if timed { lacking("times") } else { Vec::new() });
        if uncounted.is_empty() && untimed.is_empty() && self.axes_unit(scene).exists() {
            return Ok(());
        }
        let questions = self.questions(scene, progress)?;
        if !self.axes_unit(scene).exists() {
            let rows = axes::axes(&questions);
            write_unit(&self.axes_unit(scene), |folder| write_rows(folder, &rows))?;
        }
        progress.begin(&format!("{}: counting {} cells", scene.name, self.cells.len()), uncounted.len() as u64);
        let memory = Memory::default();
        uncounted.par_iter().try_for_each(|cell| {
            let (rows, trees) = count::count(cell, &questions, &memory);
            progress.advance(1);
            write_unit(&self.unit("counts", scene, cell), |folder| {
                write_rows(folder, &rows)?;
                write_rows(folder, &trees)
            })
        })?;
        if untimed.is_empty() {
            return Ok(());
        }
        progress.begin(&format!("{}: timing {} cells", scene.name, self.cells.len()), untimed.len() as u64);
        let reference = time::Reference::of(&questions);
        for cell in untimed {
            let (rows, builds) = time::time(cell, &reference, &questions, self.amount.blocks, self.plan.selection.seed);
            write_unit(&self.unit("times", scene, cell), |folder| {
                write_rows(folder, &rows)?;
                write_rows(folder, &builds)
            })?;
            progress.advance(1);
        }
        Ok(())
    }

    fn questions<'a>(&self, scene: &'a Scene, progress: &dyn Progress) -> Result<Questions<'a>, MeasureError> {
        let poses = self.plan.budget.measure_poses;
        progress.begin(&format!("{}: exact truth", scene.name), 1);
        let count = poses * POSE_RESERVE;
        let judged = judged::judge(&self.plan, scene, count, Strata::Sought, self.cache.as_ref(), &Silent)?;
        let chunks = chosen(&chunk::select_windows(&judged, poses, chunk::LONG), self.amount.chunks);
        Ok(Questions { scene, judged, chunks })
    }

    fn unit(&self, kind: &str, scene: &Scene, cell: &Cell) -> PathBuf {
        self.folder.join(UNITS).join(kind).join(&scene.name).join(cell.name())
    }

    fn axes_unit(&self, scene: &Scene) -> PathBuf {
        self.folder.join(UNITS).join("axes").join(&scene.name)
    }

    fn join<R: Row>(&self, kind: &str) -> Result<(), MeasureError> {
        let mut rows: Vec<R> = Vec::new();
        for scene in &self.plan.scenes {
            for cell in &self.cells {
                rows.extend(read_rows::<R>(&self.unit(kind, scene, cell))?);
            }
        }
        Ok(write_rows(&self.folder, &rows)?)
    }
}

/// At most `most` chunks of each stratum, evenly spread; those of the control are left out.
fn chosen(chunks: &[Chunk], most: usize) -> Vec<Chunk> {
    let mut kept = Vec::new();
    for stratum in Stratum::ALL {
        let of_it: Vec<&Chunk> = chunks
            .iter()
            .filter(|chunk| chunk.stratum == stratum && chunk.participants != Participants::Control)
            .collect();
        let count = of_it.len().min(most);
        kept.extend((0..count).map(|i| of_it[(2 * i + 1) * of_it.len() / (2 * count)].clone()));
    }
    kept
}

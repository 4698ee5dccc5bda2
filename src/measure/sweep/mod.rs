//! Sweeps: one quantity varied, everything else held.
//!
//! Every sweep is a named experiment on two parametric bodies ([`mod@stage`]), so that it needs no files. The lines along which
//! the bodies meet are the same at every value of the quantity, and every variant answers the same poses; along each
//! line one pose lies 1 mm before first contact and one 1 mm past it, unless the sweep itself says where.
//!
//! A unit is one value of the quantity: a sweep that was killed goes on with the values it lacks.

mod flip;
mod precision;
pub mod stage;
mod step;
mod time;

use super::folder::{self, UNITS, write_unit};
use super::plan::{Case, PlanError, choose};
use super::{MeasureError, Profile, Progress, environment};
use crate::geometry::Isometry;
use crate::method::{Kind, Model};
use crate::record::manifest::{PROTOCOL, Request, SCHEMA, Stage, VariantEntry};
use crate::record::{Manifest, Row, Stratum, SweepBuildRow, SweepRow, SweepTimingRow, read_rows, write_rows};
use crate::registry::{Registry, Variant};
use crate::tree::Policy;
use crate::truth::PairOracle;
use rayon::prelude::*;
use stage::{Bodies, Quantity, stage};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use thiserror::Error;

/// What a sweep leaves in its folder beside the manifest and the units.
const FILES: [&str; 6] = [
    SweepRow::FILE,
    SweepTimingRow::FILE,
    SweepBuildRow::FILE,
    crate::record::SweepSummaryRow::FILE,
    crate::record::SweepGrowthRow::FILE,
    "plots",
];
/// Groups that the lines are dealt out to: what is resampled.
const GROUPS: u32 = 12;

/// A named sweep.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    /// Name on the command line.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// What its horizontal axis measures, with the unit.
    pub axis: &'static str,
    quantity: Quantity,
    values: &'static [f64],
}

/// All sweeps.
pub const SWEEPS: [Sweep; 9] = [
    Sweep {
        name: "grading",
        about: "triangles moved from large faces (below 1) to fine detail (above 1), at the same shape and about the same number",
        axis: "grading",
        quantity: Quantity::Grading,
        values: &[0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0],
    },
    Sweep {
        name: "flips",
        about: "share of the diagonals of plane quadrilaterals that are flipped: another triangulation of the same surface",
        axis: "share of diagonals flipped",
        quantity: Quantity::Flips,
        values: &[0.0, 0.25, 0.5, 0.75, 1.0],
    },
    Sweep {
        name: "size",
        about: "density of the tessellation; x is the number of triangles of both bodies",
        axis: "triangles of both bodies",
        quantity: Quantity::Size,
        values: &[0.06, 0.12, 0.25, 0.5, 1.0, 2.0, 4.0, 10.0],
    },
    Sweep {
        name: "offset",
        about: "distance before first contact along the line of approach, mm; below 0 past it",
        axis: "distance before first contact, mm",
        quantity: Quantity::Offset,
        values: &[-5.0, -2.0, -1.0, -0.1, -0.01, 0.01, 0.1, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0],
    },
    Sweep {
        name: "rotation",
        about: "turn of both bodies in their own frames, degrees; nothing moves in the world",
        axis: "turn of the frames, degrees",
        quantity: Quantity::Rotation,
        values: &[0.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0],
    },
    Sweep {
        name: "aspect",
        about: "length over width of a bar of constant volume that meets the fixture",
        axis: "length over width",
        quantity: Quantity::Aspect,
        values: &[1.0, 2.0, 5.0, 10.0, 20.0, 50.0],
    },
    Sweep {
        name: "step",
        about: "distance of the samples on a path into contact, mm: how late is the contact reported?",
        axis: "distance of samples, mm",
        quantity: Quantity::Step,
        values: &[0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0],
    },
    Sweep {
        name: "leaf",
        about: "most triangles in a leaf",
        axis: "triangles in a leaf",
        quantity: Quantity::Leaf,
        values: &[1.0, 2.0, 4.0, 8.0],
    },
    Sweep {
        name: "precision",
        about: "the ε that the separating-axis test adds to every |R_ij|: how many overlapping boxes does it take for apart?",
        axis: "ε",
        quantity: Quantity::Precision,
        values: &[0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-6, 2e-6, 1e-5],
    },
];

/// How much a sweep does.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Amount {
    lines: usize,
    blocks: u32,
    /// Highest tessellation density.
    density: f64,
}

/// Densities are bounded so that trees of all variants fit into memory: 4 gives about 10^5 triangles, 16 a million.
const fn amount(profile: Profile) -> Amount {
    match profile {
        Profile::Smoke => Amount { lines: 24, blocks: 1, density: 0.5 },
        Profile::Quick => Amount { lines: 96, blocks: 3, density: 2.0 },
        Profile::Full => Amount { lines: 600, blocks: 8, density: 16.0 },
    }
}

/// What a sweep is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// How much.
    pub profile: Profile,
    /// Variants by id; those of a run when empty.
    pub variants: Vec<String>,
    /// Seed of all randomness.
    pub seed: u64,
    /// Highest tessellation density in the sweep of the size; the profile's when not given.
    pub density: Option<f64>,
}

/// Why a sweep cannot be made.
#[derive(Debug, Error)]
pub enum SweepError {
    /// There is none of that name.
    #[error("there is no sweep `{asked}`; there are {known}")]
    NoSuchSweep {
        /// What was asked for.
        asked: String,
        /// What there is.
        known: String,
    },
    /// A variant is not registered.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A body cannot be made at the value asked for.
    #[error("a body of the sweep cannot be made: {0}")]
    Shape(String),
    /// The folder cannot be used, or a file not be written.
    #[error(transparent)]
    Measure(#[from] MeasureError),
}

/// A sweep in its folder.
#[derive(Debug)]
pub struct SweepRun {
    sweep: Sweep,
    cases: Vec<Case>,
    amount: Amount,
    folder: PathBuf,
    manifest: Manifest,
    seed: u64,
    _lock: crate::record::FolderLock,
}

/// A case with its trees over both bodies.
type Prepared = (Case, Box<dyn Model>, Box<dyn Model>);

/// The poses of one group in one stratum.
struct Batch {
    group: u32,
    stratum: Stratum,
    poses: Vec<Isometry>,
}

impl Sweep {
    /// The sweep of that name.
    ///
    /// # Errors
    /// When there is none.
    pub fn find(name: &str) -> Result<Self, SweepError> {
        SWEEPS.into_iter().find(|sweep| sweep.name == name).ok_or_else(|| SweepError::NoSuchSweep {
            asked: name.to_owned(),
            known: SWEEPS.map(|sweep| sweep.name).join(", "),
        })
    }

    /// The variants that the sweep examines unless others are asked for: of those that a run has, the safe volumes; where
    /// contacts are reported late, all volumes.
    fn default_variants(&self, registry: &Registry) -> Result<Vec<Variant>, PlanError> {
        let unsafe_too = self.quantity == Quantity::Step;
        let mut variants = choose(&[], registry)?;
        variants.retain(|variant| variant.kind.has_volumes() && (variant.info.safe || unsafe_too));
        Ok(variants)
    }
}

impl SweepRun {
    /// Opens a sweep's folder: a new one, or one to go on with. `fresh` replaces a sweep of another request.
    ///
    /// # Errors
    /// When a variant is unknown, or the folder holds something else or cannot be written.
    pub fn open(
        sweep: Sweep,
        asked: &Asked,
        registry: &Registry,
        folder: &Path,
        fresh: bool,
    ) -> Result<Self, SweepError> {
        let by_name = !asked.variants.is_empty();
        let variants = if by_name { choose(&asked.variants, registry)? } else { sweep.default_variants(registry)? };
        // The sweep of ε is about arithmetics, not variants.
        let variants = if sweep.quantity == Quantity::Precision { Vec::new() } else { variants };
        let with_tree = variants.into_iter().filter(|variant| match variant.kind {
            Kind::Volume | Kind::Engine => true,
            Kind::Peer => by_name,
            Kind::Sampling | Kind::Control => false,
        });
        let cases: Vec<Case> =
            with_tree.map(|variant| Case { policy: variant.policy, id: variant.info.id.to_owned(), variant }).collect();
        let mut amount = amount(asked.profile);
        amount.density = asked.density.unwrap_or(amount.density);
        let (manifest, lock) = folder::open(folder, manifest(&sweep, &cases, asked, amount), fresh, &FILES)?;
        Ok(Self { sweep, cases, amount, folder: folder.to_owned(), manifest, seed: asked.seed, _lock: lock })
    }

    /// Carries the sweep out, or what is lacking of it, and writes `sweep.csv` and, when `timed`, `sweep_timings.csv`.
    ///
    /// # Errors
    /// When a body cannot be made or files cannot be written.
    pub fn run(&mut self, timed: bool, progress: &dyn Progress) -> Result<(), SweepError> {
        let values = self.values();
        progress.begin(&format!("sweep {}", self.sweep.name), values.len() as u64);
        for (number, &x) in values.iter().enumerate() {
            let [counts, times] = ["counts", "times"].map(|kind| self.unit(kind, number));
            if !counts.exists() || (timed && !times.exists()) {
                self.run_value(x, (&counts, &times), timed)?;
            }
            progress.advance(1);
        }
        self.join::<SweepRow>("counts", values.len())?;
        if timed {
            self.join::<SweepTimingRow>("times", values.len())?;
            if self.sweep.quantity == Quantity::Size {
                self.join::<SweepBuildRow>("times", values.len())?;
            }
            self.manifest.finished = vec![Stage::Measure];
            self.manifest.write(&self.folder).map_err(MeasureError::from)?;
        }
        Ok(())
    }

    fn values(&self) -> Vec<f64> {
        let is_affordable = |x: &f64| self.sweep.quantity != Quantity::Size || *x <= self.amount.density;
        self.sweep.values.iter().copied().filter(is_affordable).collect()
    }

    fn run_value(&self, x: f64, (counts, times): (&Path, &Path), timed: bool) -> Result<(), SweepError> {
        if self.sweep.quantity == Quantity::Precision {
            if !counts.exists() {
                let rows = precision::rows(self.sweep.name, x, self.amount, self.seed);
                write_unit(counts, |folder| write_rows(folder, &rows)).map_err(MeasureError::from)?;
            }
            if timed {
                let untimed: [SweepTimingRow; 0] = [];
                write_unit(times, |folder| write_rows(folder, &untimed)).map_err(MeasureError::from)?;
            }
            return Ok(());
        }
        let stage = stage(self.sweep.quantity, x, self.amount.lines, self.seed)?;
        let triangles = (stage.a.faces().len() + stage.b.faces().len()) as u64;
        let x = if self.sweep.quantity == Quantity::Size { triangles as f64 } else { x };
        let models: Vec<Prepared> = self
            .cases
            .iter()
            .map(|case| {
                let leaf = |policy: Policy| Policy { leaf: stage.leaf.unwrap_or(policy.leaf), ..policy };
                let case = Case { policy: case.policy.map(leaf), ..case.clone() };
                let [a, b] = [&stage.a, &stage.b].map(|mesh| case.variant.prepare(mesh, case.policy));
                (case, a, b)
            })
            .collect();
        let batches = batches(&stage);
        if !counts.exists() {
            let rows = if let Some(step_mm) = stage.step_mm {
                models.iter().flat_map(|model| step::rows(self.sweep.name, model, &stage, step_mm, self.seed)).collect()
            } else {
                self.count(x, triangles, &stage, &models, &batches)
            };
            write_unit(counts, |folder| write_rows(folder, &rows)).map_err(MeasureError::from)?;
        }
        if timed && !times.exists() {
            // Along a path there is nothing to time that the other sweeps do not time better.
            let rows = if stage.step_mm.is_some() { Vec::new() } else { self.time(x, &models, &batches) };
            let grows = self.sweep.quantity == Quantity::Size;
            let builds = if grows { self.time_builds(x, triangles, &stage, &models) } else { Vec::new() };
            write_unit(times, |folder| {
                write_rows(folder, &rows)?;
                if grows { write_rows(folder, &builds) } else { Ok(()) }
            })
            .map_err(MeasureError::from)?;
        }
        Ok(())
    }

    fn count(&self, x: f64, triangles: u64, stage: &Bodies, models: &[Prepared], batches: &[Batch]) -> Vec<SweepRow> {
        let oracle = PairOracle::new(Arc::clone(&stage.a), Arc::clone(&stage.b));
        let touches = |batch: &Batch| -> Vec<bool> { batch.poses.iter().map(|pose| oracle.touches(pose)).collect() };
        let touches: Vec<Vec<bool>> = batches.par_iter().map(touches).collect();
        let rows = models.iter().flat_map(|model| batches.iter().zip(&touches).map(move |(b, t)| (model, b, t)));
        let row = |((case, a, b), batch, touches): (&Prepared, &Batch, &Vec<bool>)| {
            let mut row = empty_row(self.sweep.name, x, case, triangles, batch.group, batch.stratum);
            for (pose, &touching) in batch.poses.iter().zip(touches) {
                let (verdict, counts) = a.first_counted(b.as_ref(), pose);
                row.poses += 1;
                row.queries += 1;
                row.volume_tests += counts.volume_tests;
                row.triangle_tests += counts.triangle_tests;
                row.touching += u64::from(touching);
                row.missed += u64::from(touching && !verdict);
            }
            row
        };
        rows.collect::<Vec<_>>().into_par_iter().map(row).collect()
    }

    fn unit(&self, kind: &str, number: usize) -> PathBuf {
        self.folder.join(UNITS).join(kind).join(number.to_string())
    }

    fn join<R: Row>(&self, kind: &str, values: usize) -> Result<(), MeasureError> {
        let mut rows: Vec<R> = Vec::new();
        for number in 0..values {
            rows.extend(read_rows::<R>(&self.unit(kind, number))?);
        }
        Ok(write_rows(&self.folder, &rows)?)
    }
}

/// The poses of a stage, by group of lines and stratum.
fn batches(stage: &Bodies) -> Vec<Batch> {
    let mut batches: BTreeMap<(u32, Stratum), Vec<Isometry>> = BTreeMap::new();
    for line in &stage.lines {
        for &depth in &stage.depths_mm {
            let stratum = Stratum::of(depth > 0.0, -depth);
            batches.entry((line.number % GROUPS, stratum)).or_default().push(line.at_depth(depth));
        }
    }
    batches.into_iter().map(|((group, stratum), poses)| Batch { group, stratum, poses }).collect()
}

/// A row that nothing has been counted in yet.
fn empty_row(sweep: &str, x: f64, case: &Case, triangles: u64, group: u32, stratum: Stratum) -> SweepRow {
    let (split, axes, leaf) = case.policy_columns();
    SweepRow {
        sweep: sweep.to_owned(),
        x,
        variant: case.id.clone(),
        split,
        split_axes: axes,
        leaf,
        triangles,
        group,
        stratum,
        poses: 0,
        queries: 0,
        volume_tests: 0,
        triangle_tests: 0,
        touching: 0,
        missed: 0,
        delay_mm: 0.0,
    }
}

fn manifest(sweep: &Sweep, cases: &[Case], asked: &Asked, amount: Amount) -> Manifest {
    let entry = |case: &Case| VariantEntry {
        id: case.id.clone(),
        label: case.variant.info.label.to_owned(),
        reference: case.variant.info.reference.to_owned(),
        safe: case.variant.info.safe,
        kind: case.variant.kind,
        policies: case.policy.iter().map(ToString::to_string).collect(),
    };
    Manifest {
        schema: SCHEMA,
        protocol: PROTOCOL.to_owned(),
        request: Request {
            profile: asked.profile.to_string(),
            seed: asked.seed,
            scenes: Vec::new(),
            variants: cases.iter().map(|case| case.id.clone()).collect(),
            policies: Vec::new(),
            workloads: vec![asked.density.map_or(sweep.name.to_owned(), |d| format!("{}, density to {d}", sweep.name))],
            verify_poses: 0,
            measure_poses: amount.lines as u64,
            program_steps: 0,
            blocks: amount.blocks,
            launches: 1,
            binaries: 1,
            cold_poses: 0,
        },
        inputs: BTreeMap::new(),
        variants: if sweep.quantity == Quantity::Precision {
            precision::entries()
        } else {
            cases.iter().map(entry).collect()
        },
        scenes: Vec::new(),
        program: environment::program(),
        binaries: Vec::new(),
        machine: environment::machine(),
        clock: None,
        cold: None,
        null_of: String::new(),
        cross_check: None,
        finished: Vec::new(),
        noise: Vec::new(),
        rows: BTreeMap::new(),
    }
}

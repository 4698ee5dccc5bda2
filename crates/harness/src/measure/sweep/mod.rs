//! Sweeps: one quantity is varied, and everything else stays constant.
//!
//! Every sweep is a named experiment on two parametric bodies ([`mod@stage`]), so it needs no files. The lines along which the bodies meet
//! are the same at every value of the quantity, and every variant is queried at the same poses. Along each line, one pose lies 1 mm before
//! first contact and one 1 mm past it, unless the sweep itself varies that.
//!
//! A value of the quantity is a scene of the study: a sweep that was killed continues with the missing values.

mod flip;
mod precision;
pub mod stage;
mod step;

use super::folder::{self, Folder};
use super::plan::{Case, PlanError, choose};
use super::shard::Shard;
use super::study::{self, Batch, Job, Rows, Study, Subject};
use super::{MeasureError, Profile, Progress};
use crate::analysis::grouped;
use crate::geometry::Isometry;
use crate::record::manifest::Request;
use crate::record::{FactorRow, Kind, Manifest, Stratum};
use crate::registry::{Registry, Variant};
use crate::tree::Policy;
use crate::truth::PairOracle;
use rayon::prelude::*;
use stage::{Bodies, Line, Quantity, stage};
use std::path::Path;
use std::sync::Arc;

/// Number of groups among which the lines are distributed; groups are the units of resampling.
const GROUPS: u32 = 12;

/// A named sweep.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    /// Name on the command line.
    pub name: &'static str,
    /// The effect that the sweep shows.
    pub about: &'static str,
    /// Label of the horizontal axis, with the unit.
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

/// Amount of work of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Amount {
    lines: usize,
    blocks: u32,
    /// Highest tessellation density.
    density: f64,
}

/// The amount of work of a profile. Densities are bounded so that the trees of all variants fit into memory: 4 gives about 10^5 triangles,
/// 16 a million.
const fn amount(profile: Profile) -> Amount {
    match profile {
        Profile::Smoke => Amount { lines: 24, blocks: 1, density: 0.5 },
        Profile::Quick => Amount { lines: 96, blocks: 3, density: 2.0 },
        Profile::Full => Amount { lines: 600, blocks: 8, density: 16.0 },
    }
}

/// The request for a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// Profile, which sets the amount of work.
    pub profile: Profile,
    /// Variants by id; when empty, those of a run.
    pub variants: Vec<String>,
    /// Seed of all randomness.
    pub seed: u64,
    /// Highest tessellation density in the sweep of mesh size; when absent, that of the profile.
    pub density: Option<f64>,
    /// The shard that is carried out; all of the sweep when absent.
    pub shard: Option<Shard>,
}

/// A sweep in its folder.
#[derive(Debug)]
pub struct SweepRun {
    folder: Folder,
    design: Design,
}

/// The swept quantity, and the cases that are queried.
#[derive(Debug)]
struct Design {
    sweep: Sweep,
    cases: Vec<Case>,
    amount: Amount,
    seed: u64,
}

/// One value of the swept quantity: a scene of the study.
struct Place {
    scene: String,
    /// Value of the quantity, as records hold it.
    x: f64,
    /// The bodies; `None` in the sweep of ε, which has none.
    ready: Option<Ready>,
}

/// The bodies, and the methods prepared for them.
struct Ready {
    stage: Bodies,
    triangles: u64,
    cases: Vec<Case>,
    subjects: Vec<Subject>,
    batches: Vec<Batch>,
}

impl Sweep {
    /// Finds a sweep by name.
    ///
    /// # Errors
    /// When there is none of that name.
    pub fn find(name: &str) -> Result<Self, MeasureError> {
        SWEEPS.into_iter().find(|sweep| sweep.name == name).ok_or_else(|| MeasureError::NoSuchSweep {
            asked: name.to_owned(),
            known: SWEEPS.map(|sweep| sweep.name).join(", "),
        })
    }

    /// The default variants of the sweep: the safe volumes among the variants of a run; for sweeps about late reports of contact, all
    /// volumes.
    fn default_variants(&self, registry: &Registry) -> Result<Vec<Variant>, PlanError> {
        let unsafe_too = self.quantity == Quantity::Step;
        let mut variants = choose(&[], registry)?;
        variants.retain(|variant| variant.kind.has_volumes() && (variant.info.safe || unsafe_too));
        Ok(variants)
    }

    /// The cases: each variant under its default policy. The sweep of ε has none.
    fn cases(&self, asked: &Asked, registry: &Registry) -> Result<Vec<Case>, PlanError> {
        let by_name = !asked.variants.is_empty();
        let variants = if by_name { choose(&asked.variants, registry)? } else { self.default_variants(registry)? };
        let with_tree = variants.iter().filter(|variant| match variant.kind {
            _ if self.quantity == Quantity::Precision => false,
            Kind::Volume | Kind::Engine => true,
            Kind::Peer => by_name,
            Kind::Sampling | Kind::Control => false,
        });
        Ok(with_tree.map(Case::of).collect())
    }
}

impl SweepRun {
    /// Opens a sweep's folder, new or to be continued. `fresh` replaces a sweep of another request.
    ///
    /// # Errors
    /// When a variant is unknown, or the folder holds something else or cannot be written.
    pub fn open(
        sweep: Sweep,
        asked: &Asked,
        registry: &Registry,
        folder: &Path,
        fresh: bool,
    ) -> Result<Self, MeasureError> {
        let cases = sweep.cases(asked, registry)?;
        let mut amount = amount(asked.profile);
        amount.density = asked.density.unwrap_or(amount.density);
        let whole = manifest(&sweep, &cases, asked, amount);
        let folder = Folder::open(folder, Shard::manifest(asked.shard, whole), fresh)?;
        Ok(Self { folder, design: Design { sweep, cases, amount, seed: asked.seed } })
    }

    /// Carries out the missing values of the sweep and writes its raw records; without `timed`, only the deterministic ones.
    ///
    /// # Errors
    /// When a body cannot be made or files cannot be written.
    pub fn run(&mut self, timed: bool, progress: &dyn Progress) -> Result<(), MeasureError> {
        study::carry_out(&self.design, &mut self.folder, timed, progress)
    }
}

impl Design {
    fn values(&self) -> Vec<f64> {
        let is_affordable = |x: &f64| self.sweep.quantity != Quantity::Size || *x <= self.amount.density;
        self.sweep.values.iter().copied().filter(is_affordable).collect()
    }

    fn name(&self, x: f64) -> String {
        format!("{}={x}", self.sweep.name)
    }

    fn ready(&self, stage: Bodies) -> Ready {
        let leaf = |policy: Policy| Policy { leaf: stage.leaf.unwrap_or(policy.leaf), ..policy };
        let of_value = |case: &Case| Case { policy: case.policy.map(leaf), ..case.clone() };
        let cases: Vec<Case> = self.cases.iter().map(of_value).collect();
        let meshes = [&stage.a, &stage.b];
        let subject = |case: &Case| {
            let models = meshes.iter().enumerate().map(|(part, mesh)| (part, case.variant.prepare(mesh, case.policy)));
            Subject { case: case.key(), models: models.collect() }
        };
        let triangles = meshes.iter().map(|mesh| mesh.faces().len() as u64).sum();
        Ready { triangles, subjects: cases.iter().map(subject).collect(), batches: batches(&stage), cases, stage }
    }
}

impl Study for Design {
    type Place<'a> = Place;

    fn scenes(&self) -> Vec<String> {
        self.values().into_iter().map(|x| self.name(x)).collect()
    }

    fn prepare(&self, scene: usize, _: &dyn Progress) -> Result<Place, MeasureError> {
        let x = self.values()[scene];
        if self.sweep.quantity == Quantity::Precision {
            return Ok(Place { scene: self.name(x), x, ready: None });
        }
        let ready = self.ready(stage(self.sweep.quantity, x, self.amount.lines, self.seed)?);
        let recorded = if self.sweep.quantity == Quantity::Size { ready.triangles as f64 } else { x };
        Ok(Place { scene: self.name(x), x: recorded, ready: Some(ready) })
    }

    fn describe(&self, place: &Place) -> Rows {
        let (scene, name) = (&place.scene, self.sweep.name);
        let mut factors = vec![FactorRow::of_scene(scene, name, place.x.to_string())];
        factors.extend(
            place.ready.iter().map(|ready| FactorRow::of_scene(scene, "triangles", ready.triangles.to_string())),
        );
        Rows { factors, ..Rows::default() }
    }

    fn count(&self, place: &Place, _: usize) -> Rows {
        let Some(Ready { stage, cases, subjects, batches, .. }) = &place.ready else {
            return precision::rows(&place.scene, place.x, self.amount, self.seed);
        };
        let all = || subjects.par_iter().flat_map_iter(|subject| batches.iter().map(move |batch| (subject, batch)));
        let counts = match stage.step_mm {
            Some(step_mm) => subjects
                .iter()
                .flat_map(|subject| step::rows(&place.scene, subject, stage, step_mm, self.seed))
                .collect(),
            None => all().map(|(subject, batch)| study::count(&place.scene, subject, batch)).collect(),
        };
        Rows { cases: cases.iter().map(Case::row).collect(), counts, ..Rows::default() }
    }

    fn time(&self, place: &Place, _: usize) -> Rows {
        let Some(ready) = &place.ready else { return Rows::default() };
        let (launch, seed) = ((place.scene.as_str(), 0), self.seed ^ place.x.to_bits());
        let subjects: Vec<&Subject> = ready.subjects.iter().collect();
        // Along a path there is nothing to time that the other sweeps do not time better.
        let timings = match ready.stage.step_mm {
            Some(_) => Vec::new(),
            None => study::time(launch, &subjects, &ready.batches, self.amount.blocks, seed),
        };
        let mut builds = Vec::new();
        if self.sweep.quantity == Quantity::Size {
            let stage = &ready.stage;
            let job = |case: &'_ Case| Job {
                case: case.key(),
                part: ("both".to_owned(), ready.triangles),
                build: Box::new({
                    let case = case.clone();
                    move || [&stage.a, &stage.b].map(|mesh| case.variant.prepare(mesh, case.policy))
                }),
            };
            let jobs: Vec<_> = ready.cases.iter().map(job).collect();
            builds = study::time_builds(launch, &jobs, self.amount.blocks, seed ^ 0x000b_u64).0;
        }
        Rows { timings, builds, ..Rows::default() }
    }
}

/// The poses of a stage, by group of lines and stratum; a pose has the same number at every value.
fn batches(stage: &Bodies) -> Vec<Batch> {
    let of_line = |line: &Line| {
        let pose = |&depth: &f64| ((line.number % GROUPS, Stratum::of(depth > 0.0, -depth)), line.at_depth(depth));
        stage.depths_mm.iter().map(pose).collect::<Vec<_>>()
    };
    let batches = grouped(stage.lines.iter().flat_map(of_line));
    let oracle = PairOracle::new(Arc::clone(&stage.a), Arc::clone(&stage.b));
    let batch = |((group, stratum), poses): ((u32, Stratum), Vec<Isometry>)| Batch {
        chunk: chunk_number(group, stratum),
        stratum,
        parts: [0, 1],
        touching: poses.iter().map(|pose| oracle.touches(pose)).collect(),
        poses,
    };
    batches.into_iter().collect::<Vec<_>>().into_par_iter().map(batch).collect()
}

/// The number of the chunk for a group of lines and a stratum.
fn chunk_number(group: u32, stratum: Stratum) -> u32 {
    group * Stratum::ALL.len() as u32 + stratum as u32
}

fn manifest(sweep: &Sweep, cases: &[Case], asked: &Asked, amount: Amount) -> Manifest {
    let request = Request {
        profile: asked.profile.to_string(),
        seed: asked.seed,
        variants: cases.iter().map(|case| case.id.clone()).collect(),
        workloads: vec![asked.density.map_or(sweep.name.to_owned(), |d| format!("{}, density to {d}", sweep.name))],
        measure_poses: amount.lines as u64,
        blocks: amount.blocks,
        launches: 1,
        binaries: 1,
        ..Request::default()
    };
    let is_about_arithmetics = sweep.quantity == Quantity::Precision;
    folder::begun(
        request,
        if is_about_arithmetics { precision::entries() } else { cases.iter().map(Case::entry).collect() },
    )
}

//! The thesis's method part by part: what octree, second tool level and coherence save, and what sampling misses.
//!
//! Each form of the method answers the same poses on the same free-form surface, and so does a tree of volumes over the meshes of tool and
//! surface. Counts are taken apart for the poses that hit and those that do not, verdicts are held against the exact truth on the meshes.
//!
//! Reading order: this file (what is varied), `subject` (surfaces, tool, poses), `trial` (one form, counted and timed).

mod subject;
mod trial;

use super::Progress;
use super::blocks::{self, Extent, Participation, Work};
use super::folder::{UNITS, remove, write_unit};
use crate::geometry::shapes::{Freeform, ShapeError};
use crate::interference::profile::ProfileError;
use crate::interference::{Division, Search, SecondLevel};
use crate::record::{AblationKindRow, AblationRow, AblationTimeRow, RecordError, read_rows, write_rows};
use crate::registry::Variant;
use rayon::prelude::*;
use std::path::Path;
use subject::ToolSubject;
use thiserror::Error;
use trial::{Ground, Trial};

/// Why the experiment cannot be made.
#[derive(Debug, Error)]
pub enum AblationError {
    /// A surface or the tool cannot be meshed.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The tool has impossible dimensions.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// A record cannot be read or written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// How much is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AblationBudget {
    /// Rows of the path.
    pub rows: u32,
    /// Way from contact point to contact point, mm.
    pub step_mm: f64,
    /// Rounds of timing.
    pub rounds: u32,
    /// Whether the sweeps are made beside the parts, that of the surface's size among them.
    pub sweeps: bool,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ablation {
    /// Counts.
    pub rows: Vec<AblationRow>,
    /// Local and global interference.
    pub kinds: Vec<AblationKindRow>,
    /// Times.
    pub times: Vec<AblationTimeRow>,
}

/// One form of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Form {
    sweep: &'static str,
    /// How octants are looked for; `None` for the tree of volumes over both meshes.
    search: Option<Search>,
    level: SecondLevel,
    safe: bool,
    coherent: bool,
    division: Division,
    spacing_mm: f64,
    /// Poses between two contact points of the plan.
    fineness: u32,
    /// Density of the surface's mesh.
    density: f64,
    /// Only each so many-th pose is asked.
    stride: usize,
}

/// The form that the others differ from.
const BASE: Form = Form {
    sweep: "parts",
    search: Some(Search::Octree),
    level: SecondLevel::None,
    safe: true,
    coherent: false,
    division: Division { cap: 16, depth: 12 },
    spacing_mm: 1.0,
    fineness: 1,
    density: 2.0,
    stride: 1,
};

fn forms(sweeps: bool) -> Vec<Form> {
    let mut forms = Vec::new();
    for safe in [false, true] {
        let base = Form { safe, ..BASE };
        forms.extend([Search::Points, Search::Leaves].map(|search| Form { search: Some(search), ..base }));
        forms.extend(SecondLevel::ALL.map(|level| Form { level, ..base }));
        forms.extend([SecondLevel::None, SecondLevel::Profile4].map(|level| Form { level, coherent: true, ..base }));
    }
    forms.push(Form { search: None, ..BASE });
    if sweeps {
        let cap = |cap| Form { sweep: "cap", division: Division { cap, ..BASE.division }, ..BASE };
        forms.extend([1, 4, 16, 64, 256].map(cap));
        let depth = |depth| Form { sweep: "depth", division: Division { depth, ..BASE.division }, ..BASE };
        forms.extend([3, 5, 7, 9, 12].map(depth));
        for safe in [false, true] {
            forms.extend([4.0, 2.0, 1.0, 0.5].map(|spacing_mm| Form { sweep: "spacing", spacing_mm, safe, ..BASE }));
        }
        for coherent in [false, true] {
            forms.extend([1, 4, 16].map(|fineness| Form { sweep: "step", fineness, coherent, ..BASE }));
        }
    }
    forms
}

/// Densities of the mesh and spacings of its samples, mm, at which a surface has about 10^4, 10^5 and 10^6 points, and at how many poses in a
/// hundred all of these are asked one by one.
const SIZES: [(f64, f64, usize); 3] = [(2.0, 4.0, 1), (6.3, 1.4, 10), (20.0, 0.45, 100)];

fn sizes() -> Vec<Form> {
    let of = |(density, spacing_mm, stride): (f64, f64, usize)| {
        let base = Form { sweep: "size", density, spacing_mm, ..BASE };
        [
            Form { search: Some(Search::Points), stride, ..base },
            base,
            Form { level: SecondLevel::Profile4, ..base },
            Form { coherent: true, ..base },
            Form { search: None, ..base },
        ]
    };
    SIZES.into_iter().flat_map(of).collect()
}

/// A surface with the forms that are tried on it.
struct Trials<'a> {
    name: &'static str,
    /// `parts` or `size`.
    about: &'static str,
    surface: &'a Freeform,
    forms: Vec<Form>,
}

/// Makes the experiment and writes what was found into `folder`; `mesh_variant` is the tree that the method is held against. A surface that
/// an interrupted experiment of the same kind has finished is not tried again. Counts do not depend on the machine.
///
/// # Errors
/// When a surface or the tool cannot be made, or a file not be written.
pub fn ablation(
    budget: &AblationBudget,
    mesh_variant: &Variant,
    seed: u64,
    folder: &Path,
    progress: &dyn Progress,
) -> Result<Ablation, AblationError> {
    let _lock = crate::record::FolderLock::take(folder)?;
    let tool = ToolSubject::new()?;
    let surfaces = subject::surfaces();
    let parts = surfaces.iter().map(|(name, surface)| (*name, "parts", surface, forms(budget.sweeps)));
    let sizes =
        surfaces.iter().take(usize::from(budget.sweeps)).map(|(name, surface)| (*name, "size", surface, sizes()));
    let stages = parts.chain(sizes).map(|(name, about, surface, forms)| Trials { name, about, surface, forms });
    let units = folder.join(UNITS);
    let mut found = Ablation::default();
    for stage in stages {
        let unit = units.join(request(budget, mesh_variant, seed)).join(format!("{}-{}", stage.name, stage.about));
        if !unit.exists() {
            let of_stage = try_forms(&stage, budget, mesh_variant, &tool, seed, progress)?;
            write_unit(&unit, |folder| of_stage.write(folder))?;
        }
        found.read(&unit)?;
    }
    found.write(folder)?;
    remove(&units)?;
    Ok(found)
}

/// What tells one experiment's units from those of others.
fn request(budget: &AblationBudget, mesh_variant: &Variant, seed: u64) -> String {
    let AblationBudget { rows, step_mm, rounds, sweeps } = budget;
    let program = super::environment::program();
    format!("{rows}-{step_mm}-{rounds}-{sweeps}-{seed}-{}-{}", mesh_variant.info.id, program.git_revision)
}

/// Counts all forms of a stage, on all cores, and times them one by one.
fn try_forms(
    stage: &Trials,
    budget: &AblationBudget,
    mesh_variant: &Variant,
    tool: &ToolSubject,
    seed: u64,
    progress: &dyn Progress,
) -> Result<Ablation, AblationError> {
    let what = format!("octree method on `{}`, {}", stage.name, stage.about);
    progress.begin(&what, stage.forms.len() as u64 + u64::from(budget.rounds));
    let mut ground = Ground::new(stage.name, stage.surface, budget, tool, mesh_variant);
    let trials: Vec<Trial> = stage.forms.iter().map(|form| ground.trial(*form)).collect::<Result<_, _>>()?;
    let count = |trial: &Trial| {
        let rows = trial.count();
        progress.advance(1);
        rows
    };
    let rows = trials.par_iter().map(count).collect::<Vec<_>>().concat();
    let kinds = trials.iter().filter(|trial| trial.form == BASE).flat_map(|trial| trial.kinds(tool)).collect();
    let extent = Extent { blocks: budget.rounds, warms_up: false, long_once: false };
    let samples = blocks::time(&mut Timed(&trials), extent, seed, progress);
    let times = samples.into_iter().map(|sample| trials[sample.case].time_row(sample.block, sample.ns)).collect();
    Ok(Ablation { rows, kinds, times })
}

/// Trials, each of which runs all its poses as one chunk.
struct Timed<'a>(&'a [Trial]);

impl Work for Timed<'_> {
    fn cases(&self) -> usize {
        self.0.len()
    }

    fn chunks(&self) -> Vec<usize> {
        vec![1]
    }

    /// To ask all points takes so long that one round averages the machine's noise itself.
    fn participation(&self, case: usize, _: usize) -> Participation {
        if self.0[case].form.search == Some(Search::Points) { Participation::Once } else { Participation::Always }
    }

    fn run(&mut self, case: usize, _: usize, _: usize, _: u32) {
        self.0[case].run_once();
    }
}

impl Ablation {
    fn write(&self, folder: &Path) -> Result<(), RecordError> {
        write_rows(folder, &self.rows)?;
        write_rows(folder, &self.kinds)?;
        write_rows(folder, &self.times)
    }

    fn read(&mut self, folder: &Path) -> Result<(), RecordError> {
        self.rows.extend(read_rows(folder)?);
        self.kinds.extend(read_rows(folder)?);
        self.times.extend(read_rows(folder)?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Silent;
    use super::*;
    use crate::registry::Registry;

    #[test]
    fn safe_forms_miss_nothing_and_the_hierarchy_saves_tests() {
        let budget = AblationBudget { rows: 2, step_mm: 1.5, rounds: 1, sweeps: false };
        let registry = Registry::standard();
        let folder = tempfile::tempdir().unwrap();
        let variant = registry.reference().unwrap();
        let found = ablation(&budget, variant, 1, folder.path(), &Silent).unwrap();
        let mut again = Ablation::default();
        again.read(folder.path()).unwrap();
        assert_eq!(again, found);
        let Ablation { rows, kinds, times } = found;
        assert_eq!((rows.len(), times.len()), (4 * 17 * 2, 4 * 17));
        let touching: u64 = rows.iter().map(|row| row.touching).sum();
        assert!(touching > 4 * 17 * 20, "{touching}");
        assert!(rows.iter().all(|row| row.safe == 0 || row.missed == 0), "a safe form misses contact");
        let tests = |search: &str| -> u64 {
            let of = rows.iter().filter(|row| row.search == search && row.second_level == "none" && row.coherence == 0);
            of.map(|row| row.first_level).sum()
        };
        assert!(tests("leaves") > 3 * tests("octree"), "{} {}", tests("leaves"), tests("octree"));
        for kind in ["local", "global"] {
            let of_kind = || kinds.iter().filter(|row| row.kind == kind);
            assert!(
                of_kind().map(|row| row.touching).sum::<u64>() > 20 && of_kind().all(|row| row.missed == 0),
                "{kinds:?}"
            );
        }
    }
}

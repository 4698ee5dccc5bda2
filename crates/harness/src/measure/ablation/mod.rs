//! The ablation of the thesis's method: what octree, second tool level and coherence save, and what sampling misses.
//!
//! Each form of the method is run at the same poses on the same free-form surface, and so is a tree of volumes over the meshes of tool and
//! surface. Counts are separate for colliding and free poses. Verdicts are compared with the exact ground truth on the meshes.
//!
//! Reading order: this file (what is varied), `subject` (surfaces, tool, poses), `trial` (one form, counted and timed).

mod subject;
mod trial;

use super::blocks::{self, Extent, Participation, Work};
use super::folder::{self, Folder};
use super::plan::Case;
use super::shard::Shard;
use super::study::{self, Rows, Study, timing_row};
use super::{MeasureError, Profile, Progress, Silent};
use crate::geometry::shapes::Freeform;
use crate::interference::{Division, Search, SecondLevel};
use crate::record::manifest::{Request, Stage};
use crate::registry::Variant;
use std::path::Path;
use subject::ToolSubject;
use trial::{Ground, Trial};

/// Amount of work of an ablation.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AblationBudget {
    /// Number of rows of the path.
    rows: u32,
    /// Distance between contact points, mm.
    step_mm: f64,
    /// Rounds of timing.
    rounds: u32,
    /// Whether the parameter sweeps are run too, including the sweep of surface size.
    sweeps: bool,
}

const fn budget(profile: Profile) -> AblationBudget {
    match profile {
        Profile::Smoke => AblationBudget { rows: 5, step_mm: 3.0, rounds: 1, sweeps: false },
        Profile::Quick => AblationBudget { rows: 15, step_mm: 1.0, rounds: 3, sweeps: true },
        Profile::Full => AblationBudget { rows: 60, step_mm: 0.25, rounds: 9, sweeps: true },
    }
}

/// The request for an ablation.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// Profile, which sets the amount of work.
    pub profile: Profile,
    /// The tree that the method is compared with.
    pub against: &'a Variant,
    /// Seed of the order in which forms are timed.
    pub seed: u64,
    /// The shard that is carried out; all of the ablation when absent.
    pub shard: Option<Shard>,
}

/// One form of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Form {
    sweep: &'static str,
    /// How leaves are found; `None` for the tree of volumes over both meshes.
    search: Option<Search>,
    level: SecondLevel,
    safe: bool,
    coherent: bool,
    division: Division,
    spacing_mm: f64,
    /// Number of poses between two contact points of the plan.
    fineness: u32,
    /// Density of the surface's mesh.
    density: f64,
    /// Only every `stride`-th pose is queried.
    stride: usize,
}

impl Form {
    /// Name of the case in the records, which states how the form differs from the others of its sweep.
    fn case(&self, search: &str) -> String {
        let mode = if self.safe { "safe" } else { "sampling" };
        let coherence = if self.coherent { "-coherent" } else { "" };
        let value = match self.sweep {
            "cap" => format!("-{}", self.division.cap),
            "depth" => format!("-{}", self.division.depth),
            "spacing" | "size" => format!("-{}", self.spacing_mm),
            "step" => format!("-{}", self.fineness),
            _ => String::new(),
        };
        format!("{}-{search}-{}-{mode}{coherence}{value}", self.sweep, self.level.name())
    }
}

/// The base form, from which each other form differs.
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

/// Sizes of the sweep: density of the mesh, spacing of the samples (mm), and stride of the poses at which all points are tested one by one.
/// The surfaces have about 10^4, 10^5 and 10^6 points.
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

/// A surface, which is a scene of the study, with the forms that are run on it.
struct Ablated {
    name: String,
    /// Number of the surface.
    surface: usize,
    forms: Vec<Form>,
}

/// The surfaces and forms of the study.
struct Design<'a> {
    asked: &'a Asked<'a>,
    budget: AblationBudget,
    tool: ToolSubject,
    surfaces: Vec<Freeform>,
    scenes: Vec<Ablated>,
}

/// Runs the ablation and writes its raw records into `folder`; without `timed`, only the deterministic ones. An interrupted ablation
/// continues with the missing forms, and a finished one is run again, a finished shard is not; `fresh` replaces an ablation of another request. Counts do not depend
/// on the machine.
///
/// # Errors
/// When a surface or the tool cannot be made, the folder holds something else, or a file cannot be written.
pub fn ablation(
    asked: &Asked<'_>,
    folder: &Path,
    fresh: bool,
    timed: bool,
    progress: &dyn Progress,
) -> Result<(), MeasureError> {
    carry_out(&Design::new(asked, budget(asked.profile))?, folder, fresh, timed, progress)
}

fn carry_out(
    design: &Design<'_>,
    folder: &Path,
    fresh: bool,
    timed: bool,
    progress: &dyn Progress,
) -> Result<(), MeasureError> {
    let entries = vec![Case::of(design.asked.against).entry()];
    let whole = folder::begun(request(design.asked, &design.budget), entries);
    let shard = design.asked.shard;
    let mut folder = Folder::open(folder, Shard::manifest(shard, whole), fresh)?;
    if timed && shard.is_none() && folder.has_finished(Stage::Measure) {
        folder.begin_again(Stage::Measure, &study::raw_files(), &[""])?;
    }
    study::carry_out(design, &mut folder, timed, progress)
}

impl<'a> Design<'a> {
    fn new(asked: &'a Asked<'a>, budget: AblationBudget) -> Result<Self, MeasureError> {
        let (names, surfaces): (Vec<&str>, Vec<Freeform>) = subject::surfaces().into_iter().unzip();
        let parts = |(surface, name): (usize, &&str)| Ablated {
            name: (*name).to_owned(),
            surface,
            forms: forms(budget.sweeps),
        };
        let mut scenes: Vec<Ablated> = names.iter().enumerate().map(parts).collect();
        if budget.sweeps {
            scenes.push(Ablated { name: format!("{}-size", names[0]), surface: 0, forms: sizes() });
        }
        Ok(Self { asked, budget, tool: ToolSubject::new()?, surfaces, scenes })
    }
}

impl Study for Design<'_> {
    type Place<'b>
        = Vec<Trial>
    where
        Self: 'b;

    fn scenes(&self) -> Vec<String> {
        self.scenes.iter().map(|scene| scene.name.clone()).collect()
    }

    fn counted(&self, scene: usize) -> Vec<String> {
        let name = |form: &Form| form.case(form.search.map_or(self.asked.against.info.id, Search::name));
        self.scenes[scene].forms.iter().map(name).collect()
    }

    fn prepare(&self, scene: usize, progress: &dyn Progress) -> Result<Vec<Trial>, MeasureError> {
        let Ablated { name, surface, forms } = &self.scenes[scene];
        progress.begin(&format!("{name}: octrees"), forms.len() as u64);
        let mut ground = Ground::new(name, &self.surfaces[*surface], &self.budget, &self.tool, self.asked.against);
        let trial = |form: &Form| {
            progress.advance(1);
            ground.trial(*form)
        };
        forms.iter().map(trial).collect()
    }

    fn describe(&self, _: &Vec<Trial>) -> Rows {
        Rows::default()
    }

    fn count(&self, trials: &Vec<Trial>, unit: usize) -> Rows {
        trials[unit].count(&self.tool)
    }

    /// Times all forms in turn, so that disturbances of the machine affect them equally.
    fn time(&self, trials: &Vec<Trial>, _: usize) -> Rows {
        let extent = Extent { blocks: self.budget.rounds, warms_up: false, long_once: false };
        let samples = blocks::time(&mut Timed(trials), extent, self.asked.seed, &Silent);
        let names: Vec<String> = trials.iter().map(Trial::case).collect();
        let timings = samples.iter().map(|sample| timing_row((trials[0].scene(), 0), &names, 0, sample)).collect();
        Rows { timings, builds: trials.iter().map(Trial::build_row).collect(), ..Rows::default() }
    }
}

fn request(asked: &Asked<'_>, budget: &AblationBudget) -> Request {
    Request {
        profile: asked.profile.to_string(),
        seed: asked.seed,
        variants: vec![asked.against.info.id.to_owned()],
        blocks: budget.rounds,
        launches: 1,
        binaries: 1,
        ..Request::default()
    }
}

/// Trials; each runs all its poses as one chunk.
struct Timed<'a>(&'a [Trial]);

impl Work for Timed<'_> {
    fn cases(&self) -> usize {
        self.0.len()
    }

    fn chunks(&self) -> Vec<usize> {
        vec![1]
    }

    /// Testing all points takes so long that a single round already averages the machine's noise.
    fn participation(&self, case: usize, _: usize) -> Participation {
        if self.0[case].form.search == Some(Search::Points) { Participation::Once } else { Participation::Always }
    }

    fn run(&mut self, case: usize, _: usize, _: usize, _: u32) {
        self.0[case].run_once();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{BuildRow, CountRow, FactorRow, Manifest, TimingRow, read_rows};
    use crate::registry;

    #[test]
    fn safe_forms_miss_nothing_and_the_hierarchy_saves_tests() {
        let budget = AblationBudget { rows: 2, step_mm: 1.5, rounds: 1, sweeps: false };
        let registry = registry::standard();
        let asked = Asked { profile: Profile::Smoke, against: registry.reference().unwrap(), seed: 1, shard: None };
        let folder = tempfile::tempdir().unwrap();
        let design = Design::new(&asked, budget).unwrap();
        carry_out(&design, folder.path(), false, true, &Silent).unwrap();
        Manifest::read(folder.path()).unwrap().check_rows(folder.path()).unwrap();
        let rows: Vec<CountRow> = read_rows(folder.path()).unwrap();
        let (forms, kinds): (Vec<&CountRow>, Vec<&CountRow>) =
            rows.iter().partition(|row| row.case.starts_with("parts-"));
        assert_eq!(forms.len(), 4 * 17 * 2);
        // Stretches of the path are chunks, which hold each pose once for each kind.
        let poses = |rows: &[&CountRow], case: &str| -> u64 {
            rows.iter().filter(|row| row.case == case).map(|row| row.poses).sum()
        };
        let of_path = poses(&forms, &forms[0].case);
        assert_eq!(["local", "global"].map(|kind| poses(&kinds, kind)), [of_path; 2]);
        assert!(kinds.iter().any(|row| row.chunk > 0) && kinds.iter().all(|row| row.poses <= 64), "{kinds:?}");
        assert_eq!(read_rows::<TimingRow>(folder.path()).unwrap().len(), 4 * 17);
        assert_eq!(read_rows::<BuildRow>(folder.path()).unwrap().len(), 4 * 17);
        // Eight factors of each form, two quantities on each surface, and one of each kind.
        assert_eq!(read_rows::<FactorRow>(folder.path()).unwrap().len(), 17 * 8 + 4 * 17 * 2 + 2);
        let touching: u64 = forms.iter().map(|row| row.touching).sum();
        assert!(touching > 4 * 17 * 20, "{touching}");
        let is_safe = |row: &CountRow| row.case.contains("-safe");
        assert!(forms.iter().all(|row| !is_safe(row) || row.missed == 0), "a safe form misses contact");
        let tests = |search: &str| -> u64 {
            let names = ["safe", "sampling"].map(|mode| format!("parts-{search}-none-{mode}"));
            forms.iter().filter(|row| names.contains(&row.case)).map(|row| row.volume_tests).sum()
        };
        assert!(tests("leaves") > 3 * tests("octree"), "{} {}", tests("leaves"), tests("octree"));
        for kind in ["local", "global"] {
            let of_kind = || kinds.iter().filter(|row| row.case == kind);
            assert!(
                of_kind().map(|row| row.touching).sum::<u64>() > 20 && of_kind().all(|row| row.missed == 0),
                "{kinds:?}"
            );
        }
    }
}

//! One form of the method over one surface, counted and timed.

use super::super::{MeasureError, timer};
use super::subject::{self, ToolSubject};
use super::{AblationBudget, BASE, Form};
use crate::geometry::shapes::Freeform;
use crate::geometry::{Isometry, Mesh};
use crate::interference::detect::Allowance;
use crate::interference::{BoxedTool, Coherence, Counts, Detector, Samples, SecondLevel, SurfaceOctree};
use crate::measure::study::{Rows, build_row};
use crate::method::Model;
use crate::record::rows::CaseKey;
use crate::record::{BuildRow, CaseRow, CountRow, FactorRow, Kind, TreeRow};
use crate::registry::Variant;
use crate::truth::PairOracle;
use crate::workload::BLOCK;
use rayon::prelude::*;
use std::sync::Arc;

/// A surface, with the data that its trials share.
pub struct Ground<'a> {
    scene: String,
    surface: &'a Freeform,
    budget: &'a AblationBudget,
    tool: &'a ToolSubject,
    variant: &'a Variant,
    meshes: Vec<(f64, Arc<Mesh>)>,
    octrees: Vec<(Form, Arc<SurfaceOctree>, u64)>,
    poses: Vec<(Form, Posed)>,
}

/// Poses with their ground truth, and the mean distance of the tip between them, mm.
#[derive(Clone)]
struct Posed {
    poses: Arc<Vec<Isometry>>,
    touching: Arc<Vec<bool>>,
    step_mm: f64,
}

/// The method that answers the queries.
enum Contender {
    Octree { octree: Arc<SurfaceOctree>, tool: BoxedTool },
    Trees { variant: Variant, surface: Box<dyn Model>, tool: Box<dyn Model> },
}

/// A form with all data that it needs.
pub struct Trial {
    pub form: Form,
    scene: String,
    contender: Contender,
    mesh: Arc<Mesh>,
    build_ns: u64,
    /// The poses of the surface in the tool's frame, and whether the meshes of the two touch there, exactly.
    posed: Posed,
}

/// Name of the part that trees and octrees are over.
const SURFACE: &str = "surface";

const NO_ALLOWANCE: Allowance = Allowance { gouge_mm: 0.0, clearance_mm: 0.0 };

impl<'a> Ground<'a> {
    pub fn new(
        scene: &str,
        surface: &'a Freeform,
        budget: &'a AblationBudget,
        tool: &'a ToolSubject,
        variant: &'a Variant,
    ) -> Self {
        let (meshes, octrees, poses) = (Vec::new(), Vec::new(), Vec::new());
        Self { scene: scene.to_owned(), surface, budget, tool, variant, meshes, octrees, poses }
    }

    /// Prepares a form, reusing what earlier forms have prepared.
    pub fn trial(&mut self, form: Form) -> Result<Trial, MeasureError> {
        let mesh = self.mesh(form.density)?;
        let (contender, build_ns) = if form.search.is_some() {
            let (octree, ns) = self.octree(&form, &mesh);
            (Contender::Octree { octree, tool: BoxedTool::new(self.tool.tool.clone(), form.level) }, ns)
        } else {
            let (ns, surface) = timer::time(|| self.variant.prepare(&mesh, None));
            let tool = self.variant.prepare(&self.tool.whole, None);
            (Contender::Trees { variant: *self.variant, surface, tool }, ns)
        };
        let posed = self.posed(&form, &mesh);
        Ok(Trial { form, scene: self.scene.clone(), contender, mesh, build_ns, posed })
    }

    fn mesh(&mut self, density: f64) -> Result<Arc<Mesh>, MeasureError> {
        if let Some((_, mesh)) = self.meshes.iter().find(|(of, _)| *of == density) {
            return Ok(Arc::clone(mesh));
        }
        let mesh = subject::mesh(self.surface, density)?;
        self.meshes.push((density, Arc::clone(&mesh)));
        Ok(mesh)
    }

    fn octree(&mut self, form: &Form, mesh: &Arc<Mesh>) -> (Arc<SurfaceOctree>, u64) {
        let is_same =
            |of: &Form| (of.division, of.spacing_mm, of.density) == (form.division, form.spacing_mm, form.density);
        if let Some((_, octree, ns)) = self.octrees.iter().find(|(of, ..)| is_same(of)) {
            return (Arc::clone(octree), *ns);
        }
        // Which empty octants are inside no query asks; the exact answer would be most of a large octree's time.
        let build = || SurfaceOctree::new(Samples::of(mesh, form.spacing_mm), form.division, &|_| false);
        let (ns, octree) = timer::time(build);
        let octree = Arc::new(octree);
        self.octrees.push((*form, Arc::clone(&octree), ns));
        (octree, ns)
    }

    fn posed(&mut self, form: &Form, mesh: &Arc<Mesh>) -> Posed {
        let is_same = |of: &Form| (of.fineness, of.stride, of.density) == (form.fineness, form.stride, form.density);
        if let Some((_, posed)) = self.poses.iter().find(|(of, _)| is_same(of)) {
            return posed.clone();
        }
        let (all, step_mm) = subject::poses(self.surface, self.budget, form.fineness);
        let poses: Vec<Isometry> = all.into_iter().step_by(form.stride).collect();
        let oracle = PairOracle::new(Arc::clone(&self.tool.whole), Arc::clone(mesh));
        let touching: Vec<bool> = poses.par_iter().map(|pose| oracle.touches(pose)).collect();
        let posed = Posed { poses: Arc::new(poses), touching: Arc::new(touching), step_mm };
        self.poses.push((*form, posed.clone()));
        posed
    }
}

impl Trial {
    /// Runs every pose; returns verdict and cost.
    fn run(&self) -> Vec<(bool, Counts)> {
        match (&self.contender, self.form.search) {
            (Contender::Octree { octree, tool }, Some(search)) => {
                let detector = Detector::new(octree, tool, NO_ALLOWANCE, self.form.safe, search);
                let mut coherence = Coherence::default();
                let answer = |pose: &Isometry| {
                    let mut counts = Counts::default();
                    let hit = detector.first(pose, self.form.coherent.then_some(&mut coherence), &mut counts);
                    (hit.is_some(), counts)
                };
                self.posed.poses.iter().map(answer).collect()
            }
            (Contender::Trees { surface, tool, .. }, _) => {
                let answer = |pose: &Isometry| {
                    let (hit, counts) = tool.first_counted(surface.as_ref(), pose);
                    let (first_level, points) = (counts.volume_tests, counts.triangle_tests);
                    (hit, Counts { first_level, points, ..Counts::default() })
                };
                self.posed.poses.iter().map(answer).collect()
            }
            (Contender::Octree { .. }, None) => Vec::new(), // Never made: a form without a search is one of trees.
        }
    }

    fn search_name(&self) -> &'static str {
        match (&self.contender, self.form.search) {
            (Contender::Trees { variant, .. }, _) => variant.info.id,
            (_, search) => search.map_or("none", crate::interference::Search::name),
        }
    }

    /// Size of the structure: samples, gray octants and bytes; for trees, triangles and bytes.
    fn size(&self) -> [usize; 3] {
        match &self.contender {
            Contender::Octree { octree, .. } => [octree.points().len(), octree.len(), octree.bytes()],
            Contender::Trees { surface, .. } => [self.mesh.faces().len(), 0, surface.bytes()],
        }
    }

    /// The surface, by name.
    pub fn scene(&self) -> &str {
        &self.scene
    }

    /// Name of the case in the records.
    pub fn case(&self) -> String {
        self.form.case(self.search_name())
    }

    fn row(&self) -> CaseRow {
        let kind = match &self.contender {
            Contender::Octree { .. } => Kind::Sampling,
            Contender::Trees { variant, .. } => variant.kind,
        };
        case_row(&self.case(), kind, self.form.safe, self.form == BASE)
    }

    /// The levels of the form's factors, and the values that follow from them on the surface.
    fn factors(&self) -> Vec<FactorRow> {
        let (case, Form { sweep, level, safe, coherent, division, spacing_mm, .. }) = (self.case(), self.form);
        let covering_mm = match &self.contender {
            Contender::Octree { octree, .. } => octree.covering_mm,
            Contender::Trees { .. } => 0.0,
        };
        let of_case = |factor: &str, level: String| FactorRow::of_case(&case, factor, level);
        let of_scene = |factor: &str, level: f64| FactorRow {
            scene: self.scene.clone(),
            ..FactorRow::of_case(&case, factor, level.to_string())
        };
        vec![
            of_case("sweep", sweep.to_owned()),
            of_case("search", self.search_name().to_owned()),
            of_case("second_level", level.name().to_owned()),
            of_case("safe", u8::from(safe).to_string()),
            of_case("coherence", u8::from(coherent).to_string()),
            of_case("cap", division.cap.to_string()),
            of_case("depth", division.depth.to_string()),
            of_case("spacing_mm", spacing_mm.to_string()),
            of_scene("covering_mm", covering_mm),
            of_scene("step_mm", self.posed.step_mm),
        ]
    }

    /// Counts everything that does not depend on the machine, in one row for colliding poses and one for the others.
    pub fn count(&self, tool: &ToolSubject) -> Rows {
        let mut counts = [1, 0].map(|verdict| self.empty(&self.case(), verdict));
        for ((hit, found), &touching) in self.run().iter().zip(self.posed.touching.iter()) {
            let row = &mut counts[usize::from(!hit)];
            row.poses += 1;
            row.queries += 1;
            row.volume_tests += found.first_level;
            row.second_level_tests += found.second_level;
            row.triangle_tests += found.points;
            row.recalled += found.recalled;
            row.touching += u64::from(touching);
            row.missed += u64::from(touching && !hit);
        }
        let [points, octants, bytes] = self.size().map(|size| size as u64);
        let CaseKey { variant, split, split_axes, leaf } = CaseKey::without_tree(&self.case());
        let (scene, part) = (self.scene.clone(), SURFACE.to_owned());
        let facts = TreeRow { triangles: points, nodes: octants, bytes, ..TreeRow::default() };
        let tree = TreeRow { scene, part, variant, split, split_axes, leaf, ..facts };
        let mut rows = Rows {
            cases: vec![self.row()],
            factors: self.factors(),
            counts: counts.to_vec(),
            trees: vec![tree],
            ..Rows::default()
        };
        if self.form == BASE {
            self.count_kinds(tool, &mut rows);
        }
        rows
    }

    fn empty(&self, case: &str, verdict: u8) -> CountRow {
        CountRow { verdict: Some(verdict), ..CountRow::new(&self.scene, case, 0, None) }
    }

    /// Counts local and global interference separately: the deepest places of the cutter, and those of shank and holder, beside the exact
    /// ground truth on the meshes of these parts. Each stretch of the path is a chunk, because its poses depend on one another.
    fn count_kinds(&self, tool: &ToolSubject, rows: &mut Rows) {
        let Contender::Octree { octree, .. } = &self.contender else { return };
        let boxed = BoxedTool::new(tool.tool.clone(), SecondLevel::None);
        let detector = Detector::new(octree, &boxed, NO_ALLOWANCE, self.form.safe, crate::interference::Search::Octree);
        for (kind, is_local, mesh) in [("local", true, &tool.cutter), ("global", false, &tool.above)] {
            let oracle = PairOracle::new(Arc::clone(mesh), Arc::clone(&self.mesh));
            let answer = |pose: &Isometry| {
                let hits = detector.deepest(pose, &mut Counts::default());
                (oracle.touches(pose), hits.iter().any(|hit| hit.body.is_local() == is_local))
            };
            let answers: Vec<(bool, bool)> = self.posed.poses.par_iter().map(answer).collect();
            for (chunk, answers) in (0..).zip(answers.chunks(BLOCK)) {
                let mut counts = [1, 0].map(|verdict| CountRow { chunk, ..self.empty(kind, verdict) });
                for &(touching, found) in answers {
                    let row = &mut counts[usize::from(!found)];
                    row.poses += 1;
                    row.queries += 1;
                    row.touching += u64::from(touching);
                    row.missed += u64::from(touching && !found);
                }
                rows.counts.extend(counts.into_iter().filter(|row| row.poses > 0));
            }
            rows.cases.push(case_row(kind, Kind::Sampling, self.form.safe, false));
            rows.factors.push(FactorRow::of_case(kind, "kind", kind.to_owned()));
        }
    }

    /// Runs all poses once, for timing. Trees run them in one batch without counting, as in a run.
    pub fn run_once(&self) {
        match &self.contender {
            Contender::Octree { .. } => {
                std::hint::black_box(self.run());
            }
            Contender::Trees { surface, tool, .. } => {
                let mut verdicts = Vec::with_capacity(self.posed.poses.len());
                tool.first(surface.as_ref(), &self.posed.poses, &mut verdicts);
                std::hint::black_box(verdicts);
            }
        }
    }

    /// Time to sample the surface and build its octree, or to build its tree.
    pub fn build_row(&self) -> BuildRow {
        let part = (SURFACE.to_owned(), self.mesh.faces().len() as u64);
        build_row((&self.scene, 0), CaseKey::without_tree(&self.case()), part, 0, self.build_ns)
    }
}

fn case_row(case: &str, kind: Kind, safe: bool, default: bool) -> CaseRow {
    CaseRow { default: u8::from(default), ..CaseRow::new(CaseKey::without_tree(case), case, kind, safe) }
}

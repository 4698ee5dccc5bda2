//! One form of the method over one surface, counted and timed.

use super::super::timer;
use super::subject::{self, ToolSubject};
use super::{AblationBudget, AblationError, Form};
use crate::geometry::shapes::Freeform;
use crate::geometry::{Isometry, Mesh};
use crate::interference::detect::Allowance;
use crate::interference::{BoxedTool, Coherence, Counts, Detector, Samples, SecondLevel, SurfaceOctree};
use crate::method::Model;
use crate::record::{AblationKindRow, AblationRow, AblationTimeRow};
use crate::registry::Variant;
use crate::truth::PairOracle;
use rayon::prelude::*;
use std::sync::Arc;

/// A surface with what its trials share.
pub struct Ground<'a> {
    name: &'static str,
    surface: &'a Freeform,
    budget: &'a AblationBudget,
    tool: &'a ToolSubject,
    variant: &'a Variant,
    meshes: Vec<(f64, Arc<Mesh>)>,
    octrees: Vec<(Form, Arc<SurfaceOctree>, u64)>,
    poses: Vec<(Form, Posed)>,
}

/// Poses with their truth, and the mean way of the tip between them, mm.
#[derive(Clone)]
struct Posed {
    poses: Arc<Vec<Isometry>>,
    touching: Arc<Vec<bool>>,
    step_mm: f64,
}

/// What answers.
enum Contender {
    Octree { octree: Arc<SurfaceOctree>, tool: BoxedTool },
    Trees { name: &'static str, surface: Box<dyn Model>, tool: Box<dyn Model> },
}

/// A form with all it needs.
pub struct Trial {
    pub form: Form,
    name: &'static str,
    contender: Contender,
    mesh: Arc<Mesh>,
    build_ns: u64,
    /// The surface seen from the tool, and whether the meshes of the two touch there, exactly.
    posed: Posed,
}

const NO_ALLOWANCE: Allowance = Allowance { gouge_mm: 0.0, clearance_mm: 0.0 };

impl<'a> Ground<'a> {
    pub fn new(
        name: &'static str,
        surface: &'a Freeform,
        budget: &'a AblationBudget,
        tool: &'a ToolSubject,
        variant: &'a Variant,
    ) -> Self {
        let (meshes, octrees, poses) = (Vec::new(), Vec::new(), Vec::new());
        Self { name, surface, budget, tool, variant, meshes, octrees, poses }
    }

    /// Prepares a form; what an earlier one has made is used again.
    pub fn trial(&mut self, form: Form) -> Result<Trial, AblationError> {
        let mesh = self.mesh(form.density)?;
        let (contender, build_ns) = if form.search.is_some() {
            let (octree, ns) = self.octree(&form, &mesh);
            (Contender::Octree { octree, tool: BoxedTool::new(self.tool.tool.clone(), form.level) }, ns)
        } else {
            let (ns, surface) = timer::time(|| self.variant.prepare(&mesh, None));
            let tool = self.variant.prepare(&self.tool.whole, None);
            (Contender::Trees { name: self.variant.info.id, surface, tool }, ns)
        };
        let posed = self.posed(&form, &mesh);
        Ok(Trial { form, name: self.name, contender, mesh, build_ns, posed })
    }

    fn mesh(&mut self, density: f64) -> Result<Arc<Mesh>, AblationError> {
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
    /// Verdict and cost of every pose.
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
            (Contender::Trees { name, .. }, _) => name,
            (_, search) => search.map_or("none", crate::interference::Search::name),
        }
    }

    /// Samples, gray octants and bytes; of trees, triangles and bytes.
    fn size(&self) -> [usize; 3] {
        match &self.contender {
            Contender::Octree { octree, .. } => [octree.points().len(), octree.len(), octree.bytes()],
            Contender::Trees { surface, .. } => [self.mesh.faces().len(), 0, surface.bytes()],
        }
    }

    /// A row of the poses that hit and one of the others.
    pub fn count(&self) -> Vec<AblationRow> {
        let answers = self.run();
        let [points, octants, bytes] = self.size().map(|size| size as u64);
        let of = |wanted: bool| {
            let chosen = || answers.iter().zip(self.posed.touching.iter()).filter(move |((hit, _), _)| *hit == wanted);
            let sum = |part: &dyn Fn(&Counts) -> u64| chosen().map(|((_, counts), _)| part(counts)).sum::<u64>();
            let touching = chosen().filter(|(_, touching)| **touching).count() as u64;
            AblationRow {
                sweep: self.form.sweep.to_owned(),
                surface: self.name.to_owned(),
                spacing_mm: self.form.spacing_mm,
                covering_mm: match &self.contender {
                    Contender::Octree { octree, .. } => octree.covering_mm,
                    Contender::Trees { .. } => 0.0,
                },
                points,
                cap: self.form.division.cap,
                depth: self.form.division.depth,
                octants,
                bytes,
                search: self.search_name().to_owned(),
                second_level: self.form.level.name().to_owned(),
                safe: u8::from(self.form.safe),
                coherence: u8::from(self.form.coherent),
                step_mm: self.posed.step_mm,
                hit: u8::from(wanted),
                poses: chosen().count() as u64,
                first_level: sum(&|counts| counts.first_level),
                second_level_tests: sum(&|counts| counts.second_level),
                point_tests: sum(&|counts| counts.points),
                recalled: sum(&|counts| counts.recalled),
                touching,
                missed: if wanted { 0 } else { touching },
            }
        };
        vec![of(true), of(false)]
    }

    /// Local and global interference apart: what the deepest places say of cutter and of shank and holder, beside the exact
    /// truth on the meshes of these.
    pub fn kinds(&self, tool: &ToolSubject) -> Vec<AblationKindRow> {
        let Contender::Octree { octree, .. } = &self.contender else { return Vec::new() };
        let boxed = BoxedTool::new(tool.tool.clone(), SecondLevel::None);
        let detector = Detector::new(octree, &boxed, NO_ALLOWANCE, self.form.safe, crate::interference::Search::Octree);
        let of = |kind: &str, is_local: bool, mesh: &Arc<Mesh>| {
            let oracle = PairOracle::new(Arc::clone(mesh), Arc::clone(&self.mesh));
            let answer = |pose: &Isometry| {
                let hits = detector.deepest(pose, &mut Counts::default());
                (oracle.touches(pose), hits.iter().any(|hit| hit.body.is_local() == is_local))
            };
            let answers: Vec<(bool, bool)> = self.posed.poses.par_iter().map(answer).collect();
            let count =
                |wanted: fn(&(bool, bool)) -> bool| answers.iter().filter(|answer| wanted(answer)).count() as u64;
            AblationKindRow {
                surface: self.name.to_owned(),
                kind: kind.to_owned(),
                safe: u8::from(self.form.safe),
                poses: answers.len() as u64,
                touching: count(|(touching, _)| *touching),
                found: count(|(_, found)| *found),
                missed: count(|(touching, found)| *touching && !found),
            }
        };
        vec![of("local", true, &tool.cutter), of("global", false, &tool.above)]
    }

    /// All poses once, as they are timed; trees in one batch and without counting, as a run asks them.
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

    /// The row of a sample.
    pub fn time_row(&self, round: u32, ns: u64) -> AblationTimeRow {
        AblationTimeRow {
            sweep: self.form.sweep.to_owned(),
            surface: self.name.to_owned(),
            spacing_mm: self.form.spacing_mm,
            points: self.size()[0] as u64,
            cap: self.form.division.cap,
            depth: self.form.division.depth,
            search: self.search_name().to_owned(),
            second_level: self.form.level.name().to_owned(),
            safe: u8::from(self.form.safe),
            coherence: u8::from(self.form.coherent),
            step_mm: self.posed.step_mm,
            round,
            poses: self.posed.poses.len() as u64,
            ns,
            build_ns: self.build_ns,
        }
    }
}

//! The thesis's method part by part: what octree, second tool level and coherence save, and what sampling misses.
//!
//! Each form of the method answers the same poses on the same free-form surface; counts are taken apart for the poses that hit and
//! those that do not, verdicts are held against the exact truth on the triangulated surface and tool.

use super::Progress;
use super::timer;
use crate::geometry::shapes::outline::{OutlineCorner, OutlinePoint};
use crate::geometry::shapes::{Freeform, Revolve, Shape, ShapeError, Tessellation};
use crate::geometry::{Isometry, Mesh};
use crate::interference::detect::Allowance;
use crate::interference::path::{Corner, PathPlan, Pattern};
use crate::interference::profile::{P2, Profile, ProfileError};
use crate::interference::{
    Body, BodyKind, Coherence, Counts, Detector, Division, Samples, Search, SecondLevel, SurfaceOctree, Tool,
};
use crate::record::{AblationRow, AblationTimeRow};
use crate::truth::{PairOracle, Solid};
use rand::seq::SliceRandom;
use rayon::prelude::*;
use std::sync::Arc;
use thiserror::Error;

/// Why the experiment cannot be made.
#[derive(Debug, Error)]
pub enum AblationError {
    /// A surface or the tool cannot be meshed.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The tool has impossible dimensions.
    #[error(transparent)]
    Profile(#[from] ProfileError),
}

/// How much is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AblationBudget {
    /// Contact points of a row of the path.
    pub points: u32,
    /// Rows of the path.
    pub rows: u32,
    /// Rounds of timing.
    pub rounds: u32,
    /// Whether the sweeps are made beside the parts.
    pub sweeps: bool,
}

/// One form of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Form {
    sweep: &'static str,
    search: Search,
    level: SecondLevel,
    safe: bool,
    coherent: bool,
    division: Division,
    spacing_mm: f64,
    /// Poses between two contact points of the plan.
    fineness: u32,
}

/// The form that the others differ from.
const BASE: Form = Form {
    sweep: "parts",
    search: Search::Octree,
    level: SecondLevel::None,
    safe: true,
    coherent: false,
    division: Division { cap: 16, depth: 12 },
    spacing_mm: 0.5,
    fineness: 1,
};

fn forms(sweeps: bool) -> Vec<Form> {
    let mut forms = Vec::new();
    for safe in [false, true] {
        let base = Form { safe, ..BASE };
        forms.extend([Search::Points, Search::Leaves].map(|search| Form { search, ..base }));
        forms.extend(SecondLevel::ALL.map(|level| Form { level, ..base }));
        forms.extend([SecondLevel::None, SecondLevel::Profile4].map(|level| Form { level, coherent: true, ..base }));
    }
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

/// The surfaces: a hollow, a steep wall, a saddle and a thin fin.
fn surfaces() -> Vec<(&'static str, Freeform)> {
    let net = |rows: [[f64; 6]; 5]| rows.map(|row| row.to_vec()).to_vec();
    let of = |heights_mm| Freeform { size_mm: [100.0, 80.0], heights_mm };
    vec![
        (
            "hollow",
            of(net([
                [32.0, 31.0, 30.0, 30.0, 31.0, 32.0],
                [31.0, 20.0, 8.0, 9.0, 22.0, 32.0],
                [30.0, 10.0, 4.0, 5.0, 12.0, 31.0],
                [31.0, 21.0, 9.0, 10.0, 23.0, 32.0],
                [33.0, 32.0, 31.0, 31.0, 32.0, 33.0],
            ])),
        ),
        (
            "wall",
            of(net([
                [10.0, 10.0, 10.0, 48.0, 50.0, 50.0],
                [10.0, 10.0, 11.0, 49.0, 50.0, 50.0],
                [11.0, 10.0, 12.0, 50.0, 51.0, 50.0],
                [11.0, 11.0, 11.0, 49.0, 50.0, 50.0],
                [10.0, 11.0, 10.0, 48.0, 50.0, 50.0],
            ])),
        ),
        (
            "saddle",
            of(net([
                [12.0, 20.0, 27.0, 27.0, 20.0, 12.0],
                [18.0, 21.0, 24.0, 24.0, 21.0, 18.0],
                [24.0, 22.0, 21.0, 21.0, 22.0, 24.0],
                [18.0, 21.0, 24.0, 24.0, 21.0, 18.0],
                [12.0, 20.0, 27.0, 27.0, 20.0, 12.0],
            ])),
        ),
        (
            "fin",
            of(net([
                [12.0, 12.0, 12.0, 12.0, 12.0, 12.0],
                [12.0, 12.0, 13.0, 13.0, 12.0, 12.0],
                [14.0, 40.0, 58.0, 58.0, 40.0, 14.0],
                [12.0, 12.0, 13.0, 13.0, 12.0, 12.0],
                [12.0, 12.0, 12.0, 12.0, 12.0, 12.0],
            ])),
        ),
    ]
}

const CORNER: Corner = Corner { radius_mm: 4.0, corner_mm: 1.0 };
/// Heights at which cutter and shank end, and radii and heights of the holder, mm.
const TOOL_MM: [f64; 6] = [20.0, 45.0, 10.0, 55.0, 20.0, 90.0];

/// The tool by its profiles, and the same as a mesh; the mesh's circles are inscribed, so it lies within the profiles.
fn tool() -> Result<(Tool, Mesh), AblationError> {
    let Corner { radius_mm: radius, corner_mm: corner } = CORNER;
    let [cut, neck, lower, shoulder, upper, top] = TOOL_MM;
    let points = [(0.0, neck), (lower, neck), (upper, shoulder), (upper, top), (0.0, top)];
    let bodies = vec![
        Body { kind: BodyKind::Cutter, profile: Profile::bull_nose(radius, corner, cut)? },
        Body { kind: BodyKind::Shank, profile: Profile::cylinder(radius, neck - cut)?.raised(cut) },
        Body { kind: BodyKind::Holder, profile: Profile::of_lines(&points.map(|(r, z)| P2::new(r, z))) },
    ];
    let arc = OutlineCorner { at_mm: [radius - corner, 0.0], arc_mm: corner, ..OutlineCorner::default() };
    let sharp = |at| OutlinePoint::Sharp(at);
    let profile_mm = vec![
        sharp([0.0, 0.0]),
        OutlinePoint::Detailed(arc),
        sharp([radius, corner]),
        sharp([radius, neck]),
        sharp([lower, neck]),
        sharp([upper, shoulder]),
        sharp([upper, top]),
        sharp([0.0, top]),
    ];
    let mesh = Shape::Revolve(Revolve { profile_mm }).mesh(&Tessellation { density: 2.0, grading: 1.0 })?;
    Ok((Tool { bodies }, mesh))
}

/// Sinkings of the tool, mm, each for a stretch of the path: lifted, clear, grazing, gouging.
const SUNK_MM: [f64; 6] = [-5.0, -0.3, -0.02, 0.02, 0.05, 0.3];
/// Contact points of a stretch.
const STRETCH: usize = 25;

/// The surface seen from the tool at each pose, and the mean way of the tip from pose to pose, mm.
fn poses(surface: &Freeform, budget: &AblationBudget, fineness: u32) -> (Vec<Isometry>, f64) {
    let plan = PathPlan {
        pattern: Pattern::ZigZag,
        rows: budget.rows,
        points: budget.points * fineness,
        margin: 0.06,
        lead: 0.15,
        tilt: 0.05,
    };
    let stretch = STRETCH * fineness as usize;
    // A finer path is as long in poses: its first part, so that the same time buys the same counts.
    let poses: Vec<Isometry> = plan
        .contacts(surface)
        .iter()
        .take((budget.points * budget.rows) as usize)
        .enumerate()
        .map(|(k, contact)| contact.surface_from_tool(CORNER, SUNK_MM[k / stretch % SUNK_MM.len()]))
        .collect();
    let ways = poses.windows(2).map(|pair| (pair[1].translation.vector - pair[0].translation.vector).norm());
    let mean = ways.sum::<f64>() / (poses.len().max(2) - 1) as f64;
    (poses.iter().map(Isometry::inverse).collect(), mean)
}

/// Makes the experiment. Counts do not depend on the machine.
///
/// # Errors
/// When a surface or the tool cannot be made.
pub fn ablation(
    budget: &AblationBudget,
    seed: u64,
    progress: &dyn Progress,
) -> Result<(Vec<AblationRow>, Vec<AblationTimeRow>), AblationError> {
    let (tool, tool_mesh) = tool()?;
    let tool_mesh = Arc::new(tool_mesh);
    let (mut rows, mut times) = (Vec::new(), Vec::new());
    for (name, surface) in surfaces() {
        let mesh = Arc::new(Shape::Freeform(surface.clone()).mesh(&Tessellation { density: 2.0, grading: 1.0 })?);
        let forms = forms(budget.sweeps);
        progress.begin(&format!("octree method on `{name}`"), forms.len() as u64 * u64::from(budget.rounds + 1));
        let oracle = PairOracle::new(Arc::clone(&tool_mesh), Arc::clone(&mesh));
        let solid = Solid::new(Arc::clone(&mesh));
        let mut trials: Vec<Trial> = Vec::new();
        for form in forms {
            let known = trials
                .iter()
                .find(|trial| trial.form.division == form.division && trial.form.spacing_mm == form.spacing_mm);
            let (octree, build_ns) = known.map_or_else(
                || {
                    let build =
                        || SurfaceOctree::new(Samples::of(&mesh, form.spacing_mm), form.division, &|p| solid.holds(p));
                    let (ns, octree) = timer::time(build);
                    (Arc::new(octree), ns)
                },
                |trial| (Arc::clone(&trial.octree), trial.build_ns),
            );
            let known = trials.iter().find(|trial| trial.form.fineness == form.fineness);
            let (poses, touching, step_mm) = known.map_or_else(
                || {
                    let (poses, step_mm) = poses(&surface, budget, form.fineness);
                    let touching: Vec<bool> = poses.par_iter().map(|pose| oracle.touches(pose)).collect();
                    (Arc::new(poses), Arc::new(touching), step_mm)
                },
                |trial| (Arc::clone(&trial.poses), Arc::clone(&trial.touching), trial.step_mm),
            );
            trials.push(Trial { form, octree, build_ns, poses, touching, step_mm });
        }
        for trial in &trials {
            rows.extend(trial.count(name, &tool));
            progress.advance(1);
        }
        for round in 0..budget.rounds {
            let mut order: Vec<&Trial> = trials.iter().collect();
            order.shuffle(&mut rand_pcg::Pcg64::new(u128::from(seed), u128::from(round)));
            times.extend(order.into_iter().map(|trial| {
                progress.advance(1);
                trial.time(name, &tool, round)
            }));
        }
    }
    Ok((rows, times))
}

/// A form with all it needs.
struct Trial {
    form: Form,
    octree: Arc<SurfaceOctree>,
    build_ns: u64,
    poses: Arc<Vec<Isometry>>,
    touching: Arc<Vec<bool>>,
    step_mm: f64,
}

const NO_ALLOWANCE: Allowance = Allowance { gouge_mm: 0.0, clearance_mm: 0.0 };

impl Trial {
    fn detector<'a>(&'a self, tool: &'a Tool) -> Detector<'a> {
        Detector::new(&self.octree, tool, NO_ALLOWANCE, self.form.safe, self.form.level, self.form.search)
    }

    /// Verdict and cost of every pose.
    fn run(&self, detector: &Detector) -> Vec<(bool, Counts)> {
        let mut coherence = Coherence::default();
        let answer = |pose: &Isometry| {
            let mut counts = Counts::default();
            let hit = detector.first(pose, self.form.coherent.then_some(&mut coherence), &mut counts);
            (hit.is_some(), counts)
        };
        self.poses.iter().map(answer).collect()
    }

    fn count(&self, surface: &str, tool: &Tool) -> Vec<AblationRow> {
        let answers = self.run(&self.detector(tool));
        let of = |wanted: bool| {
            let chosen = || answers.iter().zip(self.touching.iter()).filter(move |((hit, _), _)| *hit == wanted);
            let sum = |part: &dyn Fn(&Counts) -> u64| chosen().map(|((_, counts), _)| part(counts)).sum::<u64>();
            let touching = chosen().filter(|(_, touching)| **touching).count() as u64;
            AblationRow {
                sweep: self.form.sweep.to_owned(),
                surface: surface.to_owned(),
                spacing_mm: self.form.spacing_mm,
                covering_mm: self.octree.covering_mm,
                points: self.octree.points().len() as u64,
                cap: self.form.division.cap,
                depth: self.form.division.depth,
                octants: self.octree.len() as u64,
                bytes: self.octree.bytes() as u64,
                search: self.form.search.name().to_owned(),
                second_level: self.form.level.name().to_owned(),
                safe: u8::from(self.form.safe),
                coherence: u8::from(self.form.coherent),
                step_mm: self.step_mm,
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

    fn time(&self, surface: &str, tool: &Tool, round: u32) -> AblationTimeRow {
        let detector = self.detector(tool);
        let (ns, _) = timer::time(|| self.run(&detector));
        AblationTimeRow {
            sweep: self.form.sweep.to_owned(),
            surface: surface.to_owned(),
            spacing_mm: self.form.spacing_mm,
            cap: self.form.division.cap,
            depth: self.form.division.depth,
            search: self.form.search.name().to_owned(),
            second_level: self.form.level.name().to_owned(),
            safe: u8::from(self.form.safe),
            coherence: u8::from(self.form.coherent),
            step_mm: self.step_mm,
            round,
            poses: self.poses.len() as u64,
            ns,
            build_ns: self.build_ns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Silent;
    use super::*;

    #[test]
    fn safe_forms_miss_nothing_and_the_hierarchy_saves_tests() {
        let budget = AblationBudget { points: 30, rows: 5, rounds: 1, sweeps: false };
        let (rows, times) = ablation(&budget, 1, &Silent).unwrap();
        assert_eq!((rows.len(), times.len()), (4 * 16 * 2, 4 * 16));
        let touching: u64 = rows.iter().map(|row| row.touching).sum();
        assert!(touching > 4 * 16 * 20, "{touching}");
        assert!(rows.iter().all(|row| row.safe == 0 || row.missed == 0), "a safe form misses contact");
        let tests = |search: &str| -> u64 {
            let of = rows.iter().filter(|row| row.search == search && row.second_level == "none" && row.coherence == 0);
            of.map(|row| row.first_level).sum()
        };
        assert!(tests("leaves") > 3 * tests("octree"), "{} {}", tests("leaves"), tests("octree"));
    }
}

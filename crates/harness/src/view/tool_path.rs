//! Where the tips of the tools are and what carries the work: from these the page draws the way of each tool over the workpiece.

use crate::geometry::{Point, Vector};
use crate::scene::{ProgramRun, Role, Scene};
use serde::Serialize;

/// Points of a cutter that are this near to the farthest one belong to its tip, mm.
const TIP_MM: f64 = 0.05;

/// What the page needs to draw the tool path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ToolPath {
    /// The link that carries the work; `None` is the world.
    work: Option<usize>,
    /// A tip per cutter.
    tips: Vec<Tip>,
}

/// The tip of a cutter.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Tip {
    /// The tool that it belongs to; `None` is always there.
    tool: Option<u32>,
    /// The link that carries it.
    link: Option<usize>,
    /// Where it is in that link's frame, mm.
    at: [f64; 3],
}

impl ToolPath {
    /// `None` for a scene without cutters.
    pub fn of(scene: &Scene, run: &ProgramRun) -> Option<Self> {
        let cutters = (0..scene.parts.len()).filter(|&part| scene.parts[part].role == Role::Cutter);
        let tips: Vec<Tip> = cutters.map(|part| tip(scene, run, part)).collect();
        let carried = scene.parts.iter().find(|part| part.role == Role::Workpiece).map(|part| part.link);
        let work = carried.or_else(|| run.tip.as_ref().map(|tip| tip.work_link)).unwrap_or_default();
        (!tips.is_empty()).then_some(Self { work, tips })
    }
}

/// The middle of what is farthest along the tool's axis.
fn tip(scene: &Scene, run: &ProgramRun, part: usize) -> Tip {
    let cutter = &scene.parts[part];
    let along = direction(scene, run, part);
    let points: Vec<Point> = cutter.mesh.vertices().iter().map(|vertex| cutter.link_from_part * vertex).collect();
    let height = |point: &Point| along.dot(&point.coords);
    let farthest = points.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
    let end: Vec<&Point> = points.iter().filter(|point| height(point) > farthest - TIP_MM).collect();
    let sum = end.iter().fold(Vector::zeros(), |sum, point| sum + point.coords);
    Tip { tool: cutter.tool, link: cutter.link, at: (sum / end.len().max(1) as f64).into() }
}

/// From the spindle towards the tip, in the link's frame: as the scene says, else away from what holds the cutter, else down.
fn direction(scene: &Scene, run: &ProgramRun, part: usize) -> Vector {
    let cutter = &scene.parts[part];
    if let Some(tip) = run.tip.as_ref().filter(|tip| tip.tool_link == cutter.link) {
        return tip.direction.into_inner();
    }
    let middle = |index: usize| {
        let part = &scene.parts[index];
        let sum = part
            .mesh
            .vertices()
            .iter()
            .fold(Vector::zeros(), |sum, vertex| sum + (part.link_from_part * vertex).coords);
        sum / part.mesh.vertices().len().max(1) as f64
    };
    let holds = |&index: &usize| {
        let other = &scene.parts[index];
        index != part && other.link == cutter.link && (other.tool.is_none() || other.tool == cutter.tool)
    };
    let is_of_tool = |&index: &usize| matches!(scene.parts[index].role, Role::Holder | Role::Shank);
    let holders: Vec<usize> = (0..scene.parts.len()).filter(holds).collect();
    let holder = holders.iter().find(|index| is_of_tool(index)).or_else(|| holders.first());
    let away = holder.map(|&holder| middle(part) - middle(holder)).unwrap_or_default();
    // Tools lie along an axis of their link.
    let axis = away.iamax();
    if away[axis] == 0.0 { -Vector::z() } else { Vector::ith(axis, away[axis].signum()) }
}

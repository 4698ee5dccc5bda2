//! The subjects of the ablation: four free-form surfaces, a tool with its mesh, and the tool's paths over the surfaces.

use super::super::MeasureError;
use super::AblationBudget;
use crate::geometry::shapes::outline::{OutlineCorner, OutlinePoint};
use crate::geometry::shapes::{Freeform, Revolve, Shape, Tessellation};
use crate::geometry::{Isometry, Mesh};
use crate::interference::path::{Corner, Flaw, PathPlan, Pattern, flawed};
use crate::interference::profile::{P2, Profile};
use crate::interference::{Body, BodyKind, Tool};
use std::sync::Arc;

/// The surfaces: a hollow, a steep wall, a saddle and a thin fin.
pub fn surfaces() -> Vec<(&'static str, Freeform)> {
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

/// A surface as a mesh.
pub fn mesh(surface: &Freeform, density: f64) -> Result<Arc<Mesh>, MeasureError> {
    Ok(Arc::new(Shape::Freeform(surface.clone()).mesh(&Tessellation { density, grading: 1.0 })?))
}

const CORNER: Corner = Corner { radius_mm: 4.0, corner_mm: 1.0 };
/// Heights of the ends of cutter and shank, and radii and heights of the holder, mm.
const TOOL_MM: [f64; 6] = [20.0, 45.0, 10.0, 55.0, 20.0, 90.0];

/// The tool by its profiles, and as meshes: the whole tool, its cutter, and the parts above the cutter. The circles of the meshes are
/// inscribed, so the meshes lie within the profiles.
pub struct ToolSubject {
    pub tool: Tool,
    pub whole: Arc<Mesh>,
    pub cutter: Arc<Mesh>,
    pub above: Arc<Mesh>,
}

impl ToolSubject {
    pub fn new() -> Result<Self, MeasureError> {
        let Corner { radius_mm: radius, corner_mm: corner } = CORNER;
        let [cut, neck, lower, shoulder, upper, top] = TOOL_MM;
        let points = [(0.0, neck), (lower, neck), (upper, shoulder), (upper, top), (0.0, top)];
        let bodies = vec![
            Body { kind: BodyKind::Cutter, profile: Profile::bull_nose(radius, corner, cut)? },
            Body { kind: BodyKind::Shank, profile: Profile::cylinder(radius, neck - cut)?.raised(cut) },
            Body { kind: BodyKind::Holder, profile: Profile::of_lines(&points.map(|(r, z)| P2::new(r, z))) },
        ];
        let arc = OutlineCorner { at_mm: [radius - corner, 0.0], arc_mm: corner, ..OutlineCorner::default() };
        let nose =
            [OutlinePoint::Sharp([0.0, 0.0]), OutlinePoint::Detailed(arc), OutlinePoint::Sharp([radius, corner])];
        let sharp = |points: &[[f64; 2]]| points.iter().map(|&at| OutlinePoint::Sharp(at)).collect::<Vec<_>>();
        let holder = [[lower, neck], [upper, shoulder], [upper, top], [0.0, top]];
        let turned = |parts: [&[OutlinePoint]; 2]| {
            let shape = Shape::Revolve(Revolve { profile_mm: parts.concat() });
            shape.mesh(&Tessellation { density: 2.0, grading: 1.0 }).map(Arc::new)
        };
        Ok(Self {
            tool: Tool { bodies },
            whole: turned([&nose, &sharp(&[&[[radius, neck]], &holder[..]].concat())])?,
            cutter: turned([&nose, &sharp(&[[radius, cut], [0.0, cut]])])?,
            above: turned([&sharp(&[[0.0, cut], [radius, cut], [radius, neck]]), &sharp(&holder)])?,
        })
    }
}

/// State of the tool on each stretch of the path: depth in the surface, mm, and additional tilt, radians. The stretches are lifted, clear,
/// grazing, gouging, and tilted so far that the holder comes near the surface.
const STRETCHES: [(f64, f64); 7] =
    [(-5.0, 0.0), (-0.3, 0.0), (-0.02, 0.0), (0.02, 0.0), (0.05, 0.0), (0.3, 0.0), (-0.3, 1.25)];
/// Number of contact points of a stretch.
const STRETCH: usize = 25;

/// The pose of the surface in the tool's frame at each step, and the mean distance of the tip between steps, mm.
pub fn poses(surface: &Freeform, budget: &AblationBudget, fineness: u32) -> (Vec<Isometry>, f64) {
    let plan = |fineness: u32| PathPlan {
        pattern: Pattern::ZigZag,
        rows: budget.rows,
        step_mm: budget.step_mm / f64::from(fineness),
        margin: 0.06,
        lead: 0.15,
        tilt: 0.05,
    };
    let stretch = STRETCH * fineness as usize;
    // A finer path is as long in poses: its first part, so that the same time buys the same counts.
    let count = plan(1).contacts(surface).expect("a row has few points").len();
    let contacts = plan(fineness).contacts(surface).expect("the experiment's steps are coarse");
    let poses: Vec<Isometry> = contacts
        .iter()
        .take(count)
        .enumerate()
        .map(|(k, contact)| {
            let (sunk_mm, angle) = STRETCHES[k / stretch % STRETCHES.len()];
            flawed(contact, Flaw::Lean { angle }).contact.surface_from_tool(CORNER, sunk_mm)
        })
        .collect();
    let ways = poses.windows(2).map(|pair| (pair[1].translation.vector - pair[0].translation.vector).norm());
    let mean = ways.sum::<f64>() / (poses.len().max(2) - 1) as f64;
    (poses.iter().map(Isometry::inverse).collect(), mean)
}

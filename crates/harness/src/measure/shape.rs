//! Trees described before any query: size, balance, tightness level by level, and outlines for drawing.

use super::Progress;
use super::plan::{Case, Plan};
use crate::geometry::{Mesh, Point, Triangle, triangle};
use crate::record::rows::CaseKey;
use crate::record::{MESH_OUTLINE, OutlineRow, TightnessRow, TreeRow};
use crate::scene::Scene;
use crate::tree::tightness::{LevelReport, TreeReport, hull_volume};
use crate::volume::Segment;
use obbtree::cases::Draw;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Faces that meet at a sharper angle than this show an edge in a drawing, degrees.
const FEATURE_ANGLE_DEG: f64 = 30.0;
/// A normal with a component smaller than this along an axis of view counts as turned away: the sides of a prism are, in
/// spite of rounding.
const EDGE_ON: f64 = 1e-9;
/// The coordinate axes as records name them.
const VIEWS: [&str; 3] = ["x", "y", "z"];

/// What there is to say about the trees over a scene's examined parts.
#[derive(Clone, Debug, Default)]
pub struct Shapes {
    /// One row per tree.
    pub trees: Vec<TreeRow>,
    /// One row per tree and level.
    pub tightness: Vec<TightnessRow>,
    /// Feature edges of the parts, and the root volumes of every variant's default policy.
    pub outlines: Vec<OutlineRow>,
}

impl Shapes {
    fn extend(&mut self, more: Self) {
        self.trees.extend(more.trees);
        self.tightness.extend(more.tightness);
        self.outlines.extend(more.outlines);
    }
}

/// Describes the trees of every case over every part that belongs to an examined pair.
pub fn describe_scene(plan: &Plan, scene: &Scene, progress: &dyn Progress) -> Shapes {
    let parts: BTreeSet<usize> = scene.pairs.iter().flat_map(|pair| [pair.a, pair.b]).collect();
    progress.begin(&format!("{}: tightness", scene.name), (parts.len() * plan.cases.len()) as u64);
    let mut shapes = Shapes::default();
    for &part in &parts {
        let (features, silhouettes) = drawn_edges(&scene.parts[part].mesh);
        shapes.outlines.extend(outline_rows(scene, part, MESH_OUTLINE, "", &features));
        for (view, silhouette) in VIEWS.into_iter().zip(&silhouettes) {
            shapes.outlines.extend(outline_rows(scene, part, MESH_OUTLINE, view, silhouette));
        }
        let mut drawn = BTreeSet::new();
        let cases: Vec<(&Case, bool)> = plan.cases.iter().map(|case| (case, drawn.insert(case.id.as_str()))).collect();
        let of_case = |&(case, is_first_of_variant): &(&Case, bool)| {
            let mut shapes = Shapes::default();
            describe(case, scene, part, is_first_of_variant, &mut shapes);
            if is_first_of_variant {
                describe_turned(plan, case, scene, part, &mut shapes);
            }
            progress.advance(1);
            shapes
        };
        for of_case in cases.par_iter().map(of_case).collect::<Vec<Shapes>>() {
            shapes.extend(of_case);
        }
    }
    shapes
}

fn describe(case: &Case, scene: &Scene, part: usize, draw: bool, shapes: &mut Shapes) {
    let mesh = &scene.parts[part].mesh;
    let model = case.variant.prepare(mesh, case.policy);
    let Some(report) = model.tree_report() else { return };
    shapes.tightness.extend(report.levels.iter().map(|level| tightness_row(case, scene, part, 0, level)));
    if draw {
        shapes.outlines.extend(outline_rows(scene, part, &case.id, "", &report.root_outline));
    }
    shapes.trees.push(tree_row(scene, part, case.key(), &report, model.bytes()));
}

/// The row of a tree over a part.
pub fn tree_row(scene: &Scene, part: usize, case: CaseKey, report: &TreeReport, bytes: usize) -> TreeRow {
    let part = &scene.parts[part];
    // In the mesh's order of triangles, so that the sums are the same for every case to the last bit.
    let triangles = part.mesh.triangles();
    let of_volumes = report.summary.as_ref();
    let CaseKey { variant, split, split_axes, leaf } = case;
    TreeRow {
        scene: scene.name.clone(),
        part: part.name.clone(),
        variant,
        split,
        split_axes,
        leaf,
        triangles: triangles.len() as u64,
        nodes: report.nodes as u64,
        leaves: report.leaves as u64,
        depth_max: report.depth_max,
        depth_mean: report.depth_mean,
        child_ratio: report.child_ratio,
        sah_cost: report.sah_cost,
        bytes: bytes as u64,
        drift_mm: report.drift_mm,
        root_volume_mm3: of_volumes.map(|s| s.root_volume_mm3),
        hull_mm3: of_volumes.and_then(|_| hull_volume(&triangles)),
        volumes_area_mm2: of_volumes.map(|s| s.area_mm2),
        part_area_mm2: of_volumes.map(|_| triangles.iter().map(Triangle::area).sum()),
        outside_nodes: of_volumes.map(|s| s.outside_nodes),
        outside_corners_pct: of_volumes.map(|s| 100.0 * s.outside_corners as f64 / s.corners as f64),
        overhang_mm: of_volumes.map(|s| s.overhang_mm),
    }
}

/// The levels of the variant's trees over the part turned at random in its own frame.
fn describe_turned(plan: &Plan, case: &Case, scene: &Scene, part: usize, shapes: &mut Shapes) {
    let (mesh, name) = (&scene.parts[part].mesh, &scene.parts[part].name);
    for frame in 1..=plan.budget.frames {
        let turn = Draw::new(plan.selection.seed, &["frame", &scene.name, name], u64::from(frame)).rotation();
        // About the middle, so that a part far from its origin stays in range.
        let (low, high) = triangle::bounds(&mesh.triangles()).unwrap_or((Point::origin(), Point::origin()));
        let middle = nalgebra::center(&low, &high);
        let vertices = mesh.vertices().iter().map(|p| middle + turn * (p - middle)).collect();
        let Ok(turned) = Mesh::new(vertices, mesh.faces().to_vec()) else { continue };
        let Some(report) = case.variant.prepare(&turned, case.policy).tree_report() else { return };
        shapes.tightness.extend(report.levels.iter().map(|level| tightness_row(case, scene, part, frame, level)));
    }
}

fn tightness_row(case: &Case, scene: &Scene, part: usize, frame: u32, level: &LevelReport) -> TightnessRow {
    let CaseKey { variant, split, split_axes, leaf } = case.key();
    TightnessRow {
        scene: scene.name.clone(),
        part: scene.parts[part].name.clone(),
        variant,
        split,
        split_axes,
        leaf,
        frame,
        level: level.level,
        nodes: level.nodes,
        triangles: level.triangles,
        volume_mm3: level.volume_mm3,
        area_mm2: level.area_mm2,
        hull_mm3: level.hull_mm3,
        hulled_volume_mm3: level.hulled_volume_mm3,
        outside_corners_pct: level.outside_corners_pct,
        outside_area_pct: level.outside_area_pct,
        overhang_mm: level.overhang_mm,
        hausdorff_mm: level.hausdorff_mm,
        sibling_overlap_mm3: level.sibling_overlap_mm3,
    }
}

fn outline_rows(scene: &Scene, part: usize, variant: &str, view: &str, segments: &[Segment]) -> Vec<OutlineRow> {
    let row = |[p, q]: &Segment| OutlineRow {
        scene: scene.name.clone(),
        part: scene.parts[part].name.clone(),
        variant: variant.to_owned(),
        view: view.to_owned(),
        x1_mm: p.x,
        y1_mm: p.y,
        z1_mm: p.z,
        x2_mm: q.x,
        y2_mm: q.y,
        z2_mm: q.z,
    };
    segments.iter().map(row).collect()
}

/// The edges at which neighbouring faces meet at more than [`FEATURE_ANGLE_DEG`] or that have one face only; and apart from
/// these, for each coordinate axis, the edges of the silhouette seen along it.
fn drawn_edges(mesh: &Mesh) -> (Vec<Segment>, [Vec<Segment>; 3]) {
    let normals: Vec<_> = mesh.triangles().iter().map(|t| t.double_area_normal().try_normalize(0.0)).collect();
    let mut faces_of: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for (face, corners) in mesh.faces().iter().enumerate() {
        for (p, q) in [(0, 1), (1, 2), (2, 0)] {
            let (p, q) = (corners[p], corners[q]);
            faces_of.entry((p.min(q), p.max(q))).or_default().push(face);
        }
    }
    let sharp = FEATURE_ANGLE_DEG.to_radians().cos();
    let (mut features, mut silhouettes) = (Vec::new(), [const { Vec::new() }; 3]);
    for (&(p, q), faces) in &faces_of {
        let edge = [p, q].map(|vertex| mesh.vertices()[vertex as usize]);
        let &[one, other] = faces.as_slice() else {
            features.push(edge);
            continue;
        };
        // A face without a direction shows nothing.
        let Some((n, m)) = normals[one].zip(normals[other]) else { continue };
        if n.dot(&m) < sharp {
            features.push(edge);
            continue;
        }
        for (axis, silhouette) in silhouettes.iter_mut().enumerate() {
            if (n[axis] > EDGE_ON) != (m[axis] > EDGE_ON) {
                silhouette.push(edge);
            }
        }
    }
    (features, silhouettes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bent_sheet_shows_its_rim_and_its_bend() {
        let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
        let vertices = vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0), p(1.0, 1.0, 1.0)];
        let bent = Mesh::new(vertices.clone(), vec![[0, 1, 2], [1, 3, 2]]).unwrap();
        assert_eq!(drawn_edges(&bent).0.len(), 5); // four rims and the bend
        let flat = Mesh::new(vec![vertices[0], vertices[1], vertices[2], p(1.0, 1.0, 0.0)], vec![[0, 1, 2], [1, 3, 2]])
            .unwrap();
        assert_eq!(drawn_edges(&flat).0.len(), 4);
    }

    #[test]
    fn a_ball_has_no_features_and_a_round_silhouette_along_every_axis() {
        let ball = obbtree::cases::meshes::sphere(10.0, 24, 12);
        let (features, silhouettes) = drawn_edges(&ball);
        assert_eq!(features.len(), 0);
        for (axis, silhouette) in silhouettes.iter().enumerate() {
            assert!(!silhouette.is_empty());
            // All of it lies near the rim of the disc that the ball is seen as, a facet's width at most inside.
            for point in silhouette.iter().flatten() {
                let seen = [0, 1, 2].into_iter().filter(|&i| i != axis).map(|i| point[i].powi(2)).sum::<f64>().sqrt();
                assert!(seen > 9.0, "{axis}: {point}");
            }
        }
    }
}

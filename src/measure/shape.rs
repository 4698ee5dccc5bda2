//! Trees described before any query: size, balance, tightness level by level, and outlines for drawing.

use super::Progress;
use super::plan::{Case, Plan};
use crate::geometry::Mesh;
use crate::record::{MESH_OUTLINE, OutlineRow, TightnessRow, TreeRow};
use crate::scene::Scene;
use crate::volume::Segment;
use std::collections::{BTreeMap, BTreeSet};

/// Faces that meet at a sharper angle than this show an edge in a drawing, degrees.
const FEATURE_ANGLE_DEG: f64 = 30.0;
/// The same for edges on the convex hull: a fillet is seen as an outline, and drawings reach the part's extremes.
const OUTLINE_ANGLE_DEG: f64 = 2.0;

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

/// Describes the trees of every case over every part that belongs to an examined pair.
pub fn describe_scene(plan: &Plan, scene: &Scene, progress: &dyn Progress) -> Shapes {
    let parts: BTreeSet<usize> = scene.pairs.iter().flat_map(|pair| [pair.a, pair.b]).collect();
    progress.begin(&format!("{}: tightness", scene.name), (parts.len() * plan.cases.len()) as u64);
    let mut shapes = Shapes::default();
    for &part in &parts {
        shapes.outlines.extend(outline_rows(scene, part, MESH_OUTLINE, &feature_edges(&scene.parts[part].mesh)));
        let mut drawn = BTreeSet::new();
        for case in &plan.cases {
            let first_of_variant = drawn.insert(case.id.as_str());
            describe(case, scene, part, first_of_variant, &mut shapes);
            progress.advance(1);
        }
    }
    shapes
}

fn describe(case: &Case, scene: &Scene, part: usize, draw: bool, shapes: &mut Shapes) {
    let mesh = &scene.parts[part].mesh;
    let model = case.variant.prepare(mesh, case.policy);
    let Some(report) = model.tree_report() else { return };
    let (split, axes, leaf) = case.policy_columns();
    let (scene_name, part_name) = (scene.name.clone(), scene.parts[part].name.clone());
    for level in &report.levels {
        shapes.tightness.push(TightnessRow {
            scene: scene_name.clone(),
            part: part_name.clone(),
            variant: case.id.clone(),
            split: split.clone(),
            axes: axes.clone(),
            leaf,
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
        });
    }
    if draw {
        shapes.outlines.extend(outline_rows(scene, part, &case.id, &report.root_outline));
    }
    shapes.trees.push(TreeRow {
        scene: scene_name,
        part: part_name,
        variant: case.id.clone(),
        split,
        axes,
        leaf,
        triangles: mesh.faces().len() as u64,
        nodes: report.nodes as u64,
        leaves: report.leaves as u64,
        depth_max: report.depth_max,
        depth_mean: report.depth_mean,
        child_ratio: report.child_ratio,
        sah_cost: report.sah_cost,
        bytes: model.bytes() as u64,
        drift_mm: report.drift_mm,
    });
}

fn outline_rows(scene: &Scene, part: usize, variant: &str, segments: &[Segment]) -> Vec<OutlineRow> {
    let row = |[p, q]: &Segment| OutlineRow {
        scene: scene.name.clone(),
        part: scene.parts[part].name.clone(),
        variant: variant.to_owned(),
        x1_mm: p.x,
        y1_mm: p.y,
        z1_mm: p.z,
        x2_mm: q.x,
        y2_mm: q.y,
        z2_mm: q.z,
    };
    segments.iter().map(row).collect()
}

/// The edges at which neighbouring faces meet at more than [`FEATURE_ANGLE_DEG`] ([`OUTLINE_ANGLE_DEG`] on the convex hull), or
/// that have one face only.
fn feature_edges(mesh: &Mesh) -> Vec<Segment> {
    let normals: Vec<_> = mesh.triangles().iter().map(|t| t.double_area_normal().try_normalize(0.0)).collect();
    let mut faces_of: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
    for (face, corners) in mesh.faces().iter().enumerate() {
        for (p, q) in [(0, 1), (1, 2), (2, 0)] {
            let (p, q) = (corners[p], corners[q]);
            faces_of.entry((p.min(q), p.max(q))).or_default().push(face);
        }
    }
    let on_hull = hull_vertices(mesh);
    let (sharp, slight) = (FEATURE_ANGLE_DEG.to_radians().cos(), OUTLINE_ANGLE_DEG.to_radians().cos());
    let is_feature = |&(p, q): &(u32, u32), faces: &[usize]| {
        let cosine = if on_hull.contains(&p) && on_hull.contains(&q) { slight } else { sharp };
        match faces {
            &[one, other] => normals[one].zip(normals[other]).is_some_and(|(n, m)| n.dot(&m) < cosine),
            _ => true,
        }
    };
    let vertex = |v: u32| mesh.vertices()[v as usize];
    faces_of.iter().filter(|(edge, faces)| is_feature(edge, faces)).map(|(&(p, q), _)| [vertex(p), vertex(q)]).collect()
}

/// The vertices on the convex hull; none for a part without one.
fn hull_vertices(mesh: &Mesh) -> BTreeSet<u32> {
    let points: Vec<_> = mesh.vertices().iter().map(|p| p.coords.into()).collect();
    let Ok((corners, _)) = parry3d_f64::transformation::try_convex_hull(&points) else { return BTreeSet::new() };
    let key = |p: [f64; 3]| p.map(|x| (x + 0.0).to_bits());
    let corners: BTreeSet<[u64; 3]> = corners.iter().map(|p| key([p.x, p.y, p.z])).collect();
    let on_hull = mesh.vertices().iter().zip(0..).filter(|(p, _)| corners.contains(&key([p.x, p.y, p.z])));
    on_hull.map(|(_, vertex)| vertex).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    #[test]
    fn a_bent_sheet_shows_its_rim_and_its_bend() {
        let p = |x: f64, y: f64, z: f64| Point::new(x, y, z);
        let vertices = vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0), p(1.0, 1.0, 1.0)];
        let bent = Mesh::new(vertices.clone(), vec![[0, 1, 2], [1, 3, 2]]).unwrap();
        assert_eq!(feature_edges(&bent).len(), 5); // four rims and the bend
        let flat = Mesh::new(vec![vertices[0], vertices[1], vertices[2], p(1.0, 1.0, 0.0)], vec![[0, 1, 2], [1, 3, 2]])
            .unwrap();
        assert_eq!(feature_edges(&flat).len(), 4);
    }
}

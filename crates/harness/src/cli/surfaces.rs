//! What `scene info` says of the surfaces of parts: closed or not, in how many pieces, and what was done to their files.

use super::scene::table;
use crate::geometry::surface::SurfaceReport;
use crate::scene::{MeshFile, Scene};
use serde_json::{Value, json};

/// A table with a row per part, and a line per mesh file.
pub fn text(scene: &Scene) -> String {
    let mut rows = table(["PART", ">VOLUME mm³", ">AREA mm²", "SURFACE"]);
    for part in &scene.parts {
        let report = part.mesh.surface_report();
        let [volume, area] = [report.volume_mm3, report.area_mm2].map(|value| format!("{value:.1}"));
        rows.add_row([part.name.clone(), volume, area, report.to_string()]);
    }
    let mut text = rows.trim_fmt();
    if !scene.mesh_files.is_empty() {
        text.push('\n');
    }
    for MeshFile { part, file, report } in &scene.mesh_files {
        text.push_str(&format!("\n{part} from {file}: {report}"));
    }
    text
}

/// The same of one part.
pub fn json(scene: &Scene, part: &str, surface: &SurfaceReport) -> Value {
    let SurfaceReport { edges, components, leaking, inward, degenerate, volume_mm3, area_mm2 } = *surface;
    let imported = scene.mesh_files.iter().find(|file| file.part == part).map(|MeshFile { file, report, .. }| {
        json!({
            "file": file, "format": report.format.to_string(), "unit_mm": report.unit_mm, "weld_mm": report.weld_mm,
            "triangles_read": report.triangles_read, "welded_vertices": report.welded_vertices,
            "collapsed_dropped": report.collapsed, "duplicates_dropped": report.duplicate,
        })
    });
    json!({
        "open_edges": edges.open, "non_manifold_edges": edges.non_manifold, "flipped_edges": edges.flipped,
        "components": components, "leaking_components": leaking, "inward_components": inward,
        "degenerate_triangles": degenerate, "volume_mm3": volume_mm3, "area_mm2": area_mm2, "import": imported,
    })
}

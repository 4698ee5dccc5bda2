//! Bytes as a mesh file: an error, or a mesh that is what it promises to be.

use bvbench::geometry::import::{Imported, Options, parse};
use std::collections::HashSet;
use std::path::Path;

/// Reads the bytes as the file of a name, with and without a tolerance of welding.
pub fn run(name: &str, bytes: &[u8]) {
    for weld_mm in [0.0, 0.01] {
        let Ok(Imported { mesh, report }) = parse(Path::new(name), bytes, Options { unit: None, weld_mm }) else {
            continue;
        };
        assert_eq!(mesh.faces().len() + report.duplicate + report.collapsed, report.triangles_read);
        let mut seen = HashSet::new();
        for &face in mesh.faces() {
            let mut corners = face.map(|vertex| mesh.vertices()[vertex as usize]).map(|p| [p.x, p.y, p.z]);
            corners.sort_by(|a, b| a.partial_cmp(b).expect("coordinates are finite"));
            assert!(corners[0] != corners[1] && corners[1] != corners[2], "face {face:?} has collapsed");
            assert!(seen.insert(corners.map(|corner| corner.map(f64::to_bits))), "face {face:?} is there twice");
        }
        let surface = mesh.surface_report();
        assert_eq!(surface.edges.is_watertight(), surface.leaking == 0);
        assert!(surface.volume_mm3.is_finite() && surface.components >= 1 && surface.inward <= surface.components);
    }
}

//! Turns the output of a reader into a mesh: scaled to mm, welded, and without the triangles that the module's header lists as dropped.

use super::super::{Mesh, MeshError, weld};
use super::{Format, ImportReport, Imported, Raw};
use foldhash::{HashSet, HashSetExt};

/// Makes a mesh; vertices at most `weld_mm` apart are merged.
pub(super) fn clean(raw: Raw, format: Format, unit_mm: f64, weld_mm: f64) -> Result<Imported, MeshError> {
    let triangles_read = raw.faces.len();
    let scaled = raw.vertices.into_iter().map(|p| p * unit_mm).collect();
    let (vertices, mut faces) = Mesh::new(scaled, raw.faces)?.without_unused_vertices().into_parts();
    let stands_for = if weld_mm > 0.0 { weld::within(&vertices, weld_mm) } else { weld::equal(&vertices) };
    let welded_vertices = stands_for.iter().zip(0..).filter(|(first, vertex)| *first != vertex).count();

    let (mut duplicate, mut collapsed) = (0, 0);
    let mut seen = HashSet::with_capacity(triangles_read);
    faces.retain_mut(|face| {
        *face = face.map(|vertex| stands_for[vertex as usize]);
        let mut corners = *face;
        corners.sort_unstable();
        let is_collapsed = corners[0] == corners[1] || corners[1] == corners[2];
        let is_duplicate = !is_collapsed && !seen.insert(corners);
        collapsed += usize::from(is_collapsed);
        duplicate += usize::from(is_duplicate);
        !is_collapsed && !is_duplicate
    });
    let mesh = Mesh::new(vertices, faces)?.without_unused_vertices();
    let report = ImportReport { format, unit_mm, weld_mm, triangles_read, duplicate, collapsed, welded_vertices };
    Ok(Imported { mesh, report })
}

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

    let (mut collapsed, mut opposite) = (0, 0);
    let mut seen = HashSet::with_capacity(triangles_read);
    faces.retain_mut(|face| {
        *face = face.map(|vertex| stands_for[vertex as usize]);
        let [a, b, c] = *face;
        let is_collapsed = a == b || b == c || c == a;
        collapsed += usize::from(is_collapsed);
        let is_kept = !is_collapsed && seen.insert(from_least(*face));
        opposite += usize::from(is_kept && seen.contains(&reversed(*face)));
        is_kept
    });
    let both = Mesh::new(vertices, faces)?;
    let mesh = if opposite > 0 { without_opposites(both, &seen)? } else { both };
    let mesh = mesh.without_unused_vertices();
    let duplicate = triangles_read - collapsed - mesh.faces().len();
    let report = ImportReport { format, unit_mm, weld_mm, triangles_read, duplicate, collapsed, welded_vertices };
    Ok(Imported { mesh, report })
}

/// Drops each triangle that winds against an earlier one of the same corners. Bodies with a side in common have such triangles: they stay where the mesh is watertight only with
/// them, and no component consists of them alone, which would enclose nothing then.
fn without_opposites(both: Mesh, seen: &HashSet<[u32; 3]>) -> Result<Mesh, MeshError> {
    let mut before = HashSet::new();
    let mut once = both.faces().to_vec();
    once.retain(|face| {
        before.insert(from_least(*face));
        !before.contains(&reversed(*face))
    });
    let once = Mesh::new(both.vertices().to_vec(), once)?;
    let (component_of, components) = both.components();
    let single = both.faces().iter().zip(&component_of).filter(|(face, _)| !seen.contains(&reversed(**face)));
    let with_single: HashSet<u32> = single.map(|(_, component)| *component).collect();
    let is_closed = |mesh: &Mesh| mesh.edge_report().is_watertight();
    let are_needed = with_single.len() == components && is_closed(&both) && !is_closed(&once);
    Ok(if are_needed { both } else { once })
}

/// The same triangle from its least vertex on: equal for triangles with the same corners and the same winding.
fn from_least([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// The triangle that winds the other way, from its least vertex on.
fn reversed([a, b, c]: [u32; 3]) -> [u32; 3] {
    from_least([a, c, b])
}

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
/// them, and no component consists of them alone, which would enclose nothing then. Beside other components, one that does may be a cavity and the body that fills it: what is left
/// of it faces outwards, whichever came first.
fn without_opposites(both: Mesh, seen: &HashSet<[u32; 3]>) -> Result<Mesh, MeshError> {
    let (component_of, components) = both.components();
    let faces = || both.faces().iter().copied().zip(component_of.iter().map(|component| *component as usize));
    let mut has_single = vec![false; components];
    faces().for_each(|(face, component)| has_single[component] |= !seen.contains(&reversed(face)));
    let mut before = HashSet::new();
    let mut once: Vec<([u32; 3], usize)> = faces().collect();
    once.retain(|(face, _)| {
        before.insert(from_least(*face));
        !before.contains(&reversed(*face))
    });
    if has_single.contains(&true) {
        let mut volumes = vec![0.0; components];
        for (face, component) in &once {
            let [a, b, c] = both.triangle(*face).corners.map(|p| p - both.vertices()[0]);
            volumes[*component] += a.dot(&b.cross(&c));
        }
        for (face, component) in &mut once {
            if !has_single[*component] && volumes[*component] < 0.0 {
                face.swap(1, 2);
            }
        }
    }
    let once = Mesh::new(both.vertices().to_vec(), once.into_iter().map(|(face, _)| face).collect())?;
    let is_closed = |mesh: &Mesh| mesh.edge_report().is_watertight();
    let are_needed = !has_single.contains(&false) && is_closed(&both) && !is_closed(&once);
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

//! Properties of a mesh as a surface: whether it is closed, how many components it has, and which way it faces.
//!
//! Faces share an edge when they use the same two vertices, so vertices must be welded first ([`super::weld`]). Terms follow Botsch,
//! Kobbelt, Pauly, Alliez and Lévy, Polygon Mesh Processing, 2010.

use super::GridMesh;
use std::fmt;

/// How the edges of a mesh fit together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EdgeReport {
    /// Edges used by exactly one triangle: the rims of holes.
    pub open: usize,
    /// Edges used by more than two triangles, more often one way than the other.
    pub non_manifold: usize,
    /// Edges used twice in the same direction: their two triangles have opposite orientations.
    pub flipped: usize,
}

impl EdgeReport {
    /// Whether triangles run along every edge as often one way as the other. Then every ray from a point leaves the mesh equally often more
    /// than it enters, and there is an inside. Bodies may share an edge.
    #[must_use]
    pub const fn is_watertight(&self) -> bool {
        self.open == 0 && self.non_manifold == 0 && self.flipped == 0
    }
}

/// Properties of a mesh as the surface of a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceReport {
    /// How the edges fit together.
    pub edges: EdgeReport,
    /// Number of connected components; faces that share vertices are connected.
    pub components: usize,
    /// Components that are not watertight: triangles run along some edge more often one way than the other.
    pub leaking: usize,
    /// Closed components with negative volume: cavities, or bodies with reversed winding.
    pub inward: usize,
    /// Triangles with collinear corners.
    pub degenerate: usize,
    /// Enclosed volume, mm³; positive when the winding is outward. Not meaningful when a component leaks.
    pub volume_mm3: f64,
    /// The area, mm².
    pub area_mm2: f64,
}

impl SurfaceReport {
    /// Whether the mesh is closed but has negative volume.
    #[must_use]
    pub fn is_inside_out(&self) -> bool {
        self.leaking == 0 && self.volume_mm3 < 0.0
    }
}

impl fmt::Display for SurfaceReport {
    /// Formats as one line, such as `watertight, 2 components, 1 of them facing inwards`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match (self.leaking, self.is_inside_out()) {
            (0, false) => "watertight",
            (0, true) => "watertight but inside out",
            _ => "not watertight: ",
        })?;
        if self.leaking > 0 {
            let EdgeReport { open, non_manifold, flipped } = self.edges;
            let faults = [
                (open, "on one triangle"),
                (non_manifold, "on more than two"),
                (flipped, "between two that wind against each other"),
            ];
            let faults = faults
                .iter()
                .filter(|(number, _)| *number > 0)
                .map(|(number, what)| format!("{number} {} {what}", if *number == 1 { "edge" } else { "edges" }));
            f.write_str(&faults.collect::<Vec<_>>().join(", "))?;
        }
        if self.components > 1 {
            write!(f, ", {} components", self.components)?;
            for (number, what) in [(self.leaking, "leaking"), (self.inward, "facing inwards")] {
                if number > 0 {
                    write!(f, ", {number} {what}")?;
                }
            }
        }
        if self.degenerate > 0 {
            write!(f, ", {} degenerate triangles", self.degenerate)?;
        }
        Ok(())
    }
}

/// The half-edges of a mesh, sorted by their lower vertex, so that the triangles of an edge are adjacent.
struct HalfEdges {
    /// Start of the half-edges of each lower vertex, followed by the end of the last ones.
    begins: Vec<u32>,
    /// For each half-edge, twice the higher vertex, plus one when the half-edge runs from the lower vertex to the higher.
    ends: Vec<u64>,
}

impl HalfEdges {
    fn new(mesh: &GridMesh) -> Self {
        let half_edges = || mesh.faces().iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        // Counted one further on, and moved on by one while they are put there, `begins` ends as it is described.
        let mut begins = vec![0_u32; mesh.vertices().len() + 2];
        half_edges().for_each(|(from, to)| begins[from.min(to) as usize + 2] += 1);
        for vertex in 2..begins.len() {
            begins[vertex] += begins[vertex - 1];
        }
        let mut ends = vec![0; 3 * mesh.faces().len()];
        for (from, to) in half_edges() {
            let place = &mut begins[from.min(to) as usize + 1];
            ends[*place as usize] = u64::from(from.max(to)) << 1 | u64::from(from < to);
            *place += 1;
        }
        begins.pop();
        for vertex in begins.windows(2) {
            ends[vertex[0] as usize..vertex[1] as usize].sort_unstable();
        }
        Self { begins, ends }
    }

    /// For every edge: its lower vertex, and how many triangles use it upwards and downwards.
    fn edges(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        self.begins.windows(2).enumerate().flat_map(|(vertex, range)| {
            let ends = &self.ends[range[0] as usize..range[1] as usize];
            ends.chunk_by(|one, other| one >> 1 == other >> 1).map(move |edge| {
                let upwards = edge.iter().filter(|end| **end & 1 == 1).count();
                (vertex, upwards, edge.len() - upwards)
            })
        })
    }
}

impl GridMesh {
    /// How the edges fit together.
    #[must_use]
    pub fn edge_report(&self) -> EdgeReport {
        let mut report = EdgeReport::default();
        HalfEdges::new(self).edges().for_each(|(_, upwards, downwards)| count(&mut report, upwards, downwards));
        report
    }

    /// The properties of the surface.
    #[must_use]
    pub fn surface_report(&self) -> SurfaceReport {
        let (component_of, components) = self.components();
        let mut report = SurfaceReport { components, ..SurfaceReport::default() };
        let mut component_of_vertex = vec![0; self.vertices().len()];
        let mut volumes = vec![0.0; components];
        for (face, &component) in self.faces().iter().zip(&component_of) {
            face.iter().for_each(|&v| component_of_vertex[v as usize] = component);
            volumes[component as usize] += self.volume_below(*face);
            let area = self.triangle(*face).area();
            report.area_mm2 += area;
            report.degenerate += usize::from(area <= 0.0);
        }
        let mut leaks = vec![false; components];
        for (vertex, upwards, downwards) in HalfEdges::new(self).edges() {
            count(&mut report.edges, upwards, downwards);
            leaks[component_of_vertex[vertex] as usize] |= upwards != downwards;
        }
        report.leaking = leaks.iter().filter(|leaks| **leaks).count();
        report.inward = volumes.iter().zip(&leaks).filter(|(volume, leaks)| **volume < 0.0 && !**leaks).count();
        report.volume_mm3 = volumes.iter().sum();
        report
    }

    /// The volume enclosed by a watertight mesh, mm³; positive when the winding is outward.
    #[must_use]
    pub fn signed_volume(&self) -> f64 {
        self.faces().iter().map(|&face| self.volume_below(face)).sum()
    }

    /// The signed volume of the tetrahedron between a face and the first vertex of the mesh, mm³.
    fn volume_below(&self, face: [u32; 3]) -> f64 {
        let [a, b, c] = self.triangle(face).corners.map(|p| p - self.vertices()[0]);
        a.dot(&b.cross(&c)) / 6.0
    }

    /// The component number of every face (faces that share vertices are connected), counted from 0 in the order of first appearance, and
    /// the number of components.
    #[must_use]
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut parent: Vec<u32> = (0..self.vertices().len() as u32).collect();
        for &[a, b, c] in self.faces() {
            join(&mut parent, a, b);
            join(&mut parent, a, c);
        }
        const NONE: u32 = u32::MAX;
        let (mut number_of, mut numbers) = (vec![NONE; parent.len()], 0);
        let mut label = |face: &[u32; 3]| {
            let number = &mut number_of[root(&mut parent, face[0]) as usize];
            if *number == NONE {
                *number = numbers;
                numbers += 1;
            }
            *number
        };
        let labels = self.faces().iter().map(&mut label).collect();
        (labels, numbers as usize)
    }
}

/// Adds an edge to a report, given how many triangles use it in each direction.
fn count(report: &mut EdgeReport, upwards: usize, downwards: usize) {
    match (upwards, downwards) {
        _ if upwards == downwards => {}
        (1, 0) | (0, 1) => report.open += 1,
        (2, 0) | (0, 2) => report.flipped += 1,
        _ => report.non_manifold += 1,
    }
}

/// The representative of the component of `v`; halves the path to it (Tarjan and van Leeuwen 1984).
fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}

/// Joins the components of two vertices; the earlier representative represents both.
fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parent, a), root(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::super::Point;
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    /// A tetrahedron of 6 · 1 · 1 / 6 = 1 mm³, moved along x.
    fn tetrahedron(x: f64) -> GridMesh {
        let vertices = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let vertices = vertices.map(|[a, b, c]| Point::new(a + x, b, c)).to_vec();
        GridMesh::new(vertices, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
    }

    fn turned(mesh: &GridMesh, faces: std::ops::Range<usize>) -> GridMesh {
        let mut turned = mesh.faces().to_vec();
        turned[faces].iter_mut().for_each(|face| face.swap(0, 1));
        GridMesh::new(mesh.vertices().to_vec(), turned).unwrap()
    }

    /// Both meshes as one, with separate vertices.
    fn both(a: &GridMesh, b: &GridMesh) -> GridMesh {
        let first = a.vertices().len() as u32;
        let faces = a.faces().iter().copied().chain(b.faces().iter().map(|f| f.map(|v| v + first)));
        GridMesh::new([a.vertices(), b.vertices()].concat(), faces.collect()).unwrap()
    }

    #[test]
    fn tetrahedron_is_watertight_with_the_volume_of_a_sixth_box() {
        let report = tetrahedron(0.0).surface_report();
        assert!(report.edges.is_watertight() && !report.is_inside_out());
        assert!((report.volume_mm3 - 1.0).abs() < 1e-12); // 6·1·1 / 6
        // Legs 6·1, 6·1, 1·1, and |(-6, 1, 0) x (-6, 0, 1)| = |(1, 6, 6)| = √73, all halved.
        assert!((report.area_mm2 - (6.0 + 6.0 + 1.0 + 73.0_f64.sqrt()) / 2.0).abs() < 1e-12);
        assert_eq!((report.components, report.leaking, report.inward, report.degenerate), (1, 0, 0, 0));
        assert_eq!(report.to_string(), "watertight");
    }

    #[test]
    fn a_missing_face_opens_three_edges_and_a_turned_one_flips_three() {
        let mesh = tetrahedron(0.0);
        let open = GridMesh::new(mesh.vertices().to_vec(), mesh.faces()[..3].to_vec()).unwrap();
        assert_eq!(open.edge_report(), EdgeReport { open: 3, ..EdgeReport::default() });
        assert_eq!(open.surface_report().to_string(), "not watertight: 3 edges on one triangle");
        let flipped = turned(&mesh, 0..1).surface_report();
        assert_eq!(flipped.edges, EdgeReport { flipped: 3, ..EdgeReport::default() });
        assert_eq!(flipped.to_string(), "not watertight: 3 edges between two that wind against each other");
    }

    #[test]
    fn two_triangles_on_an_edge_are_enough() {
        // Three wings on the edge 0-1, two one way and one the other: it is one edge too many, and six rims are open.
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        let wings = GridMesh::new(corners.map(Point::from).to_vec(), vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
        assert_eq!(wings.edge_report(), EdgeReport { open: 6, non_manifold: 1, flipped: 0 });
    }

    #[test]
    fn bodies_that_share_an_edge_are_closed() {
        // The second tetrahedron is the first, turned by half a turn about their edge.
        let (vertices, faces) = tetrahedron(0.0).into_parts();
        let turned: Vec<Point> = vertices[2..].iter().map(|p| Point::new(p.x, -p.y, -p.z)).collect();
        let second = faces.iter().map(|face| face.map(|v| if v < 2 { v } else { v + 2 }));
        let both = faces.iter().copied().chain(second).collect();
        let mesh = GridMesh::new([vertices, turned].concat(), both).unwrap();
        let report = mesh.surface_report();
        assert!(report.edges.is_watertight() && (report.components, report.leaking) == (1, 0), "{report:?}");
        assert!((report.volume_mm3 - 2.0).abs() < 1e-12 && report.to_string() == "watertight", "{report:?}");
        let open = GridMesh::new(mesh.vertices().to_vec(), mesh.faces()[1..].to_vec()).unwrap();
        assert!(!open.edge_report().is_watertight() && open.surface_report().leaking == 1);
    }

    #[test]
    fn components_count_by_where_they_leak_and_face() {
        let (a, b) = (tetrahedron(0.0), tetrahedron(100.0));
        assert_eq!(both(&a, &b).components(), (vec![0, 0, 0, 0, 1, 1, 1, 1], 2));
        let inside_out = turned(&a, 0..4).surface_report();
        assert!(inside_out.is_inside_out() && (inside_out.volume_mm3 + 1.0).abs() < 1e-12);
        assert_eq!(inside_out.to_string(), "watertight but inside out");
        // One outward, one inward: together no volume, and not inside out.
        let report = both(&b, &turned(&a, 0..4)).surface_report();
        assert_eq!((report.components, report.leaking, report.inward), (2, 0, 1));
        assert!(report.volume_mm3.abs() < 1e-9, "{report:?}");
        assert_eq!(report.to_string().split_once(", ").unwrap().1, "2 components, 1 facing inwards");
        // One turned face in the second.
        let report = both(&a, &turned(&b, 0..1)).surface_report();
        assert_eq!((report.components, report.leaking, report.inward), (2, 1, 0));
    }

    #[test]
    fn faces_without_area_are_counted() {
        let points = [0.0, 1.0, 2.0].map(|x| Point::new(x, 0.0, 0.0)).to_vec();
        let report = GridMesh::new(points, vec![[0, 1, 2], [0, 0, 1]]).unwrap().surface_report();
        assert_eq!((report.degenerate, report.leaking, report.components), (2, 1, 1));
    }

    proptest! {
        /// Compares the edges with a table of all edges.
        #[test]
        fn edges_are_those_of_a_table(faces in prop::collection::vec([0..7_u32, 0..7_u32, 0..7_u32], 1..40)) {
            let vertices = (0..7).map(|i| Point::new(f64::from(i), f64::from(i * i), 0.0)).collect();
            let mesh = GridMesh::new(vertices, faces.clone()).unwrap();
            let mut uses: BTreeMap<(u32, u32), (usize, usize)> = BTreeMap::new();
            for (from, to) in faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]) {
                let entry = uses.entry((from.min(to), from.max(to))).or_default();
                if from < to { entry.0 += 1 } else { entry.1 += 1 }
            }
            let mut expected = EdgeReport::default();
            uses.values().for_each(|&(upwards, downwards)| count(&mut expected, upwards, downwards));
            prop_assert_eq!(mesh.edge_report(), expected);
        }
    }
}

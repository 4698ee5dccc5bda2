//! Surfaces under construction, and the checks that turn them into meshes.

use super::super::{Isometry, Mesh, Point, Triangle};
use super::error::{Fault, ShapeError};
use super::tessellation::MOST_TRIANGLES;

/// One closed component under construction. Builders share vertices by index. Vertices are not welded by distance; only those on the same
/// point of the coordinate grid are merged at the end.
#[derive(Debug, Default)]
pub(super) struct Surface {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
}

impl Surface {
    /// Adds a vertex, mm, and returns its index.
    pub fn vertex(&mut self, point: Point) -> u32 {
        self.vertices.push(point);
        (self.vertices.len() - 1) as u32
    }

    /// Adds a triangle, counter-clockwise seen from outside; one with a repeated vertex is degenerate and left out.
    pub fn triangle(&mut self, a: u32, b: u32, c: u32) {
        if a != b && b != c && c != a {
            self.faces.push([a, b, c]);
        }
    }

    /// Adds a quadrilateral, counter-clockwise seen from outside, split between `b` and `d`.
    pub fn quad(&mut self, a: u32, b: u32, c: u32, d: u32) {
        self.triangle(a, b, d);
        self.triangle(d, b, c);
    }

    /// Adds the band between two closed rows. When the rows run counter-clockwise, the outside is to the right of the direction from `low`
    /// to `high`. A row of one vertex is the tip of a fan. Rows of different length are joined in proportion.
    pub fn band(&mut self, low: &[u32], high: &[u32]) {
        let (n, m) = (low.len(), high.len());
        let (mut i, mut j) = (0, 0);
        let (last_i, last_j) = (if n == 1 { 0 } else { n }, if m == 1 { 0 } else { m });
        while i < last_i || j < last_j {
            // Advance where the next vertex comes first on the way round.
            if j == last_j || (i < last_i && (i + 1) * m <= (j + 1) * n) {
                self.triangle(low[i % n], low[(i + 1) % n], high[j % m]);
                i += 1;
            } else {
                self.triangle(high[j % m], low[i % n], high[(j + 1) % m]);
                j += 1;
            }
        }
    }

    /// How many triangles there are.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// The component as a mesh, if it is sound: watertight, wound outward, and without triangles of zero area.
    pub fn finish(&self) -> Result<Mesh, ShapeError> {
        let corner = |v: u32| self.vertices[v as usize];
        let triangles: Vec<Triangle> = self.faces.iter().map(|f| Triangle { corners: f.map(corner) }).collect();
        let mesh = Mesh::from_triangles(&triangles).map_err(|error| Fault::Mesh(error).at("shape"))?;
        let edges = mesh.edge_report();
        let without_area = mesh.triangles().iter().filter(|t| t.area() <= 0.0).count();
        let volume = mesh.signed_volume();
        if edges.is_watertight() && without_area == 0 && volume > 0.0 {
            Ok(mesh)
        } else {
            Err(Fault::Unsound { edges, without_area, volume }.at("shape"))
        }
    }
}

/// Closed components side by side, each with its placement in the assembly.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    components: Vec<(Surface, Isometry)>,
}

impl Assembly {
    /// Adds a component with its placement.
    pub fn push(&mut self, surface: Surface, placement: Isometry) -> Result<(), ShapeError> {
        self.components.push((surface, placement));
        if self.triangle_count() > MOST_TRIANGLES {
            return Err(Fault::TooManyTriangles(MOST_TRIANGLES).at("shape"));
        }
        Ok(())
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.components.iter().map(|(surface, _)| surface.len()).sum()
    }

    /// Makes one mesh of all components. Vertices of different components stay separate even where they coincide; otherwise two boxes that
    /// share an edge would no longer be two closed surfaces.
    pub fn finish(self) -> Result<Mesh, ShapeError> {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        for (surface, placement) in self.components {
            let mesh = surface.finish()?;
            let first = vertices.len() as u32;
            vertices.extend(mesh.vertices().iter().map(|p| placement * p));
            faces.extend(mesh.faces().iter().map(|f| f.map(|v| first + v)));
        }
        Mesh::new(vertices, faces).map_err(|error| Fault::Mesh(error).at("shape"))
    }
}

//! The volumes of a tree, level by level, in the part's frame.
//!
//! Nothing here knows any volume: all it has is outlines. Where every node's outline is an affine image of the root's, as with
//! boxes and spheres, a node is the images of four points; else its points, edges and faces are written out. Faces
//! are the convex hull's of the outline's points.

use super::ViewError;
use super::data::{DrawnTree, DrawnVariant, Level, Shapes};
use super::pack::{Lattice, Packed};
use crate::geometry::hull::Hull;
use crate::geometry::{Point, Vector};
use crate::measure::Progress;
use crate::registry::Variant;
use crate::scene::{Part, Scene};
use crate::tree::levels::Drawn;
use crate::volume::Segment;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Points of an outline nearer than this are one, as a part of its size: what clipping a polytope adds to rounding.
const MERGE: f64 = 1e-7;
/// How far the image of a point may be from it, as a part of the outline's size: less than a step of the lattice.
const IMAGE: f64 = 1e-5;

/// The upper levels of the trees of every part.
pub(super) fn of_variant(
    scene: &Scene,
    variant: &Variant,
    levels: u32,
    progress: &dyn Progress,
) -> Result<DrawnVariant, ViewError> {
    let of_part = |(index, part): (usize, &Part)| {
        let drawn = variant.prepare(&part.mesh, None).drawn(levels);
        progress.advance(1);
        tree(index, &drawn)
    };
    let trees: Option<Vec<DrawnTree>> = scene.parts.par_iter().enumerate().map(of_part).collect();
    let trees = trees.ok_or(ViewError::NoTree(variant.info.id))?;
    Ok(DrawnVariant { id: variant.info.id, label: variant.info.label, safe: variant.info.safe, trees })
}

/// `None` when nothing is drawn.
fn tree(part: usize, drawn: &[Drawn]) -> Option<DrawnTree> {
    let graphs: Vec<Graph> = drawn.iter().map(|node| Graph::of(&node.outline)).collect();
    let root = graphs.first()?;
    let lattice = Lattice::over(graphs.iter().flat_map(|graph| &graph.points));
    let shapes = as_images(root, &graphs, &lattice).unwrap_or_else(|| as_they_are(&graphs, &lattice));
    let deepest = drawn.iter().map(|node| node.level).max()?;
    let level = |level: u32| {
        let shown = drawn.iter().filter(|node| node.level == level || (node.leaf && node.level < level));
        shown.fold(Level::default(), |sum, node| Level {
            nodes: sum.nodes + 1,
            volume_mm3: sum.volume_mm3 + node.volume_mm3,
            leaking: sum.leaking + u32::from(node.outside > 0),
            outside: sum.outside + node.outside,
        })
    };
    Some(DrawnTree {
        part,
        levels: (0..=deepest).map(level).collect(),
        low: lattice.low.into(),
        step: lattice.step.into(),
        level_of: Packed::u8(drawn.iter().map(|node| node.level as u8)),
        flags: Packed::u8(drawn.iter().map(|node| u8::from(node.leaf) | u8::from(node.outside > 0) << 1)),
        shapes,
    })
}

/// An outline as points and edges between them.
#[derive(Clone, Debug)]
struct Graph {
    points: Vec<Point>,
    /// Pairs of point numbers, the smaller first, in the order of the outline.
    edges: Vec<[u16; 2]>,
    size: f64,
}

impl Graph {
    fn of(outline: &[Segment]) -> Self {
        let ends = || outline.iter().flatten();
        let first = ends().next().copied().unwrap_or_default();
        let size = ends().map(|p| (p - first).amax()).fold(0.0, f64::max);
        let (mut points, mut edges): (Vec<Point>, Vec<[u16; 2]>) = (Vec::new(), Vec::new());
        for segment in outline {
            let ends = segment.map(|end| {
                let known = points.iter().position(|p| (p - end).amax() <= MERGE * size);
                known.unwrap_or_else(|| {
                    points.push(end);
                    points.len() - 1
                }) as u16
            });
            let edge = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            if edge[0] != edge[1] && !edges.contains(&edge) {
                edges.push(edge);
            }
        }
        Self { points, edges, size }
    }

    /// Triangles of the convex hull of the points; none where they lie in a plane.
    fn faces(&self) -> Vec<[u16; 3]> {
        let Some(Hull::Solid(solid)) = Hull::of(self.points.iter()) else { return Vec::new() };
        let number = |corner: &Point| self.points.iter().position(|p| (p - corner).amax() == 0.0).unwrap_or(0) as u16;
        let numbers: Vec<u16> = solid.vertices.iter().map(number).collect();
        solid.faces.iter().map(|face| face.map(|corner| numbers[corner as usize])).collect()
    }

    /// Four points that span space, as well as these points do: the first, the one farthest from it, from the line, from the plane.
    fn frame(&self) -> Option<[usize; 4]> {
        let origin = *self.points.first()?;
        let farthest = |measure: &dyn Fn(&Vector) -> f64| {
            let of = |&at: &usize| measure(&(self.points[at] - origin));
            (0..self.points.len()).max_by(|i, j| of(i).total_cmp(&of(j)))
        };
        let second = farthest(&|v| v.norm_squared())?;
        let along = (self.points[second] - origin).try_normalize(0.0)?;
        let third = farthest(&|v| v.cross(&along).norm_squared())?;
        let normal = along.cross(&(self.points[third] - origin)).try_normalize(0.0)?;
        let fourth = farthest(&|v| v.dot(&normal).abs())?;
        ((self.points[fourth] - origin).dot(&normal) != 0.0).then_some([0, second, third, fourth])
    }
}

/// Columns from the first of four points to the others.
fn spanned(points: [Point; 4]) -> Matrix3<f64> {
    Matrix3::from_columns(&[points[1] - points[0], points[2] - points[0], points[3] - points[0]])
}

/// The nodes as images of the root, if they are.
fn as_images(root: &Graph, graphs: &[Graph], lattice: &Lattice) -> Option<Shapes> {
    let frame = root.frame()?;
    let at = |graph: &Graph| frame.map(|point| graph.points[point]);
    let inverse = spanned(at(root)).try_inverse()?;
    let weights: Vec<Vector> = root.points.iter().map(|p| inverse * (p - root.points[frame[0]])).collect();
    let is_image = |graph: &Graph| {
        graph.points.len() == root.points.len() && graph.edges == root.edges && {
            let (origin, columns) = (graph.points[frame[0]], spanned(at(graph)));
            let image = |weights: &Vector| origin + columns * weights;
            graph.points.iter().zip(&weights).all(|(p, weights)| (image(weights) - p).amax() <= IMAGE * graph.size)
        }
    };
    graphs.iter().all(is_image).then(|| Shapes::Images {
        weights: Packed::f32(weights.iter().flat_map(|w| [w.x, w.y, w.z])),
        edges: Packed::u16(root.edges.as_flattened().iter().copied()),
        faces: Packed::u16(root.faces().as_flattened().iter().copied()),
        frames: Packed::u16(graphs.iter().flat_map(|graph| at(graph).map(|p| lattice.place(&p)).concat())),
    })
}

fn as_they_are(graphs: &[Graph], lattice: &Lattice) -> Shapes {
    let faces: Vec<Vec<[u16; 3]>> = graphs.iter().map(Graph::faces).collect();
    let counts = graphs
        .iter()
        .zip(&faces)
        .flat_map(|(graph, faces)| [graph.points.len() as u16, graph.edges.len() as u16, faces.len() as u16]);
    Shapes::Own {
        counts: Packed::u16(counts),
        points: Packed::u16(graphs.iter().flat_map(|graph| &graph.points).flat_map(|p| lattice.place(p))),
        edges: Packed::u16(graphs.iter().flat_map(|graph| graph.edges.as_flattened()).copied()),
        faces: Packed::u16(faces.iter().flat_map(|faces| faces.as_flattened()).copied()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry;
    use obbtree::cases::meshes;

    /// The tree over a stepped tool: whether its nodes are images of the root, and the levels.
    fn tree_of(id: &str) -> (bool, Vec<Level>) {
        let registry = registry::standard();
        let drawn = registry.find(id).unwrap().prepare(&meshes::stepped_tool(10, 6), None).drawn(4);
        let tree = tree(0, &drawn).unwrap();
        (matches!(tree.shapes, Shapes::Images { .. }), tree.levels)
    }

    #[test]
    fn boxes_and_spheres_are_images_and_polytopes_are_not() {
        for (id, images) in
            [("obb-area", true), ("aabb", true), ("sphere-ritter", true), ("dop-8", false), ("rss", false)]
        {
            let (is, levels) = tree_of(id);
            assert_eq!((is, levels.len(), levels[0].nodes), (images, 4, 1), "{id}");
            assert!(levels.iter().all(|level| level.leaking == 0), "{id}");
        }
        let (_, levels) = tree_of("obb-vertex-centroid");
        assert!(levels[0].outside > 0 && levels[0].leaking == 1);
    }

    #[test]
    fn a_cube_has_eight_points_twelve_edges_and_twelve_faces() {
        let cube = crate::volume::box_outline(&Point::new(1.0, 2.0, 3.0), &Matrix3::identity(), &Vector::repeat(1.0));
        let graph = Graph::of(&cube);
        assert_eq!((graph.points.len(), graph.edges.len(), graph.faces().len()), (8, 12, 12));
        let frame = graph.frame().unwrap();
        // From a corner the farthest is the opposite one; all four span a sixth of a box or more.
        assert!(spanned(frame.map(|at| graph.points[at])).determinant().abs() > 7.9);
    }

    #[test]
    fn methods_without_a_tree_are_refused() {
        let scene = Scene::find("lathe-toolpost").unwrap();
        let registry = registry::standard();
        let refused = of_variant(&scene, registry.find("brute").unwrap(), 3, &crate::measure::Silent);
        assert!(matches!(refused, Err(ViewError::NoTree("brute"))));
    }
}

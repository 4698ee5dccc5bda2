//! The cells of the audit: every orientation with every centre, split rule and leaf size.
//!
//! A row of `ORIENTATIONS` crosses one frame rule with all centres at compile time; splits and leaf sizes are values of the
//! tree policy. Whatever a box was fitted by, it becomes the same type afterwards, so that all cells run the very same
//! machine code in a query and differ by their data alone.

use super::memory::Remembered;
use crate::geometry::{Point, Triangle, Vector, covariance, triangle};
use crate::tree::build::Fit;
use crate::tree::{Axes, Policy, SplitRule, Tree};
use crate::volume::fit;
use crate::volume::fit::centre::{AtMean, CentreRule, MidExtent, SymmetricAboutMean};
use crate::volume::fit::dito::Dito14;
use crate::volume::fit::frame::{AreaCovariance, FrameRule, HullAreaCovariance, VertexCovariance};
use crate::volume::fit::minimum::MinimumVolume;
use crate::volume::shape::obb::Obb;
use nalgebra::Matrix3;
use std::fmt::Debug;
use std::marker::PhantomData;

/// The tree of every cell.
pub type BoxTree = Tree<Obb>;

/// One combination of the four factors.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// How the axes are found.
    pub orientation: &'static str,
    /// Where the centre lies and how long the half-lengths are.
    pub centre: &'static str,
    /// Where nodes are divided.
    pub split: SplitRule,
    /// Triangles of a leaf.
    pub leaf: u8,
    fit: Fit<Obb>,
}

/// An orientation rule, crossed with all centres.
struct Orientation {
    id: &'static str,
    fits: [(&'static str, Fit<Obb>); 4],
}

/// The orientations, a line each.
const ORIENTATIONS: [Orientation; 5] = [
    Orientation::of::<VertexCovariance>("vertex"),
    Orientation::of::<AreaCovariance>("area"),
    Orientation::of::<Remembered<HullAreaCovariance>>("hull-area"),
    Orientation::of::<Remembered<Dito14>>("dito"),
    Orientation::of::<Remembered<MinimumVolume>>("min"),
];

/// The split rules.
const SPLITS: [SplitRule; 5] = SplitRule::ALL;

/// The leaf sizes.
pub const LEAVES: [u8; 4] = [1, 2, 4, 8];

impl Cell {
    /// All cells, in the order of records.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut cells = Vec::new();
        for orientation in &ORIENTATIONS {
            for &(centre, fit) in &orientation.fits {
                for split in SPLITS {
                    cells.extend(LEAVES.map(|leaf| Self { orientation: orientation.id, centre, split, leaf, fit }));
                }
            }
        }
        cells
    }

    /// The cell all others are timed against: the box and the split of the paper's better method.
    #[must_use]
    pub const fn reference() -> Self {
        Self {
            orientation: "area",
            centre: MidExtent::ID,
            split: SplitRule::AreaMean,
            leaf: 1,
            fit: crossed::<AreaCovariance, MidExtent>,
        }
    }

    /// `orientation-centre-split-leaf`, for folders and messages.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}-{}-{}-{}", self.orientation, self.centre, self.split, self.leaf)
    }

    /// The tree over `triangles` (mm, mesh frame; at least one), split along the boxes' own axes.
    #[must_use]
    pub fn tree(&self, triangles: &[Triangle]) -> BoxTree {
        BoxTree::build(self.fit, triangles, Policy { split: self.split, axes: Axes::Own, leaf: self.leaf })
    }
}

/// A centre of the experiment: a rule for the half-lengths, and the mean it is about.
trait AuditCentre {
    /// Name in records.
    const ID: &'static str;
    /// The rule.
    type Rule: CentreRule;
    /// The mean, mm; `own` is that of the orientation rule.
    fn mean(triangles: &[Triangle], own: Point) -> Point;
}

impl AuditCentre for MidExtent {
    const ID: &'static str = "mid-extent";
    type Rule = Self;
    fn mean(_: &[Triangle], own: Point) -> Point {
        own
    }
}

/// At the mean of the corners, equation (1) of the paper; half the extent to each side.
#[derive(Clone, Copy, Debug)]
struct CornerMean;

impl AuditCentre for CornerMean {
    const ID: &'static str = "mean";
    type Rule = AtMean;
    fn mean(triangles: &[Triangle], _: Point) -> Point {
        corner_mean(triangles)
    }
}

/// At the area-weighted mean, equation (4) of the paper; half the extent to each side.
#[derive(Clone, Copy, Debug)]
struct WeightedMean;

impl AuditCentre for WeightedMean {
    const ID: &'static str = "weighted-mean";
    type Rule = AtMean;
    fn mean(triangles: &[Triangle], _: Point) -> Point {
        covariance::area_weighted(triangles).0
    }
}

/// At the mean of the corners, as far to each side as the farther contents reach: what [`CornerMean`] would have to be to
/// contain everything.
#[derive(Clone, Copy, Debug)]
struct Symmetric;

impl AuditCentre for Symmetric {
    const ID: &'static str = "symmetric";
    type Rule = SymmetricAboutMean;
    fn mean(triangles: &[Triangle], _: Point) -> Point {
        corner_mean(triangles)
    }
}

fn corner_mean(triangles: &[Triangle]) -> Point {
    let origin = triangles[0].corners[0];
    let sum: Vector = triangle::corners(triangles).map(|p| p - origin).sum();
    origin + sum / (3.0 * triangles.len() as f64)
}

impl Orientation {
    const fn of<F: FrameRule>(id: &'static str) -> Self {
        Self {
            id,
            fits: [
                (CornerMean::ID, crossed::<F, CornerMean>),
                (WeightedMean::ID, crossed::<F, WeightedMean>),
                (MidExtent::ID, crossed::<F, MidExtent>),
                (Symmetric::ID, crossed::<F, Symmetric>),
            ],
        }
    }
}

/// An orientation rule with a centre of the experiment.
struct Crossed<F, C>(PhantomData<(F, C)>);

impl<F: FrameRule, C: AuditCentre> FrameRule for Crossed<F, C> {
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        let (own, axes) = F::mean_and_axes(triangles);
        (C::mean(triangles, own), axes)
    }
}

/// The box of a cell.
fn crossed<F: FrameRule, C: AuditCentre>(triangles: &[Triangle]) -> Obb {
    fit::oriented::<Crossed<F, C>, C::Rule>(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::obb_area::ObbArea;
    use crate::volume::obb_vertex_symmetric::ObbVertexSymmetric;
    use crate::volume::{BoundingVolume, Solid};
    use obbtree::cases::meshes;
    use std::collections::BTreeSet;

    #[test]
    fn the_cells_are_all_combinations_each_once() {
        let cells = Cell::all();
        assert_eq!(cells.len(), ORIENTATIONS.len() * 4 * 5 * 4);
        let names: BTreeSet<String> = cells.iter().map(Cell::name).collect();
        assert_eq!(names.len(), cells.len());
        assert!(names.contains(&Cell::reference().name()));
    }

    #[test]
    fn a_cell_is_the_variant_it_stands_for() {
        let triangles = meshes::stepped_tool(12, 40).triangles();
        let cells = Cell::all();
        let cell = |name: &str| cells.iter().find(|cell| cell.name() == name).unwrap().tree(&triangles);
        let policy = Policy::own(SplitRule::AreaMean);
        let same = |a: &BoxTree, volumes: Vec<(f64, Point)>| {
            assert_eq!(a.nodes().len(), volumes.len());
            for (node, (volume, centre)) in a.nodes().iter().zip(volumes) {
                assert_eq!(node.volume.volume().to_bits(), volume.to_bits());
                assert!((node.volume.centre() - centre).norm() < 1e-9);
            }
        };
        let area = Tree::build(ObbArea::fit, &triangles, policy);
        let volumes = area.nodes().iter().map(|n| (n.volume.volume(), n.volume.centre())).collect();
        same(&cell("area-mid-extent-area-mean-1"), volumes);
        let symmetric = Tree::build(ObbVertexSymmetric::fit, &triangles, Policy { leaf: 4, ..policy });
        let tree = cell("vertex-symmetric-area-mean-4");
        assert_eq!(tree.nodes().len(), symmetric.nodes().len());
        for (node, other) in tree.nodes().iter().zip(symmetric.nodes()) {
            assert!((node.volume.volume() / other.volume.volume() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_centre_decides_containment_whatever_else() {
        let some = || Cell::all().into_iter().filter(|cell| cell.leaf == 4 && cell.split != SplitRule::Sah16);
        for triangles in [meshes::stepped_tool(8, 10).triangles(), meshes::torus(12.0, 4.0, 14, 7).triangles()] {
            for cell in some() {
                let tree = cell.tree(&triangles);
                assert_eq!(tree.check_structure(), Ok(()), "{}", cell.name());
                if ["mid-extent", "symmetric"].contains(&cell.centre) {
                    assert_eq!(tree.check_containment(1e-9), Ok(()), "{}", cell.name());
                }
            }
        }
        let tool = meshes::stepped_tool(8, 10).triangles();
        let outside =
            some().filter(|cell| cell.tree(&tool).check_containment(1.0).is_err()).map(|c| c.centre).collect();
        assert_eq!(BTreeSet::from(["mean", "weighted-mean"]), outside);
    }
}

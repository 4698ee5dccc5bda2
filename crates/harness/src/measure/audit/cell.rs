//! The cells of the audit: every orientation with every centre, split rule and leaf size. All cells are plain values and all boxes have one
//! type, so the cells run the same machine code and differ only in their data.

use super::memory::Memory;
use crate::geometry::{Point, Triangle, Vector, covariance, triangle};
use crate::record::audit::FACTORS;
use crate::record::rows::CaseKey;
use crate::record::{CaseRow, FactorRow, Kind};
use crate::tree::{Axes, Policy, SplitRule, Tree};
use crate::volume::fit::centre::{AtMean, CentreRule, MidExtent, SymmetricAboutMean};
use crate::volume::fit::dito::Dito14;
use crate::volume::fit::frame::{AreaCovariance, FrameRule, HullAreaCovariance, VertexCovariance};
use crate::volume::fit::minimum::MinimumVolume;
use crate::volume::fit::{Centring, around};
use crate::volume::shape::obb::Obb;
use nalgebra::Matrix3;

/// The tree of every cell.
pub type BoxTree = Tree<Obb>;

/// One combination of the four factors.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Rule for the axes.
    pub orientation: &'static str,
    /// Rule for the centre and the half-lengths.
    pub centre: &'static str,
    /// Rule for dividing nodes.
    pub split: SplitRule,
    /// Largest number of triangles in a leaf.
    pub leaf: u8,
    frame: Orientation,
    placing: Centre,
}

/// An orientation: the rule for the axes, and the mean that belongs to it, mm.
#[derive(Clone, Copy, Debug)]
struct Orientation {
    id: &'static str,
    mean_and_axes: fn(&[Triangle]) -> (Point, Matrix3<f64>),
    /// Whether computing the axes takes so long that they are cached while cells are counted.
    is_slow: bool,
}

/// The orientations, one per line.
const ORIENTATIONS: [Orientation; 5] = [
    Orientation { id: "vertex", mean_and_axes: VertexCovariance::mean_and_axes, is_slow: false },
    AREA,
    Orientation { id: "hull-area", mean_and_axes: HullAreaCovariance::mean_and_axes, is_slow: true },
    Orientation { id: "dito", mean_and_axes: Dito14::mean_and_axes, is_slow: true },
    Orientation { id: "min", mean_and_axes: MinimumVolume::mean_and_axes, is_slow: true },
];
const AREA: Orientation = Orientation { id: "area", mean_and_axes: AreaCovariance::mean_and_axes, is_slow: false };

/// A centre rule: the mean about which a box is placed (mm; given that of the orientation), and how centre and half-lengths follow from it.
#[derive(Clone, Copy, Debug)]
struct Centre {
    id: &'static str,
    /// Whether a box with this centre contains all of its contents.
    is_safe: bool,
    mean: fn(&[Triangle], Point) -> Point,
    rule: Centring,
}

/// The centre rules, one per line: (1) the mean of the corners, equation (1) of the paper, with half the extent to each side; (2) the
/// area-weighted mean, equation (4), with half the extent to each side; (3) the middle of the extent; (4) the mean of the corners, extended
/// to both sides as far as the farther contents, which is how long the first box would have to be to contain everything.
const CENTRES: [Centre; 4] = [
    Centre { id: "mean", is_safe: false, mean: corner_mean, rule: AtMean::centre_and_half },
    Centre { id: "weighted-mean", is_safe: false, mean: weighted_mean, rule: AtMean::centre_and_half },
    MID_EXTENT,
    Centre { id: "symmetric", is_safe: true, mean: corner_mean, rule: SymmetricAboutMean::centre_and_half },
];
const MID_EXTENT: Centre = Centre { id: "mid-extent", is_safe: true, mean: own_mean, rule: MidExtent::centre_and_half };

const fn own_mean(_: &[Triangle], own: Point) -> Point {
    own
}

fn weighted_mean(triangles: &[Triangle], _: Point) -> Point {
    covariance::area_weighted(triangles).0
}

fn corner_mean(triangles: &[Triangle], _: Point) -> Point {
    let origin = triangles[0].corners[0];
    let sum: Vector = triangle::corners(triangles).map(|p| p - origin).sum();
    origin + sum / (3.0 * triangles.len() as f64)
}

/// The split rules.
const SPLITS: [SplitRule; 5] = SplitRule::ALL;

/// The leaf sizes.
pub const LEAVES: [u8; 4] = [1, 2, 4, 8];

impl Cell {
    /// All cells, in the order of the records.
    pub fn all() -> Vec<Self> {
        let mut cells = Vec::new();
        for frame in ORIENTATIONS {
            for placing in CENTRES {
                for split in SPLITS {
                    cells.extend(LEAVES.map(|leaf| Self::new(frame, placing, split, leaf)));
                }
            }
        }
        cells
    }

    /// The cell with which all others are compared in timing: the box and the split rule of the paper's better method.
    pub const fn reference() -> Self {
        Self::new(AREA, MID_EXTENT, SplitRule::AreaMean, 1)
    }

    const fn new(frame: Orientation, placing: Centre, split: SplitRule, leaf: u8) -> Self {
        Self { orientation: frame.id, centre: placing.id, split, leaf, frame, placing }
    }

    /// Name for folders and messages: `orientation-centre-split-leaf`.
    pub fn name(&self) -> String {
        format!("{}-{}-{}-{}", self.orientation, self.centre, self.split, self.leaf)
    }

    /// The cell in the form of the records: the box is a variant, and the rest its policy.
    pub fn key(&self) -> CaseKey {
        CaseKey {
            variant: format!("{}-{}", self.orientation, self.centre),
            split: self.split.to_string(),
            split_axes: Axes::Own.to_string(),
            leaf: self.leaf,
        }
    }

    /// The cell's row in `cases.csv`.
    pub fn row(&self) -> CaseRow {
        let label = format!("{}, {}", self.orientation, self.centre);
        let default = u8::from(self.key() == Self::reference().key());
        CaseRow { default, ..CaseRow::new(self.key(), label, Kind::Volume, self.placing.is_safe) }
    }

    /// The cell's levels of the four factors.
    pub fn factors(&self) -> Vec<FactorRow> {
        let levels =
            [self.orientation.to_owned(), self.centre.to_owned(), self.split.to_string(), self.leaf.to_string()];
        FACTORS
            .iter()
            .zip(levels)
            .map(|(factor, level)| FactorRow::of_case(&self.key().name(), factor, level))
            .collect()
    }

    /// The tree over `triangles` (mm, mesh frame; at least one), split along the axes of its boxes. If `memory` is given, axes that take
    /// long to compute are taken from it.
    pub fn tree(&self, triangles: &[Triangle], memory: Option<&Memory>) -> BoxTree {
        let Orientation { id, mean_and_axes, is_slow } = self.frame;
        let memory = memory.filter(|_| is_slow);
        let fit = |triangles: &[Triangle]| {
            let found =
                memory.map_or_else(|| mean_and_axes(triangles), |memory| memory.recall(id, triangles, mean_and_axes));
            around(((self.placing.mean)(triangles, found.0), found.1), self.placing.rule, triangles)
        };
        BoxTree::build(&fit, triangles, Policy { split: self.split, axes: Axes::Own, leaf: self.leaf })
    }
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
        let cell = |name: &str| cells.iter().find(|cell| cell.name() == name).unwrap().tree(&triangles, None);
        let policy = Policy::own(SplitRule::AreaMean);
        let same = |a: &BoxTree, volumes: Vec<(f64, Point)>| {
            assert_eq!(a.nodes().len(), volumes.len());
            for (node, (volume, centre)) in a.nodes().iter().zip(volumes) {
                assert_eq!(node.volume.volume().to_bits(), volume.to_bits());
                assert!((node.volume.centre() - centre).norm() < 1e-9);
            }
        };
        let area = Tree::build(&ObbArea::fit, &triangles, policy);
        let volumes = area.nodes().iter().map(|n| (n.volume.volume(), n.volume.centre())).collect();
        same(&cell("area-mid-extent-area-mean-1"), volumes);
        let symmetric = Tree::build(&ObbVertexSymmetric::fit, &triangles, Policy { leaf: 4, ..policy });
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
                let tree = cell.tree(&triangles, None);
                assert_eq!(tree.check_structure(), Ok(()), "{}", cell.name());
                if ["mid-extent", "symmetric"].contains(&cell.centre) {
                    assert_eq!(tree.check_containment(1e-9), Ok(()), "{}", cell.name());
                }
            }
        }
        let tool = meshes::stepped_tool(8, 10).triangles();
        let outside =
            some().filter(|cell| cell.tree(&tool, None).check_containment(1.0).is_err()).map(|c| c.centre).collect();
        assert_eq!(BTreeSet::from(["mean", "weighted-mean"]), outside);
    }
}

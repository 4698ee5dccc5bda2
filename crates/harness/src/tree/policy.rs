//! Tree policy: how a tree is built, apart from the volume.

use std::fmt;
use std::str::FromStr;

/// Rule for the position along an axis at which the triangles of a node are divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SplitRule {
    /// At the mean of the triangle corners (the paper's plain tree).
    VertexMean,
    /// At the area-weighted mean of the centroids (the paper's area-weighted tree).
    AreaMean,
    /// At the median centroid: both halves hold the same number of triangles.
    Median,
    /// In the middle of the extent of the corners.
    Midpoint,
    /// Position of the least surface-area heuristic over 16 bins, tried along the three axes and the mesh's own axes.
    Sah16,
}

/// Which axes a node may be split along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Axes {
    /// The axes of the node's volume, so that a better box also splits better (the paper's trees).
    Own,
    /// The axes of the area-weighted covariance, whatever the volume. All variants then get the same tree topology, which separates the
    /// effect of the fit from that of the split.
    Shared,
}

/// How a tree is built; every row of the records states it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Policy {
    /// Rule for the position at which a node is divided.
    pub split: SplitRule,
    /// Axes along which a node is divided.
    pub axes: Axes,
    /// Nodes with at most this many triangles are leaves; 1 to 8.
    pub leaf: u8,
}

impl SplitRule {
    /// All rules, in the order of the documentation.
    pub const ALL: [Self; 5] = [Self::VertexMean, Self::AreaMean, Self::Median, Self::Midpoint, Self::Sah16];

    /// The name in files and on the command line.
    pub const fn id(self) -> &'static str {
        match self {
            Self::VertexMean => "vertex-mean",
            Self::AreaMean => "area-mean",
            Self::Median => "median",
            Self::Midpoint => "midpoint",
            Self::Sah16 => "sah16",
        }
    }
}

impl Axes {
    /// The name in files and on the command line.
    pub const fn id(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Shared => "shared",
        }
    }
}

impl Policy {
    /// The smallest and the largest leaf size.
    pub const LEAF_RANGE: std::ops::RangeInclusive<u8> = 1..=8;

    /// The volume's own axes and single-triangle leaves.
    pub const fn own(split: SplitRule) -> Self {
        Self { split, axes: Axes::Own, leaf: 1 }
    }

    /// The shared topology and single-triangle leaves.
    pub const fn shared(split: SplitRule) -> Self {
        Self { split, axes: Axes::Shared, leaf: 1 }
    }
}

impl fmt::Display for SplitRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.id())
    }
}

impl fmt::Display for Axes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.id())
    }
}

/// Formats as `split/axes/leaf`, such as `area-mean/own/1`.
impl fmt::Display for Policy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.split, self.axes, self.leaf)
    }
}

/// The fault in the text of a policy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{text}` is not a tree policy: expected SPLIT[/AXES[/LEAF]] with SPLIT one of vertex-mean, area-mean, median, midpoint, sah16, AXES own or shared, LEAF 1 to 8"
)]
pub struct PolicyError {
    text: String,
}

impl FromStr for Policy {
    type Err = PolicyError;

    fn from_str(text: &str) -> Result<Self, PolicyError> {
        let error = || PolicyError { text: text.to_owned() };
        let mut parts = text.split('/');
        let split = parts.next().unwrap_or_default();
        let split = SplitRule::ALL.into_iter().find(|rule| rule.id() == split).ok_or_else(error)?;
        let axes = match parts.next() {
            None | Some("own") => Axes::Own,
            Some("shared") => Axes::Shared,
            Some(_) => return Err(error()),
        };
        let leaf = parts.next().map_or(Ok(1), |leaf| leaf.parse().map_err(|_| error()))?;
        if !Self::LEAF_RANGE.contains(&leaf) || parts.next().is_some() {
            return Err(error());
        }
        Ok(Self { split, axes, leaf })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_policy_reads_what_it_writes() {
        for split in SplitRule::ALL {
            for axes in [Axes::Own, Axes::Shared] {
                for leaf in Policy::LEAF_RANGE {
                    let policy = Policy { split, axes, leaf };
                    assert_eq!(policy.to_string().parse(), Ok(policy));
                }
            }
        }
        assert_eq!("median".parse(), Ok(Policy::own(SplitRule::Median)));
        for bad in ["", "mean", "median/own/0", "median/own/9", "median/other", "median/own/1/2"] {
            assert!(bad.parse::<Policy>().is_err(), "{bad}");
        }
    }
}

//! The words that records use: kinds of variants, names with a meaning of their own, classes of poses.

use serde::{Deserialize, Serialize};

/// Defines an enum by the names of its values: `ALL` lists them in order, `id` names one, and files hold the names.
#[macro_export]
macro_rules! named {
    ($(#[$about:meta])* $vis:vis enum $name:ident { $($(#[$doc:meta])* $value:ident = $id:literal),* $(,)? }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
        $vis enum $name { $($(#[$doc])* #[serde(rename = $id)] $value),* }

        impl $name {
            /// All values, in order.
            $vis const ALL: [Self; [$($id),*].len()] = [$(Self::$value),*];

            /// The name in files and on the command line.
            $vis const fn id(self) -> &'static str {
                match self { $(Self::$value => $id),* }
            }
        }
    };
}
pub use named;

/// Id of the duplicate of another variant, which shows the noise of the comparison itself.
pub const NULL_VARIANT: &str = "null-duplicate";
/// Wildcard that selects every variant.
pub const ALL_VARIANTS: &str = "all";

/// Workload of the few single poses that the exhaustive control is timed on.
pub const CONTROL_WORKLOAD: &str = "control";

/// Workload of the poses of whole programs, from start to first collision; also the metric that is made of their times.
pub const PROGRAM_TIME: &str = "program-time";

/// Workload of recorded poses.
pub const RECORDED: &str = "recorded";

/// Time of queries of whole programs with cold caches: the name of the metric, and of its workload in `ratios.csv`.
pub const PROGRAM_TIME_COLD: &str = "program-time-cold";

/// What stands in the place of a variant in an outline row that draws the part itself.
pub const MESH_OUTLINE: &str = "mesh";

/// What kind of thing a variant is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A tree of bounding volumes, or space divided into cells, built and traversed by bvbench.
    Volume,
    /// Volumes in an engine made for speed, with a tree, a traversal, arithmetic and threads of its own: what it gains is not the volume's alone.
    Engine,
    /// Samples of one mesh in an octree against the body around the other: a method of ours with a test of its own in its leaves.
    Sampling,
    /// No volume at all: what the volumes are measured against.
    Control,
    /// Another library's whole system: its own tree, traversal and triangle test.
    Peer,
}

impl Kind {
    /// Whether it is a method of ours, whose promise to be safe is compared with the truth.
    pub const fn is_ours(self) -> bool {
        self.has_volumes() || matches!(self, Self::Sampling)
    }

    /// Whether it is a hierarchy of volumes of ours, on the common tree or not.
    pub const fn has_volumes(self) -> bool {
        matches!(self, Self::Volume | Self::Engine)
    }
}

named! {
    /// How far a pair is from contact at a pose.
    pub enum Stratum {
        /// The surfaces touch.
        Colliding = "colliding",
        /// Apart by at most 1 mm.
        NearMiss = "near-miss",
        /// Apart by more than 1 mm and at most 10 mm.
        Medium = "medium",
        /// Apart by more than 10 mm.
        Far = "far",
    }
}

impl Stratum {
    /// The distances that part near misses from medium poses and these from far ones, mm.
    pub const BORDERS_MM: [f64; 2] = [1.0, 10.0];

    /// The stratum of a pose by the distance between the surfaces, mm (0 when they touch).
    pub fn of(touching: bool, clearance_mm: f64) -> Self {
        match clearance_mm {
            _ if touching => Self::Colliding,
            d if d <= Self::BORDERS_MM[0] => Self::NearMiss,
            d if d <= Self::BORDERS_MM[1] => Self::Medium,
            _ => Self::Far,
        }
    }
}

named! {
    /// How deep a colliding pose is: travel past first contact in mm, in intervals open below and closed above.
    pub enum Band {
        /// At most 1e-6 mm from first contact: either answer is right.
        Grazing = "grazing",
        /// (1e-6, 1e-3] mm.
        Micron = "1e-6..1e-3",
        /// (1e-3, 0.01] mm.
        TenMicron = "1e-3..0.01",
        /// (0.01, 0.1] mm.
        HundredMicron = "0.01..0.1",
        /// (0.1, 1] mm.
        Millimetre = "0.1..1",
        /// (1, 5] mm.
        FiveMillimetre = "1..5",
        /// More than 5 mm.
        Deep = "over-5",
        /// Apart by more than 1e-6 mm.
        Clear = "clear",
    }
}

impl Band {
    /// Within this travel of first contact, mm, a pose is grazing.
    pub const GRAZING_MM: f64 = 1e-6;

    /// The band of a colliding pose by its travel past first contact, mm.
    pub fn of_depth(depth_mm: f64) -> Self {
        match depth_mm {
            d if d <= Self::GRAZING_MM => Self::Grazing,
            d if d <= 1e-3 => Self::Micron,
            d if d <= 0.01 => Self::TenMicron,
            d if d <= 0.1 => Self::HundredMicron,
            d if d <= 1.0 => Self::Millimetre,
            d if d <= 5.0 => Self::FiveMillimetre,
            _ => Self::Deep,
        }
    }

    /// Whether a colliding pose of this band counts against a safe variant that misses it.
    pub const fn is_above_grazing(self) -> bool {
        !matches!(self, Self::Grazing | Self::Clear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_open_below_and_closed_above() {
        for (depth, band) in [
            (1e-6, Band::Grazing),
            (1.1e-6, Band::Micron),
            (1e-3, Band::Micron),
            (0.1, Band::HundredMicron),
            (5.0, Band::FiveMillimetre),
            (5.1, Band::Deep),
        ] {
            assert_eq!(Band::of_depth(depth), band, "{depth}");
        }
    }

    #[test]
    fn names_in_files_are_the_ids() {
        for band in Band::ALL {
            assert_eq!(serde_json::to_value(band).unwrap(), band.id());
        }
        for stratum in Stratum::ALL {
            assert_eq!(serde_json::to_value(stratum).unwrap(), stratum.id());
        }
    }
}

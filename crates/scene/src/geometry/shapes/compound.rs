//! Compounds of shapes: each member is placed, optionally repeated, and stays a closed surface of its own.

use super::super::{Isometry, Vector};
use super::Shape;
use super::error::{Fault, ShapeError, coordinates, within};
use super::solid::Assembly;
use super::tessellation::Sizing;
use nalgebra::{Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Deepest nesting of compounds.
const DEEPEST: usize = 16;
/// Most copies of one member.
const MOST_COPIES: usize = 10_000;

/// Several shapes as one. Members may overlap: their surfaces are neither cut nor joined. Each is a closed component of the mesh, so the
/// mesh's signed volume counts an overlap once for each member.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Compound {
    /// The members.
    pub parts: Vec<Member>,
}

/// A shape and its placement in the compound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Member {
    /// The shape.
    pub shape: Shape,
    /// Placement in the compound.
    #[serde(default)]
    pub at: Placement,
    /// Further copies of it.
    #[serde(default)]
    pub repeat: Option<Repeat>,
    /// Factor on the number of segments (as [`super::Tessellation::density`], 0.05 to 20).
    #[serde(default = "one")]
    pub density: f64,
}

const fn one() -> f64 {
    1.0
}

/// A placement: rotation first, then translation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Placement {
    /// Position of the shape's origin, mm.
    pub xyz_mm: [f64; 3],
    /// Roll, pitch and yaw, degrees: rotations about the fixed x axis, then y, then z.
    pub rpy_deg: [f64; 3],
}

/// Copies of a member; the count includes the original.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Repeat {
    /// The copies are rotated about the compound's z axis by equal fractions of a full turn.
    Around {
        /// Number of copies, including the original.
        count: usize,
    },
    /// The copies are displaced by equal steps in one direction.
    Along {
        /// Number of copies, including the original.
        count: usize,
        /// Displacement from each copy to the next, mm.
        step_mm: [f64; 3],
    },
}

impl Placement {
    /// The motion from the shape's frame to the compound's.
    ///
    /// # Errors
    /// [`ShapeError`] naming `xyz_mm` or `rpy_deg` when a number is not finite or is out of range.
    pub fn isometry(&self) -> Result<Isometry, ShapeError> {
        let [x, y, z] = coordinates("xyz_mm", self.xyz_mm)?;
        for angle in self.rpy_deg {
            within("rpy_deg", angle, -36_000.0, 36_000.0)?;
        }
        let [roll, pitch, yaw] = self.rpy_deg.map(f64::to_radians);
        let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        Ok(Isometry::from_parts(Translation3::new(x, y, z), rotation))
    }
}

impl Repeat {
    /// The motions from the original to each copy, in the compound's frame; the first is the identity.
    fn motions(&self) -> Result<Vec<Isometry>, ShapeError> {
        let (Self::Around { count } | Self::Along { count, .. }) = *self;
        if count == 0 {
            return Err(Fault::Empty.at("repeat.count"));
        }
        within("repeat.count", count as f64, 1.0, MOST_COPIES as f64)?;
        let step = match self {
            Self::Along { step_mm, .. } => Vector::from(coordinates("repeat.step_mm", *step_mm)?),
            Self::Around { .. } => Vector::zeros(),
        };
        let motion = |k: usize| match self {
            Self::Around { .. } => Isometry::rotation(Vector::z() * (TAU * k as f64 / count as f64)),
            Self::Along { .. } => Isometry::translation(step.x * k as f64, step.y * k as f64, step.z * k as f64),
        };
        Ok((0..count).map(motion).collect())
    }
}

impl Compound {
    /// Adds the placed members to `assembly`; `depth` is the number of enclosing compounds.
    pub(super) fn assemble(
        &self,
        sizing: &Sizing,
        whole_from_this: &Isometry,
        depth: usize,
        assembly: &mut Assembly,
    ) -> Result<(), ShapeError> {
        if self.parts.is_empty() {
            return Err(Fault::Empty.at("parts"));
        }
        if depth >= DEEPEST {
            return Err(Fault::TooDeep(DEEPEST).at("parts"));
        }
        for (i, member) in self.parts.iter().enumerate() {
            member
                .assemble(sizing, whole_from_this, depth, assembly)
                .map_err(|error| error.inside(&format!("parts[{i}]")))?;
        }
        Ok(())
    }
}

impl Member {
    fn assemble(
        &self,
        sizing: &Sizing,
        whole_from_compound: &Isometry,
        depth: usize,
        assembly: &mut Assembly,
    ) -> Result<(), ShapeError> {
        let sizing = sizing.denser(within("density", self.density, 0.05, 20.0)?);
        let compound_from_shape = self.at.isometry().map_err(|error| error.inside("at"))?;
        let motions = self.repeat.map_or_else(|| Ok(vec![Isometry::identity()]), |repeat| repeat.motions())?;
        for motion in motions {
            let placement = whole_from_compound * motion * compound_from_shape;
            self.shape.assemble(&sizing, &placement, depth + 1, assembly).map_err(|error| error.inside("shape"))?;
        }
        Ok(())
    }
}

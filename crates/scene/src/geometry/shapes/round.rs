//! Common solids of revolution by name; each is a [`Revolve`] with a given profile.

use super::error::{Fault, ShapeError, length, length_or_zero};
use super::outline::{OutlineCorner, OutlinePoint};
use super::revolve::Revolve;
use serde::{Deserialize, Serialize};

/// A cylinder about the z axis from z = 0 to z = `height_mm`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Radius, mm.
    pub radius_mm: f64,
    /// Height, mm.
    pub height_mm: f64,
    /// Radius of an axial bore, mm; 0 for none.
    #[serde(default)]
    pub bore_mm: f64,
    /// Radius of the rounding of both outer edges, mm; 0 for none.
    #[serde(default)]
    pub fillet_mm: f64,
    /// Bevel of both outer edges, mm; 0 for none.
    #[serde(default)]
    pub chamfer_mm: f64,
}

/// A cone, or the frustum of one, about the z axis from z = 0 to z = `height_mm`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cone {
    /// Radius at z = 0, mm; 0 for a point.
    pub bottom_radius_mm: f64,
    /// Radius at the top, mm; 0 for a point.
    pub top_radius_mm: f64,
    /// Height, mm.
    pub height_mm: f64,
}

/// A sphere about the origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Radius, mm.
    pub radius_mm: f64,
}

/// A cylinder with half spheres at its ends, about the z axis and the origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Capsule {
    /// Radius, mm.
    pub radius_mm: f64,
    /// Length of the cylindrical part, mm.
    pub length_mm: f64,
}

/// A ring torus about the z axis and the origin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Torus {
    /// Radius of the circle along which the tube's centre runs, mm.
    pub ring_radius_mm: f64,
    /// Radius of the tube, mm; must be less than the ring's.
    pub tube_radius_mm: f64,
}

fn sharp(r: f64, z: f64) -> OutlinePoint {
    OutlinePoint::Sharp([r, z])
}

fn arc(r: f64, z: f64, arc_mm: f64) -> OutlinePoint {
    OutlinePoint::Detailed(OutlineCorner { at_mm: [r, z], arc_mm, ..OutlineCorner::default() })
}

impl Cylinder {
    pub(super) fn revolve(&self) -> Result<Revolve, ShapeError> {
        let (radius, height) = (length("radius_mm", self.radius_mm)?, length("height_mm", self.height_mm)?);
        let bore = length_or_zero("bore_mm", self.bore_mm)?;
        if bore >= radius {
            return Err(Fault::HoleOutside("the cylinder").at("bore_mm"));
        }
        let (fillet_mm, chamfer_mm) = (self.fillet_mm, self.chamfer_mm);
        let corner = |at_mm| OutlinePoint::Detailed(OutlineCorner { at_mm, fillet_mm, chamfer_mm, arc_mm: 0.0 });
        let profile_mm = vec![sharp(bore, 0.0), corner([radius, 0.0]), corner([radius, height]), sharp(bore, height)];
        Ok(Revolve { profile_mm })
    }
}

impl Cone {
    pub(super) fn revolve(&self) -> Result<Revolve, ShapeError> {
        let height = length("height_mm", self.height_mm)?;
        let bottom = length_or_zero("bottom_radius_mm", self.bottom_radius_mm)?;
        let top = length_or_zero("top_radius_mm", self.top_radius_mm)?;
        let mut profile_mm = vec![sharp(0.0, 0.0)];
        if bottom > 0.0 {
            profile_mm.push(sharp(bottom, 0.0));
        }
        if top > 0.0 {
            profile_mm.push(sharp(top, height));
        }
        profile_mm.push(sharp(0.0, height));
        Ok(Revolve { profile_mm })
    }
}

impl Sphere {
    pub(super) fn revolve(&self) -> Result<Revolve, ShapeError> {
        let radius = length("radius_mm", self.radius_mm)?;
        Ok(Revolve { profile_mm: vec![arc(0.0, -radius, radius), sharp(0.0, radius)] })
    }
}

impl Capsule {
    pub(super) fn revolve(&self) -> Result<Revolve, ShapeError> {
        let (radius, half) = (length("radius_mm", self.radius_mm)?, length("length_mm", self.length_mm)? / 2.0);
        let profile_mm = vec![
            arc(0.0, -half - radius, radius),
            sharp(radius, -half),
            arc(radius, half, radius),
            sharp(0.0, half + radius),
        ];
        Ok(Revolve { profile_mm })
    }
}

impl Torus {
    pub(super) fn revolve(&self) -> Result<Revolve, ShapeError> {
        let ring = length("ring_radius_mm", self.ring_radius_mm)?;
        let tube = length("tube_radius_mm", self.tube_radius_mm)?;
        if tube >= ring {
            return Err(Fault::AcrossAxis(ring - tube).at("tube_radius_mm"));
        }
        Ok(Revolve { profile_mm: vec![arc(ring + tube, 0.0, tube), arc(ring - tube, 0.0, tube)] })
    }
}

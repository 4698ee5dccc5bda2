//! Solids of revolution.

use super::super::Point;
use super::error::{Fault, ShapeError};
use super::outline::{OutlinePoint, cut_edges, divide, pieces};
use super::solid::Surface;
use super::tessellation::{Sizing, affordable};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A profile turned once about the z axis: spindles, tool holders, cutters, centres, rims.
///
/// A profile that runs along the axis makes a solid that is closed there; a profile away from the axis makes a ring or a bore. The number
/// of segments of a circle follows from its radius, rounded up to that of the largest circle divided by a power of two. The circles are
/// inscribed, so walls thinner than the sagitta of their chords would cross themselves; this is not checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Revolve {
    /// Closed profile, points `[r, z]`, counter-clockwise with r to the right and z up, r >= 0.
    pub profile_mm: Vec<OutlinePoint>,
}

impl Revolve {
    pub(super) fn surface(&self, sizing: &Sizing) -> Result<Surface, ShapeError> {
        let profile = divide("profile_mm", &self.profile_mm, sizing)?;
        let profile = cut_edges(&profile, &pieces(&profile, sizing));
        let (least, largest) =
            profile.iter().fold((0.0_f64, 0.0_f64), |(least, largest), p| (least.min(p.x), largest.max(p.x)));
        if least < 0.0 {
            return Err(Fault::AcrossAxis(least).at("profile_mm"));
        }
        let most = sizing.circle(largest);
        affordable("profile_mm", &[2, profile.len(), most])?;

        let mut surface = Surface::default();
        let rings: Vec<Vec<u32>> = profile.iter().map(|p| ring(&mut surface, p.x, p.y, most, sizing)).collect();
        for (i, low) in rings.iter().enumerate() {
            let high = &rings[(i + 1) % rings.len()];
            // An edge on the axis is inside the solid.
            if low.len() > 1 || high.len() > 1 {
                surface.band(low, high);
            }
        }
        Ok(surface)
    }
}

/// The vertices of a circle about the axis. A circle of radius 0 is a single vertex. Otherwise the number of vertices is the smallest of
/// `most`, `most`/2, `most`/4, ... that its radius needs, so that neighbouring circles have vertices in the same directions.
fn ring(surface: &mut Surface, radius: f64, z: f64, most: usize, sizing: &Sizing) -> Vec<u32> {
    if radius == 0.0 {
        return vec![surface.vertex(Point::new(0.0, 0.0, z))];
    }
    let mut segments = most;
    while segments.is_multiple_of(2) && segments / 2 >= sizing.circle(radius) {
        segments /= 2;
    }
    let vertex = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / segments as f64).sin_cos();
        surface.vertex(Point::new(radius * cos, radius * sin, z))
    };
    (0..segments).map(vertex).collect()
}

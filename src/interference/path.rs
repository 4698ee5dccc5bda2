//! Tool paths over free-form surfaces: contact points in rows or a spiral, and the poses at which a tool touches there.
//!
//! The tool touches the surface with the rounded corner of its cutter. Where the surface's normal is n and the tool's axis d, the corner's centre
//! lies at p + r n, the axis at R - r from it in the direction of n's part across d (Ding, Mannan and Poo 2004, section 2); a ball is the
//! case R = r, a flat end r = 0. Lead turns the axis away from the normal in the direction of feed, tilt to its left.

use crate::geometry::shapes::Freeform;
use crate::geometry::{Isometry, Point, Vector};
use nalgebra::{Rotation3, Unit, UnitQuaternion};

/// How the contact points run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// To and fro along x.
    ZigZag,
    /// A rectangle that shrinks to the middle.
    Spiral,
}

/// A path over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPlan {
    /// How it runs.
    pub pattern: Pattern,
    /// Rows, or turns of the spiral.
    pub rows: u32,
    /// Contact points of a row.
    pub points: u32,
    /// Part of the surface's size kept away from its edges.
    pub margin: f64,
    /// Angle of the axis from the normal in the direction of feed, radians.
    pub lead: f64,
    /// Angle of the axis from the normal to the left of the feed, radians.
    pub tilt: f64,
}

/// The rounded corner of a cutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Radius of the tool, mm.
    pub radius_mm: f64,
    /// Radius of its corner, mm.
    pub corner_mm: f64,
}

/// A place of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The contact point, mm, in the surface's frame.
    pub point: Point,
    /// The surface's unit normal there.
    pub normal: Vector,
    /// The tool's unit axis, from its tip upwards.
    pub axis: Unit<Vector>,
}

impl PathPlan {
    /// The contact points and the tool's axis at each.
    #[must_use]
    pub fn contacts(&self, surface: &Freeform) -> Vec<Contact> {
        let places = self.places();
        let step = 1e-4;
        let contact = |index: usize| {
            let (u, v) = places[index];
            let (point, normal) = surface.at(u, v);
            // The direction of feed from the neighbours, laid into the tangent plane.
            let (from, to) = (places[index.saturating_sub(1)], places[(index + 1).min(places.len() - 1)]);
            let (du, dv) = (to.0 - from.0, to.1 - from.1);
            let scale = step / du.hypot(dv).max(f64::MIN_POSITIVE);
            let ahead = surface.at((u + du * scale).clamp(0.0, 1.0), (v + dv * scale).clamp(0.0, 1.0)).0;
            let along = ahead - point;
            let feed = (along - normal * normal.dot(&along)).try_normalize(0.0).unwrap_or_else(Vector::x);
            let left = normal.cross(&feed);
            let turn = |about: Vector, angle: f64| Rotation3::from_axis_angle(&Unit::new_normalize(about), angle);
            let axis = turn(feed, -self.tilt) * (turn(left, self.lead) * normal);
            Contact { point, normal, axis: Unit::new_normalize(axis) }
        };
        (0..places.len()).map(contact).collect()
    }

    /// Places (u, v) on the surface in order.
    fn places(&self) -> Vec<(f64, f64)> {
        let part = |k: u32, of: u32| f64::from(k) / f64::from(of.max(2) - 1);
        let inner = |w: f64| self.margin + (1.0 - 2.0 * self.margin) * w;
        match self.pattern {
            Pattern::ZigZag => (0..self.rows)
                .flat_map(|row| {
                    (0..self.points).map(move |k| {
                        let k = if row % 2 == 0 { k } else { self.points - 1 - k };
                        (inner(part(k, self.points)), inner(part(row, self.rows)))
                    })
                })
                .collect(),
            Pattern::Spiral => (0..self.rows)
                .flat_map(|turn| {
                    (0..self.points).map(move |k| {
                        let around = 4.0 * f64::from(k) / f64::from(self.points.max(1));
                        let half = 0.5 * (1.0 - (f64::from(turn) + around / 4.0) / f64::from(self.rows.max(1)));
                        let (side, along) = (around as u32 % 4, 2.0 * around.fract() - 1.0);
                        let (x, y) = match side {
                            0 => (along, -1.0),
                            1 => (1.0, along),
                            2 => (-along, 1.0),
                            _ => (-1.0, -along),
                        };
                        (inner(0.5 + half * x), inner(0.5 + half * y))
                    })
                })
                .collect(),
        }
    }
}

impl Contact {
    /// The tool's frame in the surface's when its corner touches here, sunk by `depth_mm` against the normal (negative: lifted).
    #[must_use]
    pub fn surface_from_tool(&self, corner: Corner, depth_mm: f64) -> Isometry {
        let (n, d) = (self.normal, self.axis.into_inner());
        let across = (n - d * d.dot(&n)).try_normalize(1e-9).unwrap_or_else(Vector::zeros);
        let on_axis = self.point + n * (corner.corner_mm - depth_mm) + across * (corner.radius_mm - corner.corner_mm);
        let tip = on_axis - d * corner.corner_mm;
        // Which way the tool is turned about its axis does not matter.
        let rotation = UnitQuaternion::rotation_between(&Vector::z(), &d)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI));
        Isometry::from_parts(tip.coords.into(), rotation)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Profile;
    use super::super::profile::P2;
    use super::*;

    fn hollow() -> Freeform {
        Freeform {
            size_mm: [80.0, 60.0],
            heights_mm: vec![
                vec![30.0, 30.0, 32.0, 30.0],
                vec![30.0, 15.0, 14.0, 28.0],
                vec![28.0, 16.0, 18.0, 30.0],
                vec![30.0; 4],
            ],
        }
    }

    fn plan(pattern: Pattern) -> PathPlan {
        PathPlan { pattern, rows: 5, points: 40, margin: 0.1, lead: 0.2, tilt: -0.1 }
    }

    /// The contact point lies on the tool's surface, whatever the tool, and the tool's surface is tangential there: a small way along the normal
    /// changes the distance by as much.
    #[test]
    fn the_tool_touches_at_the_contact_point() {
        for (radius_mm, corner_mm) in [(5.0, 5.0), (6.0, 1.5), (4.0, 0.0)] {
            let profile = Profile::bull_nose(radius_mm, corner_mm, 40.0).unwrap();
            for pattern in [Pattern::ZigZag, Pattern::Spiral] {
                let contacts = plan(pattern).contacts(&hollow());
                assert_eq!(contacts.len(), 200);
                for contact in contacts {
                    let pose = contact.surface_from_tool(Corner { radius_mm, corner_mm }, 0.0);
                    let distance = |p: Point| {
                        let q = pose.inverse_transform_point(&p);
                        profile.signed_distance_mm(&P2::new(q.x.hypot(q.y), q.z))
                    };
                    assert!(distance(contact.point).abs() < 1e-9, "{}", distance(contact.point));
                    if corner_mm > 0.0 {
                        assert!((distance(contact.point - contact.normal * 1e-3) - 1e-3).abs() < 1e-6);
                    }
                    let sunk = contact.surface_from_tool(Corner { radius_mm, corner_mm }, 0.05);
                    let q = sunk.inverse_transform_point(&contact.point);
                    let depth = -profile.signed_distance_mm(&P2::new(q.x.hypot(q.y), q.z));
                    assert!(corner_mm == 0.0 || (depth - 0.05).abs() < 1e-9, "{depth}");
                }
            }
        }
    }

    #[test]
    fn lead_and_tilt_are_the_axis_angles() {
        let flat = Freeform { size_mm: [50.0, 50.0], heights_mm: vec![vec![10.0; 2]; 2] };
        let first = plan(Pattern::ZigZag).contacts(&flat)[3];
        // Feed along +x: the lead leans the axis to +x, a tilt to the left to +y.
        let expected = Vector::new(0.2f64.sin(), (-0.1f64).sin() * 0.2f64.cos(), (-0.1f64).cos() * 0.2f64.cos());
        assert!((first.axis.into_inner() - expected).norm() < 1e-9, "{}", first.axis.into_inner());
    }
}

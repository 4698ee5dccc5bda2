//! Tool paths over free-form surfaces: contact points in rows or a spiral, and the poses at which a tool touches there.
//!
//! The tool touches the surface with the rounded corner of its cutter. If p is the contact point, n the surface normal, d the tool's axis,
//! r the corner radius and R the tool radius, the corner's centre is p + r n. The tool's axis is at the distance R - r from that centre, in
//! the direction of the component of n perpendicular to d (Ding, Mannan and Poo 2004, section 2). A ball is the case R = r, a flat end r =
//! 0. Lead turns the axis away from the normal in the direction of feed, tilt turns it to the left of the feed.

use crate::geometry::shapes::Freeform;
use crate::geometry::{Isometry, Point, Vector, turn_between};
use nalgebra::{Rotation3, Unit};

/// The pattern of the contact points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Back and forth along x.
    ZigZag,
    /// A rectangular spiral towards the middle.
    Spiral,
}

impl std::fmt::Display for Pattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::ZigZag => "Zig-zag",
            Self::Spiral => "Spiral",
        })
    }
}

/// A path over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPlan {
    /// How it runs.
    pub pattern: Pattern,
    /// Number of rows, or of turns of the spiral.
    pub rows: u32,
    /// Largest distance along the surface between successive contact points, mm; smaller where the normal turns by more than 3° within it.
    pub step_mm: f64,
    /// Margin at the edges, as a fraction of the surface's size.
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

/// A contact point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The contact point, mm, in the surface's frame.
    pub point: Point,
    /// The surface's unit normal there.
    pub normal: Vector,
    /// The unit direction of feed, in the tangent plane.
    pub feed: Vector,
    /// The tool's unit axis, from its tip upwards.
    pub axis: Unit<Vector>,
}

/// Number of chords that measure the length of a straight piece of a path in (u, v).
const CHORDS: u32 = 512;

/// Largest number of contact points of a path.
const MOST_CONTACTS: usize = 1_000_000;

/// The path would have too many contact points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the path would have more than {MOST_CONTACTS} contact points; take a longer step or fewer rows")]
pub struct TooManyContacts;

impl PathPlan {
    /// The contact points, and the tool's axis at each.
    ///
    /// # Errors
    /// When there would be too many.
    pub fn contacts(&self, surface: &Freeform) -> Result<Vec<Contact>, TooManyContacts> {
        let places = self.places(surface)?;
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
            let axis = turned(feed, -self.tilt, turned(left, self.lead, normal));
            Contact { point, normal, feed, axis: Unit::new_normalize(axis) }
        };
        Ok((0..places.len()).map(contact).collect())
    }

    /// Positions (u, v) on the surface in order: the pieces between corners are divided evenly by their length and by the turn of the
    /// normal.
    fn places(&self, surface: &Freeform) -> Result<Vec<(f64, f64)>, TooManyContacts> {
        let corners = self.corners();
        let mut places: Vec<(f64, f64)> = corners.first().copied().into_iter().collect();
        for pair in corners.windows(2) {
            let between = |part: f64| {
                let [from, to] = [pair[0], pair[1]];
                (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1))
            };
            let at = |chord: u32| {
                let (u, v) = between(f64::from(chord) / f64::from(CHORDS));
                surface.at(u, v)
            };
            // In steps: of way, or of the normal's turn where that takes more.
            let mut way = vec![0.0];
            let mut from = at(0);
            for chord in 1..=CHORDS {
                let to = at(chord);
                let steps = ((to.0 - from.0).norm() / self.step_mm).max(from.1.angle(&to.1) / MOST_TURN);
                way.push(way[way.len() - 1] + steps);
                from = to;
            }
            let length = way[way.len() - 1];
            let pieces = length.ceil().max(1.0);
            if places.len() as f64 + pieces > MOST_CONTACTS as f64 {
                return Err(TooManyContacts);
            }
            for piece in 1..=pieces as usize {
                let wanted = length * (piece as f64 / pieces);
                let chord = way.partition_point(|&way| way < wanted).clamp(1, CHORDS as usize);
                let part = (wanted - way[chord - 1]) / (way[chord] - way[chord - 1]).max(f64::MIN_POSITIVE);
                places.push(between(((chord - 1) as f64 + part) / f64::from(CHORDS)));
            }
        }
        Ok(places)
    }

    /// Corners (u, v) of the path.
    fn corners(&self) -> Vec<(f64, f64)> {
        let inner = |w: f64| self.margin + (1.0 - 2.0 * self.margin) * w;
        match self.pattern {
            Pattern::ZigZag => (0..self.rows)
                .flat_map(|row| {
                    let v = inner(f64::from(row) / f64::from(self.rows.max(2) - 1));
                    let ends = [(inner(0.0), v), (inner(1.0), v)];
                    if row % 2 == 0 { ends } else { [ends[1], ends[0]] }
                })
                .collect(),
            Pattern::Spiral => (0..=4 * self.rows)
                .map(|corner| {
                    let half = 0.5 * (1.0 - f64::from(corner) / f64::from(4 * self.rows.max(1)));
                    let (x, y) = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)][corner as usize % 4];
                    (inner(0.5 + half * x), inner(0.5 + half * y))
                })
                .collect(),
        }
    }
}

/// `direction` rotated by `angle`, radians, about the unit vector `about`.
fn turned(about: Vector, angle: f64, direction: Vector) -> Vector {
    Rotation3::from_axis_angle(&Unit::new_normalize(about), angle) * direction
}

/// A fault inserted into a path on purpose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flaw {
    /// At one contact point, the tool is sunk into the surface against the normal.
    Gouge {
        /// How deep, mm.
        depth_mm: f64,
    },
    /// At one contact point, the tool is tilted to the left of the feed, about its contact point.
    Lean {
        /// Angle beyond its planned tilt, radians.
        angle: f64,
    },
}

/// A programmed position of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// The contact point there.
    pub contact: Contact,
    /// Depth of the tool in the surface, mm; negative when lifted.
    pub sunk_mm: f64,
}

/// Largest turn of the tool's axis, or of the surface's normal, within one move, radians; a move with a larger turn is divided. At 3°, the
/// middle of a ball of 10 mm that rolls over an edge deviates from its straight line by 10 (3° in radians)² / 8 = 0.003 mm.
const MOST_TURN: f64 = 3.0 * std::f64::consts::PI / 180.0;

/// The stop at a contact point with a flaw.
pub fn flawed(contact: &Contact, flaw: Flaw) -> Stop {
    match flaw {
        Flaw::Gouge { depth_mm } => Stop { contact: *contact, sunk_mm: depth_mm },
        Flaw::Lean { angle } => {
            let axis = Unit::new_normalize(turned(contact.feed, -angle, contact.axis.into_inner()));
            Stop { contact: Contact { axis, ..*contact }, sunk_mm: 0.0 }
        }
    }
}

/// The programmed positions: every contact point, and additional ones where the axis would turn by more than 3° on the way to the next
/// point. In that case the tool first turns about its current contact point. The position of a flaw is a fraction of the path, 0 for the
/// first contact point and 1 for the last.
pub fn stops(contacts: &[Contact], flaws: &[(f64, Flaw)]) -> Vec<Stop> {
    let mut planned: Vec<Stop> = contacts.iter().map(|&contact| Stop { contact, sunk_mm: 0.0 }).collect();
    for &(part, flaw) in flaws {
        let index = (part.clamp(0.0, 1.0) * contacts.len().saturating_sub(1) as f64).round() as usize;
        if let Some(stop) = planned.get_mut(index) {
            *stop = flawed(&stop.contact, flaw);
        }
    }
    let mut stops: Vec<Stop> = Vec::with_capacity(planned.len());
    for stop in planned {
        if let Some(&before) = stops.last() {
            let (from, to) = (before.contact.axis, stop.contact.axis);
            let pieces = (from.angle(&to) / MOST_TURN).ceil();
            for piece in 1..pieces as u32 {
                let axis = from.try_slerp(&to, f64::from(piece) / pieces, 0.0).unwrap_or(to);
                stops.push(Stop { contact: Contact { axis, ..before.contact }, ..before });
            }
        }
        stops.push(stop);
    }
    stops
}

impl Contact {
    /// The tool's frame in the surface's frame when its corner touches here, sunk by `depth_mm` against the normal (negative: lifted).
    pub fn surface_from_tool(&self, corner: Corner, depth_mm: f64) -> Isometry {
        let (n, d) = (self.normal, self.axis.into_inner());
        let across = (n - d * d.dot(&n)).try_normalize(1e-9).unwrap_or_else(Vector::zeros);
        let on_axis = self.point + n * (corner.corner_mm - depth_mm) + across * (corner.radius_mm - corner.corner_mm);
        let tip = on_axis - d * corner.corner_mm;
        // Which way the tool is turned about its axis does not matter.
        Isometry::from_parts(tip.coords.into(), turn_between(&Vector::z(), &d))
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
        PathPlan { pattern, rows: 5, step_mm: 1.5, margin: 0.1, lead: 0.2, tilt: -0.1 }
    }

    /// For every tool, the contact point lies on the tool's surface, and that surface is tangential there: a small displacement along the
    /// normal changes the distance by the same amount.
    #[test]
    fn the_tool_touches_at_the_contact_point() {
        for (radius_mm, corner_mm) in [(5.0, 5.0), (6.0, 1.5), (4.0, 0.0)] {
            let profile = Profile::bull_nose(radius_mm, corner_mm, 40.0).unwrap();
            for pattern in [Pattern::ZigZag, Pattern::Spiral] {
                let contacts = plan(pattern).contacts(&hollow()).unwrap();
                // Five rows of 64 mm and more, or five turns around 64 by 48 mm.
                assert!(contacts.len() > 220, "{}", contacts.len());
                let steps = contacts.windows(2).map(|pair| (pair[1].point - pair[0].point).norm());
                assert!(steps.fold(0.0, f64::max) <= 1.5);
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
        let first = plan(Pattern::ZigZag).contacts(&flat).unwrap()[3];
        // Feed along +x: the lead leans the axis to +x, a tilt to the left to +y.
        let expected = Vector::new(0.2f64.sin(), (-0.1f64).sin() * 0.2f64.cos(), (-0.1f64).cos() * 0.2f64.cos());
        assert!((first.axis.into_inner() - expected).norm() < 1e-9, "{}", first.axis.into_inner());
    }

    #[test]
    fn flaws_are_where_they_were_put_and_the_axis_turns_slowly() {
        let contacts = plan(Pattern::ZigZag).contacts(&hollow()).unwrap();
        let clean = stops(&contacts, &[]);
        let flawed = stops(&contacts, &[(0.25, Flaw::Gouge { depth_mm: 0.05 }), (0.7, Flaw::Lean { angle: 0.5 })]);
        for stops in [&clean, &flawed] {
            let turns = stops.windows(2).map(|pair| pair[0].contact.axis.angle(&pair[1].contact.axis));
            assert!(turns.fold(0.0, f64::max) <= MOST_TURN + 1e-9);
        }
        // To lean by 0.5 and back takes 2 (10 - 1) more stops, give or take what the axis does anyway.
        assert!((14..=22).contains(&(flawed.len() - clean.len())), "{} {}", flawed.len(), clean.len());
        let gouge: Vec<&Stop> = flawed.iter().filter(|stop| stop.sunk_mm != 0.0).collect();
        let at = (0.25 * (contacts.len() - 1) as f64).round() as usize;
        assert!(gouge.iter().all(|stop| stop.sunk_mm == 0.05 && stop.contact.point == contacts[at].point));
        let lean = (0.7 * (contacts.len() - 1) as f64).round() as usize;
        let leant = flawed.iter().filter(|stop| stop.contact.point == contacts[lean].point);
        let most = leant.map(|stop| stop.contact.axis.angle(&contacts[lean].axis)).fold(0.0, f64::max);
        // About the feed the axis, 0.2 ahead of the normal, leans by less: cos 0.2 of it at small angles.
        assert!((0.47..=0.5).contains(&most), "{most}");
    }
}

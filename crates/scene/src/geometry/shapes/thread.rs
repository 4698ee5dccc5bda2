//! Screws: a rod with an external thread.
//!
//! The surface is divided along the helix. Every row of vertices is one edge of the thread's profile, wound up the rod, so crests and roots
//! are sharp at any density. The end planes cut the rows off at both ends. Within one pitch of an end, the thread runs out into the core,
//! as on a turned screw, so the end circles have the core's radius.

use super::super::Point;
use super::error::{SMALLEST_MM, ShapeError, length, within};
use super::solid::Surface;
use super::tessellation::{Sizing, affordable};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// A right-handed screw about the z axis, from z = 0 to z = `length_mm`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thread {
    /// Radius over the crests, mm.
    pub radius_mm: f64,
    /// Rise of one turn, mm.
    pub pitch_mm: f64,
    /// Length, mm; at least two pitches.
    pub length_mm: f64,
    /// Shape of the ridge.
    #[serde(default)]
    pub form: ThreadForm,
}

/// The shape of a thread's ridge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ThreadForm {
    /// ISO 68-1: 60° flanks, 5/8 of the height of the sharp triangle (0.541 pitches), crest pitch/8, root pitch/4.
    #[default]
    Metric,
    /// ISO 2901: 30° flanks, height half a pitch, crest and root 0.366 pitches: lead screws.
    Trapezoidal,
}

impl ThreadForm {
    /// Height of the ridge and width of root and crest, in pitches.
    const fn proportions(self) -> (f64, f64, f64) {
        match self {
            Self::Metric => (0.541_265_877_365_274_6, 0.25, 0.125), // 5/16 · √3
            Self::Trapezoidal => (0.5, 0.366, 0.366),
        }
    }
}

impl Thread {
    pub(super) fn surface(&self, sizing: &Sizing) -> Result<Surface, ShapeError> {
        let radius = length("radius_mm", self.radius_mm)?;
        let pitch = length("pitch_mm", self.pitch_mm)?;
        let length = length("length_mm", self.length_mm)?;
        let (height, ..) = self.form.proportions();
        within("pitch_mm", pitch, SMALLEST_MM, (radius - SMALLEST_MM) / height)?;
        within("length_mm", length, 2.0 * pitch, f64::MAX)?;
        let segments = sizing.circle(radius);
        let profile = self.profile(sizing);
        let turns = (length / pitch).ceil() as usize;
        affordable("pitch_mm", &[2, segments, turns + 1, profile.len()])?;

        // One row of vertices per edge of the profile and turn. The turn below the first winds through the end plane.
        let rows_per_turn = profile.len() as i64;
        let mut winding =
            Winding { screw: self, profile, segments, surface: Surface::default(), vertex_at: HashMap::new() };
        for row in -rows_per_turn..turns as i64 * rows_per_turn {
            for segment in 0..segments {
                let [a, b] = [segment, segment + 1].map(|s| winding.vertex(row, s));
                let [d, c] = [segment, segment + 1].map(|s| winding.vertex(row + 1, s));
                winding.surface.triangle(a, b, c);
                winding.surface.triangle(a, c, d);
            }
        }
        Ok(winding.close())
    }

    /// The profile of the thread: for each row of vertices, its position within the pitch and its fraction of the ridge height, both from 0
    /// to 1.
    fn profile(&self, sizing: &Sizing) -> Vec<(f64, f64)> {
        let (height, root, crest) = self.form.proportions();
        let flank = (1.0 - root - crest) / 2.0;
        let pieces = sizing.straight(self.pitch_mm * height.hypot(flank));
        let part = |k: usize| k as f64 / pieces as f64;
        let mut rows = vec![(0.0, 0.0)];
        rows.extend((0..=pieces).map(|k| (root + flank * part(k), part(k))));
        rows.extend((0..pieces).map(|k| (root + flank + crest + flank * part(k), 1.0 - part(k))));
        rows
    }
}

/// A vertex nearer to an end plane than this, in pitches, is moved onto the plane, which avoids slivers.
const END_MARGIN: f64 = 1e-3;

/// Position of a vertex of the helicoid: the end plane that cuts it off, or its row and segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Place {
    Bottom(usize),
    Top(usize),
    Row(i64, usize),
}

/// A thread under construction.
struct Winding<'a> {
    screw: &'a Thread,
    profile: Vec<(f64, f64)>,
    segments: usize,
    surface: Surface,
    vertex_at: HashMap<Place, u32>,
}

impl Winding<'_> {
    /// The vertex at which a row crosses a meridian. The meridian after the last one is the first, with rows one turn higher.
    fn vertex(&mut self, row: i64, segment: usize) -> u32 {
        let rows_per_turn = self.profile.len() as i64;
        let row = row + (segment / self.segments) as i64 * rows_per_turn;
        let segment = segment % self.segments;
        let (along, ridge) = self.profile[row.rem_euclid(rows_per_turn) as usize];
        let turns = row.div_euclid(rows_per_turn) as f64 + along + segment as f64 / self.segments as f64;
        let turns_in_all = self.screw.length_mm / self.screw.pitch_mm;
        if turns < END_MARGIN {
            self.at(Place::Bottom(segment), segment, 0.0, 0.0)
        } else if turns > turns_in_all - END_MARGIN {
            self.at(Place::Top(segment), segment, turns_in_all, 0.0)
        } else {
            let run_out = turns.min(turns_in_all - turns).min(1.0);
            self.at(Place::Row(row, segment), segment, turns, ridge * run_out)
        }
    }

    /// The vertex at a place; its height is in turns, and `ridge` runs from 0 to 1.
    fn at(&mut self, place: Place, segment: usize, turns: f64, ridge: f64) -> u32 {
        let (height, ..) = self.screw.form.proportions();
        let radius = self.screw.radius_mm - (1.0 - ridge) * height * self.screw.pitch_mm;
        let (sin, cos) = (TAU * segment as f64 / self.segments as f64).sin_cos();
        let point = Point::new(radius * cos, radius * sin, turns * self.screw.pitch_mm);
        *self.vertex_at.entry(place).or_insert_with(|| self.surface.vertex(point))
    }

    /// Adds the end faces.
    fn close(mut self) -> Surface {
        let turns_in_all = self.screw.length_mm / self.screw.pitch_mm;
        let bottom: Vec<u32> = (0..self.segments).map(|s| self.at(Place::Bottom(s), s, 0.0, 0.0)).collect();
        let top: Vec<u32> = (0..self.segments).map(|s| self.at(Place::Top(s), s, turns_in_all, 0.0)).collect();
        let below = self.surface.vertex(Point::origin());
        let above = self.surface.vertex(Point::new(0.0, 0.0, self.screw.length_mm));
        self.surface.band(&[below], &bottom);
        self.surface.band(&top, &[above]);
        self.surface
    }
}

#[cfg(test)]
mod tests {
    use super::super::tessellation::Tessellation;
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_thread_is_a_closed_rod_between_its_core_and_its_crests() {
        let screw = Thread { radius_mm: 6.0, pitch_mm: 1.75, length_mm: 30.0, form: ThreadForm::Metric };
        let mesh = screw.surface(&Sizing::new(&Tessellation::default(), 1.0)).unwrap().finish().unwrap();
        let core = 6.0 - 0.541_265_877 * 1.75;
        let cylinder = |r: f64| PI * r * r * 30.0;
        assert!(mesh.signed_volume() > cylinder(core) && mesh.signed_volume() < cylinder(6.0));
        let widest = mesh.vertices().iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max);
        assert!((widest - 6.0).abs() < 1e-6);
    }

    #[test]
    fn the_basic_profile_has_flanks_of_30_degrees() {
        let (height, root, crest) = ThreadForm::Metric.proportions();
        let flank = (1.0 - root - crest) / 2.0;
        assert!(((flank / height).atan().to_degrees() - 30.0).abs() < 1e-9);
    }
}

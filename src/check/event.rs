//! From stretches of the path to what a user is told.
//!
//! Rules. Contact of a pair is a collision, but for a cutter with the workpiece: contact that begins in a feed move is
//! cutting and is not told, nor is the retreat from it; contact that begins in a rapid move is a collision and is
//! named as such. Shank and holder of a tool never cut. Since material is not removed, a rapid that begins inside the uncut workpiece belongs to the cut before it. Nearness of
//! these two is not told at all. Contacts of one pair on one line that do not leave the narrowest zone are one.

use super::Settings;
use super::motion::Path;
use super::scan::{Nearness, Stretch};
use crate::gcode::Position;
use crate::scene::{Pair, Role, Scene};
use crate::truth::PairOracle;
use std::sync::Arc;

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Two parts touch, or overlap.
    Collision,
    /// The cutter comes into the workpiece at rapid rate.
    RapidIntoWorkpiece,
    /// Two parts are nearer than this, mm.
    Near {
        /// The zone.
        zone_mm: f64,
    },
}

impl Kind {
    /// Whether it is more than nearness.
    #[must_use]
    pub const fn is_collision(&self) -> bool {
        !matches!(self, Self::Near { .. })
    }

    /// Its name in listings.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Collision => "collision",
            Self::RapidIntoWorkpiece => "rapid-into-workpiece",
            Self::Near { .. } => "near",
        }
    }
}

/// One end of an event.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// Line of the program; 0 before its first move.
    pub line: u32,
    /// Time from the program's start, s.
    pub time_s: f64,
    /// Axis positions, mm and radians.
    pub position: Position,
    /// Whether the move is rapid.
    pub rapid: bool,
}

/// Something that happens to a pair of parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// What.
    pub kind: Kind,
    /// The parts.
    pub pair: Pair,
    /// Text of the line on which it begins.
    pub block: String,
    /// Where it begins.
    pub first: Extent,
    /// Where it ends.
    pub last: Extent,
    /// The least distance found meanwhile, mm; 0 in contact.
    pub least_mm: f64,
    /// Where the distance is least.
    pub nearest: Extent,
    /// Whether it lasts to the end of what was examined.
    pub to_the_end: bool,
}

/// All events, by the time at which they begin; `scanned` holds per chunk of the path and per pair its stretches.
pub(super) fn events(
    scene: &Scene,
    path: &Path<'_>,
    pairs: &[Pair],
    scanned: &[Vec<Vec<Stretch>>],
    settings: &Settings,
) -> Vec<Event> {
    let mut found: Vec<(f64, Event)> = Vec::new();
    for (index, &pair) in pairs.iter().enumerate() {
        let stretches: Vec<Stretch> = scanned.iter().filter_map(|chunk| chunk.get(index)).flatten().copied().collect();
        let of_pair = OfPair { scene, path, pair };
        found.extend(of_pair.collisions(&stretches));
        if !of_pair.is_cutting() {
            let mut zones = settings.zones_mm.clone();
            zones.sort_by(f64::total_cmp);
            for (zone, &zone_mm) in zones.iter().enumerate() {
                let runs = runs(&stretches, zone + 1);
                found.extend(runs.iter().map(|run| (run.from, of_pair.event(Kind::Near { zone_mm }, run))));
            }
        }
    }
    // Wider zones begin earlier or together with narrower ones and with contact; the sort keeps that order.
    found.sort_by(|(a, x), (b, y)| a.total_cmp(b).then_with(|| width(&y.kind).total_cmp(&width(&x.kind))));
    found.into_iter().map(|(_, event)| event).collect()
}

fn width(kind: &Kind) -> f64 {
    match kind {
        Kind::Near { zone_mm } => *zone_mm,
        Kind::Collision | Kind::RapidIntoWorkpiece => 0.0,
    }
}

/// The longest runs of stretches that join and are at least as near as `nearness`.
fn runs(stretches: &[Stretch], nearness: Nearness) -> Vec<Stretch> {
    let mut runs: Vec<Stretch> = Vec::new();
    let mut open = false;
    let mut end = f64::NEG_INFINITY;
    for stretch in stretches {
        let near = stretch.nearness <= nearness;
        match runs.last_mut() {
            Some(run) if near && open && joins(end, stretch.from) => {
                run.to = stretch.to;
                if stretch.least_mm < run.least_mm {
                    (run.least_mm, run.least_at) = (stretch.least_mm, stretch.least_at);
                }
            }
            _ if near => runs.push(*stretch),
            _ => {}
        }
        (open, end) = (near, stretch.to);
    }
    runs
}

/// Whether a stretch goes on where another one ended: no whole place lies between them that would have been free.
fn joins(end: f64, from: f64) -> bool {
    from - end < 1.0 && (end.ceil() >= from.floor() || end.floor() + 1.0 >= from)
}

struct OfPair<'a> {
    scene: &'a Scene,
    path: &'a Path<'a>,
    pair: Pair,
}

impl OfPair<'_> {
    /// Whether this is the cutter and the workpiece.
    fn is_cutting(&self) -> bool {
        let roles = [self.pair.a, self.pair.b].map(|part| self.scene.parts[part].role);
        roles == [Role::Cutter, Role::Workpiece] || roles == [Role::Workpiece, Role::Cutter]
    }

    fn collisions(&self, stretches: &[Stretch]) -> Vec<(f64, Event)> {
        let mut contacts: Vec<Stretch> = Vec::new();
        for episode in runs(stretches, 1) {
            let inside = |contact: &Stretch| episode.from <= contact.from && contact.to <= episode.to;
            let mut of_episode: Vec<Stretch> = Vec::new();
            for contact in runs(stretches, 0).into_iter().filter(inside) {
                match of_episode.last_mut() {
                    Some(last) if self.line(last.from) == self.line(contact.from) => last.to = contact.to,
                    _ => of_episode.push(contact),
                }
            }
            contacts.extend(of_episode);
        }
        let told = contacts.into_iter().filter_map(|contact| {
            let kind = match (self.is_cutting(), self.path.sample_at(contact.from).rapid) {
                (true, false) => return None,
                (true, true) if self.comes_from_inside(&contact) => return None,
                (true, true) => Kind::RapidIntoWorkpiece,
                (false, _) => Kind::Collision,
            };
            Some((contact.from, self.event(kind, &contact)))
        });
        told.collect()
    }

    /// Whether one part lay inside the other, their surfaces apart, before they touched: a short cutter that the cut took in whole.
    fn comes_from_inside(&self, contact: &Stretch) -> bool {
        let poses = self.scene.machine.forward(&self.path.position((contact.from.ceil() as usize).saturating_sub(1)));
        let mesh = |part: usize| Arc::clone(&self.scene.parts[part].mesh);
        let oracle = PairOracle::new(mesh(self.pair.a), mesh(self.pair.b));
        oracle.judge(&self.scene.a_from_b(self.pair, &poses)).contained
    }

    fn line(&self, place: f64) -> u32 {
        self.path.sample_at(place).line
    }

    fn event(&self, kind: Kind, run: &Stretch) -> Event {
        let first = self.extent(run.from);
        Event {
            kind,
            pair: self.pair,
            block: self.path.block(first.line).to_owned(),
            first,
            last: self.extent(run.to),
            least_mm: run.least_mm,
            nearest: self.extent(run.least_at),
            to_the_end: run.to >= self.path.samples().len() as f64,
        }
    }

    fn extent(&self, place: f64) -> Extent {
        let sample = self.path.sample_at(place);
        let line = if place <= 0.0 { 0 } else { sample.line };
        Extent {
            line,
            time_s: self.path.time_s(place),
            position: self.path.position_at(place),
            rapid: place > 0.0 && sample.rapid,
        }
    }
}

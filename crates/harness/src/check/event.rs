//! From stretches of the path to what a user is told.
//!
//! Contact of a pair is a collision, before the first move as after it. A cutter and its workpiece are another matter. Of these two:
//!
//! - The cutter takes material away in feed moves. Contact with what is left is told as the stock finds it ([`super::stock`]).
//! - Where the workpiece's mesh is open, nothing is taken away. Contact that begins in a feed move is cutting, and the first such contact is unresolved. Contact that
//!   begins at rapid rate, with a change of tools or before the first move is a collision, and so is a feed into it while the spindle stands still; behind the first
//!   cut it is unresolved.
//! - Where the workpiece stays whole, on request, the same holds, but cutting is not told, nor is a rapid that begins within it: that is a retreat.
//! - Where the workpiece is the finished part, the cutter gouges it when it goes deeper than the scene allows. Otherwise than in a feed move it may not even touch it.
//! - Nearness of the two is not told. Shank and holder of a tool never cut.
//!
//! Contacts of one pair and one kind on one line that part by less than [`super::PARTED_MM`] between them are one.

use super::motion::Path;
use super::scan::{Nearness, Stretch};
use super::stock::StockContact;
use super::turning::Needs;
use super::{Distances, PARTED_MM, Settings};
use crate::scene::{Pair, Role, Scene};
use rs274::{Move, MoveKind, Position};

/// What happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Two parts touch, or overlap.
    Collision,
    /// The cutter comes into the workpiece at rapid rate.
    RapidIntoWorkpiece,
    /// The cutter is in the workpiece when it is put into the spindle.
    ToolChangeIntoWorkpiece,
    /// The cutter feeds into the workpiece while the spindle stands still.
    StoppedSpindleIntoWorkpiece,
    /// The cutter goes deeper into the finished workpiece than it may.
    Gouge,
    /// A part may come into what is left of the workpiece, deeper than the resolution of the stock, or the workpiece is cut and its mesh is open, or a
    /// part that a spindle turns may touch something; whether it does is not known.
    Unresolved,
    /// Two parts are nearer than this, mm.
    Near {
        /// The zone.
        zone_mm: f64,
    },
}

impl Kind {
    /// Whether it is more than nearness.
    pub const fn is_collision(&self) -> bool {
        !matches!(self, Self::Near { .. })
    }

    /// Its name in listings.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Collision => "collision",
            Self::RapidIntoWorkpiece => "rapid-into-workpiece",
            Self::ToolChangeIntoWorkpiece => "tool-change-into-workpiece",
            Self::StoppedSpindleIntoWorkpiece => "stopped-spindle-into-workpiece",
            Self::Gouge => "gouge",
            Self::Unresolved => "unresolved",
            Self::Near { .. } => "near",
        }
    }
}

/// One end of an event.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// Place on the [`Path`].
    pub place: f64,
    /// Line of the program; 0 before its first move.
    pub line: u32,
    /// Part of the way through that line's move, 0 to 1.
    pub fraction: f64,
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
    /// The least distance found meanwhile, mm; 0 in contact and where one part is inside the other; of a gouge, and of contact with the stock, minus the
    /// depth that is certain; of a cutter inside a finished workpiece, minus its distance from the surface.
    pub least_mm: f64,
    /// How deep what is left of the workpiece comes into the other part, mm: at least, and at most. `None` where nothing is cut.
    pub depth_mm: Option<[f64; 2]>,
    /// Whether meanwhile one part is wholly inside the other, surfaces apart.
    pub inside: bool,
    /// Where the distance is least.
    pub nearest: Extent,
    /// Whether it lasts to the end of what was examined.
    pub to_the_end: bool,
}

/// What events are made of.
pub(super) struct EventWriter<'a> {
    pub scene: &'a Scene,
    pub path: &'a Path<'a>,
    pub pairs: &'a [Pair],
    /// The distances at which something is told of each pair.
    pub distances: &'a [Distances],
    /// Whether a pair's contact is told by the stock.
    pub is_stock: &'a (dyn Fn(Pair) -> bool + Sync),
    /// Whether a rapid that begins within a pair's workpiece is taken for a retreat.
    pub stays_whole: &'a (dyn Fn(Pair) -> bool + Sync),
}

impl EventWriter<'_> {
    /// All events, by the time at which they begin; `scanned` holds per chunk of the path and per pair its stretches.
    pub fn events(&self, scanned: &[Vec<Vec<Stretch>>], stock: &[StockContact], settings: &Settings) -> Vec<Event> {
        let mut found: Vec<(f64, Event)> = Vec::new();
        for (index, (&pair, distances)) in self.pairs.iter().zip(self.distances).enumerate() {
            let of_chunks = scanned.iter().filter_map(|chunk| chunk.get(index));
            let is_stock = (self.is_stock)(pair);
            // Within the uncut workpiece nobody knows how near the rest of it is.
            let counts = |stretch: &&Stretch| !is_stock || stretch.nearness > 0;
            let stretches: Vec<Stretch> = of_chunks.flatten().filter(counts).copied().collect();
            let of_pair = OfPair { scene: self.scene, path: self.path, pair, stays_whole: (self.stays_whole)(pair) };
            let touching = settings.touching_mm(self.scene).filter(|_| self.scene.is_cutting(pair));
            found.extend(of_pair.collisions(
                &stretches,
                distances.nearness_below(PARTED_MM),
                touching.map(|mm| distances.nearness_below(mm)),
            ));
            if !self.scene.is_cutting(pair) {
                for &zone_mm in &distances.zones_mm {
                    let runs = runs(&stretches, distances.nearness_below(zone_mm));
                    found.extend(runs.iter().map(|run| (run.from, of_pair.event(Kind::Near { zone_mm }, run))));
                }
            }
        }
        found.extend(stock.iter().map(|contact| (contact.from, self.of_stock(contact))));
        // Wider zones begin earlier or together with narrower ones and with contact; the sort keeps that order.
        found.sort_by(|(a, x), (b, y)| a.total_cmp(b).then_with(|| width(&y.kind).total_cmp(&width(&x.kind))));
        found.into_iter().map(|(_, event)| event).collect()
    }

    /// Adds contact of what a spindle turns, of which it is not known whether it happens: on each line on which the parts as drawn do not collide
    /// meanwhile.
    pub fn add_turned(&self, events: &mut Vec<Event>, turned: Vec<Event>) {
        let mut added = Vec::new();
        for contact in turned.into_iter().filter(|event| event.kind.is_collision()) {
            let is_same = |event: &&Event| event.kind.is_collision() && event.pair == contact.pair;
            let mut drawn: Vec<[f64; 2]> =
                events.iter().filter(is_same).map(|event| [event.first.place, event.last.place]).collect();
            drawn.sort_by(|[a, _], [b, _]| a.total_cmp(b));
            added.extend(self.beside(&contact, &drawn));
        }
        events.extend(added);
        events.sort_by(|a, b| {
            a.first.place.total_cmp(&b.first.place).then_with(|| width(&b.kind).total_cmp(&width(&a.kind)))
        });
    }

    /// The parts of a contact on lines on which none of the stretches `drawn`, in order, meets it.
    fn beside(&self, contact: &Event, drawn: &[[f64; 2]]) -> Vec<Event> {
        let of_pair = OfPair { scene: self.scene, path: self.path, pair: contact.pair, stays_whole: false };
        let (mut parts, mut from, end) = (Vec::new(), contact.first.place, contact.last.place);
        // Line of the last stretch before the part.
        let mut before = None;
        // `lines` are those on which the stretch before the part ends and the one behind it begins.
        let mut add = |from: f64, to: f64, lines: [Option<u32>; 2]| {
            let is_other = |place: f64, line: Option<u32>| line != Some(of_pair.line(place));
            if from < to && is_other(from, lines[1]) && is_other(to, lines[0]) {
                let (first, last) = (of_pair.extent(from), of_pair.extent(to));
                let (block, nearest) = (self.path.block(first.line).to_owned(), first.clone());
                let to_the_end = contact.to_the_end && to == end;
                parts.push(Event {
                    kind: Kind::Unresolved,
                    block,
                    first,
                    last,
                    nearest,
                    to_the_end,
                    ..contact.clone()
                });
            }
        };
        for &[begin, stop] in drawn.iter().filter(|[begin, stop]| *begin <= end && contact.first.place <= *stop) {
            add(from, begin, [before, Some(of_pair.line(begin))]);
            (from, before) = (from.max(stop.next_up()), Some(of_pair.line(stop)));
        }
        if before.is_none() {
            return vec![Event { kind: Kind::Unresolved, ..contact.clone() }];
        }
        add(from, end, [before, None]);
        parts
    }

    /// Contact with what is left of a workpiece.
    fn of_stock(&self, contact: &StockContact) -> Event {
        let StockContact { pair, kind, from, to, depth, deepest_at, .. } = *contact;
        let of_pair = OfPair { scene: self.scene, path: self.path, pair, stays_whole: false };
        let kind = if depth.low > 0.0 { kind } else { Kind::Unresolved };
        let (least_mm, least_at) = (-depth.low, deepest_at.clamp(from, to));
        let run = Stretch { nearness: 0, from, to, least_mm, least_at, inside: false, goes_on: false };
        Event { depth_mm: Some([depth.low, depth.high]), ..of_pair.event(kind, &run) }
    }
}

impl Distances {
    /// The nearness just below a border.
    fn nearness_below(&self, mm: f64) -> Nearness {
        1 + self.borders_mm.iter().take_while(|&&border| border < mm).count()
    }
}

fn width(kind: &Kind) -> f64 {
    match kind {
        Kind::Near { zone_mm } => *zone_mm,
        _ => 0.0,
    }
}

/// The longest runs of stretches that join and are at least as near as `nearness`.
pub(super) fn runs(stretches: &[Stretch], nearness: Nearness) -> Vec<Stretch> {
    let mut runs: Vec<Stretch> = Vec::new();
    let mut open = false;
    let mut end = f64::NEG_INFINITY;
    for stretch in stretches {
        let near = stretch.nearness <= nearness;
        match runs.last_mut() {
            // A chunk of the path begins with the place that ended the chunk before it.
            Some(run) if near && open && (stretch.goes_on || stretch.from <= end) => {
                run.to = stretch.to;
                run.inside |= stretch.inside;
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

struct OfPair<'a> {
    scene: &'a Scene,
    path: &'a Path<'a>,
    pair: Pair,
    stays_whole: bool,
}

impl OfPair<'_> {
    /// Contacts; those of an episode in which the pair does not get farther apart than the border `parted` are one on each line and of
    /// each kind. `touching` is the border at which a cutter touches a finished workpiece.
    fn collisions(&self, stretches: &[Stretch], parted: Nearness, touching: Option<Nearness>) -> Vec<(f64, Event)> {
        let found = self.contacts(stretches, touching);
        let mut contacts: Vec<(Stretch, Option<Kind>)> = Vec::new();
        for episode in runs(stretches, parted.max(touching.unwrap_or(0))) {
            let mut of_episode: Vec<(Stretch, Option<Kind>)> = Vec::new();
            for &(contact, kind) in found.iter().filter(|(contact, _)| contact.is_in(&episode)) {
                match of_episode.last_mut() {
                    // One line may be a whole subroutine or cycle, with feed moves that cut and rapids that must not.
                    Some((last, same)) if *same == kind && self.line(last.from) == self.line(contact.from) => {
                        last.to = contact.to;
                        last.inside |= contact.inside;
                        if contact.least_mm < last.least_mm {
                            (last.least_mm, last.least_at) = (contact.least_mm, contact.least_at);
                        }
                    }
                    _ => of_episode.push((contact, kind)),
                }
            }
            contacts.extend(of_episode);
        }
        let told = contacts.into_iter().filter_map(|(contact, kind)| {
            let mut event = self.event(kind?, &contact);
            if let Some(allowed) = self.scene.gouge_mm.filter(|_| self.scene.is_cutting(self.pair)) {
                event.least_mm -= allowed;
            }
            Some((contact.from, event))
        });
        told.collect()
    }

    /// Contacts by where they begin. A finished workpiece may be touched in feed moves only: where anything else comes to touch it, that is
    /// contact, and what begins within it other than in a feed move belongs to it.
    fn contacts(&self, stretches: &[Stretch], touching: Option<Nearness>) -> Vec<(Stretch, Option<Kind>)> {
        let with_kind = |contact: Stretch| (contact, self.kind(&contact));
        let behind_probe = |contact: Stretch| self.behind_probe(contact);
        let is_feed = |kind: &Option<Kind>| *kind == Some(Kind::Gouge);
        let mut contacts: Vec<_> = runs(stretches, 0).into_iter().filter_map(behind_probe).map(with_kind).collect();
        if self.scene.is_cutting(self.pair) && self.scene.gouge_mm.is_none() {
            let Pair { a, b } = self.pair;
            let (workpiece, cutter) = if self.scene.parts[a].role == Role::Workpiece { (a, b) } else { (b, a) };
            let needs = Needs::of(self.scene, self.path, workpiece, cutter);
            let is_stopped = |step: &Move| step.kind.is_feed() && needs.stands(step);
            let stopped = contacts.iter().flat_map(|(contact, _)| self.parts_of(contact, &is_stopped));
            let stopped = stopped.map(|part| (part, Some(Kind::StoppedSpindleIntoWorkpiece)));
            let stopped: Vec<_> = stopped.collect();
            let cut = contacts.iter().find(|(_, kind)| kind.is_none() && !self.stays_whole);
            let cut = cut.map_or(f64::INFINITY, |(contact, _)| contact.from);
            contacts.extend(stopped);
            // Once an open workpiece is cut, nobody knows what is in it. Of later cuts nothing more is told.
            for (contact, kind) in contacts.iter_mut().filter(|(contact, _)| contact.from >= cut) {
                if kind.is_some() || contact.from == cut {
                    *kind = Some(Kind::Unresolved);
                }
            }
        }
        if let Some(touching) = touching {
            // What touches where the machine stands at first has not come there.
            let touched = runs(stretches, touching).into_iter().filter(|run| run.from > 0.0);
            let touched = touched.filter_map(behind_probe).map(with_kind);
            let touched: Vec<_> = touched.filter(|(_, kind)| !is_feed(kind)).collect();
            contacts.retain(|(contact, kind)| is_feed(kind) || !touched.iter().any(|(run, _)| contact.is_in(run)));
            contacts.extend(touched);
        }
        contacts.sort_by(|(a, _), (b, _)| a.from.total_cmp(&b.from));
        contacts
    }

    /// What is left of a contact behind the way of a probe in which it begins, on which a cutter may touch its workpiece.
    fn behind_probe(&self, contact: Stretch) -> Option<Stretch> {
        let mut from = contact.from;
        while from <= contact.to && self.scene.is_cutting(self.pair) && self.path.is_probing(from) {
            from = from.ceil().next_up();
        }
        (from <= contact.to).then_some(Stretch { from, ..contact })
    }

    /// What a contact is, by the move in which it begins; `None` where it is meant.
    fn kind(&self, contact: &Stretch) -> Option<Kind> {
        if !self.scene.is_cutting(self.pair) {
            return Some(Kind::Collision);
        }
        match self.path.step(contact.from).kind {
            _ if contact.from <= 0.0 && self.scene.gouge_mm.is_none() => Some(Kind::Collision),
            MoveKind::Rapid => Some(Kind::RapidIntoWorkpiece),
            MoveKind::ToolChange { .. } => Some(Kind::ToolChangeIntoWorkpiece),
            MoveKind::Feed | MoveKind::Arc { .. } | MoveKind::Dwell { .. } => {
                self.scene.gouge_mm.is_some().then_some(Kind::Gouge)
            }
        }
    }

    /// The parts of a contact in such moves, one for each sample.
    fn parts_of(&self, contact: &Stretch, is_such: &dyn Fn(&Move) -> bool) -> Vec<Stretch> {
        let of_sample = |place: usize| {
            // A whole place belongs to the move that leads to it.
            let (begin, end) = ((place as f64).next_up(), place as f64 + 1.0);
            let (from, to) = (contact.from.max(begin), contact.to.min(end));
            is_such(self.path.step(to)).then_some(Stretch { from, to, least_at: to, ..*contact })
        };
        (contact.from.floor() as usize..contact.to.ceil() as usize).filter_map(of_sample).collect()
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
            depth_mm: None,
            inside: run.inside,
            nearest: self.extent(run.least_at),
            to_the_end: run.to >= self.path.samples().len() as f64,
        }
    }

    fn extent(&self, place: f64) -> Extent {
        let sample = self.path.sample_at(place);
        let line = if place <= 0.0 { 0 } else { sample.line };
        Extent {
            place,
            line,
            fraction: self.path.fraction(place),
            time_s: self.path.time_s(place),
            position: self.path.position_at(place),
            rapid: place > 0.0 && sample.rapid,
        }
    }
}

//! One pair along the whole path: intervals over which planes part it, contact that is proved, and what stays open.

use super::hull::{Parting, Token, Tree, piercing};
use super::motion::{Course, PairMotion, Region, Track};
use crate::geometry::{Isometry, Vector};
use crate::method::Model;
use crate::truth::Solid;
use std::cell::Cell;
use std::mem::{discriminant, take};
use std::sync::Arc;

/// Travel within an interval below which it is not halved any more, mm.
const RESOLUTION_MM: f64 = 1e-4;
/// Halvings of a step, however far it goes; fewer where places have no numbers between them.
const LOWEST: i32 = -40;
/// Most unresolved intervals of one step; at more, the rest of the step is unresolved.
const MOST_OPEN: u32 = 8;
/// Most intervals of a pair; at more, the rest of the path is unresolved.
const MOST_INTERVALS: usize = 400_000;

/// Most pairs of hulls between which planes are sought for a pair of parts; at more, the rest of the path is unresolved.
const MOST_TRIED_IN_ALL: u64 = 400_000;
/// Most unresolved intervals of a pair; at more, the rest of the path is unresolved.
const MOST_OPEN_IN_ALL: u32 = 200;
/// Most fronts of a pair with too many planes; at more, the rest of the step, and of the path, is unresolved.
const MOST_GIVEN_UP: [u32; 2] = [4, 40];

/// What is known of an interval of the path. Entries of a pair follow one another without a gap.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// Places on the path.
    pub from: f64,
    pub to: f64,
    pub finding: Finding,
}

#[derive(Clone, Debug)]
pub(super) enum Finding {
    /// Parted by planes, which intervals may share. `bound_mm` is how far the two parts' displacements from the middle differ at most.
    Free { bound_mm: f64, front: Arc<[Token]> },
    /// In contact for the first time at `place` at the latest, at most `way_mm` of travel behind `from`. What is behind that on the step is not looked at.
    Hit { place: f64, way_mm: f64, faces: [u32; 2] },
    /// Neither is proved. Holds the distance of the nearest triangles that were met, at the last interval tried, mm; `None` where nothing bounds the axes there.
    Open { apart_mm: Option<f64> },
    /// One of the two is not in the spindle.
    Away,
    /// The cutter feeds into the workpiece, or stands there: contact is what the program is for.
    Meant,
}

/// On which steps a pair may not meet.
pub(super) struct Asked {
    /// The tools that the parts belong to.
    pub tools: [Option<u32>; 2],
    /// A cutter and the workpiece: contact is meant while it feeds.
    pub is_cutting: bool,
}

/// A pair and what its search keeps in mind.
pub(super) struct Search<'a> {
    pub track: &'a Track<'a>,
    pub motion: PairMotion<'a>,
    pub link_from_part: [&'a Isometry; 2],
    pub trees: [&'a Tree; 2],
    /// What is asked for contact at the middle of an interval before planes are sought.
    pub models: [Option<&'a dyn Model>; 2],
    pub solids: [&'a Solid; 2],
    pub asked: Asked,
    pub entries: Vec<Entry>,
    front: Arc<[Token]>,
    hint: Vector,
    /// Two triangles that no plane was found for.
    failed: Option<[u32; 2]>,
    apart_mm: Option<f64>,
    open_on_step: u32,
    open_in_all: u32,
    /// Fronts that had too many planes, on the step and on the whole path.
    given_up: [u32; 2],
    tried: u64,
}

impl<'a> Search<'a> {
    pub fn new(
        track: &'a Track<'a>,
        motion: PairMotion<'a>,
        link_from_part: [&'a Isometry; 2],
        trees: [&'a Tree; 2],
        models: [Option<&'a dyn Model>; 2],
        solids: [&'a Solid; 2],
        asked: Asked,
    ) -> Self {
        Self {
            track,
            motion,
            link_from_part,
            trees,
            models,
            solids,
            asked,
            entries: Vec::new(),
            front: Arc::default(),
            hint: Vector::x(),
            failed: None,
            apart_mm: None,
            open_on_step: 0,
            open_in_all: 0,
            given_up: [0; 2],
            tried: 0,
        }
    }

    /// Goes along the path from its start to its end.
    pub fn run(&mut self) {
        let count = self.track.steps.len();
        let top = count.next_power_of_two().ilog2() as i32;
        let (mut at, mut level) = (0.0_f64, top);
        while (at as usize) < count {
            let step = at as usize;
            if at.fract() == 0.0 {
                (self.open_on_step, self.given_up[0]) = (0, 0);
                if let Some(finding) = self.left_out(step) {
                    let is_other =
                        |&next: &usize| self.left_out(next).as_ref().map(discriminant) != Some(discriminant(&finding));
                    let end = (step..count).find(is_other).unwrap_or(count);
                    self.push(at, end as f64, finding);
                    at = end as f64;
                    continue;
                }
            }
            let is_enough = self.open_in_all >= MOST_OPEN_IN_ALL || self.given_up[1] >= MOST_GIVEN_UP[1];
            let is_enough = is_enough || self.tried >= MOST_TRIED_IN_ALL;
            if is_enough || self.entries.len() > MOST_INTERVALS {
                // An interval that begins within a step ends with it.
                let gone = (step..count).find(|&step| self.left_out(step).is_some()).unwrap_or(count);
                let gone = if at.fract() == 0.0 { gone } else { step + 1 };
                self.push(at, gone as f64, Finding::Open { apart_mm: self.apart_mm });
                at = gone as f64;
                continue;
            }
            level = (level + 1).min(top);
            while (at * 2f64.powi(-level)).fract() != 0.0 {
                level -= 1;
            }
            at = self.advance(at, &mut level);
        }
        self.open_what_is_inside();
        self.begin_hits();
    }

    /// Why nothing is to be proved on a step.
    fn left_out(&self, index: usize) -> Option<Finding> {
        let step = &self.track.steps[index];
        if self.asked.tools.iter().any(|own| own.is_some_and(|own| own != step.tool)) {
            return Some(Finding::Away);
        }
        (self.asked.is_cutting && step.cuts).then_some(Finding::Meant)
    }

    /// Decides on an interval that begins at `at` and has at most 2^level steps; returns its end.
    fn advance(&mut self, at: f64, level: &mut i32) -> f64 {
        let count = self.track.steps.len() as f64;
        loop {
            let to = at + 2f64.powi(*level);
            let is_asked = || (at as usize..to as usize).all(|step| self.left_out(step).is_none());
            if *level > 0 && (to > count || !is_asked()) {
                *level -= 1;
                continue;
            }
            let mut bound_mm = f64::INFINITY;
            let region = self.track.region(at, to);
            self.apart_mm = region.as_ref().map(|_| self.apart_mm.unwrap_or(0.0));
            if let Some(region) = region {
                let sweep = self.motion.sweep(&region, self.track.control, self.link_from_part);
                bound_mm = sweep.bound_mm();
                let tried = Cell::new(0);
                let parting = Parting { a: self.trees[0], b: self.trees[1], sweep: &sweep, tried: &tried };
                let parted = self.part(&parting);
                self.tried += tried.get();
                if parted {
                    let (bound_mm, front) = (printed(bound_mm), Arc::clone(&self.front));
                    self.push(at, to, Finding::Free { bound_mm, front });
                    return to;
                }
            }
            let is_short = *level <= 0 && bound_mm < RESOLUTION_MM;
            let middle = at + 2f64.powi(*level - 1);
            let is_lowest = *level <= LOWEST || middle <= at || middle >= to;
            if is_lowest || is_short || *level <= 0 && self.given_up[0] >= MOST_GIVEN_UP[0] {
                return self.give_up(at, to);
            }
            *level -= 1;
        }
    }

    /// Whether planes part the pair over a region: those that did before, or new ones.
    fn part(&mut self, parting: &Parting<'_>) -> bool {
        if parting.holds(&self.front) {
            return true;
        }
        if let Some(failed) = self.failed
            && !parting.parts_triangles(failed)
        {
            self.apart_mm = Some(parting.apart_mm(failed));
            return false;
        }
        if self.touches_at(&parting.sweep.a_from_b) {
            self.apart_mm = Some(0.0);
            return false;
        }
        let front = parting.front(&mut self.hint);
        match &front {
            Ok(planes) => self.front = planes.as_slice().into(),
            Err(Some(failed)) => {
                (self.failed, self.apart_mm) = (Some(*failed), Some(parting.apart_mm(*failed)));
            }
            Err(None) => self.given_up = self.given_up.map(|count| count + 1),
        }
        front.is_ok()
    }

    /// Whether the variant that is asked finds contact at a pose; without one, no.
    fn touches_at(&self, a_from_b: &Isometry) -> bool {
        let [Some(a), Some(b)] = self.models else { return false };
        let mut verdicts = Vec::with_capacity(1);
        a.first(b, &[*a_from_b], &mut verdicts);
        verdicts == [true]
    }

    /// Looks for contact in an interval that is too short to be halved, and leaves it unresolved where it finds none; returns the place at which to go on.
    fn give_up(&mut self, at: f64, to: f64) -> f64 {
        let step = at.floor();
        let places = match self.track.steps[step as usize].course {
            // Whoever touches the whole workpiece need not touch what is left of it.
            _ if self.asked.is_cutting => Vec::new(),
            Course::Point => vec![step + 1.0],
            _ => vec![at, f64::midpoint(at, to), to],
        };
        let pierced = places.into_iter().find_map(|place| Some((place, self.piercing_at(step, place)?)));
        if let Some((place, faces)) = pierced {
            // `begin_hits` sets the way, once every unresolved interval of the step is known.
            self.push(at, step + 1.0, Finding::Hit { place, way_mm: f64::INFINITY, faces });
            return step + 1.0;
        }
        self.open_on_step += 1;
        self.open_in_all += u32::from(!self.asked.is_cutting);
        let is_enough = self.asked.is_cutting || self.open_on_step >= MOST_OPEN || self.given_up[0] >= MOST_GIVEN_UP[0];
        let end = if is_enough { step + 1.0 } else { to };
        if let Some(Entry { from, to, finding: Finding::Open { apart_mm } }) = self.entries.last_mut()
            && *from >= step
            && *to == at
        {
            (*to, *apart_mm) = (end, apart_mm.zip(self.apart_mm).map(|(before, apart)| apart.min(before)));
        } else {
            self.push(at, end, Finding::Open { apart_mm: self.apart_mm });
        }
        end
    }

    fn bound_mm(&self, region: &Region) -> f64 {
        self.motion.sweep(region, self.track.control, self.link_from_part).bound_mm()
    }

    /// Proof of contact at a place of a step.
    fn piercing_at(&self, step: f64, place: f64) -> Option<[u32; 2]> {
        let region = self.track.within(step as usize, place - step, place - step)?;
        let sweep = self.motion.sweep(&region, self.track.control, self.link_from_part);
        piercing(self.trees[0], self.trees[1], &sweep.a_from_b)
    }

    fn push(&mut self, from: f64, to: f64, finding: Finding) {
        assert!(to > from, "an interval of no length at {from}");
        self.entries.push(Entry { from, to, finding });
    }

    /// Surfaces that do not touch may be of solids of which one is inside the other. Where the hulls of both are parted at some time, neither is as long as the surfaces
    /// do not meet; elsewhere it is looked at once for each stretch. What is within the bounds of a mesh that is not watertight may be inside it.
    fn open_what_is_inside(&mut self) {
        let mut first = 0;
        while first < self.entries.len() {
            let is_free = |entry: &Entry| matches!(entry.finding, Finding::Free { .. });
            let end = first + self.entries[first..].iter().take_while(|entry| is_free(entry)).count();
            if end == first {
                first += 1;
                continue;
            }
            let is_rooted = |entry: &Entry| match &entry.finding {
                Finding::Free { front, .. } => matches!(front[..], [Token::Plane { .. }]),
                _ => false,
            };
            let is_outside = self.entries[first..end].iter().any(is_rooted);
            if !is_outside && self.is_inside_at(&self.entries[first]) {
                for entry in &mut self.entries[first..end] {
                    entry.finding = Finding::Open { apart_mm: Some(0.0) };
                }
            }
            first = end;
        }
    }

    /// Moves the beginning of each hit to the first unresolved interval of its step, as the first contact may be there; the hit replaces all intervals from there on.
    /// Where nothing bounds the way from there to the contact, the hit becomes unresolved.
    fn begin_hits(&mut self) {
        let mut entries: Vec<Entry> = Vec::with_capacity(self.entries.len());
        for mut entry in take(&mut self.entries) {
            if let Finding::Hit { place, way_mm, .. } = &mut entry.finding {
                let on_step = entries.partition_point(|before| before.from < entry.from.floor());
                let is_open = |before: &Entry| matches!(before.finding, Finding::Open { .. });
                if let Some(first) = entries[on_step..].iter().position(is_open) {
                    entry.from = entries[on_step + first].from;
                    entries.truncate(on_step + first);
                }
                match self.track.region(entry.from, *place) {
                    Some(region) => *way_mm = printed(2.0 * self.bound_mm(&region)),
                    None => entry.finding = Finding::Open { apart_mm: None },
                }
            }
            entries.push(entry);
        }
        self.entries = entries;
    }

    fn is_inside_at(&self, entry: &Entry) -> bool {
        let Some(region) = self.track.region(entry.from, entry.to) else { return true };
        let sweep = self.motion.sweep(&region, self.track.control, self.link_from_part);
        Solid::one_in_the_other(self.solids[0], self.solids[1], &sweep.a_from_b, true)
    }
}

/// A bound as it is printed: shortly, and never less.
fn printed(mm: f64) -> f64 {
    (mm * 1e6 + 1.0).ceil() / 1e6
}

//! One pair along a part of the path.

use super::Bodies;
use super::motion::Path;
use crate::machine::Poses;
use crate::machine::travel::Ball;
use crate::scene::{Pair, Scene};
use crate::tree::distance::Proximity;
use rs274::Position;

/// How much farther than the widest zone a distance is looked for, mm: what a longer distance is worth in skipped samples.
const OUTLOOK_MM: f64 = 60.0;
/// Most halvings of the way between two samples.
const HALVINGS: u32 = 40;
/// How far a pair may come into a narrower zone and leave it again between two samples without being told, mm. Contact is looked
/// for to the tolerance; nearness is a warning, and a pair that slides along just outside a zone would else be asked about at
/// every hundredth of a millimetre. A gouge that is not this much deeper than allowed may be missed there, too.
pub(super) const DIP_MM: f64 = 0.05;

/// How near a pair is: 0 in contact or one inside the other, then the borders from the narrowest, then free.
pub(super) type Nearness = usize;

/// A part of the path over which a pair is equally near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub nearness: Nearness,
    /// Places on the path.
    pub from: f64,
    pub to: f64,
    /// The least distance found, mm, and where.
    pub least_mm: f64,
    pub least_at: f64,
    /// Whether somewhere on it one part was wholly inside the other.
    pub inside: bool,
    /// Whether it goes on from the stretch before it, nothing free having been found between.
    pub goes_on: bool,
}

impl Stretch {
    /// Whether it lies within another.
    pub fn is_in(&self, whole: &Self) -> bool {
        whole.from <= self.from && self.to <= whole.to
    }
}

/// A distance found at a place.
#[derive(Clone, Copy)]
pub(super) struct Measured {
    place: f64,
    /// Of the surfaces, mm; of a cutter that is not inside a finished workpiece how much farther it may go, negative where it gouges.
    distance: f64,
    /// Whether one part is wholly inside the other.
    inside: bool,
    pub(super) nearness: Nearness,
}

pub(super) struct Scan<'a> {
    scene: &'a Scene,
    path: &'a Path<'a>,
    bodies: &'a Bodies,
    pair: Pair,
    balls: [Ball; 2],
    /// Clearances at which nearness changes, narrowest first, mm.
    borders: &'a [f64],
    tolerance_mm: f64,
    proximity: Proximity,
    stretches: Vec<Stretch>,
    /// Whether the last place noted was not free.
    is_near: bool,
    pub queries: u64,
}

impl<'a> Scan<'a> {
    pub fn new(
        scene: &'a Scene,
        path: &'a Path<'a>,
        bodies: &'a Bodies,
        pair: Pair,
        borders: &'a [f64],
        tolerance_mm: f64,
    ) -> Self {
        Self {
            scene,
            path,
            bodies,
            pair,
            balls: bodies.balls(pair),
            borders,
            tolerance_mm,
            proximity: Proximity::default(),
            stretches: Vec::new(),
            is_near: false,
            queries: 0,
        }
    }

    /// The stretches from place `first` to place `last` where the pair is not free, in order. `poses` are those of the
    /// whole places.
    pub fn run(&mut self, first: usize, last: usize, poses: &[Poses]) -> Vec<Stretch> {
        let mut at = first;
        while at <= last {
            let is_mounted = |at: &usize| self.scene.is_mounted(self.pair, self.path.tool(*at));
            if let Some(from) = (at..=last).find(is_mounted) {
                let to = (from..=last).take_while(is_mounted).last().unwrap_or(from);
                self.run_mounted(from, to, &poses[from - first..]);
                at = to;
            } else {
                at = last;
            }
            at += 1;
        }
        std::mem::take(&mut self.stretches)
    }

    /// As [`Scan::run`], between places from the first to the last of which both parts are there.
    fn run_mounted(&mut self, first: usize, last: usize, poses: &[Poses]) {
        self.is_near = false;
        let mut here = self.measure(first as f64, &poses[0]);
        self.note(&here);
        let mut at = first;
        while at < last {
            let (next, travel) = self.farthest(at, last, &here, &poses[at - first..]);
            let there = self.measure(next as f64, &poses[next - first]);
            if next == at + 1 {
                self.between(&here, &there, travel, HALVINGS);
            }
            self.note(&there);
            (at, here) = (next, there);
        }
    }

    /// The last place before which the pair stays free for sure, but at least the next one; and the bound on the travel to it.
    pub(super) fn farthest(&self, at: usize, last: usize, here: &Measured, poses: &[Poses]) -> (usize, f64) {
        let spare = match here.inside {
            // How deep a cutter is in a finished workpiece is asked at every sample.
            true if self.bodies.gouges.contains_key(&self.pair) => 0.0,
            // Inside the other part nothing changes before the surfaces meet.
            true => here.distance,
            false => here.distance - self.widest(),
        };
        let mut travel = 0.0;
        for (next, from) in (at + 1..=last).zip(poses) {
            let step = self.step_travel(next - 1, from);
            if next > at + 1 && travel + step > spare {
                return (next - 1, travel);
            }
            travel += step;
        }
        (last, travel)
    }

    /// Bound on the travel from a whole place to the next.
    fn step_travel(&self, at: usize, poses: &Poses) -> f64 {
        let (from, to) = (self.path.position(at), self.path.position(at + 1));
        self.travel(&from, &to, poses)
    }

    fn travel(&self, from: &Position, to: &Position, poses: &Poses) -> f64 {
        let change = Position(std::array::from_fn(|i| to.0[i] - from.0[i]));
        self.scene.machine.travel_bound_mm(&self.balls[0], &self.balls[1], poses, &change)
    }

    pub(super) fn measure(&mut self, place: f64, poses: &Poses) -> Measured {
        self.queries += 1;
        let beyond = self.widest() + OUTLOOK_MM;
        let a_from_b = self.scene.a_from_b(self.pair, poses);
        if let Some(gouge) = self.bodies.gouges.get(&self.pair) {
            let distance = gouge.spare_mm(&a_from_b, beyond);
            if distance > 0.0 && gouge.is_inside(&a_from_b) {
                return Measured { place, distance: distance - gouge.allowed_mm, inside: true, nearness: 0 };
            }
            return Measured { place, distance, inside: false, nearness: self.nearness(distance) };
        }
        let (a, b) = self.bodies.of(self.pair);
        // Beyond the outlook the distance is the outlook at least.
        let distance = a.distance_mm(b, &a_from_b, beyond, &mut self.proximity).min(beyond);
        let inside = distance > 0.0 && self.bodies.one_in_the_other(self.pair, &a_from_b);
        let nearness = if inside { 0 } else { self.nearness(distance) };
        Measured { place, distance, inside, nearness }
    }

    fn nearness(&self, distance: f64) -> Nearness {
        if distance <= 0.0 { 0 } else { 1 + self.borders.iter().take_while(|&&border| border <= distance).count() }
    }

    fn widest(&self) -> f64 {
        self.borders.last().copied().unwrap_or(0.0)
    }

    fn measure_between(&mut self, place: f64) -> (Measured, Poses) {
        let poses = self.scene.machine.forward(&self.path.position_at(place));
        (self.measure(place, &poses), poses)
    }

    /// Looks between two places that `travel` may lie between: for the border when they differ, and for contact or a narrower zone
    /// when their distances do not exclude it.
    fn between(&mut self, here: &Measured, there: &Measured, travel: f64, halvings: u32) {
        if halvings == 0 || travel <= self.tolerance_mm {
            return;
        }
        let middle = if here.nearness != there.nearness || self.may_come_nearer(here, there, travel) {
            f64::midpoint(here.place, there.place)
        } else if let Some(place) = self.gouge_between(here, there.place) {
            place
        } else {
            return;
        };
        let (found, poses) = self.measure_between(middle);
        let half =
            |from: f64, to: f64, at: &Poses| self.travel(&self.path.position_at(from), &self.path.position_at(to), at);
        let before = self.scene.machine.forward(&self.path.position_at(here.place));
        let (first, second) = (half(here.place, middle, &before), half(middle, there.place, &poses));
        self.between(here, &found, first, halvings - 1);
        self.note(&found);
        self.between(&found, there, second, halvings - 1);
    }

    /// Whether the pair may be nearer between two places of one nearness than at them. Along the way from one to the other the
    /// distance is at least (d₁ + d₂ - travel) / 2.
    pub(super) fn may_come_nearer(&self, here: &Measured, there: &Measured, travel: f64) -> bool {
        let least = 0.5 * (here.distance + there.distance - travel);
        if let Some(gouge) = self.bodies.gouges.get(&self.pair) {
            // A rapid may not even touch, and where it begins in what it touches, it may not go deeper than that. For a feed move there is
            // `gouge_between`.
            let touches = gouge.allowed_mm - DIP_MM;
            let limit = if here.distance > touches { touches } else { 0.0 };
            return here.nearness > 0 && self.path.sample_at(there.place).rapid && least <= limit;
        }
        match here.nearness {
            // In contact, or inside, at both ends: it can only come apart, and what parts by less than the samples show is
            // one contact.
            0 => false,
            1 => least <= 0.0,
            nearness => least <= (self.borders[nearness - 2] - DIP_MM).max(0.0),
        }
    }

    /// A place of a feed move, between two samples at which the cutter does not gouge the finished workpiece, at which it does. One at which it goes less than
    /// [`DIP_MM`] deeper than allowed may be missed. A feed move slides along the surface all the way: the question is whether anything is that deep, not how near it is.
    fn gouge_between(&mut self, here: &Measured, to: f64) -> Option<f64> {
        let gouge = self.bodies.gouges.get(&self.pair)?;
        if here.nearness == 0 || self.path.sample_at(to).rapid {
            return None;
        }
        let mut open = vec![[here.place, to]];
        while let Some([from, to]) = open.pop() {
            let [first, last] = [from, to].map(|place| self.path.position_at(place));
            self.queries += 1;
            if !gouge.may_gouge(self.scene, &first, &last, DIP_MM) {
                continue;
            }
            let middle = f64::midpoint(from, to);
            let poses = self.scene.machine.forward(&self.path.position_at(middle));
            if gouge.spare_mm(&self.scene.a_from_b(self.pair, &poses), 0.0) < 0.0 {
                return Some(middle);
            }
            if self.travel(&first, &last, &self.scene.machine.forward(&first)) > self.tolerance_mm {
                open.extend([[middle, to], [from, middle]]);
            }
        }
        None
    }

    /// Takes a place into the stretches; places come in order.
    fn note(&mut self, found: &Measured) {
        let &Measured { place, inside, nearness, distance } = found;
        // Solids that share a point are 0 apart; a cutter inside a finished workpiece is as deep as their surfaces are apart, or as the surface lies inside a thin one.
        let distance = match self.bodies.gouges.get(&self.pair) {
            _ if !inside => distance,
            Some(gouge) => gouge.allowed_mm - distance.abs(),
            None => 0.0,
        };
        let was_near = std::mem::replace(&mut self.is_near, nearness <= self.borders.len());
        if !self.is_near {
            return;
        }
        match self.stretches.last_mut() {
            Some(last) if was_near && last.nearness == nearness => {
                last.to = place;
                last.inside |= inside;
                if distance < last.least_mm {
                    (last.least_mm, last.least_at) = (distance, place);
                }
            }
            _ => self.stretches.push(Stretch {
                nearness,
                from: place,
                to: place,
                least_mm: distance,
                least_at: place,
                inside,
                goes_on: was_near,
            }),
        }
    }
}

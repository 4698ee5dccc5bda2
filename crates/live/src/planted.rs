//! Programs that collide, and the exact oracle that says when.

use crate::judge::is_driven;
use crate::play::{Place, Plan};
use bvbench::machine::travel::Ball;
use bvbench::scene::{Pair, Scene, pairs};
use bvbench::truth::PairOracle;
use rand::RngExt as _;
use rand_pcg::Pcg64Mcg;
use rs274::{Axis, Position};
use std::fmt::Write as _;
use std::sync::Arc;

/// Distance below which parts are said to touch, mm.
const TOUCH_MM: f64 = 1e-3;
/// Farthest clearance that is looked for along a path, mm.
const BEYOND_MM: f64 = 60.0;
/// Longest piece of a path that is skipped at once, s.
const LONGEST_S: f64 = 0.5;
/// How much a pose of the program is lowered at a time until it collides, and how often, mm.
const STEP_MM: f64 = 4.0;
const STEPS: u32 = 20;
/// Feeds of the collisions, mm/min.
const FEEDS: std::ops::Range<f64> = 2000.0..12_000.0;
/// Poses of the program that are tried.
const TRIES: u32 = 200;

/// The exact distances of the pairs that a watch judges.
pub struct Exact<'a> {
    scene: &'a Scene,
    pairs: Vec<(Pair, [Ball; 2], PairOracle)>,
}

impl<'a> Exact<'a> {
    /// Prepares the oracle of each pair.
    pub fn new(scene: &'a Scene, pairs: impl Iterator<Item = Pair>) -> Self {
        let prepare = |pair: Pair| {
            let parts = [pair.a, pair.b].map(|part| &scene.parts[part]);
            let [a, b] = parts.map(|part| Arc::clone(&part.mesh));
            (pair, parts.map(pairs::ball), PairOracle::new(a, b))
        };
        Self { scene, pairs: pairs.map(prepare).collect() }
    }

    /// The least clearance, mm; infinite beyond `beyond_mm`.
    pub fn clearance_mm(&self, at: &Position, tool: u32, beyond_mm: f64) -> f64 {
        let poses = self.scene.machine.forward(at);
        let mounted = self.pairs.iter().filter(|(pair, ..)| self.scene.is_mounted(*pair, tool));
        let clearance = |(pair, _, oracle): &(Pair, _, PairOracle)| {
            oracle.clearance_mm(&self.scene.a_from_b(*pair, &poses), beyond_mm)
        };
        mounted.map(clearance).fold(f64::INFINITY, f64::min)
    }

    /// When a program first touches, s of its own clock. The clearance of each pair is compared with the way that it can go meanwhile, so that
    /// no contact is skipped.
    pub fn first_contact_s(&self, plan: &Plan) -> Option<f64> {
        let first = self.pairs.iter().filter_map(|pair| self.first_contact_of(pair, plan));
        first.min_by(f64::total_cmp)
    }

    fn first_contact_of(&self, (pair, [a, b], oracle): &(Pair, [Ball; 2], PairOracle), plan: &Plan) -> Option<f64> {
        let (end_s, mut time_s) = (plan.duration_s(), 0.0);
        while time_s < end_s {
            let place = plan.at(time_s);
            let poses = self.scene.machine.forward(&place.position);
            let is_mounted = self.scene.is_mounted(*pair, place.tool);
            let clearance = oracle.clearance_mm(&self.scene.a_from_b(*pair, &poses), BEYOND_MM).min(BEYOND_MM);
            if is_mounted && clearance < TOUCH_MM {
                return Some(time_s);
            }
            let mut step_s = LONGEST_S;
            let way = |step_s: f64| {
                let fastest = plan.fastest(time_s, time_s + step_s);
                let change = Position(fastest.map(|speed| speed * step_s));
                self.scene.machine.travel_bound_mm(a, b, &poses, &change)
            };
            while way(step_s) >= clearance.max(TOUCH_MM) && step_s > f64::MIN_POSITIVE {
                step_s *= 0.7;
            }
            time_s += step_s;
        }
        None
    }

    /// A program that goes straight from the start of another one to where parts touch, at a random place and feed. `None` when no place is found.
    pub fn collision(&self, plan: &Plan, random: &mut Pcg64Mcg) -> Option<String> {
        (0..TRIES).find_map(|_| {
            let place = plan.at(random.random::<f64>() * plan.duration_s());
            let feed = random.random_range(FEEDS);
            let touching = (1..STEPS).find_map(|step| {
                let mut at = place.position;
                at[Axis::Z] -= STEP_MM * f64::from(step);
                let is_within = self.scene.machine.check_limits(&at).is_ok();
                (is_within && self.clearance_mm(&at, place.tool, 1.0) == 0.0).then_some(at)
            })?;
            Some(self.straight(&Place { position: touching, ..place }, feed))
        })
    }

    fn straight(&self, Place { position: to, tool, .. }: &Place, feed: f64) -> String {
        let change = if *tool > 0 { format!("T{tool} M6\n") } else { String::new() };
        let mut text = format!("G21 G90 G94\n{change}G1 G53");
        for axis in Axis::ALL.into_iter().filter(|&axis| is_driven(&self.scene.machine, axis)) {
            let value = if axis.is_rotary() { to[axis].to_degrees() } else { to[axis] };
            write!(text, " {}{value:.4}", axis.letter()).ok();
        }
        writeln!(text, " F{feed:.0}\nM2").ok();
        text
    }
}

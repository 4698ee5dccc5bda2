//! How far apart are two meshes? Branch and bound as in [`Proximity`], over pairs of slots, eight or sixteen children at a time.
//!
//! Bounds come from the lanes of [`super::visit`] and are lower bounds in spite of all rounding; triangles are measured in `f64`. A first
//! dive to a pair of triangles brings a distance that keeps most pairs from ever waiting. Where many pairs are as near as the nearest, a slab leaves
//! out those around it (`slab`).

use super::buckets::Waiting;
use super::lanes::{DOUBLES, Machine, Simd, Work};
use super::measure::Measured;
use super::node::{WIDTH, WideTree};
use super::posed::{Opened, Posed};
use super::proximity::Proximity;
use super::slab::Slab;
use super::triangles::Batch;
use super::visit::{self, Distances};
use super::volume::WideVolume;
use crate::engine::geometry::{Isometry, certified, triangle_distance};
use std::ops::ControlFlow;

/// The distance of the meshes, mm, where it is below `below_mm`; infinity where it is not. 0 where triangles touch, and only there. With [`Proximity::keeping`], a
/// lower bound of it. Where more pairs than `Search::ties` are as near as
/// the nearest, another of them may be nearer by 10⁻¹² of the distance.
pub fn distance_mm<V: WideVolume>(
    a: &WideTree<V>,
    b: &WideTree<V>,
    a_from_b: &Isometry,
    simd: Simd,
    below_mm: f64,
    proximity: &mut Proximity,
) -> f64 {
    if below_mm <= 0.0 {
        return f64::INFINITY;
    }
    let posed = Posed::new(a, b, a_from_b);
    let mut search =
        Search { posed, proximity, least: below_mm, batch: Batch::default(), may_touch: 0, measured: 0, slab: None };
    match search.known_and_others(simd) {
        ControlFlow::Break(Touching) => 0.0,
        ControlFlow::Continue(()) if search.least < below_mm => search.least,
        ControlFlow::Continue(()) => f64::INFINITY,
    }
}

/// One search.
struct Search<'a, V: WideVolume> {
    posed: Posed<'a, V>,
    proximity: &'a mut Proximity,
    /// The least distance so far, times the share that is told, mm.
    least: f64,
    /// Pairs of triangles that wait to be measured.
    batch: Batch,
    /// A bit for each of them whose volumes may touch.
    may_touch: u8,
    /// How many pairs were measured that are as near as what is known, or nearer.
    measured: u32,
    /// Leaves out pairs that are not nearer, once many were measured.
    slab: Option<Slab>,
}

/// Two triangles touch: nothing is nearer.
struct Touching;

impl<V: WideVolume> Work for &mut Search<'_, V> {
    type Output = ControlFlow<Touching>;

    #[inline(always)]
    fn run<M: Machine>(self) -> ControlFlow<Touching> {
        self.proximity.buckets.clear(self.least);
        self.dive::<M>()?;
        self.proximity.buckets.spread(self.least);
        while let Some(one) = self.next::<M>()? {
            match self.next::<M>()? {
                Some(other) => self.visit::<M>(&[one, other]),
                None => self.visit::<M>(&[one]),
            }
        }
        ControlFlow::Continue(())
    }
}

impl<V: WideVolume> Search<'_, V> {
    /// Measures the pair that was nearest at another pose, if one is known, and then looks for nearer ones.
    fn known_and_others(&mut self, simd: Simd) -> ControlFlow<Touching> {
        if let Some(pair) = self.proximity.nearest {
            self.measure(pair, true)?;
        }
        simd.run(self)
    }

    /// What to open next: of the nearest pairs that may still be nearer than what is known. Pairs of triangles that come before it gather, and are
    /// measured when they fill the lanes, or nothing is left to open.
    #[inline(always)]
    fn next<M: Machine>(&mut self) -> ControlFlow<Touching, Option<Opened>> {
        while let Some((waiting, is_apart)) = self.proximity.buckets.pop_below(self.least) {
            if self.slab.as_ref().is_some_and(|slab| slab.is_between(&self.posed, waiting)) {
                continue;
            }
            match waiting {
                Waiting::Node(opened) => return ControlFlow::Continue(Some(opened)),
                Waiting::Leaves(slots) => {
                    for pair in self.posed.pairs(slots) {
                        self.may_touch |= u8::from(!is_apart) << self.batch.len();
                        if self.batch.push(pair) {
                            self.measure_all::<M>()?;
                        }
                    }
                }
            }
        }
        self.measure_all::<M>()?;
        ControlFlow::Continue(None)
    }

    /// Measures the pairs of triangles that have gathered, with care those that may be nearer than what is known, or touch.
    #[inline(always)]
    fn measure_all<M: Machine>(&mut self) -> ControlFlow<Touching> {
        if self.batch.len() == 0 {
            return ControlFlow::Continue(());
        }
        let Posed { a, b, placement, .. } = &self.posed;
        let pairs = self.batch;
        let (waiting, measured) = self.batch.measured::<M::Double, V>(a, b, placement);
        let may_touch = std::mem::take(&mut self.may_touch);
        let left = waiting & measured.nearer(self.least) | may_touch;
        if left == 0 {
            return ControlFlow::Continue(());
        }
        self.measure_some(&pairs, left, may_touch, &measured.stored())
    }

    /// Measures the pairs that have a bit in `left` with care, the nearest first: after it others may not be nearer.
    #[inline(never)]
    fn measure_some(
        &mut self,
        pairs: &Batch,
        mut left: u8,
        may_touch: u8,
        measured: &Measured<[f64; DOUBLES]>,
    ) -> ControlFlow<Touching> {
        while left != 0 {
            let lane = measured.nearest_of(left);
            left &= !(1 << lane);
            let may_touch = may_touch >> lane & 1 != 0;
            if may_touch || measured.may_be_nearer(lane, self.least) {
                self.measure(pairs.pair(lane), may_touch)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Opens the nearest child again and again, as far as a pair of triangles.
    #[inline(always)]
    fn dive<M: Machine>(&mut self) -> ControlFlow<Touching> {
        let mut opened = self.posed.first();
        loop {
            let [mut found, _] = self.distances::<M>(&[opened]);
            let nearest = (0..WIDTH as u32)
                .filter(|place| found.nearer >> place & 1 != 0)
                .min_by(|&i, &j| found.least_mm[i as usize].total_cmp(&found.least_mm[j as usize]));
            let Some(nearest) = nearest else { return ControlFlow::Continue(()) };
            // The nearest does not wait.
            found.nearer &= !(1 << nearest);
            self.wait(opened, &found);
            match self.posed.below(opened, found.larger).at(nearest) {
                Waiting::Leaves(slots) => {
                    let is_apart = found.least_mm[nearest as usize] > 0.0;
                    return self.posed.pairs(slots).try_for_each(|pair| self.measure(pair, !is_apart));
                }
                Waiting::Node(below) => opened = below,
            }
        }
    }

    /// Opens one or two nodes and has the children wait.
    #[inline(always)]
    fn visit<M: Machine>(&mut self, opened: &[Opened]) {
        let found = self.distances::<M>(opened);
        for (&opened, found) in opened.iter().zip(&found) {
            self.wait(opened, found);
        }
    }

    /// How far the children of one or two nodes are at least.
    #[inline(always)]
    fn distances<M: Machine>(&mut self, opened: &[Opened]) -> [Distances; 2] {
        let mut found = [Distances::default(); 2];
        let see = |opened: Opened| self.posed.see(opened);
        // Not less than what is known.
        let below_mm = (self.least as f32).next_up();
        match *opened {
            [one] => visit::distances::<V, M::Single>(&[see(one)], below_mm, &mut found),
            [one, other] => visit::distances::<V, M::Single>(&[see(one), see(other)], below_mm, &mut found),
            _ => {}
        }
        found
    }

    /// Children that may be nearer than what is known wait.
    #[inline(never)]
    fn wait(&mut self, opened: Opened, found: &Distances) {
        let below = self.posed.below(opened, found.larger);
        let mut nearer = found.nearer;
        while nearer != 0 {
            let place = nearer.trailing_zeros();
            nearer &= nearer - 1;
            self.proximity.buckets.push(found.least_mm[place as usize], below.at(place));
        }
    }

    /// Measures two triangles, by their places. They are asked whether they touch only where their volumes may.
    #[inline(never)]
    fn measure(&mut self, (i, j): (u32, u32), may_touch: bool) -> ControlFlow<Touching> {
        let Posed { a, b, placement, .. } = &self.posed;
        let (still, moved) = (a.triangle(i), placement.triangle(&b.triangle(j)));
        if may_touch {
            if triangle_distance::exceeds(&still, &moved, self.least * self.least) {
                return ControlFlow::Continue(());
            }
            if certified::touch(&still, &moved) {
                (self.least, self.proximity.nearest) = (0.0, Some((i, j)));
                return ControlFlow::Break(Touching);
            }
        }
        // Apart, though rounding may have left nothing of the distance: 0 is said of contact alone.
        let measured = triangle_distance::squared(&still, &moved).sqrt();
        let distance = (self.proximity.kept() * measured).max(f64::MIN_POSITIVE);
        if distance < self.least {
            (self.least, self.proximity.nearest) = (distance, Some((i, j)));
        }
        self.measured += 1;
        if self.measured.is_multiple_of(self.ties()) {
            self.slab = Slab::between(&self.posed, (&still, &moved), self.least);
        }
        ControlFlow::Continue(())
    }

    /// After how many measured pairs a slab is laid: its pass over both meshes then takes a small part of the time.
    fn ties(&self) -> u32 {
        64 + ((self.posed.a.len() + self.posed.b.len()) / 16) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::super::aligned::Aligned;
    use super::super::ball::Ball;
    use super::super::oriented::Oriented;
    use super::super::pose::Pose;
    use super::super::traverse::{Scratch, first, search_on};
    use super::*;
    use crate::cases::{Cases, Draw};
    use crate::engine::geometry::{GridMesh, Point, Triangle, Vector};
    use std::f64::consts::TAU;

    /// The least over all pairs of triangles, by the same measure.
    fn of_all_pairs<V: WideVolume>(a: &WideTree<V>, b: &WideTree<V>, a_from_b: &Isometry) -> f64 {
        let posed = Posed::new(a, b, a_from_b);
        let moved: Vec<_> = (0..b.len() as u32).map(|j| posed.placement.triangle(&b.triangle(j))).collect();
        let mut least = f64::INFINITY;
        for i in 0..a.len() as u32 {
            let still = a.triangle(i);
            for moved in &moved {
                least = least.min(if certified::touch(&still, moved) {
                    0.0
                } else {
                    triangle_distance::squared(&still, moved).sqrt()
                });
            }
        }
        least
    }

    /// A point beside a face, both on the grid, and so near to its plane that rounding leaves nothing of the height.
    #[test]
    fn what_does_not_touch_is_not_at_distance_zero() {
        let (step, k) = (2f64.powi(-26), 2f64.powi(36));
        let triangle = |corners: [[f64; 3]; 3]| Triangle { corners: corners.map(Point::from) };
        let face = [[0.0; 3], [2048.0, 0.0, 0.0], [0.0, (2.0 * k + 1.0) * step, (2.0 * k + 3.0) * step]];
        let (face, point) = (triangle(face), triangle([[512.0, k * step, (k + 1.0) * step]; 3]));
        assert!(!certified::touch(&face, &point) && triangle_distance::squared(&face, &point) == 0.0);
        let touching = triangle([[600.0, 0.0, -1.0], [600.0, 0.0, 1.0], [601.0, 0.0, 1.0]]);
        let tree = |triangles: &[Triangle]| WideTree::<Oriented>::build(&GridMesh::from_triangles(triangles).unwrap());
        let (a, b) = (tree(&[face]), tree(&[point]));
        let (both, still) = (tree(&[point, touching]), Isometry::identity());
        for simd in Simd::available() {
            for proximity in [&mut Proximity::default(), &mut Proximity::keeping(0.75)] {
                for _ in 0..2 {
                    let found = distance_mm(&a, &b, &still, simd, f64::INFINITY, proximity);
                    assert!(found > 0.0 && found < 1e-300, "{found}, {}", simd.name());
                }
                proximity.nearest = None;
                assert_eq!(distance_mm(&a, &both, &still, simd, f64::INFINITY, proximity), 0.0, "{}", simd.name());
            }
        }
    }

    #[test]
    fn a_share_of_the_distance_is_a_lower_bound_fresh_or_warm() {
        let cases = Cases::new();
        let trees: Vec<WideTree<Oriented>> =
            cases.subjects.iter().map(|subject| WideTree::build(&subject.mesh)).collect();
        let (mut warm, mut last, mut less) = (Proximity::keeping(0.75), (0, 0), 0);
        for case in cases.cases.iter().step_by(11) {
            let (a, b, pose) = (&trees[case.a], &trees[case.b], &case.a_from_b);
            if last != (case.a, case.b) {
                (warm, last) = (Proximity::keeping(0.75), (case.a, case.b));
            }
            let expected = of_all_pairs(a, b, pose);
            for simd in Simd::available() {
                for proximity in [&mut Proximity::keeping(0.75), &mut warm] {
                    let found = distance_mm(a, b, pose, simd, f64::INFINITY, proximity);
                    assert!((0.75 * expected..=expected).contains(&found), "{found} {expected}, {}", simd.name());
                    less += u32::from(found < expected);
                    let below = distance_mm(a, b, pose, simd, 5.0, proximity);
                    assert!(if below < 5.0 { (0.75 * expected..=expected).contains(&below) } else { expected >= 5.0 });
                }
            }
        }
        assert!(less > 5, "{less}");
    }

    /// Two fans of triangles from apexes that are 1 mm apart, and a wall behind each, so that no plane is between the meshes: the pairs of the fans are all as near.
    #[test]
    fn what_is_as_near_in_many_pairs_is_measured_in_few() {
        let fan = |apex: f64, base: f64| {
            let at = |step: u32| {
                let (sin, cos) = (TAU * f64::from(step) / 1000.0).sin_cos();
                Point::new(cos, sin, base)
            };
            let mut triangles: Vec<_> = (0..1000)
                .map(|step| Triangle::new(Point::new(0.0, 0.0, apex), at(step), at((step + 1) % 1000)))
                .collect();
            let beyond = 7.0 * (apex - base).signum() + apex;
            triangles.push(Triangle::new(
                Point::new(-9.0, -9.0, beyond),
                Point::new(9.0, -9.0, beyond),
                Point::new(0.0, 9.0, beyond),
            ));
            WideTree::<Oriented>::build(&GridMesh::from_triangles(&triangles).unwrap())
        };
        let (a, b) = (fan(0.0, -3.0), fan(1.0, 4.0));
        let turned = Isometry::rotation(Vector::new(0.3, 0.2, 0.1));
        let mut warm = Proximity::default();
        for (a_from_b, below_mm) in [(Isometry::identity(), 1.0), (turned, f64::INFINITY), (Isometry::identity(), 2.0)]
        {
            let apex = Triangle { corners: [Point::new(0.0, 0.0, 1.0); 3] };
            let expected = Posed::new(&a, &b, &a_from_b).placement.triangle(&apex).corners[0].coords.norm();
            for simd in Simd::available() {
                for proximity in [&mut Proximity::default(), &mut warm] {
                    let posed = Posed::new(&a, &b, &a_from_b);
                    let batch = Batch::default();
                    let mut search =
                        Search { posed, proximity, least: below_mm, batch, may_touch: 0, measured: 0, slab: None };
                    assert!(search.known_and_others(simd).is_continue());
                    assert!((search.least - expected).abs() <= 1e-12, "{} {expected}", search.least);
                    assert!(search.measured < 3000, "{}, {}", search.measured, simd.name());
                }
            }
        }
    }

    /// Two triangles of 30 mm can pierce each other though their corners and edges are far apart. They are found in whatever place of the lanes
    /// they come, also where small triangles nearby are nearer than those edges.
    #[test]
    fn large_triangles_that_pierce_are_found_beside_small_ones_that_are_near() {
        let mut touching = 0;
        for index in 0..150 {
            let mut draw = Draw::new(2011, &["pierce"], index);
            let mut soup = || {
                let mut triangle = |size: f64| {
                    let middle = Point::from(draw.in_ball() * 12.0);
                    Triangle { corners: [0; 3].map(|_| middle + *draw.direction() * size) }
                };
                let triangles: Vec<Triangle> = (0..14).map(|i| triangle(if i < 3 { 30.0 } else { 0.5 })).collect();
                WideTree::<Oriented>::build(&GridMesh::from_triangles(&triangles).unwrap())
            };
            let (a, b, pose) = (soup(), soup(), Isometry::translation(9.0, 0.0, 0.0));
            let expected = of_all_pairs(&a, &b, &pose);
            touching += u32::from(expected == 0.0);
            for simd in Simd::available() {
                let found = distance_mm(&a, &b, &pose, simd, f64::INFINITY, &mut Proximity::default());
                assert_eq!(found, expected, "{index}, {}", simd.name());
            }
        }
        assert!((75..150).contains(&touching), "{touching}");
    }

    #[test]
    fn the_distance_is_the_least_of_all_pairs_fresh_or_warm_on_every_instruction_set() {
        is_the_least::<Oriented>();
        is_the_least::<Aligned>();
        is_the_least::<Ball>();
    }

    fn is_the_least<V: WideVolume>() {
        let cases = Cases::new();
        let trees: Vec<WideTree<V>> = cases.subjects.iter().map(|subject| WideTree::build(&subject.mesh)).collect();
        let mut warm = Proximity::default();
        let (mut last, mut apart, mut tight) = ((0, 0), 0, 0);
        for case in cases.cases.iter().step_by(11) {
            let (a, b, pose) = (&trees[case.a], &trees[case.b], &case.a_from_b);
            if last != (case.a, case.b) {
                (warm, last) = (Proximity::default(), (case.a, case.b));
            }
            let expected = of_all_pairs(a, b, pose);
            apart += u32::from(expected > 0.0);
            for simd in Simd::available() {
                let found = distance_mm(a, b, pose, simd, f64::INFINITY, &mut Proximity::default());
                assert_eq!(found, expected, "{}", simd.name());
                assert_eq!(distance_mm(a, b, pose, simd, f64::INFINITY, &mut warm), expected, "{}", simd.name());
                assert_eq!(found == 0.0, first(a, b, pose, simd, &mut Scratch::default()));
                let slack_mm = Pose::ball_slack(pose, a.reach_with(b));
                for most_visits in [u32::MAX, 3] {
                    let mut scratch = Scratch::default();
                    scratch.front.open(slack_mm);
                    let touching = search_on((a, b), pose, most_visits, simd, &mut scratch);
                    assert_eq!(touching.is_some(), expected == 0.0, "{}", simd.name());
                    let is_kept = touching.is_none() && scratch.tally.visits <= most_visits;
                    assert!(!is_kept || scratch.front.is_open());
                    assert!(touching.is_none() || !scratch.front.is_open());
                    if scratch.front.is_open() {
                        let apart_mm = scratch.front.room_mm();
                        assert!(apart_mm <= expected, "{apart_mm} {expected}");
                        tight += u32::from(apart_mm > 0.5 * expected);
                    }
                }
                let below = distance_mm(a, b, pose, simd, 1e-3, &mut warm);
                assert_eq!(below, if expected < 1e-3 { expected } else { f64::INFINITY }, "{}", simd.name());
            }
        }
        assert!(apart > 5 && tight > 5, "{apart} {tight}");
    }
}

//! One volume against the eight of a node: which may touch, and how far they are.

use super::lanes::{Lanes, Row};
use super::node::{Node, WIDTH};
use super::pose::Motion;
use super::volume::{Relation, U, WideVolume, row, slack_of, slacks_of};

/// A node, and one volume of the other mesh that is tested against its children.
#[derive(Debug)]
pub(super) struct Visit<'a, V: WideVolume> {
    /// The node.
    pub node: &'a Node<V>,
    /// The node that holds the one volume, and its place there.
    pub holder: &'a Node<V>,
    pub place: usize,
    /// From the one volume's mesh to the node's.
    pub motion: &'a Motion,
    /// What the pose contributes to the slack, mm: the same in all visits of a query.
    pub slack: f32,
}

impl<V: WideVolume> Clone for Visit<'_, V> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<V: WideVolume> Copy for Visit<'_, V> {}

/// As many visits as fit a register: their one volumes as the nodes see them.
#[derive(Clone, Copy)]
pub struct Visits<'a, V: WideVolume, L: Lanes> {
    nodes: [&'a Node<V>; 2],
    /// The one volumes' centres relative to the nodes' origins, mm.
    pub centre: [L; 3],
    /// What else there is of them.
    pub one: V::Moved<L>,
    /// What a gap must exceed, mm.
    slack: L,
}

impl<'a, V: WideVolume, L: Lanes> Visits<'a, V, L> {
    /// Of two visits, of which the second does not count where one fills a register.
    #[inline(always)]
    fn of(visits: [Visit<'a, V>; 2]) -> Self {
        let motion = |i: usize| visits[i].motion;
        let one = |i: usize| visits[i].holder.volume(visits[i].place);
        let node = L::Row::of(|i| visits[i].node.origin_and_slack());
        let holder = L::Row::of(|i| visits[i].holder.origin_and_slack());
        let points = Motion::points::<L::Row>(&motion, holder, L::Row::of(|i| row(one(i).centre())), node);
        let [x, y, z, _] = L::spread(points);
        let [_, _, _, slack] = L::spread(node);
        let (one, reach) = V::moved::<L>(&one, &motion);
        let slack = slacks_of(x.abs() + y.abs() + z.abs(), reach, slack + L::all(visits[0].slack));
        Self { nodes: [visits[0].node, visits[1].node], centre: [x, y, z], one, slack }
    }

    /// One of the numbers of the nodes' eight volumes, or of a part of them.
    #[inline(always)]
    pub fn eight(&self, part: usize, of: impl Fn(&V::Eight) -> &[f32; WIDTH]) -> L {
        L::load(part, |i| of(&self.nodes[i].volumes))
    }
}

/// What a visit found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Overlaps {
    /// For each child the largest difference of distance and reach over the axes, mm: less than 0 by how deep the volumes overlap. Not
    /// found where no child may overlap; where visits are kept it is found of all children, less the slack.
    pub gap: [f32; WIDTH],
    /// A bit for each child that may overlap.
    pub live: u8,
    /// A bit for each child that is larger than the one volume. Not found where no child may overlap.
    pub larger: u8,
}

/// What a visit found about distances.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Distances {
    /// How far each child is at least from the one volume, mm; 0 where they may touch.
    pub least_mm: [f32; WIDTH],
    /// A bit for each child that may be nearer than what was asked for.
    pub nearer: u8,
    /// A bit for each child that is larger than the one volume.
    pub larger: u8,
}

/// What the children of a node contribute to the slack, mm: the largest over the children. For [`Node::slack`].
pub(super) fn node_slack<V: WideVolume>(node: &Node<V>) -> f32 {
    let slack = |place| {
        let volume = node.volume(place);
        let [x, y, z] = volume.centre();
        slack_of((x * x + y * y + z * z).sqrt(), volume.reach())
    };
    (0..node.count as usize).map(slack).fold(0.0, f32::max) * (1.0 + 8.0 * U)
}

/// Makes one or two visits. `KEEPS` asks for gaps less the slack, of all children.
#[inline(always)]
pub(super) fn visit<V: WideVolume, L: Lanes, const KEEPS: bool>(visits: &[Visit<V>], found: &mut [Overlaps; 2]) {
    let mut first = 0;
    while first < visits.len() {
        let seen = Visits::<V, L>::of([visits[first], visits[(first + 1).min(visits.len() - 1)]]);
        let (mut gap, mut live, mut larger) = ([[0.0; WIDTH]; 2], 0, 0);
        for part in 0..L::PARTS {
            let bits = seen.gaps::<KEEPS>(part, &mut gap);
            (live, larger) = (live | bits.live, larger | bits.larger);
        }
        for i in first..(first + L::VISITS).min(visits.len()) {
            let of = |bits: u32| (bits >> (WIDTH * (i - first))) as u8;
            found[i] = Overlaps { gap: gap[i - first], live: of(live), larger: of(larger) };
        }
        first += L::VISITS;
    }
}

/// Makes one or two visits for distances below `below_mm`. Bounds above that are as good as any, and are not improved where all are.
#[inline(always)]
pub(super) fn distances<V: WideVolume, L: Lanes>(visits: &[Visit<V>], below_mm: f32, found: &mut [Distances; 2]) {
    let mut first = 0;
    while first < visits.len() {
        let seen = Visits::<V, L>::of([visits[first], visits[(first + 1).min(visits.len() - 1)]]);
        let (mut least, mut larger, mut nearer) = ([[0.0; WIDTH]; 2], 0, 0);
        for part in 0..L::PARTS {
            let (occupied, at) = (seen.occupied(part), part * WIDTH / L::PARTS);
            let enough = |squared: L| occupied & !squared.exceeds(L::all(below_mm * below_mm)) == 0;
            let relation = V::relation::<L>(part, &seen);
            let bound = relation.least_mm(seen.slack, enough);
            nearer |= (L::all(below_mm).exceeds(bound) & occupied) << at;
            larger |= relation.larger() << at;
            bound.store(part, &mut least);
        }
        for i in first..(first + L::VISITS).min(visits.len()) {
            let of = |bits: u32| (bits >> (WIDTH * (i - first))) as u8;
            found[i] = Distances { least_mm: least[i - first], nearer: of(nearer), larger: of(larger) };
        }
        first += L::VISITS;
    }
}

/// A bit for each lane, as in [`Overlaps`]; the first visit's are the lowest.
#[derive(Clone, Copy, Default)]
struct Bits {
    live: u32,
    larger: u32,
}

impl<V: WideVolume, L: Lanes> Visits<'_, V, L> {
    /// A bit for each lane of a part that holds a child.
    #[inline(always)]
    fn occupied(&self, part: usize) -> u32 {
        let lanes = u32::MAX >> (32 - L::VISITS * WIDTH / L::PARTS);
        let occupied = (0..L::VISITS).fold(0, |bits, i| bits | u32::from(self.nodes[i].occupied()) << (WIDTH * i));
        occupied >> (part * WIDTH / L::PARTS) & lanes
    }

    /// The gaps of all children, or of a part of them. None are found when none of those may overlap, unless it keeps them.
    #[inline(always)]
    fn gaps<const KEEPS: bool>(&self, part: usize, gap: &mut [[f32; WIDTH]; 2]) -> Bits {
        let relation = V::relation::<L>(part, self);
        let first = part * WIDTH / L::PARTS;
        let occupied = self.occupied(part);
        // A gap that is not a number parts nothing.
        let together = |most: L| occupied & !most.exceeds(self.slack);
        // What is quickly found parts nearly all volumes that are apart, and often all of a visit.
        let quick_gaps = relation.quick_gaps();
        let quick = quick_gaps[0].max(quick_gaps[1]).max(quick_gaps[2]);
        if together(quick) == 0 {
            if KEEPS {
                (quick - self.slack).store(part, gap);
            }
            return Bits::default();
        }
        let most = relation.gap(quick_gaps);
        (if KEEPS { most - self.slack } else { most }).store(part, gap);
        Bits { live: together(most) << first, larger: relation.larger() << first }
    }
}

#[cfg(test)]
mod tests {
    use super::super::aligned::Aligned;
    use super::super::ball::Ball;
    use super::super::lanes::{Array, Machine, Simd, Work};
    use super::super::oriented::Oriented;
    use super::super::pose::Pose;
    use super::*;
    use crate::engine::geometry::{Isometry, Point, Vector};
    use nalgebra::{Matrix3, Rotation3};
    use proptest::prelude::*;

    /// A child 7 mm from the node's origin with half-lengths of 1, 2 and 3 mm: u(43·7 + 54·6) = 625u.
    #[test]
    fn the_slack_of_a_node_is_that_of_its_farthest_and_largest_child() {
        let corners = [Point::new(1.0, 1.0, 3.0), Point::new(3.0, 5.0, 9.0)];
        let child = Aligned::fit(&Matrix3::identity(), [0.0; 3], corners.iter().map(|&p| [p; 4]));
        let small = Aligned::fit(&Matrix3::identity(), [0.0; 3], std::iter::once([corners[0]; 4]));
        let mut node = Node::empty([0.0; 3]);
        node.put(0, &small);
        node.put(1, &child);
        node.count = 2;
        let slack = node_slack(&node);
        assert!((625.0 * U..625.001 * U).contains(&slack), "{} u", slack / U);
    }

    struct Visiting<'a, V: WideVolume>(&'a [Visit<'a, V>]);

    impl<V: WideVolume> Work for Visiting<'_, V> {
        type Output = [Overlaps; 2];

        #[inline(always)]
        fn run<M: Machine>(self) -> [Overlaps; 2] {
            let mut found = [Overlaps::default(); 2];
            visit::<V, M::Single, false>(self.0, &mut found);
            found
        }
    }

    /// Of one visit the gaps of all children, whether it needs them or not, and the bounds of their distances.
    struct AllGaps<'a, V: WideVolume>(&'a Visit<'a, V>);

    impl<V: WideVolume> Work for AllGaps<'_, V> {
        type Output = [[f32; WIDTH]; 2];

        #[inline(always)]
        fn run<M: Machine>(self) -> [[f32; WIDTH]; 2] {
            let (mut gap, mut found) = ([[0.0; WIDTH]; 2], [Distances::default(); 2]);
            let seen = Visits::<V, M::Single>::of([*self.0; 2]);
            for part in 0..M::Single::PARTS {
                let relation = V::relation::<M::Single>(part, &seen);
                relation.gap(relation.quick_gaps()).store(part, &mut gap);
            }
            distances::<V, M::Single>(&[*self.0], f32::INFINITY, &mut found);
            [gap[0], found[0].least_mm]
        }
    }

    /// One or two visits for distances below a limit, mm.
    struct Below<'a, V: WideVolume>(&'a [Visit<'a, V>], f32);

    impl<V: WideVolume> Work for Below<'_, V> {
        type Output = [Distances; 2];

        #[inline(always)]
        fn run<M: Machine>(self) -> [Distances; 2] {
            let mut found = [Distances::default(); 2];
            distances::<V, M::Single>(self.0, self.1, &mut found);
            found
        }
    }

    /// What is exactly so of two volumes: their gap, and the distance by which they are apart (0 where they are not), mm.
    struct Exactly {
        gap_mm: f64,
        distance_mm: f64,
    }

    /// The largest difference of distance and reach over the fifteen axes in `f64`, from the axes of both boxes in one frame; the distance from
    /// above, between the corners of one and the other box.
    fn of_boxes(u: &Matrix3<f64>, a: &Vector, v: &Matrix3<f64>, b: &Vector, d: &Vector) -> Exactly {
        let edges = (0..9).map(|n| u.column(n / 3).cross(&v.column(n % 3)));
        let faces = (0..3).flat_map(|n| [u.column(n).into_owned(), v.column(n).into_owned()]);
        let reach = |axis: &Vector| u.tr_mul(axis).abs().dot(a) + v.tr_mul(axis).abs().dot(b);
        let gap_mm = edges.chain(faces).map(|axis| axis.dot(d).abs() - reach(&axis)).fold(f64::NEG_INFINITY, f64::max);
        // Corners of one that are nearest to the other box: an upper bound of the distance.
        let nearest = |d: Vector, u: &Matrix3<f64>, a: &Vector, v: &Matrix3<f64>, b: &Vector| {
            (0..8)
                .map(|n| {
                    let signs = Vector::from_fn(|k, _| if n >> k & 1 == 0 { a[k] } else { -a[k] });
                    let local = v.tr_mul(&(u * signs - d)).abs() - b;
                    local.map(|x| x.max(0.0)).norm()
                })
                .fold(f64::INFINITY, f64::min)
        };
        Exactly { gap_mm, distance_mm: nearest(*d, u, a, v, b).min(nearest(-d, v, b, u, a)) }
    }

    /// Where a test puts its two volumes: the node's origin and that of the other mesh's node, and the motion between the meshes.
    struct Setting {
        origins: [[f32; 3]; 2],
        motion: Isometry,
        scale: f64,
    }

    /// On every instruction set, and alike on those that fuse, the gap is the exact one within the slack, whatever the slack calls apart is apart, and no bound of a distance is
    /// above it; and the slack is small against the lengths involved, which are up to 20 times the scale.
    fn is_covered<V: WideVolume>(
        child: &V,
        one: &V,
        setting: &Setting,
        exactly: &Exactly,
    ) -> Result<(), TestCaseError> {
        let Setting { origins: [origin, other], motion, scale } = setting;
        let (node, holder) = (full(child, *origin), full(one, *other));
        let moved = Pose::new(motion, 10.0 * scale);
        let visit = Visit { node: &node, holder: &holder, place: 3, motion: &moved.a_from_b, slack: 0.0 };
        let visits = Visits::<V, Array<f32>>::of([visit; 2]);
        let mut slack = [[0.0; WIDTH]; 2];
        visits.slack.store(0, &mut slack);
        let slack = f64::from(slack[0][0]);
        let gap_mm = exactly.gap_mm;
        let sets = Simd::available();
        let results: Vec<[Overlaps; 2]> = sets.iter().map(|simd| simd.run(Visiting(&[visit, visit]))).collect();
        for (simd, [first, second]) in sets.iter().zip(&results) {
            prop_assert_eq!(first, second);
            prop_assert!(!simd.fuses() || *first == results[0][0]);
            prop_assert!(first.live == 0 || (first.larger == 255) == (child.size() > one.size()));
            prop_assert!(gap_mm > 0.0 || first.live == 255, "{gap_mm} {slack}");
            prop_assert!(gap_mm < 1e-4 * scale || first.live == 0, "{gap_mm} {slack}");
        }
        let all: Vec<_> = sets.iter().map(|simd| simd.run(AllGaps(&visit))).collect();
        for ((simd, [found, _]), gaps_and_least) in sets.iter().zip(&results).zip(&all) {
            prop_assert!(!simd.fuses() || *gaps_and_least == all[0]);
            let [gaps, least] = gaps_and_least;
            prop_assert!(found.live == 0 || found.gap == *gaps);
            for (&gap, &least) in gaps.iter().zip(least) {
                prop_assert!((f64::from(gap) - gap_mm).abs() <= slack, "{gap} {gap_mm} {slack}");
                prop_assert!(f64::from(least) <= exactly.distance_mm, "{least} {}", exactly.distance_mm);
            }
        }
        Ok(())
    }

    fn vector(size: f64) -> impl Strategy<Value = Vector> {
        prop::array::uniform3(-size..size).prop_map(Vector::from)
    }

    fn around<V: WideVolume>(turn: Vector, half: Vector, centre: Vector, origin: [f32; 3]) -> V {
        let frame = Rotation3::from_scaled_axis(turn).into_inner();
        let corners: Vec<Point> = (0..8)
            .map(|n| {
                let sign = Vector::from_fn(|k, _| if n >> k & 1 == 0 { 1.0 } else { -1.0 });
                Point::from(centre + frame * half.component_mul(&sign))
            })
            .collect();
        V::fit(&frame, origin, corners.iter().map(|&p| [p; 4]))
    }

    /// A node of eight such volumes.
    fn full<V: WideVolume>(volume: &V, origin: [f32; 3]) -> Node<V> {
        let mut node = Node::<V>::empty(origin);
        node.count = 8;
        (0..8).for_each(|place| node.put(place, volume));
        node.slack = node_slack(&node);
        node
    }

    /// Two bars stand on their edges: one of 60 x 4 x 4 mm along x, and 12 mm above it one of 60 x 6 x 6 mm, turned by 30 degrees. The ridges that
    /// face each other are at heights 2√2 and 12 - 3√2, so that the bars are 12 - 5√2 = 4.93 mm apart. Only the product of these two edges
    /// tells so: the middle of the upper bar is 25 mm from where the ridges cross.
    #[test]
    fn bounds_are_improved_where_one_is_asked_for_and_larger_children_are_named() {
        use std::f64::consts::{FRAC_PI_4, FRAC_PI_6, SQRT_2};
        let apart_mm = (12.0 - 5.0 * SQRT_2) as f32;
        let on_edge = Rotation3::from_scaled_axis(Vector::x() * FRAC_PI_4);
        let aside = Rotation3::from_scaled_axis(Vector::z() * FRAC_PI_6);
        let one: Oriented = around(on_edge.scaled_axis(), Vector::new(30.0, 2.0, 2.0), Vector::zeros(), [0.0; 3]);
        let middle = aside * Vector::new(25.0, 0.0, 0.0) + Vector::new(0.0, 0.0, 12.0);
        let child: Oriented = around((aside * on_edge).scaled_axis(), Vector::new(30.0, 3.0, 3.0), middle, [0.0; 3]);
        let (node, holder) = (full(&child, [0.0; 3]), full(&one, [0.0; 3]));
        let pose = Pose::new(&Isometry::identity(), 100.0);
        let visit = Visit { node: &node, holder: &holder, place: 5, motion: &pose.a_from_b, slack: 0.0 };
        let turned = Visit { node: &holder, holder: &node, ..visit };
        for simd in Simd::available() {
            let below = |limit_mm: f32| simd.run(Below(&[visit, turned], limit_mm))[0];
            let (plain, improved) = (below(0.0), below(f32::INFINITY));
            let [plain_mm, improved_mm] = [plain, improved].map(|found| found.least_mm[0]);
            assert!(plain_mm < 0.9 * apart_mm, "{plain_mm}");
            assert!(improved_mm <= apart_mm && improved_mm > apart_mm - 0.001, "{improved_mm} {apart_mm}");
            // Below the plain bound nothing is to be improved; above it something is, though it may not help.
            let expected = [
                (0.95 * plain_mm, plain_mm, 0),
                (1.05 * plain_mm, improved_mm, 0),
                (1.01 * apart_mm, improved_mm, 255),
            ];
            for (limit_mm, least_mm, nearer) in expected {
                assert_eq!(
                    below(limit_mm),
                    Distances { least_mm: [least_mm; WIDTH], nearer, larger: 255 },
                    "{limit_mm}"
                );
            }
            let [_, small] = simd.run(Below(&[visit, turned], f32::INFINITY));
            assert_eq!((small.nearer, small.larger), (255, 0));
        }
    }

    /// Cubes of 0.02 mm, 100 mm apart along x and one of them turned: of the distance of the centres the slack is 43u, the reach of both
    /// 2·10⁻⁴, and what remains is lowered by 48u, whether edges are asked or not.
    #[test]
    fn bounds_are_lowered_by_the_slack_and_by_what_their_own_rounding_adds() {
        let half = Vector::repeat(0.01);
        let one: Oriented = around(Vector::zeros(), half, Vector::zeros(), [0.0; 3]);
        let child: Oriented = around(Vector::x() * 0.3, half, Vector::x() * 100.0, [0.0; 3]);
        let (node, holder) = (full(&child, [0.0; 3]), full(&one, [0.0; 3]));
        let pose = Pose::new(&Isometry::identity(), 100.0);
        let visit = Visit { node: &node, holder: &holder, place: 5, motion: &pose.a_from_b, slack: 0.0 };
        let [near, far] = [&one, &child].map(|cube| cube.plain([0.0; 3]).as_box().unwrap());
        let least = far.1.x - near.1.x - near.2.x - far.2.x;
        for simd in Simd::available() {
            for limit_mm in [0.0, f32::INFINITY] {
                let found = simd.run(Below(&[visit], limit_mm))[0].least_mm[0];
                let lowered = (least - f64::from(found)) / least / f64::from(U);
                assert!((86.0..96.0).contains(&lowered), "{}: {lowered}", simd.name());
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// At any scale, for flat, long and nearly parallel boxes, for small ones in the middle of large ones, and for the boxes along the axes and the
        /// balls about them.
        #[test]
        fn the_slack_covers_the_rounding(
            turns in (vector(3.0), prop_oneof![vector(3.0), vector(1e-6), Just(Vector::zeros())]),
            halves in (vector(1.0), vector(1.0)),
            flat in prop::array::uniform2(prop_oneof![Just(1.0), Just(1e-4), Just(0.0)]),
            sizes in prop::array::uniform2(prop_oneof![Just(1.0), Just(1e-4)]),
            centres in (vector(2.0), vector(2.0)),
            pose in (vector(3.0), vector(1.0)),
            is_apart in prop::bool::ANY,
            exponent in -6..6_i32,
        ) {
            let scale = 10f64.powi(exponent);
            let half = |half: Vector, flat: f64| half.abs().component_mul(&Vector::new(1.0, 1.0, flat)) * scale;
            let halves = [half(halves.0, flat[0]) * sizes[0], half(halves.1, flat[1]) * sizes[1]];
            let away = if is_apart { 1.0 } else { 0.0 };
            let (centres, pose) = ((centres.0 * away, centres.1 * away), (pose.0, pose.1 * away));
            let origins = [(centres.0 * 0.7 * scale), centres.1 * scale].map(|x| x.map(|x| x as f32).into());
            let motion = Isometry::new(pose.1 * scale, pose.0);
            // The other box is turned against the first by the second turn, once it is moved.
            let turn = motion.rotation.inverse() * nalgebra::UnitQuaternion::from_scaled_axis(turns.0)
                * nalgebra::UnitQuaternion::from_scaled_axis(turns.1);
            let (first, second) = (centres.0 * scale, centres.1 * scale);
            let rotation = motion.rotation.to_rotation_matrix().into_inner();
            let setting = Setting { origins, motion, scale };

            let child: Oriented = around(turns.0, halves[0], first, origins[0]);
            let one: Oriented = around(turn.scaled_axis(), halves[1], second, origins[1]);
            let ((u, p, a), (v, q, b)) =
                (one.plain(origins[1]).as_box().unwrap(), child.plain(origins[0]).as_box().unwrap());
            is_covered(&child, &one, &setting, &of_boxes(&(rotation * u), &a, &v, &b, &(q - setting.motion * p)))?;

            let child: Aligned = around(turns.0, halves[0], first, origins[0]);
            let one: Aligned = around(turn.scaled_axis(), halves[1], second, origins[1]);
            let boxed = |volume: Aligned, origin| volume.plain(origin).as_box().unwrap();
            let ((u, p, a), (v, q, b)) = (boxed(one, origins[1]), boxed(child, origins[0]));
            is_covered(&child, &one, &setting, &of_boxes(&(rotation * u), &a, &v, &b, &(q - setting.motion * p)))?;

            let child: Ball = around(turns.0, halves[0], first, origins[0]);
            let one: Ball = around(turn.scaled_axis(), halves[1], second, origins[1]);
            let between = (child.plain(origins[0]).centre() - setting.motion * one.plain(origins[1]).centre()).norm();
            let gap_mm = between - f64::from(child.reach()) - f64::from(one.reach());
            is_covered(&child, &one, &setting, &Exactly { gap_mm, distance_mm: gap_mm.max(0.0) })?;
        }
    }
}

//! An upper bound on the travel of a part relative to another while axes move, for time steps that must not skip a contact.
//!
//! F. Schwarzer, M. Saha, J.-C. Latombe, "Adaptive dynamic collision checking", IEEE Transactions on Robotics 21(3), 2005: a prismatic
//! joint moves every point by its travel, and a rotary joint moves it by the angle times the point's distance from the axis. The joints
//! between the part and the axis can increase that distance during the motion, so their travel is added to it.

use super::joint::Motion;
use super::tree::{Machine, Poses};
use crate::geometry::{Point, Vector};
use rs274::Position;

/// A bounding sphere of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// The link to which the part is fixed; `None` is the world.
    pub link: Option<usize>,
    /// Centre of the sphere in the link's frame, mm.
    pub centre: Point,
    /// Its radius, mm.
    pub radius: f64,
}

impl Machine {
    /// Upper bound, mm, on the sum of the path lengths of any two points, one of each ball, seen from the nearest link that carries both, while
    /// every axis moves at a constant rate by `change` (mm and radians), starting from the poses `poses`. The distance of the two points
    /// changes by no more. Seen from the other ball's link, a point may travel farther: that link may turn.
    pub fn travel_bound_mm(&self, a: &Ball, b: &Ball, poses: &Poses, change: &Position) -> f64 {
        let shared = self.nearest_shared(a.link, b.link);
        self.travel_to(a, shared, poses, change) + self.travel_to(b, shared, poses, change)
    }

    /// Upper bound, mm, on the change of the distance between the balls' centres from that at `poses`, when every axis stays within
    /// `within` (mm and radians) of its position there. Infinite or not a number when `within` is infinite for an axis between them.
    pub fn shift_bound_mm(&self, a: &Ball, b: &Ball, poses: &Poses, within: &Position) -> f64 {
        let shared = self.nearest_shared(a.link, b.link);
        self.shift_from(a, shared, poses, within) + self.shift_from(b, shared, poses, within)
    }

    /// Upper bound, mm, on the displacement of the ball's centre from its position at `poses`, seen from `base`, which carries the ball. A
    /// rotation by an angle t displaces a point at distance d from the axis by 2 d sin(t / 2). A displacement by the joints nearer to the
    /// ball keeps its length under that rotation.
    fn shift_from(&self, ball: &Ball, base: Option<usize>, poses: &Poses, within: &Position) -> f64 {
        let centre = poses.world_from(ball.link) * ball.centre;
        let shift = |link: usize| {
            let (step, distance) = self.lever(link, poses, &centre, within)?;
            let chord = |distance: f64| 2.0 * distance * (0.5 * step.min(std::f64::consts::PI)).sin();
            Some(distance.map_or(step, chord))
        };
        self.chain(ball.link).take_while(|&link| Some(link) != base).filter_map(shift).sum()
    }

    /// Step of a link's joint when the axes move by `change`, mm or radians, and the distance of `point` from the axis of a rotary joint, mm. `point`
    /// is in the world's frame. `None` for a link without a joint.
    #[inline]
    pub fn lever(&self, link: usize, poses: &Poses, point: &Point, change: &Position) -> Option<(f64, Option<f64>)> {
        let joint = self.links()[link].joint.as_ref()?;
        let distance = match joint.motion {
            Motion::Prismatic { .. } => None,
            Motion::Rotary { direction, point: on_axis } => {
                let world_from_link = &poses.0[link];
                let from_axis: Vector = point - world_from_link * on_axis;
                Some((world_from_link * direction.into_inner()).cross(&from_axis).norm())
            }
        };
        Some((joint.value(change).abs(), distance))
    }

    /// The nearest link that carries both links; `None` is the world.
    pub fn nearest_shared(&self, a: Option<usize>, b: Option<usize>) -> Option<usize> {
        self.chain(a).find(|&link| self.chain(b).any(|other| other == link))
    }

    /// Upper bound on the path length of the ball's points, seen from `base`, which carries the ball.
    fn travel_to(&self, ball: &Ball, base: Option<usize>, poses: &Poses, change: &Position) -> f64 {
        let centre = poses.world_from(ball.link) * ball.centre;
        let mut travel = 0.0;
        for link in self.chain(ball.link).take_while(|&link| Some(link) != base) {
            if let Some((step, reach)) = self.lever(link, poses, &centre, change) {
                travel += reach.map_or(step, |reach| step * (reach + ball.radius + travel));
            }
        }
        travel
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;
    use crate::machine::joint::{Joint, Limits};
    use crate::machine::tree::Link;
    use proptest::prelude::*;
    use rs274::Axis;

    fn link(name: &str, parent: Option<&str>, shift: [f64; 3], joint: Joint) -> Link {
        let parent_from_link = Isometry::translation(shift[0], shift[1], shift[2]);
        Link { name: name.into(), parent: parent.map(Into::into), parent_from_link, joint: Some(joint) }
    }

    /// A machine in which X carries B and B carries C; Z is separate.
    fn machine() -> Machine {
        let slide = |axis, direction| Joint::prismatic(axis, direction, Limits::NONE).unwrap();
        let turn = |axis, direction| Joint::rotary(axis, direction, Point::new(1.0, 2.0, 3.0), Limits::NONE).unwrap();
        Machine::new(vec![
            link("x", None, [0.0; 3], slide(Axis::X, Vector::x())),
            link("b", Some("x"), [10.0, 0.0, 0.0], turn(Axis::B, Vector::y())),
            link("c", Some("b"), [0.0, 20.0, 5.0], turn(Axis::C, Vector::z())),
            link("z", None, [0.0, 0.0, 100.0], slide(Axis::Z, Vector::z())),
        ])
        .unwrap()
    }

    #[test]
    fn a_turn_moves_a_point_by_its_angle_times_its_distance() {
        let ball = |link| Ball { link, centre: Point::new(1.0, 2.0, 10.0), radius: 0.5 };
        let poses = machine().forward(&Position::default());
        let mut change = Position::default();
        change[Axis::B] = 0.1;
        // 7 above B's axis, and half a millimetre of radius.
        let bound = machine().travel_bound_mm(&ball(Some(1)), &ball(None), &poses, &change);
        assert!((bound - 0.75).abs() < 1e-12, "{bound}");
        change[Axis::Z] = -2.0;
        let bound = machine().travel_bound_mm(&ball(Some(1)), &ball(Some(3)), &poses, &change);
        assert!((bound - 2.75).abs() < 1e-12, "{bound}");
        // What carries both moves neither against the other.
        change[Axis::X] = 50.0;
        assert_eq!(machine().travel_bound_mm(&ball(Some(2)), &ball(Some(2)), &poses, &change), 0.0);
    }

    #[test]
    fn what_slides_outwards_while_it_turns_goes_farther_than_either() {
        // On C's axis at first; X, which C carries, slides it 10 mm outwards while C turns by 1 radian. It goes along the spiral of
        // Archimedes r = 10 t: 10 (√2 + asinh 1) / 2 = 11.478 mm, more than the slide's 10. The bound is 10 + 1 · (0 + 10).
        let turn = Joint::rotary(Axis::C, Vector::z(), Point::origin(), Limits::NONE).unwrap();
        let slide = Joint::prismatic(Axis::X, Vector::x(), Limits::NONE).unwrap();
        let links = vec![link("c", None, [0.0; 3], turn), link("x", Some("c"), [0.0; 3], slide)];
        let machine = Machine::new(links).unwrap();
        let ball = |link, radius| Ball { link, centre: Point::origin(), radius };
        let mut change = Position::default();
        (change[Axis::C], change[Axis::X]) = (1.0, 10.0);
        let poses = machine.forward(&Position::default());
        let bound = machine.travel_bound_mm(&ball(Some(1), 0.0), &ball(None, 0.0), &poses, &change);
        let spiral = 5.0 * (2f64.sqrt() + 1f64.asinh());
        assert!(bound >= spiral && (bound - 20.0).abs() < 1e-12, "{bound} {spiral}");
        // A radius of 2 mm turns too, either way round.
        change[Axis::C] = -1.0;
        let bound = machine.travel_bound_mm(&ball(None, 0.0), &ball(Some(1), 2.0), &poses, &change);
        assert!((bound - 22.0).abs() < 1e-12, "{bound}");
    }

    #[test]
    fn a_centre_is_shifted_by_slides_and_by_chords_of_its_circles() {
        // (9, 2, 3) is 8 mm from the axis along Y through (1, 2, 3), both in the frame of link `b`.
        let a = Ball { link: Some(1), centre: Point::new(9.0, 2.0, 3.0), radius: 1.0 };
        let b = Ball { link: None, centre: Point::origin(), radius: 1.0 };
        let poses = machine().forward(&Position::default());
        let shift = |x: f64, angle: f64| {
            let mut within = Position::default();
            (within[Axis::X], within[Axis::B]) = (x, angle);
            machine().shift_bound_mm(&a, &b, &poses, &within)
        };
        // A quarter turn is a chord of √2 radii; half a turn or more, the diameter.
        for (x, angle, expected) in [
            (3.0, 0.0, 3.0),
            (0.0, std::f64::consts::FRAC_PI_2, 8.0 * 2f64.sqrt()),
            (-3.0, -std::f64::consts::PI, 19.0),
            (3.0, 5.0, 19.0),
        ] {
            assert!((shift(x, angle) - expected).abs() < 1e-12, "{x} {angle}: {}", shift(x, angle));
        }
        assert!(!shift(f64::INFINITY, 0.0).is_finite());
        assert_eq!(machine().shift_bound_mm(&a, &a, &poses, &Position([1.0; 9])), 0.0);
    }

    proptest! {
        #[test]
        fn no_centre_is_shifted_farther(
            start in prop::array::uniform4(-2.0..2.0f64),
            within in prop::array::uniform4(0.0..5.0f64),
            parts in prop::array::uniform4(-1.0..1.0f64),
        ) {
            let machine = machine();
            let position = |values: [f64; 4]| {
                let mut position = Position::default();
                for (axis, value) in [Axis::X, Axis::B, Axis::C, Axis::Z].into_iter().zip(values) {
                    position[axis] = value;
                }
                position
            };
            let a = Ball { link: Some(2), centre: Point::new(3.0, -4.0, 6.0), radius: 0.0 };
            let b = Ball { link: Some(3), centre: Point::origin(), radius: 0.0 };
            let distance = |at: &Position| {
                let poses = machine.forward(at);
                (poses.world_from(a.link) * a.centre - poses.world_from(b.link) * b.centre).norm()
            };
            let bound = machine.shift_bound_mm(&a, &b, &machine.forward(&position(start)), &position(within));
            let there = position(std::array::from_fn(|i| start[i] + parts[i] * within[i]));
            prop_assert!((distance(&there) - distance(&position(start))).abs() <= bound + 1e-9);
        }

        #[test]
        fn no_point_goes_farther(
            start in prop::array::uniform4(-2.0..2.0f64),
            step in prop::array::uniform4(-1.5..1.5f64),
            offset in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let machine = machine();
            let position = |values: [f64; 4]| {
                let mut position = Position::default();
                for (axis, value) in [Axis::X, Axis::B, Axis::C, Axis::Z].into_iter().zip(values) {
                    position[axis] = value;
                }
                position
            };
            let a = Ball { link: Some(2), centre: Point::new(3.0, -4.0, 6.0), radius: 3f64.sqrt() };
            let b = Ball { link: Some(3), centre: Point::origin(), radius: 1.0 };
            let bound = machine.travel_bound_mm(&a, &b, &machine.forward(&position(start)), &position(step));
            let seen = |t: f64| {
                let poses = machine.forward(&position(std::array::from_fn(|i| start[i] + t * step[i])));
                poses.world_from(b.link).inverse() * poses.world_from(a.link) * (a.centre + Vector::from(offset))
            };
            let way: f64 = (0..200).map(|i| (seen(f64::from(i + 1) / 200.0) - seen(f64::from(i) / 200.0)).norm()).sum();
            prop_assert!(way <= bound + 1e-9, "{} > {}", way, bound);
        }
    }
}

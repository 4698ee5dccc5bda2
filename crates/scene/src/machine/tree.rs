//! The tree of links, and its forward kinematics.

use super::joint::{Joint, OutOfLimits};
use crate::geometry::Isometry;
use rs274::{Axis, Position};
use std::collections::HashMap;
use std::f64::consts::TAU;
use thiserror::Error;

/// Why links do not form a machine.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{message}")]
pub struct MachineError {
    /// Index of the faulty link; of a cycle, that of its first link.
    pub link: usize,
    /// Whether the parent that the link names is to blame.
    pub of_parent: bool,
    /// What is wrong.
    pub message: String,
}

/// A rigid member of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name, unique in the machine.
    pub name: String,
    /// Name of the parent link; `None` for the world.
    pub parent: Option<String>,
    /// The link's frame in its parent's frame at axis position zero, mm.
    pub parent_from_link: Isometry,
    /// The joint between the link and its parent; `None` when the link is fixed.
    pub joint: Option<Joint>,
}

/// A checked kinematic tree (or forest: several links may have the world as parent).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Machine {
    links: Vec<Link>,
    /// Index of each link's parent.
    parents: Vec<Option<usize>>,
    /// Indices of the links, parents before children.
    order: Vec<usize>,
}

/// `world_from_link` per link, in the order of [`Machine::links`].
#[derive(Clone, Debug, PartialEq)]
pub struct Poses(pub Vec<Isometry>);

impl Machine {
    /// Checks the links and finds the parent of each.
    ///
    /// # Errors
    /// [`MachineError`]: an unknown parent, a cycle, a name given twice, or a placement that is not finite.
    pub fn new(links: Vec<Link>) -> Result<Self, MachineError> {
        let wrong = |link: usize, message: String| MachineError { link, of_parent: false, message };
        let mut index_of = HashMap::new();
        for (link, Link { name, parent_from_link, .. }) in links.iter().enumerate() {
            if index_of.insert(name.as_str(), link).is_some() {
                return Err(wrong(link, format!("there are two links named `{name}`")));
            }
            if !is_usable(parent_from_link) {
                let message = format!("the placement of link `{name}` is not finite, or farther than 1e9 mm");
                return Err(wrong(link, message));
            }
        }
        let mut parents = Vec::with_capacity(links.len());
        for (link, Link { name, parent, .. }) in links.iter().enumerate() {
            parents.push(match parent {
                None => None,
                Some(parent) => Some(*index_of.get(parent.as_str()).ok_or_else(|| {
                    let message = format!("link `{name}` stands on `{parent}`, which is not a link of this machine");
                    MachineError { of_parent: true, ..wrong(link, message) }
                })?),
            });
        }
        let order = parents_first(&links, &parents)?;
        Ok(Self { links, parents, order })
    }

    /// The links, in the order given.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Index of the link with a name.
    pub fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Index of a link's parent; `None` for the world.
    pub fn parent(&self, link: usize) -> Option<usize> {
        self.parents[link]
    }

    /// The links from the given one, which is the first, to the world.
    pub fn chain(&self, link: Option<usize>) -> impl Iterator<Item = usize> {
        std::iter::successors(link, move |&link| self.parent(link))
    }

    /// The links from `from` up to the first that carries `other` too, which is left out.
    pub fn up_to_shared(&self, from: Option<usize>, other: Option<usize>) -> impl Iterator<Item = usize> {
        self.chain(from).take_while(move |&link| self.chain(other).all(|carrier| carrier != link))
    }

    /// The link whose joint moves the given link: the nearest link with a joint on the path to the world, including the link itself; `None`
    /// when there is none. Links with the same result never move relative to each other.
    pub fn rigid_body(&self, link: Option<usize>) -> Option<usize> {
        self.chain(link).find(|&link| self.links[link].joint.is_some())
    }

    /// The poses of all links at an axis position. Limits are not checked; [`Machine::check_limits`] does that.
    pub fn forward(&self, position: &Position) -> Poses {
        let mut poses = vec![Isometry::identity(); self.links.len()];
        for &link in &self.order {
            let Link { parent_from_link, joint, .. } = &self.links[link];
            let displacement = joint.as_ref().map_or_else(Isometry::identity, |joint| joint.displacement(position));
            let world_from_parent = self.parents[link].map_or_else(Isometry::identity, |parent| poses[parent]);
            poses[link] = world_from_parent * parent_from_link * displacement;
        }
        Poses(poses)
    }

    /// The range that all joints of an axis permit, in the unit of the axis (mm or radians); infinite without a limit. `None` for an axis
    /// without a joint.
    pub fn axis_limits(&self, axis: Axis) -> Option<[f64; 2]> {
        let limits = self.joints_of(axis).map(|joint| [joint.limits.min, joint.limits.max].map(|x| x / joint.gain()));
        limits.reduce(|[low, high], [min, max]| [low.max(min), high.min(max)])
    }

    /// The way of an axis, in its unit, after which all its joints are where they were: a full turn. `None` when a joint slides, or there is none.
    pub fn full_turn(&self, axis: Axis) -> Option<f64> {
        let joint = self.joints_of(axis).next()?;
        self.joints_of(axis).all(Joint::turns).then(|| TAU / joint.gain())
    }

    /// The joints that an axis drives, in link order.
    pub fn joints_of(&self, axis: Axis) -> impl Iterator<Item = &Joint> {
        self.links.iter().filter_map(|link| link.joint.as_ref()).filter(move |joint| joint.axis == axis)
    }

    /// Checks that all joints of one axis permit a position.
    ///
    /// # Errors
    /// [`OutOfLimits`] for the first joint that does not.
    pub fn check_axis(&self, axis: Axis, position: &Position) -> Result<(), OutOfLimits> {
        self.joints_of(axis).try_for_each(|joint| joint.check(position))
    }

    /// Checks that every joint permits an axis position.
    ///
    /// # Errors
    /// [`OutOfLimits`] for the first joint, in link order, that does not.
    pub fn check_limits(&self, position: &Position) -> Result<(), OutOfLimits> {
        self.links.iter().filter_map(|link| link.joint.as_ref()).try_for_each(|joint| joint.check(position))
    }
}

impl Poses {
    /// `world_from_link` of a link; the identity for `None`.
    pub fn world_from(&self, link: Option<usize>) -> Isometry {
        link.map_or_else(Isometry::identity, |link| self.0[link])
    }
}

/// Whether all seven numbers of a rigid motion are finite, and its translation is within the range of an axis.
pub fn is_usable(motion: &Isometry) -> bool {
    let translation = motion.translation.vector;
    motion.rotation.coords.iter().all(|x| x.is_finite())
        && translation.iter().all(|x| x.abs() <= rs274::interpret::FARTHEST)
}

/// The links in an order in which parents come before their children.
fn parents_first(links: &[Link], parents: &[Option<usize>]) -> Result<Vec<usize>, MachineError> {
    let mut order = Vec::with_capacity(links.len());
    let mut placed = vec![false; links.len()];
    for link in 0..links.len() {
        let mut chain = Vec::new();
        let mut at = Some(link);
        while let Some(next) = at.filter(|&next| !placed[next]) {
            if let Some(first) = chain.iter().position(|&seen| seen == next) {
                return Err(cycle(links, &chain[first..]));
            }
            chain.push(next);
            at = parents[next];
        }
        for &next in chain.iter().rev() {
            placed[next] = true;
            order.push(next);
        }
    }
    Ok(order)
}

fn cycle(links: &[Link], circle: &[usize]) -> MachineError {
    let names: Vec<&str> = circle.iter().chain(&circle[..1]).map(|&link| links[link].name.as_str()).collect();
    let message = format!("links stand on one another in a circle: {}", names.join(" -> "));
    MachineError { link: circle[0], of_parent: false, message }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Vector};
    use crate::machine::joint::Limits;
    use std::f64::consts::FRAC_PI_2;

    fn link(name: &str, parent: Option<&str>, at: [f64; 3], joint: Option<Joint>) -> Link {
        Link {
            name: name.to_owned(),
            parent: parent.map(str::to_owned),
            parent_from_link: Isometry::translation(at[0], at[1], at[2]),
            joint,
        }
    }

    /// A column 100 mm up, a slide along X on it, and a table that rotates about Z at (50, 0) of the slide. The links are declared in
    /// reverse order.
    fn machine() -> Machine {
        let slide = Joint::prismatic(Axis::X, Vector::x(), Limits { min: -200.0, max: 200.0 }).unwrap();
        let turn = Joint::rotary(Axis::C, Vector::z(), Point::origin(), Limits::NONE).unwrap();
        Machine::new(vec![
            link("table", Some("slide"), [50.0, 0.0, 0.0], Some(turn)),
            link("slide", Some("column"), [0.0, 0.0, 10.0], Some(slide)),
            link("column", None, [0.0, 0.0, 100.0], None),
        ])
        .unwrap()
    }

    #[test]
    fn poses_add_up_along_the_chain() {
        let mut position = Position::default();
        position[Axis::X] = 7.0;
        position[Axis::C] = FRAC_PI_2;
        let poses = machine().forward(&position);
        // On the table, 3 along its x after a quarter turn is 3 along the world's y: (7 + 50, 3, 100 + 10).
        let tip = poses.world_from(machine().link("table")) * Point::new(3.0, 0.0, 0.0);
        assert!((tip - Point::new(57.0, 3.0, 110.0)).norm() < 1e-12, "{tip}");
        let slide = poses.world_from(machine().link("slide")) * Point::origin();
        assert!((slide - Point::new(7.0, 0.0, 110.0)).norm() < 1e-12);
        assert_eq!(poses.world_from(None), Isometry::identity());
        assert_eq!(machine().parent(0), Some(1));
        assert_eq!([Some(0), Some(2), None].map(|link| machine().rigid_body(link)), [Some(0), None, None]);
    }

    #[test]
    fn one_axis_may_drive_two_joints() {
        let slide = |sign: f64| Joint::prismatic(Axis::Y, Vector::y() * sign, Limits::NONE).ok();
        let gripper =
            Machine::new(vec![link("left", None, [0.0; 3], slide(1.0)), link("right", None, [0.0; 3], slide(-1.0))])
                .unwrap();
        let mut position = Position::default();
        position[Axis::Y] = 4.0;
        let Poses(poses) = gripper.forward(&position);
        assert_eq!(poses[0].translation.y, 4.0);
        assert_eq!(poses[1].translation.y, -4.0);
    }

    #[test]
    fn an_axis_has_a_full_turn_when_all_its_joints_turn() {
        let turn = |axis| Joint::rotary(axis, Vector::z(), Point::origin(), Limits::NONE).ok();
        let slide = |axis| Joint::prismatic(axis, Vector::x(), Limits::NONE).ok();
        let machine = Machine::new(vec![
            link("a", None, [0.0; 3], turn(Axis::A)),
            link("b", None, [0.0; 3], turn(Axis::B)),
            link("b2", None, [0.0; 3], slide(Axis::B)),
            link("u", None, [0.0; 3], turn(Axis::U)),
            link("x", None, [0.0; 3], slide(Axis::X)),
        ])
        .unwrap();
        assert_eq!(machine.full_turn(Axis::A), Some(4.0 * FRAC_PI_2));
        // An axis in mm turns a degree per mm.
        assert!((machine.full_turn(Axis::U).unwrap() - 360.0).abs() < 1e-9);
        assert_eq!([Axis::B, Axis::X, Axis::C].map(|axis| machine.full_turn(axis)), [None; 3]);
    }

    #[test]
    fn limits_are_checked_for_every_joint() {
        let mut position = Position::default();
        assert!(machine().check_limits(&position).is_ok());
        position[Axis::X] = -200.5;
        assert_eq!(machine().check_limits(&position).unwrap_err().axis, 'X');
    }

    #[test]
    fn circles_are_named() {
        let links = vec![
            link("leaf", Some("a"), [0.0; 3], None),
            link("a", Some("b"), [0.0; 3], None),
            link("b", Some("a"), [0.0; 3], None),
        ];
        let error = Machine::new(links).unwrap_err();
        assert_eq!(error.to_string(), "links stand on one another in a circle: a -> b -> a");
        let own = Machine::new(vec![link("a", Some("a"), [0.0; 3], None)]).unwrap_err();
        assert_eq!(own.to_string(), "links stand on one another in a circle: a -> a");
    }

    #[test]
    fn strangers_twins_and_infinities_are_refused() {
        let stranger = Machine::new(vec![link("a", Some("moon"), [0.0; 3], None)]).unwrap_err();
        assert!(stranger.link == 0 && stranger.of_parent && stranger.message.contains("`moon`"), "{stranger}");
        let twins = Machine::new(vec![link("a", None, [0.0; 3], None), link("a", None, [0.0; 3], None)]).unwrap_err();
        assert_eq!(twins.link, 1);
        let lost = Machine::new(vec![link("a", None, [0.0, f64::NAN, 0.0], None)]).unwrap_err();
        assert!(lost.link == 0 && lost.message.contains("not finite"), "{lost}");
    }
}

//! Machines from URDF, the Unified Robot Description Format of ROS: links, joints and geometry.
//!
//! URDF uses metres, radians, and fixed-axis roll, pitch and yaw; here all lengths are converted to mm. Fixed, prismatic, revolute and
//! continuous joints are supported, from version 1.0 of the format on. Each moving joint gets an axis letter, so that a program can move
//! it: the letter that the caller gives, or the next free letter in the order of the file. Prismatic joints use X Y Z U V W; rotary joints
//! use A B C U V W X Y Z.

use super::file::Form;
use super::joint::{Joint, Limits};
use super::tree::{Link, Machine};
use crate::geometry::shapes::round::{Capsule, Cylinder, Sphere};
use crate::geometry::shapes::{RoundedBox, Shape};
use crate::geometry::{Isometry, Point, Vector};
use nalgebra::{Translation3, UnitQuaternion};
use quick_xml::Reader;
use quick_xml::events::Event;
use rs274::Axis;
use std::collections::BTreeMap;
use thiserror::Error;
use urdf_rs::{Geometry, JointType, Pose, Robot};

/// Length of URDF's unit, mm.
const METRE: f64 = 1000.0;
/// Deepest nesting of elements. URDF needs five levels; XML parsers recurse once per level.
const MOST_NESTED: usize = 64;

/// Letters for sliding joints, in the order in which they are assigned.
const SLIDING: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W];
/// Letters for rotary joints, in the order in which they are assigned.
const TURNING: [Axis; 9] = [Axis::A, Axis::B, Axis::C, Axis::U, Axis::V, Axis::W, Axis::X, Axis::Y, Axis::Z];

/// Why a URDF file does not describe a machine.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{message}")]
pub struct UrdfError {
    /// Name of the link or joint to blame, which locates the error in the file.
    pub name: Option<String>,
    /// What is wrong.
    pub message: String,
}

impl UrdfError {
    /// An error of the file as a whole.
    fn of_file(message: impl std::fmt::Display) -> Self {
        Self { name: None, message: format!("{message}") }
    }

    /// An error of a link or joint.
    fn at(name: &str, message: String) -> Self {
        Self { name: Some(name.to_owned()), message }
    }
}

/// One body of a link's geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Name: the name of the link, numbered when the link has several bodies.
    pub name: String,
    /// Index of the link.
    pub link: usize,
    /// The body's frame in the link's frame, mm.
    pub link_from_body: Isometry,
    /// Its geometry.
    pub solid: Solid,
}

/// The geometry of a body.
#[derive(Clone, Debug, PartialEq)]
pub enum Solid {
    /// One of URDF's own solids.
    Shape(Shape),
    /// A mesh file.
    Mesh {
        /// The path as written in the file, or a URI with `package://` or `file://`.
        file: String,
        /// Length of the mesh's unit, mm.
        unit_mm: f64,
    },
}

/// Reads a machine and the bodies of its links. `letters` assigns axis letters to joints.
///
/// # Errors
/// [`UrdfError`], with the name of the faulty element.
pub fn read(text: &str, letters: &BTreeMap<String, char>, form: Form) -> Result<(Machine, Vec<Body>), UrdfError> {
    check_elements(text)?;
    let robot = urdf_rs::read_from_string(text).map_err(UrdfError::of_file)?;
    let axes = axes(&robot, letters)?;
    let parents = parents(&robot)?;
    let mut links = Vec::with_capacity(robot.links.len());
    for link in &robot.links {
        let joint = parents.get(link.name.as_str()).copied();
        links.push(Link {
            name: link.name.clone(),
            parent: joint.map(|joint| joint.parent.link.clone()),
            parent_from_link: joint
                .map_or_else(|| Ok(Isometry::identity()), |joint| placed(&joint.name, &joint.origin))?,
            joint: joint.map(|joint| moved(joint, &axes)).transpose()?.flatten(),
        });
    }
    let machine = Machine::new(links).map_err(|error| UrdfError::at(&robot.links[error.link].name, error.message))?;
    let mut bodies = Vec::new();
    for (index, link) in robot.links.iter().enumerate() {
        bodies.append(&mut bodies_of(index, link, form)?);
    }
    Ok((machine, bodies))
}

/// Refuses elements of xacro, and elements that are nested too deeply, by pulling one event after the other, which needs no stack.
fn check_elements(text: &str) -> Result<(), UrdfError> {
    let mut xml = Reader::from_str(text);
    // A tag that closes another element than it names is told by the parser that reads the robot.
    xml.config_mut().check_end_names = false;
    xml.config_mut().allow_unmatched_ends = true;
    let mut depth = 0_usize;
    loop {
        match xml.read_event().map_err(UrdfError::of_file)? {
            Event::Start(tag) | Event::Empty(tag) if tag.name().0.starts_with("xacro:") => {
                return Err(UrdfError::of_file("this is xacro; expand it first, with `xacro FILE > robot.urdf`"));
            }
            Event::Start(_) => depth += 1,
            Event::End(_) => depth = depth.saturating_sub(1),
            Event::Eof => return Ok(()),
            _ => {}
        }
        if depth > MOST_NESTED {
            return Err(UrdfError::of_file(format!("elements are nested deeper than {MOST_NESTED}")));
        }
    }
}

/// The axis of every moving joint, by the joint's name.
fn axes<'a>(robot: &'a Robot, letters: &BTreeMap<String, char>) -> Result<BTreeMap<&'a str, Axis>, UrdfError> {
    let slides = |joint: &urdf_rs::Joint| joint.joint_type == JointType::Prismatic;
    let moving: Vec<&urdf_rs::Joint> =
        robot.joints.iter().filter(|joint| joint.joint_type != JointType::Fixed).collect();
    let mut axes = BTreeMap::new();
    for (name, &letter) in letters {
        let joint = moving.iter().find(|joint| joint.name == *name).ok_or_else(|| {
            let known = moving.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>().join(", ");
            UrdfError::of_file(format!("there is no joint `{name}` to give axis {letter} to; there are {known}"))
        })?;
        let bad = |why| UrdfError::at(name, format!("joint `{name}` cannot be axis `{letter}`: {why}"));
        let axis = Axis::from_letter(letter).ok_or_else(|| bad("the axes are X Y Z A B C U V W"))?;
        if slides(joint) && axis.is_rotary() {
            return Err(bad("it slides, and A, B and C turn"));
        }
        axes.insert(joint.name.as_str(), axis);
    }
    for joint in moving {
        if axes.contains_key(joint.name.as_str()) {
            continue;
        }
        let choice: &[Axis] = if slides(joint) { &SLIDING } else { &TURNING };
        let free = choice.iter().find(|&axis| !axes.values().any(|taken| taken == axis));
        axes.insert(&joint.name, *free.ok_or_else(|| no_letter(&joint.name))?);
    }
    Ok(axes)
}

fn no_letter(name: &str) -> UrdfError {
    let advice = "give several joints one letter, or make joints `fixed`";
    UrdfError::at(name, format!("no letter is left for joint `{name}`; {advice}"))
}

/// The joint of which each link is the child, by the link's name; root links have none.
fn parents(robot: &Robot) -> Result<BTreeMap<&str, &urdf_rs::Joint>, UrdfError> {
    let mut parents: BTreeMap<&str, &urdf_rs::Joint> = BTreeMap::new();
    for joint in &robot.joints {
        for link in [&joint.parent.link, &joint.child.link] {
            if !robot.links.iter().any(|known| known.name == *link) {
                let name = &joint.name;
                return Err(UrdfError::at(name, format!("joint `{name}` names the link `{link}`, which is not there")));
            }
        }
        if let Some(first) = parents.insert(&joint.child.link, joint) {
            let (name, first, second) = (&joint.child.link, &first.name, &joint.name);
            let message = format!(
                "link `{name}` is the child of two joints, `{first}` and `{second}`: a closed chain is not a tree"
            );
            return Err(UrdfError::at(name, message));
        }
    }
    Ok(parents)
}

fn placed(name: &str, origin: &Pose) -> Result<Isometry, UrdfError> {
    if !origin.xyz.iter().chain(origin.rpy.iter()).all(|x| x.abs() <= rs274::interpret::FARTHEST) {
        return Err(UrdfError::at(name, format!("a placement at `{name}` is not finite, or farther than 1e9")));
    }
    let [roll, pitch, yaw] = *origin.rpy;
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Ok(Isometry::from_parts(Translation3::from(Vector::from(*origin.xyz) * METRE), turn))
}

/// The joint that moves a link; `None` for a fixed joint.
fn moved(joint: &urdf_rs::Joint, axes: &BTreeMap<&str, Axis>) -> Result<Option<Joint>, UrdfError> {
    let name = &joint.name;
    let refuse = |why: &str| Err(UrdfError::at(name, format!("joint `{name}` {why}")));
    let kind =
        |kind: &str| refuse(&format!("is {kind}; only fixed, prismatic, revolute and continuous joints are taken"));
    if let Some(mimic) = &joint.mimic {
        let advice = "give both the letter of one axis where they move alike, or fix it";
        return refuse(&format!("mimics `{}`, which is not supported; {advice}", mimic.joint));
    }
    match joint.joint_type {
        JointType::Fixed => return Ok(None),
        JointType::Planar => return kind("planar"),
        JointType::Floating => return kind("floating"),
        JointType::Spherical => return kind("spherical"),
        JointType::Prismatic | JointType::Revolute if joint.limit.lower == joint.limit.upper => {
            return refuse("has no range: it needs `<limit lower=... upper=...>`, or to be `fixed` or `continuous`");
        }
        JointType::Prismatic | JointType::Revolute | JointType::Continuous => {}
    }
    let Some(&axis) = axes.get(joint.name.as_str()) else { return Err(no_letter(name)) };
    let direction = Vector::from(*joint.axis.xyz);
    let limits = |scale: f64| Limits { min: joint.limit.lower * scale, max: joint.limit.upper * scale };
    let made = match joint.joint_type {
        JointType::Prismatic => Joint::prismatic(axis, direction, limits(METRE)),
        JointType::Revolute => Joint::rotary(axis, direction, Point::origin(), limits(1.0)),
        _ => Joint::rotary(axis, direction, Point::origin(), Limits::NONE),
    };
    made.map(Some).map_err(|cause| UrdfError::at(name, format!("joint `{name}`: {cause}")))
}

fn bodies_of(index: usize, link: &urdf_rs::Link, form: Form) -> Result<Vec<Body>, UrdfError> {
    let is_visual = link.collision.is_empty() || form == Form::Visual && !link.visual.is_empty();
    let described: Vec<(&Pose, &Geometry)> = if is_visual {
        link.visual.iter().map(|visual| (&visual.origin, &visual.geometry)).collect()
    } else {
        link.collision.iter().map(|collision| (&collision.origin, &collision.geometry)).collect()
    };
    let several = described.len() > 1;
    let body = |(number, (origin, geometry)): (usize, (&Pose, &Geometry))| {
        let (link_from_solid, solid) = solid(&link.name, geometry)?;
        Ok(Body {
            name: if several { format!("{}-{}", link.name, number + 1) } else { link.name.clone() },
            link: index,
            link_from_body: placed(&link.name, origin)? * link_from_solid,
            solid,
        })
    };
    described.into_iter().enumerate().map(body).collect()
}

/// The solid of this project that corresponds to a URDF geometry, with the translation between their origins.
fn solid(link: &str, geometry: &Geometry) -> Result<(Translation3<f64>, Solid), UrdfError> {
    let mm = |metres: &f64| metres * METRE;
    let mut shift = Translation3::identity();
    let shape = match geometry {
        Geometry::Box { size } => {
            Shape::RoundedBox(RoundedBox { size_mm: size.0.map(|x| mm(&x)), fillet_mm: 0.0, holes: Vec::new() })
        }
        // URDF's is about the origin, ours stands on it.
        Geometry::Cylinder { radius, length } => {
            let height_mm = mm(length);
            shift.z = -0.5 * height_mm;
            Shape::Cylinder(Cylinder {
                radius_mm: mm(radius),
                height_mm,
                bore_mm: 0.0,
                fillet_mm: 0.0,
                chamfer_mm: 0.0,
            })
        }
        Geometry::Capsule { radius, length } => {
            Shape::Capsule(Capsule { radius_mm: mm(radius), length_mm: mm(length) })
        }
        Geometry::Sphere { radius } => Shape::Sphere(Sphere { radius_mm: mm(radius) }),
        Geometry::Mesh { filename, scale } => {
            let scale = scale.map_or([1.0; 3], |scale| scale.0);
            if !(scale[0] > 0.0 && scale[0].is_finite() && scale[1] == scale[0] && scale[2] == scale[0]) {
                let message = format!(
                    "a mesh of link `{link}` is scaled by {scale:?}; only one positive factor for all axes is taken"
                );
                return Err(UrdfError::at(link, message));
            }
            return Ok((shift, Solid::Mesh { file: filename.clone(), unit_mm: scale[0] * METRE }));
        }
    };
    Ok((shift, Solid::Shape(shape)))
}

#[cfg(test)]
mod tests;

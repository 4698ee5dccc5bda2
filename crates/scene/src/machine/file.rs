//! The TOML form of a machine: a list of links.
//!
//! ```toml
//! [[links]]
//! name = "carriage"
//! parent = "bed"                                   # without it the link stands in the world
//! at = { xyz_mm = [0, 0, 250], rpy_deg = [0, 0, 90] }
//! joint = { axis = "Z", direction = [0, 0, 1], min_mm = -900, max_mm = 50 }
//! ```
//!
//! The letters A, B and C are rotary (`point_mm`, `min_deg`, `max_deg`); the other six are linear (`min_mm`, `max_mm`). With `turns =
//! true`, a joint of a linear letter turns by one degree per millimetre of its axis, because robots have more than three rotary joints.

use super::joint::{Joint, JointError, Limits};
use super::tree::{Link, Machine};
use crate::geometry::{Isometry, Point, Vector};
use nalgebra::{Translation3, UnitQuaternion};
use rs274::Axis;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// A link in the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkFile {
    /// Name, unique in the machine.
    pub name: Spanned<String>,
    /// The parent link; when absent, the world.
    pub parent: Option<Spanned<String>>,
    /// The link's frame in its parent's frame.
    #[serde(default)]
    pub at: PlacementFile,
    /// The joint that moves the link; when absent, the link is fixed.
    pub joint: Option<JointFile>,
}

/// A placement in the file: rotation first, then translation.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlacementFile {
    /// Translation, mm.
    #[serde(default)]
    pub xyz_mm: [f64; 3],
    /// Rotations about the fixed axes X, then Y, then Z, degrees.
    #[serde(default)]
    pub rpy_deg: [f64; 3],
}

impl PlacementFile {
    /// The placement as a rigid motion. Not finite when its numbers are not.
    pub fn isometry(&self) -> Isometry {
        let [roll, pitch, yaw] = self.rpy_deg.map(f64::to_radians);
        Isometry::from_parts(
            Translation3::from(Vector::from(self.xyz_mm)),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        )
    }
}

/// A joint in the file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointFile {
    /// Letter of the axis.
    pub axis: Spanned<char>,
    /// Direction, any length but zero.
    pub direction: Spanned<[f64; 3]>,
    /// Whether the joint is rotary although its letter is that of a linear axis: a degree per mm.
    #[serde(default)]
    pub turns: bool,
    /// A point on a rotary joint's line, mm.
    pub point_mm: Option<Spanned<[f64; 3]>>,
    /// Lower limit of a prismatic joint, mm.
    pub min_mm: Option<Spanned<f64>>,
    /// Upper limit of a prismatic joint, mm.
    pub max_mm: Option<Spanned<f64>>,
    /// Lower limit of a rotary joint, degrees.
    pub min_deg: Option<Spanned<f64>>,
    /// Upper limit of a rotary joint, degrees.
    pub max_deg: Option<Spanned<f64>>,
}

/// Which description of a URDF link is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// `<collision>`, or `<visual>` for links without it.
    #[default]
    Collision,
    /// `<visual>`, or `<collision>` for links without it.
    Visual,
}

/// A fault of a list of links: the byte range to blame, and what is wrong.
pub type Fault = (Range<usize>, String);

/// Builds the machine.
///
/// # Errors
/// [`Fault`], with the byte range of the faulty value, or of the link's name.
pub fn build(links: &[LinkFile]) -> Result<Machine, Fault> {
    let mut built = Vec::with_capacity(links.len());
    for link in links {
        let name = link.name.get_ref();
        let joint = link.joint.as_ref().map(|file| joint(name, file)).transpose()?;
        built.push(Link {
            name: name.clone(),
            parent: link.parent.as_ref().map(|parent| parent.get_ref().clone()),
            parent_from_link: link.at.isometry(),
            joint,
        });
    }
    Machine::new(built).map_err(|error| {
        let LinkFile { name, parent, .. } = &links[error.link];
        let span = parent.as_ref().filter(|_| error.of_parent).map_or_else(|| name.span(), Spanned::span);
        (span, error.message)
    })
}

fn joint(name: &str, file: &JointFile) -> Result<Joint, Fault> {
    let letter = *file.axis.get_ref();
    let axis = Axis::from_letter(letter).ok_or_else(|| {
        (file.axis.span(), format!("link `{name}`: `{letter}` is not an axis; the axes are X Y Z A B C U V W"))
    })?;
    let turns = axis.is_rotary() || file.turns;
    let span = |limit: &Option<Spanned<f64>>| limit.as_ref().map(Spanned::span);
    let (verb, foreign) = if turns {
        ("turns", [("min_mm", span(&file.min_mm)), ("max_mm", span(&file.max_mm)), ("", None)])
    } else {
        let point = ("point_mm", file.point_mm.as_ref().map(Spanned::span));
        ("slides", [("min_deg", span(&file.min_deg)), ("max_deg", span(&file.max_deg)), point])
    };
    if let Some((key, span)) = foreign.into_iter().find_map(|(key, span)| Some((key, span?))) {
        let axis = axis.letter();
        return Err((span, format!("link `{name}`: axis {axis} {verb}, so `{key}` means nothing here")));
    }
    let (min, max, unit) =
        if turns { (&file.min_deg, &file.max_deg, 1f64.to_radians()) } else { (&file.min_mm, &file.max_mm, 1.0) };
    let limit = |limit: &Option<Spanned<f64>>| limit.as_ref().map(|limit| limit.get_ref() * unit);
    let limits = Limits { min: limit(min).unwrap_or(Limits::NONE.min), max: limit(max).unwrap_or(Limits::NONE.max) };
    let direction = Vector::from(*file.direction.get_ref());
    let point = Point::from(file.point_mm.as_ref().map_or([0.0; 3], |point| *point.get_ref()));
    let joint =
        if turns { Joint::rotary(axis, direction, point, limits) } else { Joint::prismatic(axis, direction, limits) };
    joint.map_err(|cause| (to_blame(file, &cause), format!("link `{name}`: {cause}")))
}

/// The byte range of the numbers that make a joint invalid.
fn to_blame(file: &JointFile, cause: &JointError) -> Range<usize> {
    let limits = [&file.min_mm, &file.max_mm, &file.min_deg, &file.max_deg].map(Option::as_ref);
    let mut limits = limits.into_iter().flatten();
    let is_finite = |vector: &Spanned<[f64; 3]>| vector.get_ref().iter().all(|x| x.is_finite());
    let found = match cause {
        JointError::ZeroDirection { .. } => None,
        JointError::EmptyLimits { .. } => limits.next().map(Spanned::span),
        JointError::NotFinite { .. } if !is_finite(&file.direction) => None,
        JointError::NotFinite { .. } => match file.point_mm.as_ref().filter(|point| !is_finite(point)) {
            Some(point) => Some(point.span()),
            None => limits.find(|limit| limit.get_ref().is_nan()).map(Spanned::span),
        },
    };
    found.unwrap_or_else(|| file.direction.span())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rs274::Position;

    #[derive(Deserialize)]
    struct Links {
        links: Vec<LinkFile>,
    }

    fn parse(text: &str) -> Result<Machine, Fault> {
        build(&toml::from_str::<Links>(text).unwrap().links)
    }

    #[test]
    fn degrees_become_radians_and_placements_turn_before_they_move() {
        let machine = parse(
            r#"
            links = [
                { name = "base", at = { xyz_mm = [1, 2, 3], rpy_deg = [0, 0, 90] } },
                { name = "table", parent = "base", joint = { axis = "c", direction = [0, 0, 2], min_deg = -90, max_deg = 90 } },
            ]"#,
        )
        .unwrap();
        let mut position = Position::default();
        position[Axis::C] = std::f64::consts::FRAC_PI_2;
        assert!(machine.check_limits(&position).is_ok());
        // Turned by 90° on the table and by 90° with the base: (5, 0, 0) -> (-5, 0, 0), then moved by (1, 2, 3).
        let tip = machine.forward(&position).world_from(machine.link("table")) * Point::new(5.0, 0.0, 0.0);
        assert!((tip - Point::new(-4.0, 2.0, 3.0)).norm() < 1e-12, "{tip}");
        position[Axis::C] = 1.6;
        assert_eq!(machine.check_limits(&position).unwrap_err().max, 90.0);
    }

    #[test]
    fn six_joints_may_turn() {
        let machine =
            parse(r#"links = [{ name = "wrist", joint = { axis = "W", turns = true, direction = [1, 0, 0], max_deg = 30 } }]"#)
                .unwrap();
        let mut position = Position::default();
        position[Axis::W] = 30.0;
        assert!(machine.check_limits(&position).is_ok());
        position[Axis::W] = 31.0;
        assert_eq!(machine.check_limits(&position).unwrap_err().unit, "degrees");
    }

    #[test]
    fn errors_point_at_the_value_to_blame() {
        let text = "links = [{ name = \"a\" }, { name = \"slide\", joint = { axis = \"Q\", direction = [1, 0, 0] } }]";
        let (span, error) = parse(text).unwrap_err();
        assert_eq!(&text[span], "\"Q\"");
        assert_eq!(error, "link `slide`: `Q` is not an axis; the axes are X Y Z A B C U V W");
        let text = "links = [{ name = \"a\", parent = \"b\" }]";
        let (span, error) = parse(text).unwrap_err();
        assert_eq!(&text[span], "\"b\"");
        assert_eq!(error, "link `a` stands on `b`, which is not a link of this machine");
        let text = "links = [{ name = \"a\" }, { name = \"a\" }]";
        assert_eq!(parse(text).unwrap_err().0, 34..37, "the second name");
        for (joint, wrong) in [
            ("axis = \"X\", direction = [0, 0, 0]", "[0, 0, 0]"),
            ("axis = \"X\", direction = [0, nan, 0]", "[0, nan, 0]"),
            ("axis = \"X\", direction = [1, 0, 0], min_mm = 7, max_mm = 6", "7"),
            ("axis = \"X\", direction = [1, 0, 0], min_mm = 7, max_mm = nan", "nan"),
            ("axis = \"A\", direction = [1, 0, 0], point_mm = [inf, 0, 0]", "[inf, 0, 0]"),
            ("axis = \"A\", direction = [1, 0, 0], max_deg = 9, min_deg = nan", "nan"),
            ("axis = \"A\", direction = [1, 0, 0], max_mm = 8", "8"),
        ] {
            let text = format!("links = [{{ name = \"a\", joint = {{ {joint} }} }}]");
            let (span, error) = parse(&text).unwrap_err();
            assert_eq!(&text[span], wrong, "{error}");
        }
    }

    #[test]
    fn keys_of_the_other_kind_of_joint_are_refused() {
        for (joint, key) in [
            ("{ axis = \"X\", direction = [1, 0, 0], min_deg = 0 }", "min_deg"),
            ("{ axis = \"X\", direction = [1, 0, 0], point_mm = [0, 0, 0] }", "point_mm"),
            ("{ axis = \"A\", direction = [1, 0, 0], max_mm = 0 }", "max_mm"),
        ] {
            let (_, error) = parse(&format!("links = [{{ name = \"a\", joint = {joint} }}]")).unwrap_err();
            assert!(error.ends_with(&format!("so `{key}` means nothing here")), "{error}");
        }
        let (_, error) =
            parse("links = [{ name = \"a\", joint = { axis = \"X\", direction = [0, 0, 0] } }]").unwrap_err();
        assert_eq!(error, "link `a`: the direction of axis X is zero");
    }
}

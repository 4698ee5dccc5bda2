//! A tool as bodies of revolution on one axis, and its oriented boxes in two levels.
//!
//! Level 1 has one box per body; level 2 divides each into four boxes. The abstract of the thesis does not say how, so three divisions are
//! implemented ([`SecondLevel`]).

use super::profile::Profile;
use crate::geometry::Vector;

/// The kind of a tool's body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BodyKind {
    /// The cutter may touch the surface, but not gouge it. Its interference is local.
    Cutter,
    /// The shank is between cutter and holder. Its interference, like the holder's, is global.
    Shank,
    /// Holds the tool.
    Holder,
}

impl BodyKind {
    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cutter => "cutter",
            Self::Shank => "shank",
            Self::Holder => "holder",
        }
    }

    /// Whether the interference of this kind of body is local.
    pub const fn is_local(self) -> bool {
        matches!(self, Self::Cutter)
    }
}

/// A body of revolution about the tool's axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// What it is.
    pub kind: BodyKind,
    /// Profile of the body in the tool's frame, mm.
    pub profile: Profile,
}

/// A tool: its tip at the origin, its axis +z.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Its bodies.
    pub bodies: Vec<Body>,
}

/// A tool with its boxes of both levels, in the order of its bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxedTool {
    tool: Tool,
    boxes: Vec<(ToolBox, Vec<ToolBox>)>,
}

impl BoxedTool {
    /// Finds the boxes.
    pub fn new(tool: Tool, level: SecondLevel) -> Self {
        let boxes = tool.bodies.iter().map(|body| (body.first_level(), body.second_level(level))).collect();
        Self { tool, boxes }
    }

    /// Each body with its box of level 1 and its boxes of level 2.
    pub fn bodies(&self) -> impl Iterator<Item = (&Body, &ToolBox, &[ToolBox])> {
        self.tool.bodies.iter().zip(&self.boxes).map(|(body, (first, second))| (body, first, second.as_slice()))
    }
}

/// How the four boxes of the second level are divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SecondLevel {
    /// There is none.
    None,
    /// Divides the body along its axis at the three heights with the least total volume, among the ends of its profile's pieces and 64
    /// more.
    Profile4,
    /// Divides the body along its axis into four parts of equal height.
    Axial4,
    /// Divides the body's box across its axis into four quarters, which leaves the total volume unchanged.
    Quad4,
}

impl SecondLevel {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::None, Self::Profile4, Self::Axial4, Self::Quad4];

    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Profile4 => "profile4",
            Self::Axial4 => "axial4",
            Self::Quad4 => "quad4",
        }
    }
}

/// A box along the axes of the tool's frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolBox {
    /// Its middle.
    pub centre: Vector,
    /// Half its sides.
    pub half: Vector,
}

impl ToolBox {
    fn around(radius: f64, low: f64, high: f64) -> Self {
        Self {
            centre: Vector::new(0.0, 0.0, f64::midpoint(low, high)),
            half: Vector::new(radius, radius, 0.5 * (high - low)),
        }
    }

    /// The box widened on all sides; a negative amount has no effect.
    pub fn widened(&self, by_mm: f64) -> Self {
        Self { half: self.half.add_scalar(by_mm.max(0.0)), ..*self }
    }

    fn volume(&self) -> f64 {
        8.0 * self.half.product()
    }
}

/// Heights that are tried for [`SecondLevel::Profile4`] in addition to those of the profile.
const CUTS: usize = 64;

impl Body {
    /// The box of level 1.
    pub fn first_level(&self) -> ToolBox {
        let [low, high] = self.profile.span_mm();
        ToolBox::around(self.profile.radius_mm(), low, high)
    }

    /// The boxes of level 2.
    pub fn second_level(&self, level: SecondLevel) -> Vec<ToolBox> {
        let [low, high] = self.profile.span_mm();
        let slice = |(&from, &to): (&f64, &f64)| ToolBox::around(self.profile.radius_between_mm(from, to), from, to);
        let slices = |cuts: &[f64]| cuts.iter().zip(&cuts[1..]).map(slice).collect();
        match level {
            SecondLevel::None => Vec::new(),
            SecondLevel::Axial4 => slices(&[0.0, 0.25, 0.5, 0.75, 1.0].map(|part: f64| low + part * (high - low))),
            SecondLevel::Profile4 => slices(&self.best_cuts()),
            SecondLevel::Quad4 => {
                let ToolBox { centre, half } = self.first_level();
                let half = Vector::new(0.5 * half.x, 0.5 * half.y, half.z);
                let corner =
                    |x: f64, y: f64| ToolBox { centre: centre + Vector::new(x * half.x, y * half.y, 0.0), half };
                vec![corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)]
            }
        }
    }

    /// The ends, and the three heights between them at which four boxes have the least total volume, by dynamic programming.
    fn best_cuts(&self) -> Vec<f64> {
        let [low, high] = self.profile.span_mm();
        let mut heights = self.profile.heights_mm();
        heights.extend((1..CUTS).map(|k| low + (high - low) * k as f64 / CUTS as f64));
        heights.sort_by(f64::total_cmp);
        heights.dedup();
        let last = heights.len() - 1;
        let cost = |i: usize, j: usize| {
            ToolBox::around(self.profile.radius_between_mm(heights[i], heights[j]), heights[i], heights[j]).volume()
        };
        // least[j]: volume of the boxes up to height j, and where the last of them begins; one table per box.
        let mut tables: Vec<Vec<(f64, usize)>> = vec![(0..=last).map(|j| (cost(0, j), 0)).collect()];
        for _ in 1..4 {
            let before = &tables[tables.len() - 1];
            let best = |j: usize| {
                let options = (0..=j).map(|i| (before[i].0 + cost(i, j), i));
                options.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
            };
            let table = (0..=last).map(best).collect();
            tables.push(table);
        }
        let (mut at, mut cuts) = (last, vec![high]);
        for table in tables.iter().rev() {
            at = table[at].1;
            cuts.push(heights[at]);
        }
        cuts.reverse();
        cuts.dedup(); // A plain cylinder needs fewer than four.
        cuts
    }
}

#[cfg(test)]
mod tests {
    use super::super::profile::P2;
    use super::*;

    fn stepped() -> Body {
        // 2 wide up to 10, 4 up to 12, 1 up to 30, 5 up to 31.
        let points = [
            (0.0, 0.0),
            (2.0, 0.0),
            (2.0, 10.0),
            (4.0, 10.0),
            (4.0, 12.0),
            (1.0, 12.0),
            (1.0, 30.0),
            (5.0, 30.0),
            (5.0, 31.0),
            (0.0, 31.0),
        ];
        Body { kind: BodyKind::Holder, profile: Profile::of_lines(&points.map(|(r, z)| P2::new(r, z))) }
    }

    fn holds(boxes: &[ToolBox], p: &Vector) -> bool {
        boxes.iter().any(|b| ((p - b.centre).abs() - b.half).max() <= 1e-12)
    }

    #[test]
    fn the_profile_is_cut_at_its_steps() {
        let heights: Vec<[f64; 2]> = stepped()
            .second_level(SecondLevel::Profile4)
            .iter()
            .map(|b| [b.centre.z - b.half.z, b.centre.z + b.half.z])
            .collect();
        // A slice that only touches a step takes its radius, so each cut lies on it or a step of the search beside it.
        assert_eq!(heights.len(), 4);
        for (found, expected) in heights.iter().zip([[0.0, 10.0], [10.0, 12.0], [12.0, 30.0], [30.0, 31.0]]) {
            assert!((found[0] - expected[0]).abs() <= 31.0 / 64.0 && (found[1] - expected[1]).abs() <= 31.0 / 64.0);
        }
        let cylinder = Body { kind: BodyKind::Cutter, profile: Profile::cylinder(3.0, 9.0).unwrap() };
        assert_eq!(
            cylinder.first_level(),
            ToolBox { centre: Vector::new(0.0, 0.0, 4.5), half: Vector::new(3.0, 3.0, 4.5) }
        );
    }

    #[test]
    fn every_level_holds_the_body() {
        for body in [stepped(), Body { kind: BodyKind::Cutter, profile: Profile::ball(5.0, 30.0).unwrap() }] {
            for level in SecondLevel::ALL {
                let boxes =
                    if level == SecondLevel::None { vec![body.first_level()] } else { body.second_level(level) };
                for k in 0..=310 {
                    let z = 0.1 * f64::from(k);
                    let radius = body.profile.radius_between_mm(z, z);
                    for turn in 0..16 {
                        let (sin, cos) = (f64::from(turn) * 0.4).sin_cos();
                        let p = Vector::new(radius * cos, radius * sin, z);
                        let inside = body.profile.signed_distance_mm(&P2::new(radius, z)) <= 1e-9;
                        assert!(!inside || holds(&boxes, &p), "{level:?} at {p}");
                    }
                }
            }
            let volume = |level| body.second_level(level).iter().map(ToolBox::volume).sum::<f64>();
            assert!(volume(SecondLevel::Profile4) <= volume(SecondLevel::Axial4) + 1e-9);
            assert!((volume(SecondLevel::Quad4) - body.first_level().volume()).abs() < 1e-9);
        }
    }
}

//! Round holes in the faces of a cuboid: blind or through, plain or counterbored.

use super::super::Point;
use super::error::{Fault, SMALLEST_MM, ShapeError, coordinates, length, within};
use super::outline::circle;
use super::polygon::{P2, Polygon};
use super::solid::Surface;
use super::tessellation::Sizing;
use serde::{Deserialize, Serialize};

/// A face of a cuboid, by the direction of its normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    /// The face at the smallest x.
    #[serde(rename = "-x")]
    NegativeX,
    /// The face at the largest x.
    #[serde(rename = "+x")]
    PositiveX,
    /// The face at the smallest y.
    #[serde(rename = "-y")]
    NegativeY,
    /// The face at the largest y.
    #[serde(rename = "+y")]
    PositiveY,
    /// The face at the smallest z.
    #[serde(rename = "-z")]
    NegativeZ,
    /// The face at the largest z.
    #[serde(rename = "+z")]
    PositiveZ,
}

impl Side {
    const fn axis(self) -> usize {
        match self {
            Self::NegativeX | Self::PositiveX => 0,
            Self::NegativeY | Self::PositiveY => 1,
            Self::NegativeZ | Self::PositiveZ => 2,
        }
    }

    const fn is_positive(self) -> bool {
        matches!(self, Self::PositiveX | Self::PositiveY | Self::PositiveZ)
    }
}

/// A round hole, perpendicular to a face.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxHole {
    /// The face it is drilled from.
    pub face: Side,
    /// Centre relative to the middle of the face, mm, along the two other axes in the order x, y, z.
    pub at_mm: [f64; 2],
    /// Radius, mm.
    pub radius_mm: f64,
    /// Depth of the cylindrical part, measured from the face, mm; when absent, the hole goes through.
    #[serde(default)]
    pub depth_mm: Option<f64>,
    /// Angle of the conical end that a drill leaves in a blind hole, degrees, such as 118; when absent, the bottom is flat.
    #[serde(default)]
    pub point_deg: Option<f64>,
    /// A wider part at the face.
    #[serde(default)]
    pub counterbore: Option<Counterbore>,
}

/// The wider part of a hole at the face.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counterbore {
    /// Radius, mm.
    pub radius_mm: f64,
    /// Depth from the face, mm.
    pub depth_mm: f64,
}

impl BoxHole {
    fn widest(&self) -> f64 {
        self.counterbore.map_or(self.radius_mm, |bore| bore.radius_mm)
    }

    /// Height of the conical end, mm.
    fn point_height(&self) -> f64 {
        self.point_deg.map_or(0.0, |angle| self.radius_mm / (angle.to_radians() / 2.0).tan())
    }

    /// Centre, mm, along the two axes that follow the hole's axis in the cyclic order x, y, z.
    fn centre(&self) -> P2 {
        let [u, v] = self.at_mm;
        if self.face.axis() == 1 { P2::new(v, u) } else { P2::new(u, v) }
    }

    /// Smallest and largest coordinates of a box around the hole, mm.
    fn bounds(&self, size: [f64; 3]) -> [(f64, f64); 3] {
        let (axis, centre, radius) = (self.face.axis(), self.centre(), self.widest());
        let half = size[axis] / 2.0;
        let depth = self.depth_mm.map_or(size[axis], |depth| depth + self.point_height());
        let mut bounds = [(0.0, 0.0); 3];
        bounds[axis] = if self.face.is_positive() { (half - depth, half) } else { (-half, depth - half) };
        bounds[(axis + 1) % 3] = (centre.x - radius, centre.x + radius);
        bounds[(axis + 2) % 3] = (centre.y - radius, centre.y + radius);
        bounds
    }

    fn check(&self, name: &str, size: [f64; 3], fillet: f64) -> Result<(), ShapeError> {
        let field = |part: &str| format!("{name}.{part}");
        coordinates(&field("at_mm"), self.at_mm)?;
        let radius = length(&field("radius_mm"), self.radius_mm)?;
        let axis = self.face.axis();
        let deepest = size[axis] - SMALLEST_MM;
        if let Some(angle) = self.point_deg {
            within(&field("point_deg"), angle, 30.0, 175.0)?;
            if self.depth_mm.is_none() {
                return Err(Fault::HoleOutside("the box: a through hole has no point").at(field("point_deg")));
            }
        }
        let depth = match self.depth_mm {
            Some(depth) => within(&field("depth_mm"), depth, SMALLEST_MM, deepest - self.point_height())?,
            None => size[axis],
        };
        if let Some(bore) = self.counterbore {
            within(&field("counterbore.radius_mm"), bore.radius_mm, radius + SMALLEST_MM, f64::MAX)?;
            within(&field("counterbore.depth_mm"), bore.depth_mm, SMALLEST_MM, depth - SMALLEST_MM)?;
        }
        let centre = self.centre();
        let fits = |offset: f64, axis: usize| offset.abs() + self.widest() + SMALLEST_MM <= size[axis] / 2.0 - fillet;
        if fits(centre.x, (axis + 1) % 3) && fits(centre.y, (axis + 2) % 3) {
            Ok(())
        } else {
            Err(Fault::HoleOutside("the plane part of its face").at(name))
        }
    }

    /// Whether two checked holes may meet. Parallel holes are compared as circles, others by their bounding boxes.
    fn may_meet(&self, other: &Self, size: [f64; 3]) -> bool {
        let (a, b) = (self.bounds(size), other.bounds(size));
        let boxes_meet = (0..3).all(|i| a[i].0 <= b[i].1 + SMALLEST_MM && b[i].0 <= a[i].1 + SMALLEST_MM);
        let parallel = self.face.axis() == other.face.axis();
        let apart = parallel && (self.centre() - other.centre()).norm() > self.widest() + other.widest() + SMALLEST_MM;
        boxes_meet && !apart
    }
}

/// Checks that every hole can be drilled and that no two holes meet.
pub(super) fn check_holes(size: [f64; 3], fillet: f64, holes: &[BoxHole]) -> Result<(), ShapeError> {
    for (i, hole) in holes.iter().enumerate() {
        hole.check(&format!("holes[{i}]"), size, fillet)?;
        if let Some(j) = holes[..i].iter().position(|other| other.may_meet(hole, size)) {
            return Err(Fault::HolesMeet(format!("holes[{j}]")).at(format!("holes[{i}]")));
        }
    }
    Ok(())
}

/// A hole with its wall and bottom already in the surface, and the rings that the faces must leave open.
pub(super) struct Drilled {
    axis: usize,
    positive: bool,
    entrance: (Polygon, Vec<u32>),
    exit: Option<(Polygon, Vec<u32>)>,
}

impl Drilled {
    /// Adds wall and bottom of a checked hole.
    pub fn new(hole: &BoxHole, size: [f64; 3], sizing: &Sizing, surface: &mut Surface) -> Self {
        let (axis, positive) = (hole.face.axis(), hole.face.is_positive());
        let ring = |surface: &mut Surface, radius: f64, depth: f64| -> (Polygon, Vec<u32>) {
            let polygon = match radius {
                0.0 => vec![hole.centre()],
                radius => circle(hole.centre(), radius, sizing.circle(radius)),
            };
            let height = (size[axis] / 2.0 - depth) * if positive { 1.0 } else { -1.0 };
            let lift = |p: &P2| {
                let mut point = Point::origin();
                (point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3]) = (height, p.x, p.y);
                surface.vertex(point)
            };
            let vertices = polygon.iter().map(lift).collect();
            (polygon, vertices)
        };
        let profile = profile(hole, size[axis], sizing);
        let rings: Vec<_> = profile.iter().map(|&(radius, depth)| ring(surface, radius, depth)).collect();
        for pair in rings.windows(2) {
            let (outer, inner) = (&pair[0].1, &pair[1].1);
            if positive { surface.band(outer, inner) } else { surface.band(inner, outer) }
        }
        let mut rings = rings.into_iter();
        let entrance = rings.next().expect("a hole's profile begins at its face");
        let exit = if hole.depth_mm.is_none() { rings.next_back() } else { None };
        Self { axis, positive, entrance, exit }
    }

    /// The loop that the hole cuts out of a face, and the vertices of that loop; `None` when the hole does not open there.
    pub fn opening(&self, axis: usize, positive: bool) -> Option<(&Polygon, &Vec<u32>)> {
        if axis != self.axis {
            None
        } else if positive == self.positive {
            Some((&self.entrance.0, &self.entrance.1))
        } else {
            self.exit.as_ref().map(|(polygon, vertices)| (polygon, vertices))
        }
    }
}

/// Radii and depths of the rings of a hole, from its face to its end.
fn profile(hole: &BoxHole, thickness: f64, sizing: &Sizing) -> Vec<(f64, f64)> {
    let mut rings = Vec::new();
    let mut bore = |radius: f64, from: f64, to: f64| {
        let pieces = sizing.straight(to - from);
        rings.extend((0..=pieces).map(|k| (radius, from + (to - from) * k as f64 / pieces as f64)));
    };
    let wide_depth = hole.counterbore.map_or(0.0, |wide| {
        bore(wide.radius_mm, 0.0, wide.depth_mm);
        wide.depth_mm
    });
    bore(hole.radius_mm, wide_depth, hole.depth_mm.unwrap_or(thickness));
    if let Some(depth) = hole.depth_mm {
        rings.push((0.0, depth + hole.point_height()));
    }
    rings
}

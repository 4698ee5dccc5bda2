//! Stock given by its dimensions or by a mesh file, in the coordinates of G54: the workpiece before the first cut.

use super::folder::LARGEST_FILE;
use super::{Part, Role};
use crate::geometry::import::{self, FileInUnit};
use crate::geometry::shapes::round::Cylinder;
use crate::geometry::shapes::{RoundedBox, Shape, Tessellation};
use crate::geometry::{Isometry, Mesh, Vector};
use std::ffi::OsStr;
use std::path::Path;
use std::sync::Arc;

/// The name of the part that represents the stock.
const PART_NAME: &str = "stock";
/// Tessellation of round stock: its chords deviate by at most 0.0027 mm up to a diameter of 4.5 m.
const TESSELLATION: Tessellation = Tessellation { grading: 1.0, density: 3.0 };

/// The workpiece before the first cut, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct StockSpec {
    form: Form,
    /// Position: the corner of least X, Y and Z of a box, the middle of the lower end of a cylinder, or the origin of a file. `None` for
    /// the default position.
    at: Option<[f64; 3]>,
}

#[derive(Clone, Debug, PartialEq)]
enum Form {
    Box([f64; 3]),
    Cylinder { diameter: f64, length: f64 },
    File(FileInUnit),
}

impl StockSpec {
    /// Parses the text of a command line: `box:X,Y,Z`, `cylinder:DIAMETER,LENGTH` or a mesh file, each with an optional position `@X,Y,Z`.
    ///
    /// # Errors
    /// A message that states the expected form.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (what, at) = match text.rsplit_once('@') {
            Some((what, at)) if numbers::<3>(at).is_ok() => (what, Some(numbers::<3>(at)?)),
            _ => (text, None),
        };
        let lengths = |name: &str, lengths: &[f64]| match lengths.iter().find(|&&length| length <= 0.0) {
            Some(length) => Err(format!("{name}: the length {length} must be above 0")),
            None => Ok(()),
        };
        let form = if let Some(sizes) = what.strip_prefix("box:") {
            let sizes = numbers::<3>(sizes).map_err(|why| format!("box: {why}, as in box:100,60,30"))?;
            lengths("box", &sizes)?;
            Form::Box(sizes)
        } else if let Some(sizes) = what.strip_prefix("cylinder:") {
            let sizes = numbers::<2>(sizes).map_err(|why| format!("cylinder: {why}, as in cylinder:50,120"))?;
            lengths("cylinder", &sizes)?;
            Form::Cylinder { diameter: sizes[0], length: sizes[1] }
        } else {
            Form::File(OsStr::new(what).into())
        };
        Ok(Self { form, at })
    }

    /// The mesh file, if it is one.
    pub fn file(&self) -> Option<&Path> {
        match &self.form {
            Form::File(file) => Some(&file.path),
            Form::Box(_) | Form::Cylinder { .. } => None,
        }
    }

    /// The part on the link that carries the workpiece, and a description of its position. The frame of its mesh is that of G54, or that of
    /// the file, so that a wanted part can be drawn in it.
    ///
    /// # Errors
    /// A message when the file cannot be read, or the dimensions make no solid.
    pub(super) fn part(&self, link: Option<usize>, link_from_work: &Isometry) -> Result<(Part, String), String> {
        let (mesh, shape, at) = match &self.form {
            Form::Box(size) => {
                let shape = Shape::RoundedBox(RoundedBox { size_mm: *size, fillet_mm: 0.0, holes: Vec::new() });
                // The shape is about its middle; the usual place is the middle of the top at zero.
                let corner = self.at.unwrap_or([-0.5 * size[0], -0.5 * size[1], -size[2]]);
                let middle = std::array::from_fn(|i| corner[i] + 0.5 * size[i]);
                (solid(&shape, middle)?, Some(shape), None)
            }
            Form::Cylinder { diameter, length } => {
                let shape = Shape::Cylinder(Cylinder {
                    radius_mm: 0.5 * diameter,
                    height_mm: *length,
                    bore_mm: 0.0,
                    fillet_mm: 0.0,
                    chamfer_mm: 0.0,
                });
                (solid(&shape, self.at.unwrap_or([0.0, 0.0, -length]))?, Some(shape), None)
            }
            Form::File(FileInUnit { path, unit }) => {
                let wrong = |why: &dyn std::fmt::Display| format!("{}: {why}", path.display());
                let bytes = rs274::file::bytes(path, LARGEST_FILE)
                    .map_err(|why| format!("{} (or give box:X,Y,Z or cylinder:DIAMETER,LENGTH)", wrong(&why)))?;
                let options = import::Options { unit: *unit, weld_mm: 0.0 };
                let imported = import::parse(path, &bytes, options).map_err(|why| wrong(&why))?;
                (imported.mesh, None, self.at)
            }
        };
        let at = at.unwrap_or_default();
        let link_from_part = link_from_work * Isometry::translation(at[0], at[1], at[2]);
        let range = |axis: usize| {
            let ends = mesh.vertices().iter().map(|v| v[axis] + at[axis]);
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        };
        let [x, y, z] = [0, 1, 2].map(range).map(|[low, high]| format!("{low:.3} to {high:.3}"));
        let place = format!("X {x}, Y {y}, Z {z} in G54");
        let part = Part {
            name: PART_NAME.to_owned(),
            mesh: Arc::new(mesh),
            link,
            link_from_part,
            shape: shape.map(Arc::new),
            role: Role::Workpiece,
            tool: None,
            groove_mm: 0.0,
            turns: None,
        };
        Ok((part, place))
    }
}

/// The mesh of a shape whose origin is at `at`, mm.
fn solid(shape: &Shape, at: [f64; 3]) -> Result<Mesh, String> {
    let (mut vertices, faces) = shape.mesh(&TESSELLATION).map_err(|error| error.to_string())?.into_parts();
    vertices.iter_mut().for_each(|vertex| *vertex += Vector::from(at));
    Mesh::new(vertices, faces).map_err(|error| error.to_string())
}

/// Parses N finite numbers, separated by commas.
///
/// # Errors
/// A message that repeats the text.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    let found = text.split(',').count();
    match <[f64; N]>::try_from(numbers) {
        Ok(numbers) if found == N && numbers.iter().all(|number| number.is_finite()) => Ok(numbers),
        _ => Err(format!("`{text}` must be {N} finite numbers with commas between them")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    #[test]
    fn the_frame_of_boxes_and_cylinders_is_that_of_g54() {
        let link_from_work = Isometry::translation(7.0, 8.0, 9.0);
        for (text, low, high) in [
            ("box:100,60,30", [-50.0, -30.0, -30.0], [50.0, 30.0, 0.0]),
            ("box:100,60,30@10,20,-40", [10.0, 20.0, -40.0], [110.0, 80.0, -10.0]),
            ("cylinder:50,120", [-25.0, -25.0, -120.0], [25.0, 25.0, 0.0]),
            ("cylinder:50,120@5,0,10", [-20.0, -25.0, 10.0], [30.0, 25.0, 130.0]),
        ] {
            let (part, _) = StockSpec::parse(text).unwrap().part(None, &link_from_work).unwrap();
            assert_eq!(part.link_from_part, link_from_work, "{text}");
            let vertices = part.mesh.vertices();
            let ends = vertices.iter().fold((vertices[0], vertices[0]), |(l, h), v| (l.inf(v), h.sup(v)));
            for (found, wanted) in [(ends.0, Point::from(low)), (ends.1, Point::from(high))] {
                assert!((found - wanted).amax() < 0.01, "{text}: {found}");
            }
        }
    }
}

//! Sizes and positions of parts, and warnings about likely wrong units and about meshes that are open or inside out.

use super::{Part, Scene};
use crate::geometry::Point;
use crate::machine::Poses;
use crate::truth::stray_components;

/// A part from a mesh file that is smaller than this across, mm, is more likely in metres or inches than in mm.
const TINY_MM: f64 = 5.0;
/// Smallest plausible size of all parts from mesh files together, mm across. A machine is larger; a model in metres or inches read as mm is
/// smaller.
const SMALL_MACHINE_MM: f64 = 100.0;

/// An axis-aligned bounding box in the world frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extents {
    /// Least coordinates.
    pub low: Point,
    /// Greatest coordinates.
    pub high: Point,
}

impl Extents {
    /// Lengths along X, Y and Z, mm.
    pub fn size(&self) -> [f64; 3] {
        (self.high - self.low).into()
    }

    /// The diagonal, mm.
    pub fn across_mm(&self) -> f64 {
        (self.high - self.low).norm()
    }

    /// The box around both boxes.
    pub fn with(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }
}

impl Scene {
    /// The box around a part when the links are at `poses`.
    pub fn extents(&self, part: usize, poses: &Poses) -> Extents {
        let world_from_part = self.world_from_part(part, poses);
        let mut corners = self.parts[part].mesh.vertices().iter().map(|vertex| world_from_part * vertex);
        let first = corners.next().unwrap_or_default();
        corners.fold(Extents { low: first, high: first }, |all, point| Extents {
            low: all.low.inf(&point),
            high: all.high.sup(&point),
        })
    }

    /// The poses of the links before the first move of the program.
    pub fn poses_at_start(&self) -> Poses {
        self.machine.forward(&self.program.as_ref().map(|run| run.start).unwrap_or_default())
    }

    /// Warnings about the meshes, one line each: units, holes, and surfaces that face inwards.
    pub fn mesh_warnings(&self) -> Vec<String> {
        let poses = self.poses_at_start();
        let from_file: Vec<(usize, Extents)> = (0..self.parts.len())
            .filter(|&part| self.parts[part].shape.is_none())
            .map(|part| (part, self.extents(part, &poses)))
            .collect();
        let mut warnings: Vec<String> =
            from_file.iter().filter_map(|(part, extents)| unit_warning(&self.parts[*part], extents)).collect();
        let whole = from_file.iter().map(|(_, extents)| *extents).reduce(|all, one| all.with(&one));
        if let (true, Some(whole)) = (warnings.is_empty() && from_file.len() > 1, whole)
            && whole.across_mm() < SMALL_MACHINE_MM
        {
            warnings.push(format!(
                "all parts from mesh files together are {} mm across: files in metres or inches? then give `unit = \"m\"` or `\"inch\"`",
                rounded(whole.across_mm())
            ));
        }
        for (part, _) in from_file {
            let Part { name, mesh, .. } = &self.parts[part];
            let report = mesh.surface_report();
            if report.is_inside_out() {
                warnings.push(format!(
                    "`{name}` is inside out: its volume is told as negative, and what it encloses counts as inside all the same"
                ));
            } else if report.leaking > 0 {
                warnings.push(format!("`{name}` is {report}: what lies wholly inside it is not found"));
            } else if report.inward > 0 {
                let strays = stray_components(mesh).len();
                if strays > 0 {
                    warnings.push(format!(
                        "`{name}` has components that face inwards and are not wholly inside one that faces outwards ({strays}): their volume is told as negative, and what they enclose counts as inside all the same"
                    ));
                }
            }
        }
        warnings
    }
}

/// A warning when a part is so small that its file is probably in another unit. A part that is too large is refused elsewhere, because the
/// coordinate grid ends at 4096 mm.
fn unit_warning(part: &Part, extents: &Extents) -> Option<String> {
    let (name, across) = (&part.name, extents.across_mm());
    let size = rounded(across);
    (across < TINY_MM).then(|| {
        let [metres, inches] = [rounded(across * 1000.0), rounded(across * 25.4)];
        format!(
            "`{name}` is {size} mm across: if its file is in metres ({metres} mm) or inches ({inches} mm), give `unit = \"m\"` or `\"inch\"`"
        )
    })
}

/// The number rounded to three significant digits.
fn rounded(mm: f64) -> String {
    let digits = (2 - mm.abs().max(1e-9).log10().floor() as i32).max(0);
    format!("{mm:.*}", digits as usize)
}

//! How large parts are and where they lie, and what that says of a mistaken unit; meshes that are open or inside out.

use super::{Part, Scene};
use crate::geometry::Point;
use crate::machine::Poses;

/// A mesh file whose part is smaller than this is in metres or inches more likely than in mm, mm across.
const TINY_MM: f64 = 5.0;
/// All parts from mesh files together are at least this far across, mm: a machine is, and its model in metres or inches read as mm is not.
const SMALL_MACHINE_MM: f64 = 100.0;

/// The box around something, along the axes of the world, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extents {
    /// Least coordinates.
    pub low: Point,
    /// Greatest coordinates.
    pub high: Point,
}

impl Extents {
    /// Lengths along X, Y and Z, mm.
    #[must_use]
    pub fn size(&self) -> [f64; 3] {
        (self.high - self.low).into()
    }

    /// The diagonal, mm.
    #[must_use]
    pub fn across_mm(&self) -> f64 {
        (self.high - self.low).norm()
    }

    /// Around both.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }
}

impl Scene {
    /// The box around a part when the links are at `poses`.
    #[must_use]
    pub fn extents(&self, part: usize, poses: &Poses) -> Extents {
        let world_from_part = self.world_from_part(part, poses);
        let mut corners = self.parts[part].mesh.vertices().iter().map(|vertex| world_from_part * vertex);
        let first = corners.next().unwrap_or_default();
        corners.fold(Extents { low: first, high: first }, |all, point| Extents {
            low: all.low.inf(&point),
            high: all.high.sup(&point),
        })
    }

    /// Where the links are before the program's first move.
    #[must_use]
    pub fn poses_at_start(&self) -> Poses {
        self.machine.forward(&self.program.as_ref().map(|run| run.start).unwrap_or_default())
    }

    /// What in the meshes should make a reader doubt: units, holes, surfaces that face inwards. A line each.
    #[must_use]
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
                    "`{name}` is inside out: turn its triangles round, or what lies inside it is misjudged"
                ));
            } else if report.leaking > 0 {
                warnings.push(format!("`{name}` is {report}: what lies wholly inside it is not found"));
            }
        }
        warnings
    }
}

/// A part that is so small that its file is in another unit more likely. One too large is refused: the grid of coordinates ends at 4096 mm.
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

/// Three digits.
fn rounded(mm: f64) -> String {
    let digits = (2 - mm.abs().max(1e-9).log10().floor() as i32).max(0);
    format!("{mm:.*}", digits as usize)
}

//! Parametric machine parts as watertight meshes; a scene file may describe a part by a shape in place of a mesh file.
//!
//! Reading order: [`Shape`] and [`Tessellation`]; [`outline`] (lines and arcs), [`revolve`], [`extrude`],
//! [`freeform`], [`rounded_box`], [`thread`], [`round`] (common solids by name), [`compound`].
//!
//! The tessellations are as nonuniform as those of real models: plane faces are a few large triangles, and fillets, holes and threads are
//! many small ones. This matters because bounding volumes that weight vertices and those that weight areas differ only on nonuniform
//! meshes. [`Tessellation::grading`] changes the nonuniformity while keeping the shape and, nearly, the number of triangles.

pub mod box_holes;
pub mod compound;
pub mod error;
pub mod extrude;
pub mod freeform;
pub mod outline;
pub mod revolve;
pub mod round;
pub mod rounded_box;
pub mod tessellation;
pub mod thread;
mod planar;
mod polygon;
mod solid;
#[cfg(test)]
mod tests;

pub use compound::{Compound, Member, Placement, Repeat};
pub use error::{Fault, ShapeError};
pub use extrude::Extrude;
pub use freeform::Freeform;
pub use revolve::Revolve;
pub use rounded_box::RoundedBox;
pub use tessellation::Tessellation;
pub use thread::Thread;

use super::{Isometry, Mesh};
use round::{Capsule, Cone, Cylinder, Sphere, Torus};
use serde::{Deserialize, Serialize};
use solid::Assembly;
use tessellation::{Sizing, balance};

/// A description of a solid, in mm and degrees, in the part's own frame. In files it is a table with a `kind`.
///
/// ```
/// use bvbench_scene::geometry::shapes::{Shape, Tessellation};
/// let shape: Shape = toml::from_str("kind = 'cylinder'\nradius_mm = 5\nheight_mm = 20").unwrap();
/// let mesh = shape.mesh(&Tessellation::default()).unwrap();
/// assert!(mesh.edge_report().is_watertight());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Shape {
    /// A profile turned about the z axis.
    Revolve(Revolve),
    /// An outline drawn out along z.
    Extrude(Extrude),
    /// A block with a free-form top.
    Freeform(Freeform),
    /// A cuboid with rounded edges and holes.
    RoundedBox(RoundedBox),
    /// A screw.
    Thread(Thread),
    /// A cylinder or tube.
    Cylinder(Cylinder),
    /// A cone or frustum.
    Cone(Cone),
    /// A sphere.
    Sphere(Sphere),
    /// A cylinder with half spheres at its ends.
    Capsule(Capsule),
    /// A ring torus.
    Torus(Torus),
    /// Several shapes combined into one.
    Compound(Compound),
}

impl Shape {
    /// The shape as a mesh. Every component is watertight, with outward winding and no triangle of zero area.
    ///
    /// # Errors
    /// [`ShapeError`] with the field and the cause, when a number is not finite or out of range, an outline is
    /// clockwise or meets itself, a fillet or hole does not fit, or there would be millions of triangles.
    pub fn mesh(&self, tessellation: &Tessellation) -> Result<Mesh, ShapeError> {
        self.assembly(tessellation)?.finish()
    }

    /// The number of triangles that [`Shape::mesh`] makes; faster than making the mesh.
    ///
    /// # Errors
    /// As [`Shape::mesh`], except for faults that only the finished mesh shows.
    pub fn triangle_count(&self, tessellation: &Tessellation) -> Result<usize, ShapeError> {
        Ok(self.assembly(tessellation)?.triangle_count())
    }

    fn assembly(&self, tessellation: &Tessellation) -> Result<Assembly, ShapeError> {
        tessellation.check()?;
        let assembled = |sizing: &Sizing| {
            let mut assembly = Assembly::default();
            self.assemble(sizing, &Isometry::identity(), 0, &mut assembly)?;
            Ok(assembly)
        };
        let factor = balance(tessellation, |sizing| assembled(sizing).map(|a| a.triangle_count()))?;
        assembled(&Sizing::new(tessellation, factor))
    }

    /// Adds the shape's components to `assembly`; `depth` is the number of enclosing compounds.
    fn assemble(
        &self,
        sizing: &Sizing,
        placement: &Isometry,
        depth: usize,
        assembly: &mut Assembly,
    ) -> Result<(), ShapeError> {
        let surface = match self {
            Self::Compound(compound) => return compound.assemble(sizing, placement, depth, assembly),
            Self::Revolve(revolve) => revolve.surface(sizing),
            Self::Extrude(extrude) => extrude.surface(sizing),
            Self::Freeform(freeform) => freeform.surface(sizing),
            Self::RoundedBox(rounded_box) => rounded_box.surface(sizing),
            Self::Thread(thread) => thread.surface(sizing),
            Self::Cylinder(cylinder) => cylinder.revolve()?.surface(sizing),
            Self::Cone(cone) => cone.revolve()?.surface(sizing),
            Self::Sphere(sphere) => sphere.revolve()?.surface(sizing),
            Self::Capsule(capsule) => capsule.revolve()?.surface(sizing),
            Self::Torus(torus) => torus.revolve()?.surface(sizing),
        };
        assembly.push(surface?, *placement)
    }
}

//! Ordered poses, where one helps the next.

use crate::collider::{Collider, Nearest};
use crate::engine::path::Memory;
use crate::engine::proximity::Proximity;
use crate::pair::Pair;
use crate::pose::PoseError;
use nalgebra::Isometry3;

/// Two colliders along a path: the same answers as [`Collider::collides`] and [`Collider::distance`], sooner where poses are near the one before.
///
/// Between two poses nothing is known: a path answers at the poses it is asked about, not for the motion.
///
/// ```
/// use obbtree::{Collider, Mesh, Path};
/// use obbtree::nalgebra::Isometry3;
///
/// let plate = Collider::new(Mesh::new([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]], [[0, 1, 2]])?);
/// let mut path = Path::new(&plate, &plate);
/// let touching = (0..=400).map(|i| path.collides(&Isometry3::translation(1.0, 1.0, f64::from(i) * 0.01 - 2.0)));
/// assert_eq!(touching.filter(|verdict| *verdict == Ok(true)).count(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Path {
    pair: Pair,
    memory: Memory,
    proximity: Proximity,
}

impl Path {
    /// A path of `b` in the frame of `a`.
    #[must_use]
    pub fn new(a: &Collider, b: &Collider) -> Self {
        Self { pair: Pair::new(a, b), memory: Memory::default(), proximity: Proximity::default() }
    }

    /// [`Collider::collides`] at the next pose.
    ///
    /// # Errors
    /// As [`Collider::collides`].
    pub fn collides(&mut self, a_from_b: &Isometry3<f64>) -> Result<bool, PoseError> {
        self.pair.collides_along(a_from_b, &mut self.memory)
    }

    /// [`Collider::distance`] at the next pose. Of several pairs of faces that are as near, it may name another; where they are many, 64 and more, the
    /// distance may differ from that of a single query by 10⁻¹² of it.
    ///
    /// # Errors
    /// As [`Collider::distance`].
    pub fn distance(&mut self, a_from_b: &Isometry3<f64>) -> Result<Nearest, PoseError> {
        let found = self.pair.distance_along(a_from_b, f64::INFINITY, &mut self.proximity)?;
        Ok(found.expect("two meshes have a distance"))
    }
}

//! Volumes stored in single precision: half the memory. They are rounded outward, and every test is made in double precision.
//!
//! Each number is rounded to single precision, and the volume is then enlarged, in double precision, by the displacement due to rounding,
//! so the stored volume contains the original. C. Ericson, "Real-Time Collision Detection", 2005, section 6.6.4, describes compact nodes. A
//! frame is stored as a unit quaternion and normalised when it is loaded. It is then a rotation to the last bits of double precision, so
//! the separating-axis test keeps its small epsilon.

use super::aligned_box::{AlignedBox, BoxTest};
use super::dop::{Directions, Dop};
use super::obb::Obb;
use super::sphere::Sphere;
use crate::geometry::{Isometry, Point, Triangle, Vector};
use crate::volume::{Segment, Shape, Solid};
use nalgebra::{Matrix3, Quaternion, Rotation3, Unit, UnitQuaternion};
use std::fmt::Debug;
use std::marker::PhantomData;

/// A shape that can be stored in single precision.
pub trait Storable: Shape {
    /// The stored form.
    type Stored: Clone + Debug + Send + Sync + 'static;
    /// Stores the volume; the stored volume contains the original.
    fn store(&self) -> Self::Stored;
    /// The stored volume in double precision.
    fn load(stored: &Self::Stored) -> Self;
}

/// A volume in single precision.
#[derive(Debug)]
pub struct Single<S: Storable> {
    stored: S::Stored,
}

impl<S: Storable> Single<S> {
    /// Stores the volume in single precision.
    pub fn new(volume: &S) -> Self {
        Self { stored: volume.store() }
    }

    #[inline(always)]
    fn load(&self) -> S {
        S::load(&self.stored)
    }
}

impl<S: Storable> Clone for Single<S> {
    fn clone(&self) -> Self {
        Self { stored: self.stored.clone() }
    }
}

impl<S: Storable> Shape for Single<S> {
    type Pose = S::Pose;

    #[inline]
    fn pose(a_from_b: &Isometry) -> Self::Pose {
        S::pose(a_from_b)
    }

    #[inline]
    fn overlaps(&self, other: &Self, pose: &Self::Pose) -> bool {
        self.load().overlaps(&other.load(), pose)
    }

    fn gap_mm(&self, other: &Self, pose: &Self::Pose) -> f64 {
        self.load().gap_mm(&other.load(), pose)
    }

    fn size(&self) -> f64 {
        self.load().size()
    }

    fn split_axes(&self, triangles: &[Triangle]) -> [Unit<Vector>; 3] {
        self.load().split_axes(triangles)
    }
}

impl<S: Storable> Solid for Single<S> {
    fn contains(&self, point: &Point, slack_mm: f64) -> bool {
        self.load().contains(point, slack_mm)
    }

    fn centre(&self) -> Point {
        self.load().centre()
    }

    fn volume(&self) -> f64 {
        self.load().volume()
    }

    fn surface_area(&self) -> f64 {
        self.load().surface_area()
    }

    fn outline(&self) -> Vec<Segment> {
        self.load().outline()
    }

    fn axes(&self) -> Matrix3<f64> {
        self.load().axes()
    }
}

/// The nearest number in single precision that is not below `x`.
fn up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

fn nearest(v: &Vector) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

fn double(v: &[f32; 3]) -> Vector {
    Vector::from(v.map(f64::from))
}

/// A centre and a radius, mm.
#[derive(Clone, Debug)]
pub struct StoredSphere {
    centre: [f32; 3],
    radius: f32,
}

impl Storable for Sphere {
    type Stored = StoredSphere;

    fn store(&self) -> StoredSphere {
        let centre = nearest(&self.centre.coords);
        StoredSphere { centre, radius: up(self.radius + (self.centre.coords - double(&centre)).norm()) }
    }

    fn load(stored: &StoredSphere) -> Self {
        Self { centre: Point::from(double(&stored.centre)), radius: f64::from(stored.radius) }
    }
}

/// A centre and half-lengths, mm.
#[derive(Clone, Debug)]
pub struct StoredAlignedBox {
    centre: [f32; 3],
    half: [f32; 3],
}

impl<T: BoxTest> Storable for AlignedBox<T> {
    type Stored = StoredAlignedBox;

    fn store(&self) -> StoredAlignedBox {
        let centre = nearest(&self.centre.coords);
        let half = self.half + (self.centre.coords - double(&centre)).abs();
        StoredAlignedBox { centre, half: [up(half.x), up(half.y), up(half.z)] }
    }

    fn load(stored: &StoredAlignedBox) -> Self {
        Self::new(Point::from(double(&stored.centre)), double(&stored.half))
    }
}

/// The slabs, mm.
#[derive(Clone, Debug)]
pub struct StoredDop<const K: usize> {
    high: [f32; K],
    negated_low: [f32; K],
}

impl<D: Directions<K>, const K: usize> Storable for Dop<D, K> {
    type Stored = StoredDop<K>;

    fn store(&self) -> StoredDop<K> {
        StoredDop { high: self.high.map(up), negated_low: self.negated_low.map(up) }
    }

    fn load(stored: &StoredDop<K>) -> Self {
        Self {
            high: stored.high.map(f64::from),
            negated_low: stored.negated_low.map(f64::from),
            directions: PhantomData,
        }
    }
}

/// A frame as a quaternion (i, j, k, w), a centre and half-lengths, mm.
#[derive(Clone, Debug)]
pub struct StoredObb {
    frame: [f32; 4],
    centre: [f32; 3],
    half: [f32; 3],
}

impl StoredObb {
    #[inline(always)]
    fn axes(&self) -> Matrix3<f64> {
        let [i, j, k, w] = self.frame.map(f64::from);
        UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k)).to_rotation_matrix().into_inner()
    }
}

impl Storable for Obb {
    type Stored = StoredObb;

    fn store(&self) -> StoredObb {
        let frame = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(self.axes));
        let frame = [frame.i as f32, frame.j as f32, frame.k as f32, frame.w as f32];
        let centre = nearest(&self.centre.coords);
        let mut stored = StoredObb { frame, centre, half: [0.0; 3] };
        // The extent of the original box along the stored axes, about the stored centre.
        let from_original = stored.axes().tr_mul(&self.axes);
        let shift = stored.axes().tr_mul(&(self.centre.coords - double(&centre)));
        let half = from_original.abs() * self.half + shift.abs();
        stored.half = [up(half.x), up(half.y), up(half.z)];
        stored
    }

    #[inline(always)]
    fn load(stored: &StoredObb) -> Self {
        Self { axes: stored.axes(), centre: Point::from(double(&stored.centre)), half: double(&stored.half) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::BoundingVolume;
    use crate::volume::aabb::Aabb;
    use crate::volume::dop_8::Dop8;
    use crate::volume::obb_area::ObbArea;
    use crate::volume::sphere_ritter::SphereRitter;
    use obbtree::cases::meshes;

    #[test]
    fn up_is_never_below() {
        assert_eq!(up(0.5), 0.5);
        assert_eq!(up(0.1), 0.1_f32); // 0.1 in single precision is 0.100000001...
        assert_eq!(up(0.7), 0.7_f32.next_up()); // and 0.7 is 0.699999988...
        assert_eq!(up(-0.1), (-0.1_f32).next_up());
    }

    #[test]
    fn a_stored_volume_takes_half_the_memory() {
        assert_eq!((size_of::<StoredSphere>(), size_of::<Sphere>()), (16, 32));
        assert_eq!((size_of::<StoredAlignedBox>(), size_of::<<Aabb as BoundingVolume>::Shape>()), (24, 48));
        assert_eq!((size_of::<StoredDop<4>>(), size_of::<<Dop8 as BoundingVolume>::Shape>()), (32, 64));
        assert_eq!((size_of::<StoredObb>(), size_of::<Obb>()), (40, 120));
    }

    /// The ratio of the stored volume's size to the original's; checks that the stored volume still contains the contents.
    fn stored<V: BoundingVolume<Shape: Storable>>(triangles: &[Triangle]) -> f64 {
        let volume = V::fit(triangles);
        let loaded = V::Shape::load(&volume.store());
        assert!(crate::geometry::triangle::corners(triangles).all(|corner| loaded.contains(corner, 0.0)));
        loaded.surface_area() / volume.surface_area()
    }

    #[test]
    fn storing_costs_little_even_far_from_the_origin() {
        let far = Isometry::new(Vector::new(3000.0, -2500.0, 3900.0), Vector::new(0.3, -1.1, 0.7));
        let triangles = meshes::moved(&meshes::stepped_tool(10, 6), 1.0, &far).triangles();
        // A step of single precision at 3900 is 2.4e-4 mm; the tool is 40 by 40 by 80 mm.
        for ratio in [
            stored::<SphereRitter>(&triangles),
            stored::<Aabb>(&triangles),
            stored::<Dop8>(&triangles),
            stored::<ObbArea>(&triangles),
        ] {
            assert!((1.0..1.0 + 1e-4).contains(&ratio), "{ratio}");
        }
    }
}

//! Axes found once are not sought again: the cells of one orientation and split fit their boxes to the same triangles, and the
//! search for the smallest box takes a hundred times as long as all else. Only while cells are counted; what is timed is
//! built in full.
//!
//! The key is a hash of the triangles in their order, on which rounding depends: whoever finds the axes first, they are the
//! same, so that results do not depend on the number of threads.

use crate::geometry::{Point, Triangle};
use crate::volume::fit::frame::FrameRule;
use nalgebra::Matrix3;
use std::any::TypeId;
use std::collections::HashMap;
use std::marker::PhantomData;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// An orientation rule that remembers.
#[derive(Clone, Copy, Debug)]
pub struct Remembered<F>(PhantomData<F>);

/// Rule and triangles.
type Key = (TypeId, [u8; 32]);

/// Mean and axes by key; `None` while nothing shall be remembered.
type Memory = Option<HashMap<Key, (Point, Matrix3<f64>)>>;

static MEMORY: Mutex<Memory> = Mutex::new(None);

/// Remembers from now on, and forgets everything when dropped.
#[derive(Debug)]
pub struct Remembering(());

impl Remembering {
    /// Begins with an empty memory.
    pub fn begin() -> Self {
        *memory() = Some(HashMap::new());
        Self(())
    }
}

impl Drop for Remembering {
    fn drop(&mut self) {
        *memory() = None;
    }
}

/// A thread that panicked while it held the memory left it whole: entries are inserted at once.
fn memory() -> MutexGuard<'static, Memory> {
    MEMORY.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<F: FrameRule + 'static> FrameRule for Remembered<F> {
    fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
        if memory().is_none() {
            return F::mean_and_axes(triangles);
        }
        let mut hasher = blake3::Hasher::new();
        for x in triangles.iter().flat_map(|t| t.corners).flat_map(|p| [p.x, p.y, p.z]) {
            hasher.update(&x.to_le_bytes());
        }
        let key = (TypeId::of::<F>(), *hasher.finalize().as_bytes());
        if let Some(found) = memory().as_ref().and_then(|memory| memory.get(&key)) {
            return *found;
        }
        let found = F::mean_and_axes(triangles);
        if let Some(memory) = memory().as_mut() {
            memory.insert(key, found);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::fit::frame::AreaCovariance;
    use obbtree::cases::meshes;
    use std::sync::atomic::{AtomicU32, Ordering};

    static SOUGHT: AtomicU32 = AtomicU32::new(0);

    /// Counts how often it is asked.
    struct Counted;

    impl FrameRule for Counted {
        fn mean_and_axes(triangles: &[Triangle]) -> (Point, Matrix3<f64>) {
            SOUGHT.fetch_add(1, Ordering::Relaxed);
            AreaCovariance::mean_and_axes(triangles)
        }
    }

    #[test]
    fn axes_are_sought_once_and_forgotten_in_the_end() {
        let triangles = meshes::stepped_tool(8, 4).triangles();
        let (all, some) = (triangles.as_slice(), &triangles[1..]);
        let find = |of: &[Triangle]| {
            let before = SOUGHT.load(Ordering::Relaxed);
            assert_eq!(Remembered::<Counted>::mean_and_axes(of), AreaCovariance::mean_and_axes(of));
            SOUGHT.load(Ordering::Relaxed) - before
        };
        let remembering = Remembering::begin();
        assert_eq!([find(all), find(all), find(some), find(all)], [1, 0, 1, 0]);
        drop(remembering);
        assert_eq!([find(all), find(all)], [1, 1]);
    }
}

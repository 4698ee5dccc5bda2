//! A cache of box axes. The cells of one orientation and split fit their boxes to the same triangles, and the search for the smallest box
//! takes a hundred times as long as everything else. The cache is used only while cells are counted; timed trees are built in full.
//!
//! The key is a hash of the triangles in their order, because rounding depends on that order. The axes are therefore the same whichever
//! thread computes them first, and results do not depend on the number of threads.

use crate::geometry::{Point, Triangle};
use nalgebra::Matrix3;
use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Mean (mm) and axes of the boxes around some triangles.
type Found = (Point, Matrix3<f64>);

/// Mean and axes by rule and by hash of the triangles.
#[derive(Debug, Default)]
pub struct Memory(Mutex<HashMap<(&'static str, [u8; 32]), Found>>);

impl Memory {
    /// The result of the rule `find`, named `rule`, for `triangles`; computed if it is not cached.
    pub fn recall(&self, rule: &'static str, triangles: &[Triangle], find: fn(&[Triangle]) -> Found) -> Found {
        let mut hasher = blake3::Hasher::new();
        for x in triangles.iter().flat_map(|t| t.corners).flat_map(|p| [p.x, p.y, p.z]) {
            hasher.update(&x.to_le_bytes());
        }
        let key = (rule, *hasher.finalize().as_bytes());
        if let Some(found) = self.entries().get(&key) {
            return *found;
        }
        // Not while the lock is held: finding takes long.
        let found = find(triangles);
        self.entries().insert(key, found);
        found
    }

    /// The locked entries. A thread that panicked while holding the lock left them valid, because an entry is inserted in one step.
    fn entries(&self) -> MutexGuard<'_, HashMap<(&'static str, [u8; 32]), Found>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::fit::frame::{AreaCovariance, FrameRule};
    use obbtree::cases::meshes;
    use std::sync::atomic::{AtomicU32, Ordering};

    static SOUGHT: AtomicU32 = AtomicU32::new(0);

    fn counted(triangles: &[Triangle]) -> Found {
        SOUGHT.fetch_add(1, Ordering::Relaxed);
        AreaCovariance::mean_and_axes(triangles)
    }

    #[test]
    fn axes_are_sought_once_for_each_rule_and_triangles() {
        let triangles = meshes::stepped_tool(8, 4).triangles();
        let (all, some, memory) = (triangles.as_slice(), &triangles[1..], Memory::default());
        let find = |rule, of: &[Triangle]| {
            let before = SOUGHT.load(Ordering::Relaxed);
            assert_eq!(memory.recall(rule, of, counted), AreaCovariance::mean_and_axes(of));
            SOUGHT.load(Ordering::Relaxed) - before
        };
        assert_eq!([find("a", all), find("a", all), find("a", some), find("b", all), find("a", all)], [1, 0, 1, 1, 0]);
    }
}

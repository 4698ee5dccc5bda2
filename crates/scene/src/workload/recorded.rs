//! Recorded poses, frame by frame.

use super::{PosedPair, block_of};
use crate::scene::{Pair, Recording};

/// At most `count` poses of one pair, spread evenly over the recording. Blocks of neighbouring poses are clusters.
pub fn poses(recording: &Recording, pair: Pair, count: usize) -> Vec<PosedPair> {
    let frames = recording.frames();
    let count = count.clamp(1, frames);
    let pose = |index: usize| {
        let frame = index * frames / count;
        let a_from_b = recording.pose(pair.a, frame).inv_mul(&recording.pose(pair.b, frame));
        PosedPair { a_from_b, cluster: block_of(index), line: None, depth_mm: None }
    };
    (0..count).map(pose).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Isometry;

    #[test]
    fn a_small_budget_keeps_poses_spread_over_the_whole() {
        let mut recording = Recording::new(&[Isometry::translation(1.0, 0.0, 0.0), Isometry::identity()]);
        for i in 0..10 {
            recording.begin_frame();
            recording.add(1, Isometry::translation(f64::from(i), 0.0, 0.0));
        }
        let x = |count| -> Vec<f64> {
            let poses = poses(&recording, Pair { a: 0, b: 1 }, count);
            poses.iter().map(|pose| pose.a_from_b.translation.x).collect()
        };
        assert_eq!(x(5), [-1.0, 1.0, 3.0, 5.0, 7.0]);
        assert_eq!(x(1000).len(), 10);
    }
}

//! How deep is a recorded contact? Unknown counts as deep.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use bvbench::geometry::Isometry;
use bvbench::record::vocabulary::Band;
use bvbench::truth::{PairOracle, path_depths};
use obbtree::cases::meshes;
use std::sync::Arc;

#[test]
fn a_recording_that_stands_still_inside_a_part_is_deep() {
    let sphere = Arc::new(meshes::sphere(10.0, 24, 12));
    let oracle = PairOracle::new(Arc::clone(&sphere), sphere);
    let standing = [Isometry::translation(10.0, 0.0, 0.0); 3];
    let depths = path_depths(&oracle, &standing, &standing.map(|pose| oracle.judge(&pose)));
    for depth in depths {
        assert_eq!(Band::of_depth(depth.unwrap()), Band::Deep);
    }
}

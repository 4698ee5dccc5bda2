//! Arrays of poses, answered on as many threads as there are.

use crate::pose::PoseError;
use rayon::prelude::*;
use std::fmt;

/// Poses that a thread answers at a time.
const CHUNK: usize = 32;

/// A pose of an array that cannot be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchError {
    /// The number of the pose in the array.
    pub index: usize,
    /// What is wrong with it.
    pub error: PoseError,
}

impl fmt::Display for BatchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "pose {}: {}", self.index, self.error)
    }
}

impl std::error::Error for BatchError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.error)
    }
}

/// The answer at each pose, or the first error in order.
pub(crate) fn each<P: Sync, T: Send>(
    poses: &[P],
    answer: impl Fn(&P) -> Result<T, PoseError> + Send + Sync,
) -> Result<Vec<T>, BatchError> {
    let numbered = |(index, answer): (usize, Result<T, PoseError>)| answer.map_err(|error| BatchError { index, error });
    map(poses, answer).into_iter().enumerate().map(numbered).collect()
}

/// The answer at each pose.
pub(crate) fn map<P: Sync, T: Send>(poses: &[P], answer: impl Fn(&P) -> T + Send + Sync) -> Vec<T> {
    poses.par_iter().with_min_len(CHUNK).map(answer).collect()
}

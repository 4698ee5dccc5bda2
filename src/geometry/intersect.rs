//! placeholder
use super::Triangle;
/// placeholder: bounds overlap.
#[must_use]
pub fn touch(a: &Triangle, b: &Triangle) -> bool {
    let ((al, ah), (bl, bh)) = (a.bounds(), b.bounds());
    (0..3).all(|i| al[i] <= bh[i] && bl[i] <= ah[i])
}

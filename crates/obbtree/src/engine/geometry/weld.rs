//! Welding: which vertices are merged.
//!
//! Every vertex gets the index of its representative: the earliest vertex with which it is merged, or its own index. [`equal`] merges equal
//! vertices. [`within`] merges near vertices: each goes to the earliest representative that is near enough, or becomes a representative
//! itself when there is none. Distances are measured to representatives only, so a chain of short steps never moves a vertex farther than
//! the tolerance.

use super::Point;
use foldhash::{HashMap, HashMapExt};
use std::collections::hash_map::Entry;

/// For every vertex, the index of the first vertex with the same coordinates; 0 and -0 are equal.
#[must_use]
pub fn equal(vertices: &[Point]) -> Vec<u32> {
    // A closed surface has two faces for each vertex, and a file of loose triangles so six corners.
    let mut first: HashMap<(u64, u64, u64), u32> = HashMap::with_capacity(vertices.len() / 4);
    let bits = |x: f64| (x + 0.0).to_bits();
    let keys = vertices.iter().map(|p| (bits(p.x), bits(p.y), bits(p.z)));
    keys.zip(0..).map(|(key, index)| *first.entry(key).or_insert(index)).collect()
}

/// For every vertex, the index of the first representative at most `tolerance` away, in the unit of the vertices. Coordinates must be
/// finite and at most 2⁶² times the tolerance.
///
/// Vertices are sorted into cells of the tolerance's width. Representatives are farther apart than the tolerance, so a cell holds at most
/// eight of them for any input, and 27 cells are searched.
#[must_use]
pub fn within(vertices: &[Point], tolerance: f64) -> Vec<u32> {
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(vertices.len() / 4);
    let mut stands_for = Vec::with_capacity(vertices.len());
    for (point, index) in vertices.iter().zip(0..) {
        let cell: [i64; 3] = point.coords.map(|x| (x / tolerance).floor() as i64).into();
        let near = neighbours(cell).filter_map(|cell| cells.get(&cell)).flatten().copied();
        let first = near.filter(|&i| (vertices[i as usize] - point).norm() <= tolerance).min();
        if first.is_none() {
            match cells.entry(cell) {
                Entry::Occupied(mut cell) => cell.get_mut().push(index),
                Entry::Vacant(cell) => drop(cell.insert(vec![index])),
            }
        }
        stands_for.push(first.unwrap_or(index));
    }
    stands_for
}

/// A cell and the 26 around it.
fn neighbours([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (-1..=1).flat_map(move |i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn row(x: &[f64]) -> Vec<Point> {
        x.iter().map(|&x| Point::new(x, 0.0, 0.0)).collect()
    }

    #[test]
    fn equal_vertices_go_to_the_first() {
        assert_eq!(equal(&row(&[1.0, 2.0, 1.0, 0.0, -0.0, 2.0])), [0, 1, 0, 3, 3, 1]);
    }

    #[test]
    fn near_vertices_go_to_the_first_that_stays_and_chains_break() {
        // 0.6 goes to 0; 1.2 is 0.6 from 0.6, which went, and 1.2 from 0, so it stays; 1.0 is near both and goes to 0.
        assert_eq!(within(&row(&[0.0, 0.6, 1.2, 1.0, 2.3]), 1.0), [0, 0, 2, 0, 4]);
        assert_eq!(within(&row(&[-0.4, 0.4]), 1.0), [0, 0]); // across a border of cells
    }

    proptest! {
        /// Compares with the definition: every vertex with every earlier one.
        #[test]
        fn cells_find_what_the_definition_says(
            points in prop::collection::vec([-3.0..3.0_f64, -3.0..3.0, -3.0..3.0], 1..60), tolerance in 0.1..2.0_f64,
        ) {
            let points: Vec<Point> = points.into_iter().map(Point::from).collect();
            let mut expected: Vec<u32> = Vec::new();
            for (i, point) in points.iter().enumerate() {
                let stays = |j: &usize| expected[*j] == *j as u32;
                let first = (0..i).filter(stays).find(|&j| (points[j] - point).norm() <= tolerance);
                expected.push(first.unwrap_or(i) as u32);
            }
            prop_assert_eq!(within(&points, tolerance), expected);
        }
    }
}

//! Turns, scales, mirrors and tilts of X, Y and Z: what stands between a program's coordinates and those of its work offset.

use super::offsets::Values9;

type Matrix = [[f64; 3]; 3];

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// `matrix` x + `origin`, invertible. Only X, Y and Z change.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Affine {
    matrix: Matrix,
    inverse: Matrix,
    origin: [f64; 3],
}

impl Affine {
    /// Turns by `degrees` about an axis (0 for X) through a point, counter-clockwise seen from the axis's positive end.
    pub fn rotation(axis: usize, degrees: f64, through: [f64; 3]) -> Self {
        Self::about(turn_matrix(axis, degrees), turn_matrix(axis, -degrees), through)
    }

    /// Scales each axis about a point, which stays; `None` when a factor is zero. A negative factor mirrors.
    pub fn scale(factors: [f64; 3], about: [f64; 3]) -> Option<Self> {
        let diagonal =
            |values: [f64; 3]| std::array::from_fn(|i| std::array::from_fn(|j| if i == j { values[i] } else { 0.0 }));
        let usable = factors.iter().all(|factor| factor.is_finite() && *factor != 0.0 && factor.recip().is_finite());
        usable.then(|| Self::about(diagonal(factors), diagonal(factors.map(f64::recip)), about))
    }

    /// A plane tilted by Euler's angles, degrees: about Z, about the X that results, about the Z that results; and its origin.
    pub fn tilted(angles: [f64; 3], origin: [f64; 3]) -> Self {
        let [first, second, third] = [(2, angles[0]), (0, angles[1]), (2, angles[2])];
        let product = |sign: f64, order: [(usize, f64); 3]| {
            order
                .into_iter()
                .fold(IDENTITY, |matrix, (axis, degrees)| times(&matrix, &turn_matrix(axis, sign * degrees)))
        };
        Self { matrix: product(1.0, [first, second, third]), inverse: product(-1.0, [third, second, first]), origin }
    }

    fn about(matrix: Matrix, inverse: Matrix, fixed: [f64; 3]) -> Self {
        let moved = applied(&matrix, fixed);
        Self { matrix, inverse, origin: std::array::from_fn(|i| fixed[i] - moved[i]) }
    }

    /// This one after `first`.
    pub fn after(&self, first: &Self) -> Self {
        let moved = applied(&self.matrix, first.origin);
        Self {
            matrix: times(&self.matrix, &first.matrix),
            inverse: times(&first.inverse, &self.inverse),
            origin: std::array::from_fn(|i| moved[i] + self.origin[i]),
        }
    }

    pub fn apply(&self, values: &mut Values9) {
        self.apply_linear(values);
        for (value, origin) in values.iter_mut().zip(self.origin) {
            *value += origin;
        }
    }

    pub fn apply_linear(&self, values: &mut Values9) {
        [values[0], values[1], values[2]] = applied(&self.matrix, [values[0], values[1], values[2]]);
    }

    /// The opposite of [`Self::apply`].
    pub fn undo(&self, values: &mut Values9) {
        let from = std::array::from_fn(|i| values[i] - self.origin[i]);
        [values[0], values[1], values[2]] = applied(&self.inverse, from);
    }

    /// At least the most by which a length grows: Frobenius' norm.
    pub fn norm(&self) -> f64 {
        self.matrix.iter().flatten().map(|x| x * x).sum::<f64>().sqrt()
    }
}

fn applied(matrix: &Matrix, vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn turn_matrix(axis: usize, degrees: f64) -> Matrix {
    let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
    // Quarter turns are exact.
    let (sin, cos) = match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => degrees.to_radians().sin_cos(),
    };
    let mut matrix = IDENTITY;
    (matrix[first][first], matrix[second][second]) = (cos, cos);
    (matrix[second][first], matrix[first][second]) = (sin, -sin);
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(affine: &Affine, point: [f64; 3]) -> [f64; 3] {
        let mut values = [point[0], point[1], point[2], 7.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        affine.apply(&mut values);
        let moved = [values[0], values[1], values[2]];
        affine.undo(&mut values);
        assert!(values.iter().zip(point).all(|(a, b)| (a - b).abs() < 1e-12) && values[3] == 7.0);
        moved
    }

    #[test]
    fn a_turn_keeps_its_centre_and_a_scale_its_point() {
        assert_eq!(at(&Affine::rotation(2, 90.0, [1.0, 0.0, 0.0]), [3.0, 0.0, 5.0]), [1.0, 2.0, 5.0]);
        assert_eq!(at(&Affine::rotation(0, 90.0, [0.0; 3]), [3.0, 1.0, 0.0]), [3.0, 0.0, 1.0]);
        assert_eq!(at(&Affine::scale([2.0, -1.0, 1.0], [1.0, 1.0, 0.0]).unwrap(), [2.0, 3.0, 4.0]), [3.0, -1.0, 4.0]);
        assert_eq!(Affine::scale([0.0, 1.0, 1.0], [0.0; 3]), None);
        let both = Affine::rotation(2, 90.0, [0.0; 3]).after(&Affine::scale([2.0, 1.0, 1.0], [0.0; 3]).unwrap());
        assert_eq!(at(&both, [1.0, 1.0, 0.0]), [-1.0, 2.0, 0.0]);
    }

    #[test]
    fn a_tilted_plane_turns_about_z_then_x_then_z() {
        // By 90 about Z the new X is Y; by 90 about that the new Z is X; by 90 about that the new X is Z.
        let tilted = Affine::tilted([90.0, 90.0, 90.0], [10.0, 0.0, 0.0]);
        assert_eq!(at(&tilted, [1.0, 0.0, 0.0]), [10.0, 0.0, 1.0]);
        assert_eq!(at(&tilted, [0.0, 0.0, 1.0]), [11.0, 0.0, 0.0]);
    }
}

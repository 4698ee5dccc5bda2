//! Arrays of numbers as text: little-endian, base64. A reader in any language gets them back with two calls.

use crate::geometry::{Point, Vector};
use base64::prelude::{BASE64_STANDARD, Engine};
use serde::{Serialize, Serializer};

/// Numbers as they go into JSON.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Packed(Vec<u8>);

impl Serialize for Packed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&BASE64_STANDARD.encode(&self.0))
    }
}

impl Packed {
    /// Bytes.
    pub fn u8(values: impl IntoIterator<Item = u8>) -> Self {
        Self(values.into_iter().collect())
    }

    /// Unsigned numbers of 16 bits.
    pub fn u16(values: impl IntoIterator<Item = u16>) -> Self {
        Self(values.into_iter().flat_map(u16::to_le_bytes).collect())
    }

    /// Unsigned numbers of 32 bits.
    pub fn u32(values: impl IntoIterator<Item = u32>) -> Self {
        Self(values.into_iter().flat_map(u32::to_le_bytes).collect())
    }

    /// Numbers in single precision.
    pub fn f32(values: impl IntoIterator<Item = f64>) -> Self {
        Self(values.into_iter().flat_map(|value| (value as f32).to_le_bytes()).collect())
    }
}

/// A grid of 2¹⁶ steps along each coordinate over a box: 6 bytes a point. In a box of a metre a step is 0.015 mm, which no screen
/// shows.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    /// The box's lowest corner, mm.
    pub low: Point,
    /// A step, mm; 0 where the box is flat.
    pub step: Vector,
}

impl Lattice {
    /// The grid over the bounds of some points, mm; about the origin without any.
    pub fn over<'a>(points: impl Iterator<Item = &'a Point> + Clone) -> Self {
        let low = points.clone().copied().reduce(|low, p| low.inf(&p)).unwrap_or_default();
        let high = points.copied().reduce(|high, p| high.sup(&p)).unwrap_or_default();
        Self { low, step: (high - low) / f64::from(u16::MAX) }
    }

    /// The nearest place of the grid.
    pub fn place(&self, point: &Point) -> [u16; 3] {
        let along = |axis: usize| match self.step[axis] {
            step if step > 0.0 => ((point[axis] - self.low[axis]) / step).round() as u16,
            _ => 0,
        };
        [0, 1, 2].map(along)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_become_text() {
        // 1, 256 in little-endian are the bytes 01 00 00 01, in base64 000000 010000 000000 000000 01(0000) = AQAAAQ==.
        assert_eq!(serde_json::to_string(&Packed::u16([1, 256])).unwrap(), "\"AQAAAQ==\"");
        // 1.0 in single precision is 3f80 0000.
        assert_eq!(Packed::f32([1.0]).0, [0, 0, 0x80, 0x3f]);
    }

    #[test]
    fn the_lattice_spans_its_points() {
        let points = [Point::new(-5.0, 2.0, 7.0), Point::new(5.0, 4.0, 7.0), Point::new(0.0, 3.0, 7.0)];
        let lattice = Lattice::over(points.iter());
        assert_eq!(lattice.place(&points[0]), [0, 0, 0]);
        assert_eq!(lattice.place(&points[1]), [65_535, 65_535, 0]);
        assert_eq!(lattice.place(&points[2]), [32_768, 32_768, 0]); // 32767.5, rounded away from zero
        assert_eq!(Lattice::over(std::iter::empty()).place(&Point::origin()), [0, 0, 0]);
    }
}

//! Errors in the description of a shape: the field, by its path in the description, and the cause.

use super::super::{MeshError, surface::EdgeReport};
use thiserror::Error;

/// The path of a field of a shape, and what is wrong with the field.
#[derive(Debug, Error, PartialEq)]
#[error("{field}: {fault}")]
pub struct ShapeError {
    /// Path of the field, as in `parts[2].shape.outline_mm[3]`.
    pub field: String,
    /// What is wrong.
    pub fault: Fault,
}

/// A fault of a field. Lengths are in mm.
#[derive(Debug, Error, PartialEq)]
pub enum Fault {
    /// NaN or infinite.
    #[error("{0} is not a finite number")]
    NotFinite(f64),
    /// Outside the permitted interval.
    #[error("{value} is outside {low} to {high}")]
    OutOfRange {
        /// The value given.
        value: f64,
        /// The smallest permitted.
        low: f64,
        /// The largest permitted.
        high: f64,
    },
    /// Too few points to enclose an area.
    #[error("{0} points enclose no area")]
    TooFewPoints(usize),
    /// A row of a control net with another length than the first row.
    #[error("the row has {found} numbers, the first one {expected}")]
    Ragged {
        /// Length of the row.
        found: usize,
        /// Length of the first row.
        expected: usize,
    },
    /// Two successive points coincide.
    #[error("the point coincides with the next one")]
    Coincident,
    /// The outline runs clockwise.
    #[error("the outline runs clockwise; list its points counter-clockwise")]
    Clockwise,
    /// Two edges of the outlines cross or touch.
    #[error("the outline touches or crosses itself or another near ({x}, {y})")]
    Crossing {
        /// First coordinate of one end of one of the edges.
        x: f64,
        /// Its second coordinate.
        y: f64,
    },
    /// A fillet or chamfer needs more of an edge than its length.
    #[error("the corner needs {needed} mm of an edge that has {available} mm to give")]
    CornerTooLarge {
        /// Length that the corners at both ends of the edge need together.
        needed: f64,
        /// Length of the edge.
        available: f64,
    },
    /// A fillet or chamfer on a corner where an arc begins or ends.
    #[error("a fillet or chamfer needs straight edges on both sides")]
    CornerOnArc,
    /// A corner with both a fillet and a chamfer.
    #[error("a corner has a fillet or a chamfer, not both")]
    FilletAndChamfer,
    /// An arc whose radius is less than half its chord.
    #[error("an arc of radius {radius} mm cannot span {chord} mm")]
    ArcTooSmall {
        /// The radius given.
        radius: f64,
        /// The distance between the ends of the arc.
        chord: f64,
    },
    /// A profile that crosses its axis of revolution.
    #[error("the profile reaches r = {0} mm, across the axis")]
    AcrossAxis(f64),
    /// A rim whose fillet or chamfer leaves nothing of the outline.
    #[error("a rim {0} mm wide is wider than the outline allows")]
    RimTooWide(f64),
    /// A hole that does not lie within its face or outline.
    #[error("the hole is not inside {0}")]
    HoleOutside(&'static str),
    /// Two holes that meet.
    #[error("the hole meets {0}")]
    HolesMeet(String),
    /// A compound without members, or a repetition with a count of zero.
    #[error("there is nothing in it")]
    Empty,
    /// Compounds that are nested too deeply.
    #[error("compounds are nested more than {0} deep")]
    TooDeep(usize),
    /// More triangles than the limit of a shape.
    #[error("this would take more than {0} triangles")]
    TooManyTriangles(usize),
    /// The triangles are finer than the coordinate grid, or the solid is thinner than its own tessellation.
    #[error("the tessellation is not sound ({edges:?}, {without_area} triangles without area, volume {volume} mm³)")]
    Unsound {
        /// Report on how the edges fit together.
        edges: EdgeReport,
        /// Triangles without area.
        without_area: usize,
        /// Enclosed volume, mm³.
        volume: f64,
    },
    /// The mesh was refused.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl Fault {
    /// An error with this fault, at the given field.
    pub(super) fn at(self, field: impl Into<String>) -> ShapeError {
        ShapeError { field: field.into(), fault: self }
    }
}

impl ShapeError {
    /// The same error, with the path of its field prefixed by `outer`.
    pub(super) fn inside(self, outer: &str) -> Self {
        Self { field: format!("{outer}.{}", self.field), fault: self.fault }
    }
}

/// Smallest length in a description, mm: 1 µm, about 67 000 steps of the coordinate grid, so that even a finely divided feature is much
/// larger than a grid step.
pub(super) const SMALLEST_MM: f64 = 1e-3;
/// Largest length in a description, mm: the whole range of the coordinate grid.
pub(super) const LARGEST_MM: f64 = 2.0 * super::super::grid::LIMIT_MM;

/// Returns `value` if it is finite and in `low..=high`.
pub(super) fn within(field: &str, value: f64, low: f64, high: f64) -> Result<f64, ShapeError> {
    if !value.is_finite() {
        Err(Fault::NotFinite(value).at(field))
    } else if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(Fault::OutOfRange { value, low, high }.at(field))
    }
}

/// Returns `value`, mm, if it is a permitted length of a feature.
pub(super) fn length(field: &str, value: f64) -> Result<f64, ShapeError> {
    within(field, value, SMALLEST_MM, LARGEST_MM)
}

/// Returns `value`, mm, if it is zero (no such feature) or a permitted length of a feature.
pub(super) fn length_or_zero(field: &str, value: f64) -> Result<f64, ShapeError> {
    if value == 0.0 { Ok(0.0) } else { length(field, value) }
}

/// Returns `values`, mm, if they are permitted coordinates of a mesh.
pub(super) fn coordinates<const N: usize>(field: &str, values: [f64; N]) -> Result<[f64; N], ShapeError> {
    for value in values {
        within(field, value, -LARGEST_MM, LARGEST_MM)?;
    }
    Ok(values)
}

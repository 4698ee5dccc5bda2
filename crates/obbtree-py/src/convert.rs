//! From arrays to points, faces and poses, and back.

use numpy::{Element, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use obbtree::nalgebra::{Isometry3, Point3};
use obbtree::{BatchError, ManagerError, pose_from_matrix};
use pyo3::exceptions::{PyKeyError, PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::fmt::Display;

/// Bad values become a `ValueError` with the message of the cause.
pub fn value_error(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Names that are not there become a `KeyError`, bad values a `ValueError`.
pub fn manager_error(error: ManagerError) -> PyErr {
    match error {
        ManagerError::NoSuchObject(name) => PyKeyError::new_err(name),
        other => value_error(other),
    }
}

/// How many answers are wanted at most: all where there is no limit, or more than can be counted.
pub fn limit(limit: Option<&Bound<'_, PyAny>>) -> PyResult<usize> {
    let Some(limit) = limit else { return Ok(usize::MAX) };
    if limit.lt(0)? {
        return Err(value_error(format!("the limit is {limit}; it cannot be negative")));
    }
    match limit.extract::<usize>() {
        Err(error) if error.is_instance_of::<PyOverflowError>(limit.py()) => Ok(usize::MAX),
        found => found,
    }
}

/// A length that distances are compared with; it may be infinite.
pub fn length(length: f64) -> PyResult<f64> {
    if length.is_nan() { Err(value_error("the length is nan, not a number")) } else { Ok(length) }
}

/// Anything like an array, as numbers of a type with their shape. In one piece and aligned, for strides are counted in whole numbers; a field of packed
/// records has others, and is copied.
fn array<T: Element + Copy>(data: &Bound<'_, PyAny>, dtype: &str) -> PyResult<(Vec<usize>, Vec<T>)> {
    let array = data.py().import("numpy")?.call_method1("require", (data, dtype, "CAE"))?;
    let array: PyReadonlyArrayDyn<T> = array.extract()?;
    Ok((array.shape().to_vec(), array.as_array().iter().copied().collect()))
}

fn numbers(data: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<f64>)> {
    array(data, "float64")
}

/// An array of shape (n, 3).
pub fn points(data: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    match numbers(data)? {
        (shape, numbers) if shape.len() == 2 && shape[1] == 3 => Ok(numbers.as_chunks::<3>().0.to_vec()),
        (shape, _) => Err(value_error(format!("vertices have shape {shape:?}; (n, 3) is expected"))),
    }
}

/// An array of integers of shape (n, 3).
pub fn faces(data: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    let array = data.py().import("numpy")?.call_method1("asarray", (data,))?;
    let untyped = array.cast::<PyUntypedArray>()?;
    let (shape, kind) = (untyped.shape().to_vec(), untyped.dtype().getattr("kind")?.extract::<char>()?);
    // An array without numbers has no type that counts.
    if !shape.contains(&0) && !['i', 'u'].contains(&kind) {
        return Err(PyTypeError::new_err("faces are not integers"));
    }
    if shape.contains(&0) {
        return Ok(Vec::new());
    }
    if shape.len() != 2 || shape[1] != 3 {
        return Err(value_error(format!("faces have shape {shape:?}; (n, 3) is expected")));
    }
    let (_, numbers) = self::array::<i64>(&array, "int64")?;
    let numbers = numbers.into_iter().map(u32::try_from).collect::<Result<Vec<u32>, _>>();
    let numbers = numbers.map_err(|_| value_error("a face has a negative vertex, or one above 4294967295"))?;
    Ok(numbers.as_chunks::<3>().0.to_vec())
}

fn rows(numbers: &[f64; 16]) -> [[f64; 4]; 4] {
    [0, 4, 8, 12].map(|row| [numbers[row], numbers[row + 1], numbers[row + 2], numbers[row + 3]])
}

/// A 4 × 4 matrix; no motion where there is none.
pub fn pose(data: Option<&Bound<'_, PyAny>>) -> PyResult<Isometry3<f64>> {
    let Some(data) = data else { return Ok(Isometry3::identity()) };
    match numbers(data)? {
        (shape, numbers) if shape == [4, 4] => {
            pose_from_matrix(rows(&numbers.as_chunks::<16>().0[0])).map_err(value_error)
        }
        (shape, _) => Err(value_error(format!("the pose has shape {shape:?}; (4, 4) is expected"))),
    }
}

/// An array of shape (n, 4, 4).
pub fn poses(data: &Bound<'_, PyAny>) -> PyResult<Vec<Isometry3<f64>>> {
    match numbers(data)? {
        (shape, numbers) if shape.len() == 3 && shape[1..] == [4, 4] => {
            let pose = |(index, numbers): (usize, &[f64; 16])| {
                pose_from_matrix(rows(numbers)).map_err(|error| value_error(BatchError { index, error }))
            };
            numbers.as_chunks::<16>().0.iter().enumerate().map(pose).collect()
        }
        (shape, _) => Err(value_error(format!("the poses have shape {shape:?}; (n, 4, 4) is expected"))),
    }
}

/// An array of shape (n, k, 4, 4), row by row, with a pose for each of k names.
pub fn pose_rows(data: &Bound<'_, PyAny>, names: &[String]) -> PyResult<Vec<Vec<Isometry3<f64>>>> {
    let k = names.len();
    match numbers(data)? {
        (shape, numbers) if shape.len() == 4 && shape[1..] == [k, 4, 4] => {
            let matrices = numbers.as_chunks::<16>().0;
            let pose = |row: usize, name: &String, matrix: &[f64; 16]| {
                let in_row = |error| manager_error(ManagerError::PoseInRow { row, name: name.clone(), error });
                pose_from_matrix(rows(matrix)).map_err(in_row)
            };
            let of_row = |row: usize| {
                let matrices = &matrices[row * k..(row + 1) * k];
                names.iter().zip(matrices).map(|(name, matrix)| pose(row, name, matrix)).collect()
            };
            (0..shape[0]).map(of_row).collect()
        }
        (shape, _) => Err(value_error(format!("the poses have shape {shape:?}; (n, {k}, 4, 4) is expected"))),
    }
}

/// A pose as a 4 × 4 matrix, row by row.
pub fn matrix(pose: &Isometry3<f64>) -> Vec<Vec<f64>> {
    let matrix = pose.to_homogeneous();
    (0..4).map(|i| (0..4).map(|j| matrix[(i, j)]).collect()).collect()
}

/// Coordinates, point by point.
pub fn coordinates(points: &[Point3<f64>]) -> Vec<Vec<f64>> {
    points.iter().map(|p| vec![p.x, p.y, p.z]).collect()
}

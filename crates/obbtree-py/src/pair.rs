//! Meshes, colliders and paths.

use crate::convert::{self, coordinates, faces, points, pose, poses, value_error};
use crate::threads::released;
use numpy::{PyArray1, PyArray2, PyArray3};
use obbtree::nalgebra::Point3;
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Vertices and faces, in any unit of length.
#[pyclass(frozen, module = "obbtree")]
pub struct Mesh(pub obbtree::Mesh);

#[pymethods]
impl Mesh {
    #[new]
    fn new(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<Self> {
        obbtree::Mesh::new(points(vertices)?, self::faces(faces)?).map(Self).map_err(value_error)
    }

    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &coordinates(self.0.vertices()))
    }

    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        array(py, &self.0.faces().iter().map(|face| face.to_vec()).collect::<Vec<_>>())
    }

    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &coordinates(&self.0.bounds()))
    }

    fn __repr__(&self) -> String {
        format!("<obbtree.Mesh of {} vertices and {} faces>", self.0.vertices().len(), self.0.faces().len())
    }
}

/// An array of rows of three; of shape (0, 3) where there is none.
fn array<'py, T: numpy::Element>(py: Python<'py>, rows: &[Vec<T>]) -> PyResult<Bound<'py, PyArray2<T>>> {
    if rows.is_empty() {
        return Ok(PyArray2::zeros(py, [0, 3], false));
    }
    PyArray2::from_vec2(py, rows).map_err(value_error)
}

/// A mesh with the tree that queries need.
#[pyclass(frozen, module = "obbtree")]
#[derive(Clone)]
pub struct Collider(pub obbtree::Collider);

/// A mesh of ours, or anything that has vertices and faces.
pub fn mesh_of(mesh: &Bound<'_, PyAny>) -> PyResult<obbtree::Mesh> {
    match mesh.cast::<Mesh>() {
        Ok(mesh) => Ok(mesh.get().0.clone()),
        Err(_) => Ok(Mesh::new(&mesh.getattr("vertices")?, &mesh.getattr("faces")?)?.0),
    }
}

#[pymethods]
impl Collider {
    #[new]
    fn new(py: Python<'_>, mesh: &Bound<'_, PyAny>) -> PyResult<Self> {
        let mesh = mesh_of(mesh)?;
        Ok(Self(released(py, || obbtree::Collider::new(mesh))))
    }

    #[getter]
    fn mesh(&self) -> Mesh {
        Mesh(self.0.mesh().clone())
    }

    #[pyo3(signature = (other, pose = None))]
    fn collides(&self, py: Python<'_>, other: &Self, pose: Option<&Bound<'_, PyAny>>) -> PyResult<bool> {
        let pose = self::pose(pose)?;
        released(py, || self.0.collides(&other.0, &pose)).map_err(value_error)
    }

    #[pyo3(signature = (other, pose = None, limit = None))]
    fn contacts(
        &self,
        py: Python<'_>,
        other: &Self,
        pose: Option<&Bound<'_, PyAny>>,
        limit: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Contacts> {
        let (pose, limit) = (self::pose(pose)?, convert::limit(limit)?);
        released(py, || self.0.contacts(&other.0, &pose, limit)).map(Contacts).map_err(value_error)
    }

    #[pyo3(signature = (other, pose = None))]
    fn distance(&self, py: Python<'_>, other: &Self, pose: Option<&Bound<'_, PyAny>>) -> PyResult<Nearest> {
        let pose = self::pose(pose)?;
        released(py, || self.0.distance(&other.0, &pose)).map(Nearest).map_err(value_error)
    }

    fn distance_below(
        &self,
        py: Python<'_>,
        other: &Self,
        pose: Option<&Bound<'_, PyAny>>,
        limit: f64,
    ) -> PyResult<Option<Nearest>> {
        let (pose, limit) = (self::pose(pose)?, convert::length(limit)?);
        let found = released(py, || self.0.distance_below(&other.0, &pose, limit)).map_err(value_error)?;
        Ok(found.map(Nearest))
    }

    fn collides_each<'py>(
        &self,
        py: Python<'py>,
        other: &Self,
        poses: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let poses = self::poses(poses)?;
        let verdicts = released(py, || self.0.collides_each(&other.0, &poses)).map_err(value_error)?;
        Ok(PyArray1::from_vec(py, verdicts))
    }

    #[expect(clippy::type_complexity, reason = "three arrays, as Python has them")]
    fn distance_each<'py>(
        &self,
        py: Python<'py>,
        other: &Self,
        poses: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<u32>>)> {
        let poses = self::poses(poses)?;
        let found = released(py, || self.0.distance_each(&other.0, &poses)).map_err(value_error)?;
        if found.is_empty() {
            let none = PyArray1::zeros(py, 0, false);
            return Ok((none, PyArray3::zeros(py, [0, 2, 3], false), PyArray2::zeros(py, [0, 2], false)));
        }
        let distances = PyArray1::from_iter(py, found.iter().map(|nearest| nearest.distance));
        let points: Vec<_> = found.iter().map(|nearest| coordinates(&nearest.points)).collect();
        let faces: Vec<_> = found.iter().map(|nearest| nearest.faces.to_vec()).collect();
        Ok((
            distances,
            PyArray3::from_vec3(py, &points).map_err(value_error)?,
            PyArray2::from_vec2(py, &faces).map_err(value_error)?,
        ))
    }

    #[getter]
    fn bytes(&self) -> usize {
        self.0.bytes()
    }

    fn __repr__(&self) -> String {
        format!("<obbtree.Collider of {} faces>", self.0.mesh().faces().len())
    }
}

/// The nearest points of two meshes.
#[pyclass(frozen, module = "obbtree")]
pub struct Nearest(pub obbtree::Nearest);

#[pymethods]
impl Nearest {
    #[getter]
    fn distance(&self) -> f64 {
        self.0.distance
    }

    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, &coordinates(&self.0.points))
    }

    #[getter]
    fn faces(&self) -> (u32, u32) {
        self.0.faces.into()
    }

    fn __repr__(&self) -> String {
        format!("<obbtree.Nearest distance={:?} faces={:?}>", self.0.distance, self.0.faces)
    }
}

/// Pairs of triangles that touch.
#[pyclass(frozen, module = "obbtree")]
pub struct Contacts(pub Vec<obbtree::Contact>);

#[pymethods]
impl Contacts {
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        if self.0.is_empty() {
            return Ok(PyArray2::zeros(py, [0, 2], false));
        }
        let faces: Vec<_> = self.0.iter().map(|contact| contact.faces.to_vec()).collect();
        PyArray2::from_vec2(py, &faces).map_err(value_error)
    }

    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points: Vec<Point3<f64>> = self.0.iter().map(|contact| contact.point).collect();
        array(py, &coordinates(&points))
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    fn __repr__(&self) -> String {
        format!("<obbtree.Contacts of {} pairs>", self.0.len())
    }
}

/// Two colliders along a path.
#[pyclass(frozen, module = "obbtree")]
pub struct Path {
    colliders: [obbtree::Collider; 2],
    /// The path, unless a thread asks it. As a manager's, its lock is held for an instant, by a thread that has the interpreter.
    idle: Mutex<Option<obbtree::Path>>,
}

impl Path {
    /// With the path, or a new one where another thread has it, or had it when this process was forked.
    fn with<T: Send>(&self, py: Python<'_>, ask: impl FnOnce(&mut obbtree::Path) -> T + Send) -> T {
        let idle = || self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = idle().take();
        let (answer, path) = released(py, || {
            let [a, b] = &self.colliders;
            let mut path = taken.unwrap_or_else(|| obbtree::Path::new(a, b));
            (ask(&mut path), path)
        });
        *idle() = Some(path);
        answer
    }
}

#[pymethods]
impl Path {
    #[new]
    fn new(py: Python<'_>, a: &Collider, b: &Collider) -> Self {
        // It may have to make a tree.
        let path = released(py, || obbtree::Path::new(&a.0, &b.0));
        Self { colliders: [a.0.clone(), b.0.clone()], idle: Mutex::new(Some(path)) }
    }

    fn collides(&self, py: Python<'_>, pose: &Bound<'_, PyAny>) -> PyResult<bool> {
        let pose = self::pose(Some(pose))?;
        self.with(py, |path| path.collides(&pose)).map_err(value_error)
    }

    fn distance(&self, py: Python<'_>, pose: &Bound<'_, PyAny>) -> PyResult<Nearest> {
        let pose = self::pose(Some(pose))?;
        self.with(py, |path| path.distance(&pose)).map(Nearest).map_err(value_error)
    }
}

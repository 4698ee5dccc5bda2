//! Managers of named objects.

use crate::convert::{self, manager_error, matrix, pose, pose_rows, value_error};
use crate::pair::{Collider, Contacts, Nearest};
use crate::threads::released;
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

type Names = (String, String);

fn owned([first, second]: [&str; 2]) -> Names {
    (first.to_owned(), second.to_owned())
}

/// Named colliders with poses in one world, and the pairs of them that are not asked about.
// The lock is held for an instant, by a thread that has the interpreter: no process is forked meanwhile, and no child waits for a thread that it does not
// have.
#[pyclass(frozen, module = "obbtree")]
#[derive(Default)]
pub struct Manager(Mutex<Arc<obbtree::Manager>>);

impl Manager {
    /// The manager, for one who has the interpreter.
    fn held(&self, _: Python<'_>) -> MutexGuard<'_, Arc<obbtree::Manager>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The manager as it is now: what changes it later changes a copy, which shares all meshes.
    fn now(&self, py: Python<'_>) -> Arc<obbtree::Manager> {
        self.held(py).clone()
    }

    fn ask<T: Send>(&self, py: Python<'_>, query: impl FnOnce(&obbtree::Manager) -> T + Send) -> T {
        let now = self.now(py);
        released(py, || query(&now))
    }

    fn change<T>(&self, py: Python<'_>, change: impl FnOnce(&mut obbtree::Manager) -> T) -> T {
        change(Arc::make_mut(&mut self.held(py)))
    }
}

fn nearest_of(found: &obbtree::NearestObjects) -> (Names, Nearest) {
    (owned(found.names), Nearest(found.nearest))
}

fn contacts_of(found: Vec<obbtree::ObjectContacts>) -> Vec<(Names, Contacts)> {
    found.into_iter().map(|found| (owned(found.names), Contacts(found.contacts))).collect()
}

#[pymethods]
impl Manager {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    #[pyo3(signature = (name, collider, pose = None))]
    fn insert(&self, py: Python<'_>, name: &str, collider: &Collider, pose: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let pose = self::pose(pose)?;
        self.change(py, |manager| manager.insert(name, collider.0.clone(), pose)).map_err(manager_error)
    }

    fn remove(&self, py: Python<'_>, name: &str) -> PyResult<Collider> {
        self.change(py, |manager| manager.remove(name)).map(Collider).map_err(manager_error)
    }

    fn set_pose(&self, py: Python<'_>, name: &str, pose: &Bound<'_, PyAny>) -> PyResult<()> {
        let pose = self::pose(Some(pose))?;
        self.change(py, |manager| manager.set_pose(name, pose)).map_err(manager_error)
    }

    fn pose<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let pose = self.held(py).get(name).map(|(_, pose)| *pose);
        let pose = pose.ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        PyArray2::from_vec2(py, &matrix(&pose)).map_err(value_error)
    }

    fn collider(&self, py: Python<'_>, name: &str) -> PyResult<Collider> {
        let collider = self.held(py).get(name).map(|(collider, _)| collider.clone());
        collider.map(Collider).ok_or_else(|| PyKeyError::new_err(name.to_owned()))
    }

    fn ignore(&self, py: Python<'_>, name: &str, other: &str) {
        self.change(py, |manager| manager.ignore(name, other));
    }

    fn consider(&self, py: Python<'_>, name: &str, other: &str) {
        self.change(py, |manager| manager.consider(name, other));
    }

    fn is_ignored(&self, py: Python<'_>, name: &str, other: &str) -> bool {
        self.held(py).is_ignored(name, other)
    }

    #[getter]
    fn names(&self, py: Python<'_>) -> Vec<String> {
        self.held(py).names().map(str::to_owned).collect()
    }

    fn __len__(&self, py: Python<'_>) -> usize {
        self.held(py).len()
    }

    fn __contains__(&self, py: Python<'_>, name: &str) -> bool {
        self.held(py).get(name).is_some()
    }

    fn collides(&self, py: Python<'_>) -> bool {
        self.ask(py, obbtree::Manager::collides)
    }

    fn colliding_pairs(&self, py: Python<'_>) -> Vec<Names> {
        self.ask(py, |manager| manager.colliding_pairs().into_iter().map(owned).collect())
    }

    #[pyo3(signature = (limit = None))]
    fn contacts(&self, py: Python<'_>, limit: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<(Names, Contacts)>> {
        let limit = convert::limit(limit)?;
        Ok(self.ask(py, |manager| contacts_of(manager.contacts(limit))))
    }

    #[pyo3(signature = (reach = 0.0))]
    fn near_pairs(&self, py: Python<'_>, reach: f64) -> PyResult<Vec<Names>> {
        let reach = convert::length(reach)?;
        Ok(self.ask(py, |manager| manager.near_pairs(reach).into_iter().map(owned).collect()))
    }

    fn nearest(&self, py: Python<'_>) -> PyResult<Option<(Names, Nearest)>> {
        let found = self.ask(py, |manager| Ok(manager.nearest()?.as_ref().map(nearest_of)));
        found.map_err(|error: obbtree::PoseError| value_error(error))
    }

    fn nearest_to(&self, py: Python<'_>, name: &str) -> PyResult<Option<(Names, Nearest)>> {
        self.ask(py, |manager| Ok(manager.nearest_to(name)?.as_ref().map(nearest_of))).map_err(manager_error)
    }

    fn collides_with(&self, py: Python<'_>, other: &Self) -> bool {
        let other = other.now(py);
        self.ask(py, |manager| manager.collides_with(&other))
    }

    fn colliding_pairs_with(&self, py: Python<'_>, other: &Self) -> Vec<Names> {
        let other = other.now(py);
        self.ask(py, |manager| manager.colliding_pairs_with(&other).into_iter().map(owned).collect())
    }

    #[pyo3(signature = (other, limit = None))]
    fn contacts_with(
        &self,
        py: Python<'_>,
        other: &Self,
        limit: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<(Names, Contacts)>> {
        let (limit, other) = (convert::limit(limit)?, other.now(py));
        Ok(self.ask(py, |manager| contacts_of(manager.contacts_with(&other, limit))))
    }

    #[pyo3(signature = (other, reach = 0.0))]
    fn near_pairs_with(&self, py: Python<'_>, other: &Self, reach: f64) -> PyResult<Vec<Names>> {
        let (reach, other) = (convert::length(reach)?, other.now(py));
        Ok(self.ask(py, |manager| manager.near_pairs_with(&other, reach).into_iter().map(owned).collect()))
    }

    fn nearest_with(&self, py: Python<'_>, other: &Self) -> PyResult<Option<(Names, Nearest)>> {
        let other = other.now(py);
        let found = self.ask(py, |manager| Ok(manager.nearest_with(&other)?.as_ref().map(nearest_of)));
        found.map_err(|error: obbtree::PoseError| value_error(error))
    }

    fn collides_each<'py>(
        &self,
        py: Python<'py>,
        names: Vec<String>,
        poses: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let rows = pose_rows(poses, &names)?;
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let verdicts = self.ask(py, |manager| manager.collides_each(&names, &rows)).map_err(manager_error)?;
        Ok(PyArray1::from_vec(py, verdicts))
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        format!("<obbtree.Manager of {} objects>", self.__len__(py))
    }
}

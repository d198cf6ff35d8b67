//! The bodies of a call, as Python holds them.

use super::convert::{BodyColumns, of_rows, same_length};
use super::forces::PyForces;
use crate::body::Body;
use crate::forces::Forces;
use crate::scene::Scene;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::ops::Range;

/// `rigid.model.bodies.Bodies`: columns with a row for each body, or with one row for all.
#[derive(FromPyObject)]
pub struct Bodies<'py> {
    kind: Bound<'py, PyString>,
    moments: Bound<'py, PyArray2<f64>>,
    weight: Bound<'py, PyArray2<f64>>,
    omega: Bound<'py, PyArray2<f64>>,
    attitude: Bound<'py, PyArray2<f64>>,
    forces: Option<Bound<'py, PyForces>>,
    /// Whether a torque or weight may stop them, on which drag acts.
    pub may_stop: bool,
}

impl Bodies<'_> {
    /// What moves them.
    pub fn scene(&self) -> PyResult<&'static Scene> {
        Ok(Scene::parse(self.kind.to_str()?)?)
    }

    /// What is read from the columns as they are now, before the lock of the interpreter is given up.
    fn read<T>(&self, read: impl FnOnce(BodyColumns<'_>) -> PyResult<T>) -> PyResult<T> {
        of_rows("moments", &self.moments, |moments| {
            of_rows("weight", &self.weight, |weight| {
                of_rows("omega", &self.omega, |omega| {
                    of_rows("attitude", &self.attitude, |attitude| {
                        read(BodyColumns::new(moments, weight, omega, attitude)?)
                    })
                })
            })
        })
    }

    /// Number of bodies.
    pub fn len(&self) -> PyResult<usize> {
        self.read(|columns| Ok(columns.len()))
    }

    /// Copies of some bodies.
    pub fn of(&self, part: Range<usize>) -> PyResult<Vec<Body>> {
        self.read(|columns| Ok(columns.bodies(part)?))
    }

    /// Copies of all bodies.
    pub fn all(&self) -> PyResult<Vec<Body>> {
        self.of(0..self.len()?)
    }

    /// The forces on so many bodies.
    pub fn forces(&self, bodies: usize) -> PyResult<&Forces> {
        let forces = self.forces.as_ref().map_or(Forces::NONE, |forces| &forces.get().0);
        if forces.bodies() > 1 {
            same_length("forces", bodies, forces.bodies())?;
        }
        Ok(forces)
    }
}

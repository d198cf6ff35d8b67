//! The bodies of a call, as Python holds them.

use super::convert::{BodyColumns, rows_in, same_length};
use super::forces::PyForces;
use crate::forces::Forces;
use crate::scene::Scene;
use crate::start::Body;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyString;

/// `rigid.solve.bodies.Bodies`: columns with a row for each body, or with one row for all.
#[derive(FromPyObject)]
pub struct Bodies<'py> {
    kind: Bound<'py, PyString>,
    moments: Bound<'py, PyArray2<f64>>,
    weight: Bound<'py, PyArray2<f64>>,
    omega: Bound<'py, PyArray2<f64>>,
    attitude: Bound<'py, PyArray2<f64>>,
    forces: Option<Bound<'py, PyForces>>,
}

impl Bodies<'_> {
    /// What moves them.
    pub fn scene(&self) -> PyResult<&'static Scene> {
        Ok(Scene::parse(self.kind.to_str()?)?)
    }

    /// The columns as they are now: to be read before the lock of the interpreter is given up.
    pub fn columns(&self) -> PyResult<BodyColumns<'_>> {
        BodyColumns::new(
            rows_in("moments", &self.moments)?,
            rows_in("weight", &self.weight)?,
            rows_in("omega", &self.omega)?,
            rows_in("attitude", &self.attitude)?,
        )
    }

    /// Copies of all bodies.
    pub fn all(&self) -> PyResult<Vec<Body>> {
        let columns = self.columns()?;
        Ok(columns.bodies(0..columns.len())?)
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

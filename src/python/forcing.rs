//! Torque and damping from Python.

use super::convert::{copied, rows};
use crate::forcing::Forcing;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// Forcing of all bodies of a request: a torque in the body and in space at some times, linear between them (no times:
/// constant), and damping, entries 11, 22, 33, 23, 31, 12 of its matrix.
#[pyclass(frozen, name = "Forcing", module = "rigid._core")]
pub struct PyForcing(pub Forcing);

#[pymethods]
impl PyForcing {
    #[new]
    #[pyo3(signature = (*, times, body, space, damping))]
    fn new(
        times: PyReadonlyArray1<'_, f64>,
        body: PyReadonlyArray2<'_, f64>,
        space: PyReadonlyArray2<'_, f64>,
        damping: [f64; 6],
    ) -> PyResult<Self> {
        let (body, space) = (rows::<3>("torque", &body)?, rows::<3>("torque", &space)?);
        let times = copied("torque times", &times)?;
        Ok(PyForcing(Forcing::new(&times, body, space, damping)?))
    }

    /// The rate k, if the forcing is a damping `D = k I` of a body with these moments, without torque.
    fn slows_evenly(&self, moments: [f64; 3]) -> Option<f64> {
        self.0.slows_evenly(moments)
    }

    /// The entries 11, 22, 33, 23, 31, 12 of the damping matrix; None if a torque acts too.
    fn damping_alone(&self) -> Option<[f64; 6]> {
        self.0.damping_alone()
    }

    /// Damping rates of a body with these moments without torque, ascending.
    fn damping_rates(&self, moments: [f64; 3]) -> [f64; 3] {
        self.0.damping_rates(moments)
    }
}

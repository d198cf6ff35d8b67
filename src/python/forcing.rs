//! Torque and damping from Python.

use super::convert::{copied, copied_rows, rows, same_length};
use crate::called::TorqueFunction;
use crate::float_environment::FloatEnvironment;
use crate::forcing::{BodyForcing, Forcing};
use crate::memory;
use crate::satellite::Satellite;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// Forcing of the bodies of a request: torques in the body and in space at some times, linear between them (no times:
/// constant), table after table, damping, entries 11, 22, 33, 23, 31, 12 of its matrices, and the 16 numbers of rotor,
/// energy sink, drag and orbit. One table, matrix or row may serve all bodies; without tables no torque is applied. A
/// function that returns a further torque is its address, its data in rows, what its torques are multiplied by, and a
/// bound of the rates, or 0.
#[pyclass(frozen, name = "Forcing", module = "rigid._core")]
pub struct PyForcing(pub Forcing);

/// Address, data, units and the bound of the rates of a function.
type GivenFunction<'py> = (usize, PyReadonlyArray2<'py, f64>, PyReadonlyArray1<'py, f64>, f64);

#[pymethods]
impl PyForcing {
    #[new]
    #[pyo3(signature = (*, times, body, space, damping, satellite = None, function = None))]
    fn new(
        times: PyReadonlyArray1<'_, f64>,
        body: PyReadonlyArray2<'_, f64>,
        space: PyReadonlyArray2<'_, f64>,
        damping: PyReadonlyArray2<'_, f64>,
        satellite: Option<PyReadonlyArray2<'_, f64>>,
        function: Option<GivenFunction<'_>>,
    ) -> PyResult<Self> {
        let _standard = FloatEnvironment::standard();
        let (body, space) = (rows::<3>("torque", &body)?, rows::<3>("torque", &space)?);
        let times = copied("torque times", &times)?;
        let forcing = Forcing::new(&times, body, space, rows::<6>("damping", &damping)?)?;
        let forcing = match &satellite {
            Some(satellite) => {
                forcing.with_satellites(rows::<{ Satellite::LEN }>("satellite", satellite)?)?
            }
            None => forcing,
        };
        let Some((address, data, units, fastest)) = function else { return Ok(PyForcing(forcing)) };
        let (data, width) = copied_rows("data of a torque", &data)?;
        let units = copied("units", &units)?;
        // SAFETY: what `rigid.Torque.call` asks of its caller.
        let function = unsafe { TorqueFunction::new(address, data, width, units, fastest)? };
        Ok(PyForcing(forcing.with_function(function)?))
    }

    /// The forcing of some bodies, in this order.
    fn select(&self, bodies: PyReadonlyArray1<'_, isize>) -> PyResult<Self> {
        let bodies = bodies.as_array();
        // No body has a negative index.
        let indices = bodies.iter().map(|&body| usize::try_from(body).unwrap_or(usize::MAX));
        let indices = memory::collected("bodies", bodies.len(), indices)?;
        Ok(PyForcing(self.0.of_some(&indices)?))
    }

    /// The same with damping that is rounded otherwise.
    fn rounded_otherwise(&self) -> PyResult<Self> {
        Ok(PyForcing(self.0.rounded_otherwise()?))
    }

    /// The rate k of each body with these moments, if its forcing is a damping `D = k I` without torque, else NaN.
    fn slows_evenly<'py>(
        &self,
        py: Python<'py>,
        moments: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.of_each(py, &moments, |forcing, moments| forcing.slows_evenly(moments).unwrap_or(f64::NAN))
    }

    /// Whether each body is driven: a torque is applied, or damping that is not zero.
    fn drives<'py>(&self, py: Python<'py>, bodies: usize) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let drives = (0..bodies).map(|body| !self.0.of(body).is_none());
        Ok(memory::collected("bodies", bodies, drives)?.into_pyarray(py))
    }

    /// The entries 11, 22, 33, 23, 31, 12 of the damping matrices, (n, 6), or those of all in one row; if they are wanted
    /// alone NaN for a body on which a torque acts too.
    fn dampings<'py>(&self, py: Python<'py>, alone: bool) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let bodies = self.0.bodies();
        let of = |forcing: BodyForcing| if alone { forcing.damping_alone() } else { Some(forcing.damping()) };
        let entries = (0..bodies).map(|body| of(self.0.of(body)).unwrap_or([f64::NAN; 6]));
        let entries = memory::collected("damping", bodies, entries)?.into_flattened();
        entries.into_pyarray(py).reshape([bodies, 6])
    }

    /// The largest damping rate of each body with these moments without torque.
    fn damping_rates<'py>(
        &self,
        py: Python<'py>,
        moments: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.of_each(py, &moments, |forcing, moments| forcing.damping_rates(moments)[2])
    }
}

impl PyForcing {
    /// A number of each body; one row of moments may be those of all.
    fn of_each<'py>(
        &self,
        py: Python<'py>,
        moments: &PyReadonlyArray2<'_, f64>,
        of: impl Fn(BodyForcing<'_>, [f64; 3]) -> f64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let _standard = FloatEnvironment::standard();
        let moments = rows::<3>("moments", moments)?;
        let bodies = self.0.bodies().max(moments.len());
        if moments.len() > 1 && self.0.bodies() > 1 {
            same_length("moments", self.0.bodies(), moments.len())?;
        }
        let number = |body: usize| of(self.0.of(body), moments[if moments.len() == 1 { 0 } else { body }]);
        Ok(memory::collected("numbers of the bodies", bodies, (0..bodies).map(number))?.into_pyarray(py))
    }
}

//! Bodies that Python moves step by step.

use super::bodies::Bodies;
use super::convert::{Aligned1, Aligned2, copied, interruptible_calls, rows, same_length};
use super::unraisable::carrying;
use crate::body::Body;
use crate::float_environment::FloatEnvironment;
use crate::memory;
use crate::method::Method;
use crate::parallel::{Interrupt, caught, owned};
use crate::simd::Isa;
use crate::trajectory::{Motion, NUMBERS, Torques};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// Bodies below which a step keeps the lock of the interpreter: it takes a few microseconds.
const FEW: usize = 64;

/// Bodies in motion; see `rigid.Motion`.
#[pyclass(name = "Motion", module = "rigid._core")]
pub struct PyMotion {
    motion: Motion,
    /// The unit of moments and weight of each body, or of all: a torque is divided by it.
    units: Vec<f64>,
    threads: usize,
    /// Whether steps call functions.
    calls: bool,
}

#[pymethods]
impl PyMotion {
    #[new]
    #[pyo3(signature = (bodies, *, method, time, units, threads))]
    fn new(
        bodies: Bodies<'_>,
        method: &str,
        time: f64,
        units: Aligned1<'_, f64>,
        threads: usize,
    ) -> PyResult<Self> {
        let _standard = FloatEnvironment::standard();
        let all = bodies.all()?;
        let units = copied("units", &units)?;
        if units.len() != 1 {
            same_length("units", all.len(), units.len())?;
        }
        let forces = bodies.forces(all.len())?.copied()?;
        let calls = forces.of(0).function.is_some();
        let motion =
            Motion::new(&all, time, bodies.scene()?, Method::parse(method)?, forces, Isa::current()?)?;
        Ok(PyMotion { motion, units, threads, calls })
    }

    /// The numbers of the steps of each body, and whether a torque has been applied; see `restore`.
    fn numbers<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray2<f64>>, bool)> {
        let (all, pushed) = self.motion.numbers()?;
        let n = all.len();
        Ok((all.into_flattened().into_pyarray(py).reshape([n, NUMBERS])?, pushed))
    }

    /// Sets the bodies to the numbers of a motion that began alike.
    fn restore(&mut self, numbers: Aligned2<'_, f64>, pushed: bool) -> PyResult<()> {
        Ok(self.motion.restore(rows::<NUMBERS>("numbers", &numbers)?, pushed)?)
    }

    /// Begins the motion again with other rates and attitudes, where these are not those before.
    fn begin(
        &mut self,
        omega: Aligned2<'_, f64>,
        attitude: Aligned2<'_, f64>,
        omega_before: Aligned2<'_, f64>,
        attitude_before: Aligned2<'_, f64>,
    ) -> PyResult<()> {
        let _standard = FloatEnvironment::standard();
        let after = (rows("omega", &omega)?, rows("attitude", &attitude)?);
        let before = (rows("omega", &omega_before)?, rows("attitude", &attitude_before)?);
        Ok(self.motion.begin(after, before)?)
    }

    /// The present time.
    #[getter]
    fn time(&self) -> f64 {
        self.motion.time()
    }

    /// The present rates, shape (n, 3).
    fn omega<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.array(py, |body| body.omega)
    }

    /// The present attitudes, shape (n, 4).
    fn attitude<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.array(py, |body| body.attitude)
    }

    /// Makes one step under a torque: three numbers, or an array of shape (n, 3) or (1, 3). The largest angle of the step
    /// (rad), the first time that the method does not bear the angle.
    #[pyo3(signature = (dt, torque=None))]
    fn step(
        &mut self,
        py: Python<'_>,
        dt: &Bound<'_, PyAny>,
        torque: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Option<f64>> {
        let _standard = FloatEnvironment::standard();
        let no_number = |_| PyTypeError::new_err(format!("dt = {dt}: must be a real number"));
        let dt: f64 = dt.extract().map_err(no_number)?;
        let Some(torque) = torque else { return self.make(py, dt, &[]) };
        if let Ok(torque) = torque.extract::<[f64; 3]>() {
            return self.push(py, dt, &[torque]);
        }
        let array: Aligned2<'_, f64> = torque
            .extract()
            .map_err(|_| PyTypeError::new_err(format!("torque = {torque}: must be real numbers")))?;
        self.push(py, dt, rows::<3>("torque", &array)?)
    }
}

impl PyMotion {
    /// Makes one step under torques that are not divided by the units yet.
    fn push(&mut self, py: Python<'_>, dt: f64, torques: Torques) -> PyResult<Option<f64>> {
        let scaled = |(torque, unit): (&[f64; 3], &f64)| torque.map(|x| x / unit);
        if let ([unit], [torque]) = (&self.units[..], torques) {
            return self.make(py, dt, &[scaled((torque, unit))]);
        }
        // A single torque or unit is that of all bodies.
        let count = if torques.len() == 1 { self.units.len() } else { torques.len() };
        let pairs = torques.iter().cycle().zip(self.units.iter().cycle());
        let torques = memory::collected("torques", count, pairs.map(scaled))?;
        self.make(py, dt, &torques)
    }

    fn make(&mut self, py: Python<'_>, dt: f64, torques: Torques) -> PyResult<Option<f64>> {
        let PyMotion { motion, threads, calls, .. } = self;
        if motion.passes_many_knots(dt) {
            let work = |stop: &Interrupt| motion.step(dt, torques, *threads, stop);
            return Ok(interruptible_calls(py, None, *calls, work)??);
        }
        let few = motion.len() < FEW;
        let mut work = || caught(|| motion.step(dt, torques, *threads, &Interrupt::never()));
        let mut make = || if few { work() } else { py.detach(&mut work) };
        if *calls { carrying(py, |call| Ok(owned(call, make)?)) } else { Ok(make()?) }
    }

    fn array<'py, const N: usize>(
        &self,
        py: Python<'py>,
        of: impl Fn(&Body) -> [f64; N],
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let n = self.motion.len();
        let numbers = self.motion.bodies().flat_map(of);
        memory::collected("an array of the result", N * n, numbers)?.into_pyarray(py).reshape([n, N])
    }
}

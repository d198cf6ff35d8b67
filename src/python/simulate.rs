//! States at given times, and the rates that determine steps.

use super::convert::{bodies, column, copied, evaluated, interruptible, parse_record, rows, same_length};
use super::forcing::PyForcing;
use crate::forcing::Forcing;
use crate::memory;
use crate::scene::Scene;
use crate::scheme::Scheme;
use crate::simd::Isa;
use crate::solver::{Solver, default_step};
use crate::start::Body;
use crate::status::Status;
use crate::trajectory::{self, Column, Request, Schedule, States, time_range};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// States of bodies at given times; see `rigid.simulate`.
#[pyfunction]
#[pyo3(signature = (*, scene, method, record, moments, weight, omega, attitude, step, max_steps, threads, times=None, strides=None, refinement=1.0, tolerance=None, forcing=None))]
#[allow(clippy::too_many_arguments)] // The request of `trajectory`, column by column.
pub fn simulate<'py>(
    py: Python<'py>,
    scene: &str,
    method: &str,
    record: &str,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
    step: Option<PyReadonlyArray1<'py, f64>>,
    max_steps: u64,
    threads: usize,
    times: Option<PyReadonlyArray1<'py, f64>>,
    strides: Option<Vec<u64>>,
    refinement: f64,
    tolerance: Option<f64>,
    forcing: Option<PyRef<'py, PyForcing>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (scene, solver, record, isa) =
        (Scene::parse(scene)?, Solver::parse(method)?, parse_record(record)?, Isa::current()?);
    let omega = rows::<3>("omega", &omega)?;
    let n = omega.len();
    let bodies = bodies(
        rows::<3>("moments", &moments)?,
        rows::<3>("weight", &weight)?,
        omega,
        rows::<4>("attitude", &attitude)?,
    )?;
    let forcing = forcing.as_ref().map_or(Forcing::NONE, |forcing| &forcing.0);
    // Copies: without the lock other threads may write to the arrays.
    let times = times.map(|times| copied("times", &times)).transpose()?;
    let span = times.as_deref().map_or([0.0; 2], time_range);
    let steps = match (step, solver) {
        (Some(step), _) => copied("steps", &step)?,
        (None, Solver::Steps(method)) => {
            let step = |body: &Body| default_step(method, body.step_rate(method, forcing, span));
            memory::collected("steps", n, bodies.iter().map(step))?
        }
        (None, Solver::Exact) => memory::filled("steps", n, f64::INFINITY)?,
    };
    same_length("step", n, steps.len())?;
    let schedule = match (&times, &strides) {
        (Some(times), _) => Schedule::Times(times),
        (None, Some(strides)) => Schedule::Strides(strides),
        (None, None) => Schedule::Times(&[]),
    };
    let steps = &steps;
    let bodies = &bodies;
    let request =
        Request { bodies, scene, forcing, solver, record, schedule, steps, refinement, tolerance, max_steps };
    let states = interruptible(py, None, |stop| trajectory::simulate(&request, threads, isa, stop))??;
    states_to_dict(py, states, n, request.schedule.len())
}

/// Bounds of |omega| over the whole motion, from the conserved quantities, to choose a step. With forcing the bounds
/// hold between the two times of `span`; with a method they are the rates that determine its steps.
#[pyfunction]
#[pyo3(signature = (*, scene, moments, weight, omega, attitude, forcing=None, span=None, method=None))]
#[allow(clippy::too_many_arguments)] // The columns of a request.
pub fn fastest_rates<'py>(
    py: Python<'py>,
    scene: &str,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
    forcing: Option<PyRef<'py, PyForcing>>,
    span: Option<[f64; 2]>,
    method: Option<&str>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    Scene::parse(scene)?;
    let forcing = forcing.as_ref().map_or(Forcing::NONE, |forcing| &forcing.0);
    let (method, span) = (method.map(Scheme::parse).transpose()?, span.unwrap_or_default());
    let bodies = bodies(
        rows::<3>("moments", &moments)?,
        rows::<3>("weight", &weight)?,
        rows::<3>("omega", &omega)?,
        rows::<4>("attitude", &attitude)?,
    )?;
    let rate = |body: &Body| match method {
        None => body.fastest_rate(forcing, span),
        Some(method) => body.step_rate(method, forcing, span),
    };
    Ok(evaluated(py, "rates", bodies.len(), |index| Ok(rate(&bodies[index])))?.into_pyarray(py))
}

/// The default steps of a method at these rates; infinite for a rate of zero.
#[pyfunction]
pub fn default_steps<'py>(
    py: Python<'py>,
    method: &str,
    rates: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let method = Scheme::parse(method)?;
    let rates = copied("rates", &rates)?;
    column(py, &rates, |&rate| default_step(method, rate))
}

/// Names of the status codes of a run, in the order of the codes.
#[pyfunction]
pub fn status_names() -> Vec<&'static str> {
    Status::ALL.into_iter().map(Status::name).collect()
}

/// The columns of states as arrays; None for what is not recorded.
fn states_to_dict(py: Python<'_>, states: States, n: usize, times: usize) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("nanoseconds", states.nanoseconds)?;
    for (name, values) in states.into_columns() {
        match values {
            Column::Series(_, None) => dict.set_item(name, py.None())?,
            Column::Series(1, Some(values)) => {
                dict.set_item(name, values.into_pyarray(py).reshape([n, times])?)?;
            }
            Column::Series(width, Some(values)) => {
                dict.set_item(name, values.into_pyarray(py).reshape([n, times, width])?)?;
            }
            Column::Numbers(values) => dict.set_item(name, values.into_pyarray(py))?,
            Column::Counts(values) => dict.set_item(name, values.into_pyarray(py))?,
            Column::Statuses(values) => {
                dict.set_item(name, column(py, &values, |&status| status as u8)?)?;
            }
        }
    }
    Ok(dict)
}

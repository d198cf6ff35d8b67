//! States at given times, and the rates that determine steps.

use super::convert::{
    BodyColumns, column, copied, copied_rows, evaluated, interruptible, parse_record, rows, same_length,
};
use super::forces::PyForces;
use super::target::Target;
use crate::float_environment::FloatEnvironment;
use crate::forces::{Forces, ParameterChange};
use crate::map::MethodChoice;
use crate::memory;
use crate::method::{AnyMethod, Method, default_step};
use crate::parallel::{self, Interrupt};
use crate::scene::Scene;
use crate::simd::Isa;
use crate::start::Body;
use crate::status::Status;
use crate::trajectory::{self, Column, Record, Request, Schedule, States, time_range};
use numpy::ndarray::Array3;
use numpy::{
    IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Bytes of the states of so many bodies at so many times.
#[pyfunction]
#[pyo3(signature = (*, scene, record, bodies, times, forces=None))]
pub fn state_bytes(
    scene: &str,
    record: &str,
    bodies: usize,
    times: usize,
    forces: Option<PyRef<'_, PyForces>>,
) -> PyResult<u128> {
    let request = Request {
        bodies: &[],
        scene: Scene::parse(scene)?,
        forces: forces.as_ref().map_or(Forces::NONE, |forces| &forces.0),
        method: AnyMethod::Exact,
        record: parse_record(record, &[], &[])?,
        schedule: Schedule::Times(&[]),
        steps: &[],
        refinement: 1.0,
        tolerance: None,
        max_steps: 0,
    };
    Ok(States::bytes(&request, bodies, times, &[]))
}

/// States of bodies at given times; see `rigid.simulate`.
#[pyfunction]
#[pyo3(signature = (*, scene, method, record, moments, weight, omega, attitude, step, max_steps, threads, times=None, strides=None, refinement=1.0, tolerance=None, forces=None, deviations=None, changes=None, out=None, single=false))]
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
    times: Option<PyReadonlyArray2<'py, f64>>,
    strides: Option<Vec<u64>>,
    refinement: f64,
    tolerance: Option<f64>,
    forces: Option<PyRef<'py, PyForces>>,
    deviations: Option<PyReadonlyArray2<'py, f64>>,
    changes: Option<PyReadonlyArray2<'py, f64>>,
    out: Option<&Bound<'py, PyDict>>,
    single: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let _standard = FloatEnvironment::standard();
    let (scene, method, isa) = (Scene::parse(scene)?, AnyMethod::parse(method)?, Isa::current()?);
    let columns = BodyColumns::of_arrays(&moments, &weight, &omega, &attitude)?;
    let n = columns.len();
    let forces = forces_of(forces.as_ref(), n)?;
    let deviations = match &deviations {
        Some(given) => {
            let given = rows::<6>("deviations", given)?;
            memory::collected("deviations", given.len(), given.iter().copied())?
        }
        None => Vec::new(),
    };
    let changes = match &changes {
        Some(given) => {
            let given = rows::<{ ParameterChange::LEN }>("changes", given)?;
            memory::collected("changes", given.len(), given.iter().map(ParameterChange::of))?
        }
        None => Vec::new(),
    };
    let record = parse_record(record, &deviations, &changes)?;
    match record {
        Record::Tangent(deviations) => same_length("deviations", n, deviations.len())?,
        Record::Sensitivity(changes) => same_length("changes", n, changes.len())?,
        _ => {}
    }
    // Copies: without the lock other threads may write to the arrays.
    let times = times.map(|times| copied_rows("times", &times)).transpose()?;
    if let Some(step) = &step {
        same_length("step", n, step.len())?;
    }
    let schedule = match (&times, &strides) {
        // One row of times is that of all bodies.
        (Some((times, count)), _) if times.len() == *count => Schedule::Times(times),
        (Some((times, count)), _) => {
            same_length("t", n * count, times.len())?;
            Schedule::TimesOfEach(times, *count)
        }
        (None, Some(strides)) => Schedule::Strides(strides),
        (None, None) => Schedule::Times(&[]),
    };
    let (bodies, steps) = (&[], &[]);
    let request =
        Request { bodies, scene, forces, method, record, schedule, steps, refinement, tolerance, max_steps };
    let mut targets = Target::all(py, &request, n, out, single)?;
    let given: Vec<_> = targets.iter().map(|target| target.name).collect();
    let mut states = States::reserved(&request, n, &given)?;
    let (mut rest, mut nanoseconds) = (states.whole(), 0);
    for part in columns.parts(threads) {
        let bodies = &columns.bodies(part.clone())?;
        let own = if part.len() < n { forces.of_range(part.clone())? } else { None };
        let (forces, schedule) = (own.as_ref().unwrap_or(forces), schedule.of_range(part.clone()));
        let steps = &match (&step, method) {
            (Some(step), _) => {
                let steps = step.as_array();
                memory::collected("steps", part.len(), part.clone().map(|index| steps[index]))?
            }
            (None, AnyMethod::Steps(method)) => {
                let step = |(index, body): (usize, &Body)| {
                    let span = schedule.times_of(index).map_or([0.0; 2], time_range);
                    default_step(method, body.step_rate(method, forces.of(index), span))
                };
                memory::collected("steps", part.len(), bodies.iter().enumerate().map(step))?
            }
            (None, AnyMethod::Exact) => Vec::new(),
        };
        let record = match record {
            Record::Tangent(deviations) => Record::Tangent(&deviations[part.clone()]),
            Record::Sensitivity(changes) => Record::Sensitivity(&changes[part.clone()]),
            record => record,
        };
        let request = &Request { bodies, forces, schedule, steps, record, ..request };
        let mut states = rest.split_off(request.schedule.len(), part.len());
        for target in &mut targets {
            states.give(target.name, target.part(part.clone())?);
        }
        let run = |stop: &Interrupt| {
            let simulate = || trajectory::simulate_into(request, states, threads, isa, stop);
            if forces.of(0).function.is_some() { parallel::apart(stop, simulate) } else { simulate() }
        };
        nanoseconds += interruptible(py, None, run)?.map_err(|error| error.of_part(part.start))?.nanoseconds;
        for target in &mut targets {
            target.finish(part.clone())?;
        }
        py.check_signals()?;
    }
    states.effort.nanoseconds = nanoseconds;
    let dict = states_to_dict(py, states, n, request.schedule.len())?;
    for target in targets {
        dict.set_item(target.name, target.shaped()?)?;
    }
    Ok(dict)
}

/// The forces on so many bodies.
pub(super) fn forces_of<'a>(forces: Option<&'a PyRef<'_, PyForces>>, bodies: usize) -> PyResult<&'a Forces> {
    let forces = forces.map_or(Forces::NONE, |forces| &forces.0);
    if forces.bodies() > 1 {
        same_length("forces", bodies, forces.bodies())?;
    }
    Ok(forces)
}

/// Bounds of |omega| over the whole motion, from the conserved quantities, to choose a step. With forces the bounds
/// hold between the two times of each row of `span`, or of its only row; with a method they are the rates that determine
/// its steps.
#[pyfunction]
#[pyo3(signature = (*, scene, moments, weight, omega, attitude, forces=None, span=None, method=None))]
#[allow(clippy::too_many_arguments)] // The columns of a request.
pub fn fastest_rates<'py>(
    py: Python<'py>,
    scene: &str,
    moments: PyReadonlyArray2<'py, f64>,
    weight: PyReadonlyArray2<'py, f64>,
    omega: PyReadonlyArray2<'py, f64>,
    attitude: PyReadonlyArray2<'py, f64>,
    forces: Option<PyRef<'py, PyForces>>,
    span: Option<PyReadonlyArray2<'py, f64>>,
    method: Option<&str>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    Scene::parse(scene)?;
    let method = method.map(Method::parse).transpose()?;
    let columns = BodyColumns::of_arrays(&moments, &weight, &omega, &attitude)?;
    let forces = forces_of(forces.as_ref(), columns.len())?;
    let spans = span.as_ref().map(|span| rows::<2>("span", span)).transpose()?.unwrap_or(&[[0.0; 2]]);
    if spans.len() != 1 {
        same_length("span", columns.len(), spans.len())?;
    }
    let rate = |index: usize, body: &Body| {
        let span = spans[if spans.len() == 1 { 0 } else { index }];
        match method {
            None => body.fastest_rate(forces.of(index), span),
            Some(method) => body.step_rate(method, forces.of(index), span),
        }
    };
    let mut rates = memory::reserved("rates", columns.len())?;
    for part in columns.parts(1) {
        let bodies = columns.bodies(part.clone())?;
        let own = |index: usize| Ok(rate(part.start + index, &bodies[index]));
        rates.extend(evaluated(py, "rates", bodies.len(), own)?);
    }
    Ok(rates.into_pyarray(py))
}

/// The default steps of a method at these rates, or those of a map that chooses its method, for its samples or for the
/// growth of their deviation vectors; infinite for a rate of zero.
#[pyfunction]
#[pyo3(signature = (method, rates, of_growth=false))]
pub fn default_steps<'py>(
    py: Python<'py>,
    method: &str,
    rates: PyReadonlyArray1<'py, f64>,
    of_growth: bool,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let _standard = FloatEnvironment::standard();
    let choice = MethodChoice::parse(method)?;
    let rates = copied("rates", &rates)?;
    column(py, &rates, |&rate| choice.default_step(of_growth, rate))
}

/// Names of the status codes of a run, in the order of the codes.
#[pyfunction]
pub fn status_names() -> Vec<&'static str> {
    Status::ALL.into_iter().map(Status::name).collect()
}

/// The columns of states as arrays; None for what is not recorded.
fn states_to_dict(py: Python<'_>, states: States, n: usize, times: usize) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("nanoseconds", states.effort.nanoseconds)?;
    for (name, values) in states.into_columns() {
        match values {
            Column::Series(_, None) => dict.set_item(name, py.None())?,
            Column::Series(1, Some(values)) => {
                dict.set_item(name, values.into_pyarray(py).reshape([n, times])?)?;
            }
            Column::Series(width, Some(values)) => {
                let rows = Array3::from_shape_vec([n, times, width], values).expect("as long as reserved");
                dict.set_item(name, rows.into_pyarray(py))?;
            }
            Column::Numbers(values) => dict.set_item(name, of_bodies(py, values))?,
            Column::Counts(values) => dict.set_item(name, of_bodies(py, values))?,
            Column::Statuses(values) => {
                dict.set_item(name, column(py, &values, |&status| status as u8)?)?;
            }
        }
    }
    Ok(dict)
}

/// An array with a number of each body: of few bodies a copy, which is faster.
fn of_bodies<T: numpy::Element + Copy>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    const FEW: usize = 64;
    if values.len() <= FEW { PyArray1::from_slice(py, &values) } else { values.into_pyarray(py) }
}

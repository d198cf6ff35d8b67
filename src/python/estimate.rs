//! The errors of runs: states of two runs in, errors out.

use super::bodies::Bodies;
use super::convert::{
    Aligned1, Aligned2, at_once, copied_numbers, interruptible_calls, rows, same_length, times_of_bodies,
};
use super::states::{of_bodies, shaped};
use crate::error::Error;
use crate::estimate::{
    PhaseError, ROUNDINGS, Recorded, Run, depends_on_change, distances as distances_of, error_of_closed_form,
    fastest, measured_change, phase_error, round_otherwise, stated,
};
use crate::float_environment::FloatEnvironment;
use crate::memory;
use crate::method::Method;
use crate::parallel::Interrupt;
use crate::simd::Isa;
use crate::start::Body;
use crate::trajectory::{Schedule, time_range};
use numpy::{
    Element, PyArray1, PyArray2, PyArray3, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyString;
use std::ops::Range;

/// What an estimate needs of `rigid.solve.request.Request`.
#[derive(FromPyObject)]
pub struct Judged<'py> {
    bodies: Bodies<'py>,
    times: Bound<'py, PyArrayDyn<f64>>,
    method: Bound<'py, PyString>,
    tolerance: Option<f64>,
}

/// Rows of numbers.
type Rows<'py> = Bound<'py, PyArray2<f64>>;

/// A number of each body.
type Column<'py> = Bound<'py, PyArray1<f64>>;

/// The errors that are stated for the states of a request, from those of other runs: `safety` times the distance of the
/// farthest, and what all may have in common; or the distance `alone`. `taken` are the steps of the run with the longer ones;
/// a coarser run by a tolerance names it. Of each body there is the largest error, the output time nearest to 0 from which on
/// its error is 1 or more, and how many more times show whether its runs differ by whole turns, or 0.
#[pyfunction]
#[pyo3(signature = (request, states, others, taken, safety, coarser_tolerance=None, alone=false))]
#[allow(clippy::too_many_arguments)] // What differs between the estimates of one request.
pub fn estimate<'py>(
    py: Python<'py>,
    request: Judged<'py>,
    states: &Bound<'py, PyAny>,
    others: Vec<Bound<'py, PyAny>>,
    taken: Aligned1<'py, u64>,
    safety: f64,
    coarser_tolerance: Option<f64>,
    alone: bool,
) -> PyResult<(Column<'py>, Column<'py>, Column<'py>)> {
    let _standard = FloatEnvironment::standard();
    let (isa, method, n) = (Isa::current()?, Method::parse(request.method.to_str()?)?, request.bodies.len()?);
    let (times, forces) = (copied_numbers("times", &request.times)?, request.bodies.forces(n)?);
    let times = times_of_bodies(&times, request.times.shape(), n)?;
    let m = times.len();
    let drift: Aligned1<'py, f64> = states.get_item(intern!(py, "energy_drift"))?.extract()?;
    let steps: Aligned1<'py, u64> = states.get_item(intern!(py, "steps"))?.extract()?;
    let states = Columns::read(states, [n, m])?;
    let others = others.iter().map(|other| Columns::read(other, [n, m])).collect::<PyResult<Vec<_>>>()?;
    let lengths =
        [("taken", &taken), ("steps", &steps)].map(|(name, column)| (name, column.as_array().len()));
    for (argument, length) in lengths.into_iter().chain([("energy_drift", drift.as_array().len())]) {
        same_length(argument, n, length)?;
    }
    let scene = request.bodies.scene()?;
    let mut errors_of_body = memory::zeros("errors of a body", m.saturating_mul(2))?;
    let (error, apart) = errors_of_body.split_at_mut(m);
    let reserved = || memory::reserved("errors of the bodies", n);
    let (mut errors, mut lost_from, mut looks) = (reserved()?, reserved()?, reserved()?);
    in_parts(py, &request.bodies, |bodies, part| {
        let states = states.recorded()?;
        let others = others.iter().map(Columns::recorded).collect::<PyResult<Vec<_>>>()?;
        for (body, index) in bodies.iter().zip(part) {
            let mut run = Run {
                body,
                forces: forces.of(index),
                times: own_times(&times, index),
                states: states.of(index, m),
                drift: drift.as_array()[index],
                steps: steps.as_array()[index] as f64,
                taken: taken.as_array()[index] as f64,
                change: None,
                method,
                tolerance: request.tolerance,
                coarser_tolerance,
            };
            if !alone && depends_on_change(&run) {
                let change = |stop: &Interrupt| measured_change(&run, (scene, forces, index), isa, stop);
                let calls = run.forces.function.is_some();
                let measured =
                    if calls { interruptible_calls(py, None, calls, change)? } else { at_once(change) };
                run.change = Some(measured?);
            }
            let others = others.iter().map(|other| other.of(index, m));
            let own = stated(isa, &run, others, safety, alone, [&mut *error, &mut *apart]);
            errors.push(own.error);
            lost_from.push(own.lost_from);
            looks.push(own.looks);
        }
        Ok(())
    })?;
    Ok((of_bodies(py, errors), of_bodies(py, lost_from), of_bodies(py, looks)))
}

/// The relative distances of the states of two runs, (n, m); see `rigid.solve.error_estimate`. Rates that
/// are rest beside a `scale` of their body are compared with it, and without one no rates are rest.
#[pyfunction]
#[pyo3(signature = (states, other, scale=None))]
pub fn distances<'py>(
    py: Python<'py>,
    states: &Bound<'py, PyAny>,
    other: &Bound<'py, PyAny>,
    scale: Option<Aligned1<'py, f64>>,
) -> PyResult<Rows<'py>> {
    let _standard = FloatEnvironment::standard();
    let omega = states.get_item(intern!(py, "omega"))?;
    let omega = omega.cast::<PyArray3<f64>>()?;
    let shape @ [n, m] = [omega.shape()[0], omega.shape()[1]];
    let (states, other) = (Columns::read(states, shape)?, Columns::read(other, shape)?);
    if let Some(scale) = &scale {
        same_length("scale", n, scale.as_array().len())?;
    }
    let mut apart = memory::zeros("distances", n.saturating_mul(m))?;
    let (of_run, of_other) = (states.recorded()?, other.recorded()?);
    for (body, apart) in apart.chunks_exact_mut(m.max(1)).enumerate() {
        let scale = scale.as_ref().map_or(0.0, |scale| scale.as_array()[body]);
        distances_of(&of_run.of(body, m), &of_other.of(body, m), scale, apart);
    }
    shaped(py, apart, shape)
}

/// The errors of closed forms and the times from which on they are 1 or more, (n,) each, of bodies at these times,
/// (m,) or (n, m), with these rates, (n, m, 3).
#[pyfunction]
pub fn errors_of_closed_forms<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    times: Bound<'py, PyArrayDyn<f64>>,
    omega: &Bound<'py, PyAny>,
) -> PyResult<(Column<'py>, Column<'py>)> {
    let _standard = FloatEnvironment::standard();
    let (isa, n) = (Isa::current()?, bodies.len()?);
    let (numbers_of_times, forces) = (copied_numbers("times", &times)?, bodies.forces(n)?);
    let times = times_of_bodies(&numbers_of_times, times.shape(), n)?;
    let shape = [n, times.len(), 3];
    let rates = match omega.cast::<PyArrayDyn<f32>>() {
        Ok(_) => Rates::Single(numbers("omega", omega, shape)?),
        Err(_) => Rates::Double(numbers("omega", omega, shape)?),
    };
    let reserved = || memory::reserved("errors of the bodies", n);
    let (mut errors, mut lost_from) = (reserved()?, reserved()?);
    in_parts(py, &bodies, |bodies, part| {
        for (body, index) in bodies.iter().zip(part) {
            let span = time_range(own_times(&times, index));
            // Of a free body they do not matter.
            let weighs = body.weight != [0.0; 3];
            let fastest = if weighs { rates.fastest(index, times.len())? } else { 0.0 };
            let [error, lost] = error_of_closed_form(isa, body, forces.of(index), span, fastest);
            errors.push(error);
            lost_from.push(lost);
        }
        Ok(())
    })?;
    Ok((of_bodies(py, errors), of_bodies(py, lost_from)))
}

/// Rates of bodies at some times, in either precision.
enum Rates<'py> {
    Single(PyReadonlyArrayDyn<'py, f32>),
    Double(PyReadonlyArrayDyn<'py, f64>),
}

impl Rates<'_> {
    /// The fastest of a body.
    fn fastest(&self, body: usize, times: usize) -> PyResult<f64> {
        let own = body * times..(body + 1) * times;
        Ok(match self {
            Rates::Single(rates) => fastest(&chunks::<f32, 3>(rates)?[own]),
            Rates::Double(rates) => fastest(&chunks::<f64, 3>(rates)?[own]),
        })
    }
}

/// The phase errors of free bodies next to their separatrix and the times from which on their phase is lost, (n,) each, at
/// these times, (m,) or (n, m), from their states; None if no body has one.
#[pyfunction]
pub fn phase_errors<'py>(
    py: Python<'py>,
    bodies: Bodies<'py>,
    times: Bound<'py, PyArrayDyn<f64>>,
    states: &Bound<'py, PyAny>,
) -> PyResult<Option<(Column<'py>, Column<'py>)>> {
    let _standard = FloatEnvironment::standard();
    let (isa, n) = (Isa::current()?, bodies.len()?);
    let numbers_of_times = copied_numbers("times", &times)?;
    let times = times_of_bodies(&numbers_of_times, times.shape(), n)?;
    let m = times.len();
    let states = Columns::read(states, [n, m])?;
    let mut errors = memory::reserved("errors of the bodies", n)?;
    in_parts(py, &bodies, |bodies, part| {
        let recorded = states.recorded()?;
        for (body, index) in bodies.iter().zip(part) {
            let own = recorded.of(index, m);
            errors.push(phase_error(isa, body, own.omega, own.work, time_range(own_times(&times, index))));
        }
        Ok(())
    })?;
    if errors.iter().all(|&error| error == PhaseError::NONE) {
        return Ok(None);
    }
    let column = |of: fn(&PhaseError) -> f64| {
        PyResult::Ok(of_bodies(py, memory::collected("errors of the bodies", n, errors.iter().map(of))?))
    };
    Ok(Some((column(|error| error.delay)?, column(|error| error.lost_from)?)))
}

/// Rates, (n, 3), and attitudes, (n, 4), of starts that are rounded otherwise, in one of `ROUNDINGS` ways.
#[pyfunction]
pub fn rounded_otherwise<'py>(
    py: Python<'py>,
    omega: Aligned2<'py, f64>,
    attitude: Aligned2<'py, f64>,
    rounding: usize,
) -> PyResult<(Rows<'py>, Rows<'py>)> {
    check_rounding(rounding)?;
    let (omega, attitude) = (rows::<3>("omega", &omega)?, rows::<4>("attitude", &attitude)?);
    Ok((all_rounded(py, omega, rounding)?, all_rounded(py, attitude, rounding)?))
}

/// Refuses what is none of the ways to round.
pub(super) fn check_rounding(rounding: usize) -> Result<(), Error> {
    if rounding < ROUNDINGS {
        return Ok(());
    }
    let (value, rule) = (rounding.to_string(), "there is no such way to round");
    Err(Error::Value { argument: "rounding", value, rule })
}

fn all_rounded<'py, const N: usize>(
    py: Python<'py>,
    rows: &[[f64; N]],
    rounding: usize,
) -> PyResult<Rows<'py>> {
    let _standard = FloatEnvironment::standard();
    let rounded = rows.iter().map(|&row| round_otherwise(row, rounding));
    let rounded = memory::collected("starts", rows.len(), rounded)?.into_flattened();
    shaped(py, rounded, [rows.len(), N])
}

/// Bodies judged between two looks at signals.
const PART: usize = 1 << 12;

/// Judges bodies, part after part. In between the interpreter handles signals; meanwhile nobody reads an array.
fn in_parts(
    py: Python<'_>,
    bodies: &Bodies<'_>,
    mut judge: impl FnMut(&[Body], Range<usize>) -> PyResult<()>,
) -> PyResult<()> {
    let n = bodies.len()?;
    for first in (0..n).step_by(PART) {
        let part = first..n.min(first + PART);
        judge(&bodies.of(part.clone())?, part)?;
        py.check_signals()?;
    }
    Ok(())
}

/// The output times of a body.
fn own_times<'a>(times: &Schedule<'a>, body: usize) -> &'a [f64] {
    times.times_of(body).unwrap_or(&[])
}

/// An array of this shape to be read: that of the caller, or a copy where its numbers are not aligned or not in the order
/// of C.
fn numbers<'py, T: Element, const N: usize>(
    argument: &'static str,
    object: &Bound<'py, PyAny>,
    shape: [usize; N],
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let array = object.cast::<PyArrayDyn<T>>()?;
    if array.shape() != shape {
        let (expected, got) = (format!("{shape:?}"), format!("{:?}", array.shape()));
        return Err(Error::Shape { argument, expected, got }.into());
    }
    if array.is_aligned() && array.is_c_contiguous() {
        return Ok(array.try_readonly()?);
    }
    Ok(array.call_method0(intern!(array.py(), "copy"))?.cast_into::<PyArrayDyn<T>>()?.try_readonly()?)
}

/// The states of a run.
struct Columns<'py> {
    omega: PyReadonlyArrayDyn<'py, f64>,
    gamma: Option<PyReadonlyArrayDyn<'py, f64>>,
    attitude: Option<PyReadonlyArrayDyn<'py, f64>>,
    work: Option<PyReadonlyArrayDyn<'py, f64>>,
}

impl<'py> Columns<'py> {
    /// Those of so many bodies at so many times, from a mapping; what is missing or None is not recorded.
    fn read(states: &Bound<'py, PyAny>, [n, m]: [usize; 2]) -> PyResult<Self> {
        let py = states.py();
        let recorded = |name: &Bound<'py, PyString>| -> PyResult<Option<Bound<'py, PyAny>>> {
            Ok(states.call_method1(intern!(py, "get"), (name,))?.extract()?)
        };
        let column = |argument, name, width| {
            recorded(name)?.map(|given| numbers(argument, &given, [n, m, width])).transpose()
        };
        Ok(Columns {
            omega: numbers("omega", &states.get_item(intern!(py, "omega"))?, [n, m, 3])?,
            gamma: column("gamma", intern!(py, "gamma"), 3)?,
            attitude: column("attitude", intern!(py, "attitude"), 4)?,
            work: recorded(intern!(py, "work"))?.map(|given| numbers("work", &given, [n, m])).transpose()?,
        })
    }

    /// The states of all bodies as rows.
    fn recorded(&self) -> PyResult<Recorded<'_>> {
        Ok(Recorded {
            omega: chunks(&self.omega)?,
            gamma: self.gamma.as_ref().map(chunks).transpose()?,
            attitude: self.attitude.as_ref().map(chunks).transpose()?,
            work: self.work.as_ref().map(|work| work.as_slice()).transpose()?,
        })
    }
}

fn chunks<'a, T: Element, const N: usize>(array: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<&'a [[T; N]]> {
    Ok(array.as_slice()?.as_chunks::<N>().0)
}

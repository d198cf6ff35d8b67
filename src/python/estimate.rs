//! The errors of closed forms, and the distances of the states of two runs.

use super::bodies::Bodies;
use super::convert::{Aligned1, copied_numbers, same_length, times_of_bodies};
use super::states::{of_bodies, shaped};
use crate::error::Error;
use crate::estimate::{Recorded, distances as distances_of, error_of_closed_form, fastest};
use crate::float_environment::FloatEnvironment;
use crate::memory;
use crate::simd::Isa;
use crate::trajectory::time_range;
use numpy::{
    Element, PyArray1, PyArray2, PyArray3, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyString;

/// Rows of numbers.
type Rows<'py> = Bound<'py, PyArray2<f64>>;

/// A number of each body.
type Column<'py> = Bound<'py, PyArray1<f64>>;

/// The relative distances of the states of two runs, (n, m); the larger of those of rates, relative to the fastest rate, and of directions. Rates that
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
    // Between two parts the interpreter handles signals; meanwhile nobody reads an array.
    for first in (0..n).step_by(PART) {
        let part = first..n.min(first + PART);
        for (body, index) in bodies.of(part.clone())?.iter().zip(part) {
            let span = time_range(times.times_of(index).unwrap_or(&[]));
            // Of a free body they do not matter.
            let weighs = body.weight != [0.0; 3];
            let fastest = if weighs { rates.fastest(index, times.len())? } else { 0.0 };
            let [error, lost] = error_of_closed_form(isa, body, forces.of(index), span, fastest);
            errors.push(error);
            lost_from.push(lost);
        }
        py.check_signals()?;
    }
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

/// Bodies judged between two looks at signals.
const PART: usize = 1 << 12;

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
            states: None,
        })
    }
}

fn chunks<'a, T: Element, const N: usize>(array: &'a PyReadonlyArrayDyn<'_, T>) -> PyResult<&'a [[T; N]]> {
    Ok(array.as_slice()?.as_chunks::<N>().0)
}
